//! Machines that QEMU emulates and the firmware supports.

/// A machine and the build parameters of its firmware.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Machine {
    /// Package of the board.
    pub package: &'static str,
    /// Program in that package.
    pub program: &'static str,
    /// Features to enable.
    pub features: &'static str,
    /// Compilation target.
    pub target: &'static str,
    /// Program name of the emulator.
    pub emulator: &'static str,
    /// Debian package of the emulator.
    pub install: &'static str,
    /// Arguments of the emulator. The serial port after these is the link.
    pub arguments: &'static [&'static str],
}

impl Machine {
    /// Folder below `target` for its image: programs with other features have the same name.
    #[must_use]
    pub fn target_folder(&self) -> &'static str {
        if self.features.contains("places") {
            "qemu-places"
        } else if self.features.contains("any-body") {
            "qemu-any-body"
        } else {
            "qemu"
        }
    }

    /// Olimex STM32-H405, the machine of the address `qemu`.
    pub const OLIMEX_H405: Self = Self {
        package: "stm32f405",
        program: "olimex_h405",
        features: "qemu",
        target: "thumbv7em-none-eabihf",
        emulator: "qemu-system-arm",
        install: "qemu-system-arm",
        arguments: &["-M", "netduinoplus2"],
    };

    /// The same, for sensors anywhere on the body.
    pub const OLIMEX_H405_ANY_BODY: Self = Self {
        features: "qemu,any-body",
        ..Self::OLIMEX_H405
    };

    /// The same, with a memory of places.
    pub const OLIMEX_H405_PLACES: Self = Self {
        features: "qemu,places",
        ..Self::OLIMEX_H405
    };

    /// Adafruit Feather STM32F405 Express: the same chip; the link is its third port.
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

    /// A RISC-V machine that exists only in QEMU.
    pub const RISCV32_VIRT: Self = Self {
        package: "riscv32_virt",
        program: "riscv32_virt",
        features: "",
        target: "riscv32imac-unknown-none-elf",
        emulator: "qemu-system-riscv32",
        install: "qemu-system-misc",
        arguments: &["-M", "virt", "-bios", "none"],
    };

    /// The same, for sensors anywhere on the body.
    pub const RISCV32_VIRT_ANY_BODY: Self = Self {
        features: "any-body",
        ..Self::RISCV32_VIRT
    };

    /// The same, with a memory of places.
    pub const RISCV32_VIRT_PLACES: Self = Self {
        features: "places",
        ..Self::RISCV32_VIRT
    };
}
