//! The program for the Adafruit Feather STM32F405 Express.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
stm32f405::application!(feather_f405, USART3);

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This program is for the chip: firmware/README.md says how to build and start it there or in an emulator."
    );
}
