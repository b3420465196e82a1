//! Long randomized runs that try to break the controller, its link and its clock.
//!
//! The same seed gives the same figures on any number of threads. Each campaign returns a
//! [`CampaignVerdict`]: its figures and the violated requirements.

mod bench;
mod bridged;
mod channel;
pub mod chip;
pub mod clock;
pub mod drift;
pub mod frames;
pub mod link;
pub mod mutate;
pub mod shield;
pub mod silence;
mod wheels;

use rand_core::{Rng as _, SeedableRng as _};
use rand_xoshiro::{SplitMix64, Xoshiro256PlusPlus};
use std::fmt::Write as _;

/// Result of a campaign.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CampaignVerdict {
    /// The figures, as Markdown.
    pub text: String,
    /// Violated requirements; empty on success.
    pub broken: Vec<String>,
}

impl CampaignVerdict {
    fn say(&mut self, line: impl std::fmt::Display) {
        let _ = writeln!(self.text, "{line}");
    }

    fn table<const COLUMNS: usize>(&mut self, heads: [&str; COLUMNS], rows: &[[String; COLUMNS]]) {
        self.say(format_args!("| {} |", heads.join(" | ")));
        let rules: Vec<_> = (0..COLUMNS)
            .map(|column| if column == 0 { "---" } else { "---:" })
            .collect();
        self.say(format_args!("| {} |", rules.join(" | ")));
        for row in rows {
            self.say(format_args!("| {} |", row.join(" | ")));
        }
    }

    fn require(&mut self, holds: bool, what: impl Into<String>) {
        if !holds {
            self.broken.push(what.into());
        }
    }
}

/// Called with the number of finished steps.
pub type ProgressCallback<'a> = &'a (dyn Fn(u64) + Sync);

/// The random generator of part `part` of a campaign.
fn generator(seed: u64, part: u64) -> Xoshiro256PlusPlus {
    let start = SplitMix64::seed_from_u64(seed).next_u64();
    Xoshiro256PlusPlus::seed_from_u64(start.wrapping_add(part))
}

/// A uniform number below `bound`, which is greater than 0.
fn below(random: &mut Xoshiro256PlusPlus, bound: usize) -> usize {
    ((u128::from(random.next_u64()) * bound as u128) >> 64) as usize
}

/// True with this probability, in percent.
fn happens(random: &mut Xoshiro256PlusPlus, percent: usize) -> bool {
    below(random, 100) < percent
}

/// Splits `count` into parts of at most `size`: number and size of each.
fn parts(count: u64, size: u64) -> Vec<(u64, u64)> {
    (0..count.div_ceil(size))
        .map(|part| (part, size.min(count - part * size)))
        .collect()
}

/// A number with separated thousands.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up_and_numbers_are_grouped() {
        assert_eq!(parts(25, 10), [(0, 10), (1, 10), (2, 5)]);
        assert!(parts(0, 10).is_empty());
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_234_567), "1 234 567");
    }

    #[test]
    fn other_parts_draw_other_numbers() {
        let draw = |seed, part| generator(seed, part).next_u64();
        assert_eq!(draw(1, 2), draw(1, 2));
        assert_ne!(draw(1, 2), draw(1, 3));
        assert_ne!(draw(1, 2), draw(2, 1));
        let mut random = generator(1, 0);
        assert!((0..1_000).all(|_| below(&mut random, 7) < 7));
    }
}
