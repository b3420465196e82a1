//! Clocks, pins, timer and port of a board with nothing connected but the debugger.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![allow(unsafe_code)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("These tests are for the chip: firmware/README.md says how to run them.");
}

/// Milliseconds since the start.
#[cfg(target_os = "none")]
static NOW_MS: core::sync::atomic::AtomicU32 = core::sync::atomic::AtomicU32::new(0);

// SAFETY: the vector table refers to this name, and no other function has it.
#[cfg(target_os = "none")]
#[unsafe(no_mangle)]
extern "C" fn SysTick() {
    NOW_MS.fetch_add(1, core::sync::atomic::Ordering::Relaxed);
}

#[cfg(target_os = "none")]
#[embedded_test::tests(default_timeout = 10)]
mod tests {
    use super::NOW_MS;
    use amp::units::Millis;
    use amp::wire::message::Oscillator;
    use core::sync::atomic::Ordering;
    use firmware::sonar_ring::EchoCapture;
    use firmware::uart::UartPort;
    use stm32f4xx_hal::pac;
    use stm32f405::chip::{CORE_HZ, Devices};
    use stm32f405::clocks;
    #[cfg(feature = "feather")]
    use stm32f405::feather_f405 as board_module;
    #[cfg(not(feature = "feather"))]
    use stm32f405::olimex_h405 as board_module;

    /// Frequency of the board's crystal.
    const CRYSTAL_HZ: u32 = if cfg!(feature = "feather") {
        12_000_000
    } else {
        8_000_000
    };
    /// Frequency of the internal oscillator.
    const INTERNAL_HZ: u32 = 16_000_000;

    /// A board, started as the firmware starts it.
    struct BoardBench(Devices<board_module::LinkUart>);

    #[init]
    fn init() -> BoardBench {
        let device = pac::Peripherals::take().expect("not taken yet");
        let core = cortex_m::Peripherals::take().expect("not taken yet");
        let board = BoardBench(board_module::init(device, core));
        // A watchdog reset during a test must not count against the crystal.
        clocks::mark_proven();
        board
    }

    fn now_ms() -> u32 {
        NOW_MS.load(Ordering::Relaxed)
    }

    impl BoardBench {
        /// Waits for one period of the control task.
        fn wait_one_period(&mut self) -> Millis {
            let from = now_ms();
            while now_ms().wrapping_sub(from) < 10 {}
            self.0.watchdog.feed();
            Millis::from_ms(now_ms())
        }
    }

    /// The level of a pin of port B. An output reads its actual level.
    fn port_b(pin: u32) -> bool {
        // SAFETY: this register is only read, which has no side effects.
        let port = unsafe { pac::GPIOB::steal() };
        port.idr().read().bits() >> pin & 1 == 1
    }

    /// Checks the PLL's settings and, with a crystal, counts clocks during periods of the crystal.
    #[test]
    fn the_processor_runs_at_168_mhz_from_the_reported_oscillator(board: BoardBench) {
        // SAFETY: the clocks run and nothing else uses these registers; `measure` restores them.
        let (rcc, timer) = unsafe { (pac::RCC::steal(), pac::TIM11::steal()) };
        assert!(rcc.cfgr().read().sws().is_pll());
        let settings = rcc.pllcfgr().read();
        let by_crystal = settings.pllsrc().is_hse();
        let named = [Oscillator::Internal, Oscillator::Crystal][usize::from(by_crystal)];
        assert_eq!(board.0.oscillator, named);
        let source_hz = if by_crystal { CRYSTAL_HZ } else { INTERNAL_HZ };
        let input_hz = source_hz / u32::from(settings.pllm().bits());
        let divider = 2 * (u32::from(settings.pllp().bits()) + 1);
        assert_eq!(
            input_hz * u32::from(settings.plln().bits()) / divider,
            CORE_HZ
        );
        if by_crystal {
            let measured = clocks::measure(&rcc, &timer).expect("the crystal swings");
            let expected = measured.periods * (CORE_HZ / CRYSTAL_HZ);
            defmt::info!("{=u32} ticks, {=u32} expected", measured.ticks, expected);
            assert!(measured.ticks.abs_diff(expected) <= expected / 1_000);
        } else {
            defmt::warn!("no crystal: the internal oscillator drives the multiplier");
        }
    }

    #[test]
    fn the_supply_is_high_enough(board: BoardBench) {
        assert!(!board.0.supply.is_low());
    }

    #[test]
    fn emergency_stop_and_bumper_read_open_and_the_permit_stands_still(mut board: BoardBench) {
        let level = port_b(15);
        for _ in 0..20 {
            let now = board.wait_one_period();
            let alarms = board.0.safety.read(now);
            assert!(alarms.emergency_stop && alarms.bumper_open && !alarms.touched);
            assert!(port_b(13) && port_b(14));
            board.0.safety.toggle_permit(true, now);
            assert_eq!(port_b(15), level);
        }
    }

    /// The chip's own resistor closes the emergency stop. Gives the permit for half a second.
    #[test]
    fn the_permit_is_a_square_wave_while_the_emergency_stop_is_closed(mut board: BoardBench) {
        // SAFETY: nothing else changes this register after the start.
        let port = unsafe { pac::GPIOB::steal() };
        port.pupdr().modify(|_, w| w.pupdr13().pull_down());
        let (mut changes, mut level) = (0, port_b(15));
        for _ in 0..50 {
            let now = board.wait_one_period();
            let _ = board.0.safety.read(now);
            board.0.safety.toggle_permit(true, now);
            changes += u32::from(port_b(15) != level);
            level = port_b(15);
        }
        // Debouncing takes two periods.
        assert!((45..=49).contains(&changes), "{}", changes);
        port.pupdr().modify(|_, w| w.pupdr13().pull_up());
        for _ in 0..5 {
            let now = board.wait_one_period();
            let _ = board.0.safety.read(now);
        }
        let now = board.wait_one_period();
        assert!(board.0.safety.read(now).emergency_stop);
    }

    #[test]
    fn the_rings_timer_counts_microseconds(mut board: BoardBench) {
        let _ = board.wait_one_period();
        let (from_ms, from_us) = (now_ms(), board.0.ring_timer.now_us());
        // Each read is within half a turn of the timer.
        for _ in 0..100 {
            let _ = board.wait_one_period();
            let _ = board.0.ring_timer.now_us();
        }
        let (to_ms, to_us) = (now_ms(), board.0.ring_timer.now_us());
        let us = to_us.wrapping_sub(from_us);
        let expected = to_ms.wrapping_sub(from_ms) * 1_000;
        defmt::info!("{=u32} us, {=u32} expected", us, expected);
        assert!(us.abs_diff(expected) <= 20);
    }

    /// The bridge connects PA9 and PA10; on the Feather the pads TX and RX.
    #[test]
    #[ignore = "takes a bridge from the port's transmitter to its receiver"]
    fn the_port_receives_what_it_sends_through_a_bridge(mut board: BoardBench) {
        // Setting up the pins may have looked like a received byte.
        let _ = board.wait_one_period();
        let BoardBench(devices) = &mut board;
        if devices.port.status().received {
            let _ = devices.port.receive();
        }
        let from_us = devices.ring_timer.now_us();
        for byte in 0..=u8::MAX {
            while !devices.port.status().can_send {}
            devices.port.send(byte);
            let from = now_ms();
            while !devices.port.status().received {
                assert!(now_ms().wrapping_sub(from) < 5, "nothing comes back");
                let _ = devices.ring_timer.now_us();
            }
            assert!(!devices.port.status().overrun);
            assert_eq!(devices.port.receive(), byte);
        }
        // Ten bits per byte.
        let us = devices.ring_timer.now_us().wrapping_sub(from_us);
        defmt::info!("{=u32} us", us);
        assert!((21_500..24_500).contains(&us), "not 115 200 baud");
    }
}
