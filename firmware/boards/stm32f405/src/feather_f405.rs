//! Adafruit Feather STM32F405 Express: its 12 MHz crystal, its pins, and the link at USART3.
//!
//! The ring uses no pin of the SD socket, flash chip, NeoPixel, battery or I2C connector.

use crate::pinout::Pinout;

/// The board's pins.
pub const PINOUT: Pinout = Pinout {
    board: "feather_f405",
    used: &[
        ("PB10", "link: USART3 transmits (pad TX)"),
        ("PB11", "link: USART3 receives (pad RX)"),
        ("PC1", "status LED, lit when high"),
        ("PA4", "ring: address bit 0 (pad A0)"),
        ("PA5", "ring: address bit 1 (pad A1)"),
        ("PA6", "ring: address bit 2 (pad A2)"),
        ("PA7", "ring: address bit 3 (pad A3)"),
        ("PC6", "ring: ECHO, captured by timer 3 (pad D6)"),
        ("PC7", "ring: INIT (pad D5)"),
        ("PC2", "ring: BINH (pad D12)"),
        ("PC3", "ring: BLNK (pad D11)"),
        ("PB13", "emergency stop, closed to ground (pad SCK)"),
        ("PB14", "bumper, closed to ground (pad MI)"),
        ("PB15", "motion permit (pad MO)"),
    ],
    reserved: &[
        ("PA3", "half of the battery's voltage"),
        ("PA9", "USB supply sense"),
        ("PA10", "USB identification"),
        ("PA11", "USB data -"),
        ("PA12", "USB data +"),
        ("PA13", "debugger: SWDIO"),
        ("PA14", "debugger: SWCLK"),
        ("PA15", "flash chip: select"),
        ("PB2", "BOOT1"),
        ("PB3", "flash chip: clock"),
        ("PB4", "flash chip: data out"),
        ("PB5", "flash chip: data in"),
        ("PB6", "I2C connector: SCL, with pull-up"),
        ("PB7", "I2C connector: SDA, with pull-up"),
        ("PB12", "SD socket: card detect"),
        ("PC0", "NeoPixel"),
        ("PC8", "SD socket: data 0"),
        ("PC9", "SD socket: data 1"),
        ("PC10", "SD socket: data 2"),
        ("PC11", "SD socket: data 3"),
        ("PC12", "SD socket: clock"),
        ("PC14", "32 kHz crystal"),
        ("PC15", "32 kHz crystal"),
        ("PD2", "SD socket: command"),
        ("PH0", "12 MHz crystal"),
        ("PH1", "12 MHz crystal"),
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
    pub type LinkUart = pac::USART3;

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
        let led = gpioc.pc1.into_push_pull_output_in_state(PinState::Low);
        // Pull-up: an open wire would be noise, and the idle line is high.
        let receive = gpiob.pb11.into_alternate().internal_resistor(Pull::Up);
        let ring_pins = RingPins {
            address: [
                gpioa.pa4.into_push_pull_output().erase(),
                gpioa.pa5.into_push_pull_output().erase(),
                gpioa.pa6.into_push_pull_output().erase(),
                gpioa.pa7.into_push_pull_output().erase(),
            ],
            init: gpioc.pc7.into_push_pull_output().erase(),
            binh: gpioc.pc2.into_push_pull_output().erase(),
            blnk: gpioc.pc3.into_push_pull_output().erase(),
        };
        let safety = safety_lines(gpiob.pb13, gpiob.pb14, gpiob.pb15);
        let ring_timer = RingTimer::start(device.TIM3, gpioc.pc6.into_alternate(), &mut chip.rcc);
        let serial = device
            .USART3
            .serial::<u8>((gpiob.pb10, receive), settings(), &mut chip.rcc)
            .expect("every clock used here can make this rate");
        Devices {
            port: SerialPort::listen(serial.release().0, pac::Interrupt::USART3),
            led: StatusLed::new(led.erase(), PinState::High),
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
