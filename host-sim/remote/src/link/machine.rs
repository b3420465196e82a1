//! Machines that QEMU emulates and the firmware runs on.

/// A machine, and how the firmware for it is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Machine {
    /// Package of the firmware's board.
    pub package: &'static str,
    /// Program in that package.
    pub program: &'static str,
    /// Features of that package.
    pub features: &'static str,
    /// Target of the compiler.
    pub target: &'static str,
    /// The emulator's program.
    pub emulator: &'static str,
    /// The Debian package that has the emulator.
    pub install: &'static str,
    /// What the emulator is started with. The link is the serial port after these.
    pub arguments: &'static [&'static str],
}

impl Machine {
    /// Olimex STM32-H405: the board that `qemu` means.
    pub const OLIMEX_H405: Self = Self {
        package: "stm32f405",
        program: "olimex_h405",
        features: "qemu",
        target: "thumbv7em-none-eabihf",
        emulator: "qemu-system-arm",
        install: "qemu-system-arm",
        arguments: &["-M", "netduinoplus2"],
    };

    /// Adafruit Feather STM32F405 Express: the same chip with the link at its third port.
    pub const FEATHER_F405: Self = Self {
        program: "feather_f405",
        arguments: &["-M", "netduinoplus2", "-serial", "null", "-serial", "null"],
        ..Self::OLIMEX_H405
    };

    /// BBC micro:bit: a Cortex-M0 with 16 KiB of memory.
    pub const MICROBIT: Self = Self {
        package: "microbit",
        program: "microbit",
        features: "",
        target: "thumbv6m-none-eabi",
        emulator: "qemu-system-arm",
        install: "qemu-system-arm",
        arguments: &["-M", "microbit"],
    };

    /// A RISC-V machine that exists in QEMU only.
    pub const RISCV32_VIRT: Self = Self {
        package: "riscv32_virt",
        program: "riscv32_virt",
        features: "",
        target: "riscv32imac-unknown-none-elf",
        emulator: "qemu-system-riscv32",
        install: "qemu-system-misc",
        arguments: &["-M", "virt", "-bios", "none"],
    };
}
