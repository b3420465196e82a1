//! Which pin of the Olimex STM32-H405 does what.
//!
//! The chip is an STM32F405RG in its 64-pin package: ports A, B and C whole, PD2, and the crystal's two pins (PH0, PH1).
//! An emulated chip sets the ring's pins up and leaves them alone.

/// What a pin is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// Driven or read by this firmware.
    Now,
    /// Kept free for later.
    Planned,
}

/// One pin and its task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Assignment {
    /// The chip's name of the pin.
    pub pin: &'static str,
    /// What it does.
    pub function: &'static str,
    /// Whether it does so already.
    pub used: Use,
}

const fn now(pin: &'static str, function: &'static str) -> Assignment {
    Assignment {
        pin,
        function,
        used: Use::Now,
    }
}

const fn planned(pin: &'static str, function: &'static str) -> Assignment {
    Assignment {
        pin,
        function,
        used: Use::Planned,
    }
}

/// Every pin the firmware uses or will use.
pub const ASSIGNMENTS: [Assignment; 12] = [
    now("PA9", "link: USART1 transmits"),
    now("PA10", "link: USART1 receives"),
    now("PC12", "lamp, lit when low"),
    planned("PA0", "button"),
    // One ranging module serves sixteen transducers, chosen by a four-bit address. All five lines in a row of port C,
    // so that an address is one write.
    now("PC0", "ring: address bit 0"),
    now("PC1", "ring: address bit 1"),
    now("PC2", "ring: address bit 2"),
    now("PC3", "ring: address bit 3"),
    // Timer 3, channel 1 captures the edge. The module's output is an open collector pulled up to 5 V: the pin is one of
    // the chip's 5 V tolerant ones.
    now("PC6", "ring: ECHO, captured by timer 3"),
    now("PC7", "ring: INIT"),
    now("PC8", "ring: BINH"),
    now("PC9", "ring: BLNK"),
];

/// Pins that belong to the board, and to what.
pub const RESERVED: [(&str, &str); 14] = [
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
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::string::String;
    use std::vec::Vec;

    /// The pins that `board.rs` takes from the ports, as `gpioa.pa9` and the like.
    fn taken_by_the_board() -> BTreeSet<String> {
        let words = include_str!("board.rs").split(|c: char| !(c.is_alphanumeric() || c == '.'));
        words
            .filter_map(|word| word.strip_prefix("gpio")?.split('.').nth(1))
            .filter(|pin| pin.len() >= 3 && pin.starts_with('p'))
            .map(str::to_uppercase)
            .collect()
    }

    #[test]
    fn no_pin_is_used_twice_and_none_that_belongs_to_the_board() {
        let mut seen = BTreeSet::new();
        let reserved = RESERVED.iter().map(|&(pin, _)| pin);
        for pin in ASSIGNMENTS.iter().map(|entry| entry.pin).chain(reserved) {
            assert!(seen.insert(pin), "{pin} has two owners");
        }
    }

    #[test]
    fn every_pin_exists_in_the_64_pin_package() {
        let reserved = RESERVED.iter().map(|&(pin, _)| pin);
        for pin in ASSIGNMENTS.iter().map(|entry| entry.pin).chain(reserved) {
            let (port, number) = pin.split_at(2);
            let number: u8 = number.parse().expect("a number");
            let exists = match port {
                "PA" | "PB" | "PC" => number < 16,
                "PD" => number == 2,
                "PH" => number < 2,
                _ => false,
            };
            assert!(exists, "{pin}");
        }
    }

    #[test]
    fn the_board_takes_exactly_the_pins_in_use() {
        let in_use: BTreeSet<String> = ASSIGNMENTS
            .iter()
            .filter(|entry| entry.used == Use::Now)
            .map(|entry| entry.pin.into())
            .collect();
        assert_eq!(taken_by_the_board(), in_use);
    }

    #[test]
    fn the_readme_has_every_pin() {
        let readme = include_str!("../README.md");
        let rows: Vec<_> = ASSIGNMENTS
            .iter()
            .map(|entry| (entry.pin, entry.function))
            .chain(RESERVED)
            .collect();
        for (pin, function) in rows {
            let row = readme
                .lines()
                .find(|line| line.starts_with(&std::format!("| {pin} |")));
            assert!(
                row.is_some_and(|row| row.contains(function)),
                "{pin}: {function}"
            );
        }
    }
}
