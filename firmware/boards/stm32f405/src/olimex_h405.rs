//! Olimex STM32-H405: its 8 MHz crystal, its pins, and the link at USART1.

use crate::pinout::Pinout;

/// The board's pins.
pub const PINOUT: Pinout = Pinout {
    board: "olimex_h405",
    used: &[
        ("PA9", "link: USART1 transmits"),
        ("PA10", "link: USART1 receives"),
        ("PC12", "status LED, lit when low"),
        // One ranging module serves 16 transducers, selected by a 4-bit address.
        ("PC0", "ring: address bit 0"),
        ("PC1", "ring: address bit 1"),
        ("PC2", "ring: address bit 2"),
        ("PC3", "ring: address bit 3"),
        // Channel 1 of timer 3. The module's output is an open collector with a pull-up to 5 V,
        // which this pin tolerates.
        ("PC6", "ring: ECHO, captured by timer 3"),
        ("PC7", "ring: INIT"),
        ("PC8", "ring: BINH"),
        ("PC9", "ring: BLNK"),
        ("PB13", "emergency stop, closed to ground"),
        ("PB14", "bumper, closed to ground"),
        ("PB15", "motion permit"),
    ],
    reserved: &[
        ("PA0", "button"),
        ("PA11", "USB data -"),
        ("PA12", "USB data +"),
        ("PA13", "debugger: SWDIO"),
        ("PA14", "debugger: SWCLK"),
        ("PA15", "debugger: JTAG TDI"),
        ("PB2", "BOOT1"),
        ("PB3", "debugger: JTAG TDO, trace"),
        ("PB4", "debugger: JTAG reset"),
        ("PC4", "USB supply sense"),
        ("PC11", "USB pull-up"),
        ("PC14", "32 kHz crystal"),
        ("PC15", "32 kHz crystal"),
        ("PH0", "8 MHz crystal"),
        ("PH1", "8 MHz crystal"),
    ],
};

#[cfg(target_os = "none")]
pub use device::{LinkUart, init};

#[cfg(target_os = "none")]
mod device {
    use crate::chip::{
        Devices, StartedChip, StatusLed, SupplyInterrupt, SupplyMonitor, safety_lines,
    };
    use crate::flash::StoreFlash;
    use crate::ring_timer::RingTimer;
    use crate::serial::{SerialPort, settings};
    use firmware::sonar_ring::RingPins;
    use stm32f4xx_hal::gpio::{PinState, Pull};
    use stm32f4xx_hal::pac;
    use stm32f4xx_hal::prelude::*;

    /// The USART of the link.
    pub type LinkUart = pac::USART1;

    /// Starts the chip and takes the pins.
    ///
    /// # Panics
    /// The clocks cannot make the link's rate; each supported clock can.
    pub fn init(device: pac::Peripherals, core: cortex_m::Peripherals) -> Devices<LinkUart> {
        let guards = (device.IWDG, &device.DBGMCU);
        let mut chip = StartedChip::start(guards, (device.RCC, device.TIM11), core);
        let gpioa = device.GPIOA.split(&mut chip.rcc);
        let gpiob = device.GPIOB.split(&mut chip.rcc);
        let gpioc = device.GPIOC.split(&mut chip.rcc);
        let led = gpioc.pc12.into_push_pull_output_in_state(PinState::High);
        // Pull-up: an open wire would be noise, and the idle line is high.
        let receive = gpioa.pa10.into_alternate().internal_resistor(Pull::Up);
        let ring_pins = RingPins {
            address: [
                gpioc.pc0.into_push_pull_output().erase(),
                gpioc.pc1.into_push_pull_output().erase(),
                gpioc.pc2.into_push_pull_output().erase(),
                gpioc.pc3.into_push_pull_output().erase(),
            ],
            init: gpioc.pc7.into_push_pull_output().erase(),
            binh: gpioc.pc8.into_push_pull_output().erase(),
            blnk: gpioc.pc9.into_push_pull_output().erase(),
        };
        let safety = safety_lines(gpiob.pb13, gpiob.pb14, gpiob.pb15);
        let ring_timer = RingTimer::start(device.TIM3, gpioc.pc6.into_alternate(), &mut chip.rcc);
        let serial = device
            .USART1
            .serial::<u8>((gpioa.pa9, receive), settings(), &mut chip.rcc)
            .expect("every clock used here can make this rate");
        Devices {
            port: SerialPort::listen(serial.release().0, pac::Interrupt::USART1),
            led: StatusLed::new(led.erase(), PinState::Low),
            watchdog: chip.watchdog,
            ring_pins,
            ring_timer,
            flags: chip.flags,
            oscillator: chip.oscillator,
            safety,
            supply: SupplyMonitor::watch(device.PWR, &mut chip.rcc),
            supply_alarm: SupplyInterrupt::listen(device.EXTI),
            flash: StoreFlash::new(device.FLASH),
        }
    }
}
