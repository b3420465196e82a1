//! Pin tables of the boards; tests compare them with the boards' code and with the README.
//!
//! The chip is an STM32F405RG in its 64-pin package: ports A, B and C, PD2, PH0 and PH1.

/// A pin and its function.
pub type PinAssignment = (&'static str, &'static str);

/// The pins of one board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pinout {
    /// Name of the board's module.
    pub board: &'static str,
    /// Pins that this firmware drives or reads.
    pub used: &'static [PinAssignment],
    /// Pins that the board itself uses.
    pub reserved: &'static [PinAssignment],
}

#[cfg(test)]
mod tests {
    use super::Pinout;
    use crate::{feather_f405, olimex_h405};
    use std::collections::BTreeSet;
    use std::string::String;
    use std::vec::Vec;

    /// Each board with its source.
    const BOARDS: [(Pinout, &str); 2] = [
        (feather_f405::PINOUT, include_str!("feather_f405.rs")),
        (olimex_h405::PINOUT, include_str!("olimex_h405.rs")),
    ];

    /// The pins that a board's source takes, such as `gpioa.pa9`.
    fn taken(source: &str) -> BTreeSet<String> {
        let words = source.split(|c: char| !(c.is_alphanumeric() || c == '.'));
        words
            .filter_map(|word| word.strip_prefix("gpio")?.split('.').nth(1))
            .filter(|pin| pin.len() >= 3 && pin.starts_with('p'))
            .map(str::to_uppercase)
            .collect()
    }

    fn all(pinout: &Pinout) -> Vec<&'static str> {
        let rows = pinout.used.iter().chain(pinout.reserved);
        rows.map(|&(pin, _)| pin).collect()
    }

    #[test]
    fn no_pin_is_used_twice_and_none_that_the_board_uses() {
        for (pinout, _) in BOARDS {
            let mut seen = BTreeSet::new();
            for pin in all(&pinout) {
                assert!(seen.insert(pin), "{}: {pin} has two owners", pinout.board);
            }
        }
    }

    #[test]
    fn every_pin_exists_in_the_64_pin_package() {
        for (pinout, _) in BOARDS {
            for pin in all(&pinout) {
                let (port, number) = pin.split_at(2);
                let number: u8 = number.parse().expect("a number");
                let exists = match port {
                    "PA" | "PB" | "PC" => number < 16,
                    "PD" => number == 2,
                    "PH" => number < 2,
                    _ => false,
                };
                assert!(exists, "{}: {pin}", pinout.board);
            }
        }
    }

    #[test]
    fn a_board_takes_exactly_the_pins_of_its_table() {
        for (pinout, source) in BOARDS {
            let used: BTreeSet<String> = pinout.used.iter().map(|&(pin, _)| pin.into()).collect();
            assert!(used.len() >= 10, "{}", pinout.board);
            assert_eq!(taken(source), used, "{}", pinout.board);
        }
    }

    /// The README has a row for each pin under a heading with the board's name.
    #[test]
    fn the_readme_has_every_pin() {
        let readme = include_str!("../../../README.md");
        for (pinout, _) in BOARDS {
            let heading = std::format!("### Pins of `{}`\n", pinout.board);
            let (_, section) = readme.split_once(&heading).expect("the board's heading");
            let section = section.split("\n#").next().unwrap_or(section);
            for (pin, function) in pinout.used.iter().chain(pinout.reserved) {
                let begins = std::format!("| {pin} |");
                let row = section.lines().find(|line| line.starts_with(&begins));
                assert!(
                    row.is_some_and(|row| row.contains(function)),
                    "{}: {pin}: {function}",
                    pinout.board
                );
            }
            let rows = section.lines().filter(|line| line.starts_with("| P"));
            assert_eq!(
                rows.count(),
                pinout.used.len() + pinout.reserved.len(),
                "{}",
                pinout.board
            );
        }
    }
}
