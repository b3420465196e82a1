//! Damaged frames through receiver and decoder: no panic, and no more accepted than a CRC-32
//! explains.
//!
//! The frames are the examples of PROTOCOL.md, with every message. *Wrongly accepted*: it passes
//! the CRC and is none of the examples.

use super::mutate::FrameDamage;
use super::{CampaignVerdict, ProgressCallback, below, generator, grouped, parts};
use amp::wire::frame::{FrameError, unpack};
use amp::wire::{HostMessage, Receiver, Report};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use sim::statistics::{poisson_interval, poisson_tail};

/// Frames of a full campaign.
pub const COUNT: u64 = 1_000_000_000;
/// Frames per random generator.
const PART: u64 = 100_000;
/// The document with an example of every message.
const PROTOCOL: &str = include_str!("../../../shared/PROTOCOL.md");

/// A valid frame, without its delimiter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Example {
    pub(super) bytes: Vec<u8>,
    pub(super) to_device: bool,
}

/// The examples of PROTOCOL.md.
pub(super) fn examples() -> Vec<Example> {
    let block = PROTOCOL.split("```hex\n").nth(1).unwrap_or_default();
    let mut examples = Vec::new();
    let mut to_device = true;
    for line in block.lines().take_while(|line| !line.starts_with("```")) {
        if line.contains(',') {
            to_device = line.starts_with("to device");
            continue;
        }
        let bytes = line
            .split(' ')
            .filter_map(|byte| u8::from_str_radix(byte, 16).ok());
        let mut bytes: Vec<_> = bytes.collect();
        bytes.pop();
        examples.push(Example { bytes, to_device });
    }
    examples
}

/// Counts of damaged frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct FrameCounts {
    /// Frames sent.
    frames: u64,
    /// Identical to the original after the damage.
    unharmed: u64,
    /// Parts between delimiters.
    pieces: u64,
    /// Parts too long for the receiver.
    oversized: u64,
    /// Parts that are not COBS, or too short.
    malformed: u64,
    /// Parts with a wrong checksum.
    wrong_sum: u64,
    /// Parts that equal an example.
    sound: u64,
    /// Parts that were wrongly accepted.
    wrong: u64,
}

impl FrameCounts {
    fn plus(mut self, other: &Self) -> Self {
        self.frames += other.frames;
        self.unharmed += other.unharmed;
        self.pieces += other.pieces;
        self.oversized += other.oversized;
        self.malformed += other.malformed;
        self.wrong_sum += other.wrong_sum;
        self.sound += other.sound;
        self.wrong += other.wrong;
        self
    }

    /// Checksums that were compared with those of other bytes.
    const fn compared(&self) -> u64 {
        self.wrong_sum + self.wrong
    }
}

type Tallies = [FrameCounts; FrameDamage::ALL.len()];

/// Damages `count` frames.
#[must_use]
pub fn run(seed: u64, count: u64, progress: ProgressCallback<'_>) -> CampaignVerdict {
    let examples = examples();
    let damaged = |(part, size): (u64, u64)| {
        let tallies = damage(&examples, &mut generator(seed, part), size);
        progress(size);
        tallies
    };
    let add = |one: Tallies, other: Tallies| -> Tallies {
        std::array::from_fn(|kind| one[kind].plus(&other[kind]))
    };
    let tallies = parts(count, PART)
        .into_par_iter()
        .map(damaged)
        .reduce(Tallies::default, add);
    verdict(&tallies, examples.len())
}

fn damage(examples: &[Example], random: &mut Xoshiro256PlusPlus, count: u64) -> Tallies {
    let mut tallies = Tallies::default();
    let mut frame = Vec::with_capacity(1_024);
    for _ in 0..count {
        let kind = below(random, FrameDamage::ALL.len());
        let [one, other] = [(); 2].map(|()| &examples[below(random, examples.len())]);
        frame.clear();
        frame.extend_from_slice(&one.bytes);
        FrameDamage::ALL[kind].inflict(&mut frame, &other.bytes, random);
        let tally = &mut tallies[kind];
        tally.frames += 1;
        if frame == one.bytes {
            tally.unharmed += 1;
        } else {
            receive(&frame, one.to_device, examples, tally);
        }
    }
    tallies
}

fn receive(bytes: &[u8], to_device: bool, examples: &[Example], tally: &mut FrameCounts) {
    let mut receiver = Receiver::new();
    for &byte in bytes.iter().chain(&[0]) {
        let Some(piece) = receiver.push(byte) else {
            continue;
        };
        tally.pieces += 1;
        let error = if to_device {
            unpack::<HostMessage<16>>(piece).err()
        } else {
            unpack::<Report<16>>(piece).err()
        };
        match error {
            Some(FrameError::Shape | FrameError::TooLong) => tally.malformed += 1,
            Some(FrameError::Crc) => tally.wrong_sum += 1,
            None | Some(FrameError::Content { .. }) => {
                if examples.iter().any(|example| example.bytes == piece) {
                    tally.sound += 1;
                } else {
                    tally.wrong += 1;
                }
            }
        }
    }
    let oversized = u64::from(receiver.oversized());
    tally.pieces += oversized;
    tally.oversized += oversized;
}

fn verdict(tallies: &Tallies, examples: usize) -> CampaignVerdict {
    let sum = tallies
        .iter()
        .fold(FrameCounts::default(), FrameCounts::plus);
    let row = |name: &str, tally: &FrameCounts| {
        [
            name.to_owned(),
            grouped(tally.frames),
            grouped(tally.unharmed),
            grouped(tally.pieces),
            grouped(tally.malformed + tally.oversized),
            grouped(tally.wrong_sum),
            grouped(tally.sound),
            grouped(tally.wrong),
        ]
    };
    let mut rows: Vec<_> = FrameDamage::ALL
        .iter()
        .zip(tallies)
        .map(|(damage, tally)| row(damage.name(), tally))
        .collect();
    rows.push(row("all", &sum));
    let mut verdict = CampaignVerdict::default();
    verdict.say(format_args!(
        "{} damaged frames, made of {examples} valid ones\n",
        grouped(sum.frames)
    ));
    let heads = [
        "damage",
        "frames",
        "unchanged",
        "pieces",
        "no COBS, or too long",
        "wrong CRC",
        "another whole example",
        "wrongly accepted",
    ];
    verdict.table(heads, &rows);
    judge(&mut verdict, &sum);
    verdict
}

/// Checks whether chance explains the wrongly accepted parts.
fn judge(verdict: &mut CampaignVerdict, sum: &FrameCounts) {
    let expected = sum.compared() as f64 / 4_294_967_296.0;
    let [low, high] = poisson_interval(sum.wrong);
    let tail = poisson_tail(sum.wrong, expected);
    verdict.say(format_args!(
        "\nsums compared: {}; of as many random ones 2^-32 would match: {expected:.4} expected, {} found (exact Poisson 95 % \
         interval {low:.2} to {high:.2}); as many or more by chance: {tail:.3}",
        grouped(sum.compared()),
        sum.wrong
    ));
    verdict.require(tail >= 0.025, "more wrong frames than chance explains");
    let seen = sum.malformed + sum.oversized + sum.compared() + sum.sound;
    verdict.require(seen == sum.pieces, "a part was not counted");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_examples_are_sound_frames_of_both_directions() {
        let examples = examples();
        assert!(examples.len() > 30);
        assert!(examples.iter().any(|example| !example.to_device));
        let mut tally = FrameCounts::default();
        for example in &examples {
            receive(&example.bytes, example.to_device, &examples, &mut tally);
        }
        let all = examples.len() as u64;
        assert_eq!((tally.pieces, tally.sound), (all, all));
        // Without the examples for comparison each would be an error.
        let example = &examples[0];
        receive(&example.bytes, example.to_device, &[], &mut tally);
        assert_eq!(tally.wrong, 1);
    }

    #[test]
    fn one_wrong_frame_in_few_is_more_than_chance() {
        let few = FrameCounts {
            pieces: 1_000,
            wrong_sum: 999,
            wrong: 1,
            ..FrameCounts::default()
        };
        let many = FrameCounts {
            pieces: 4_000_000_000,
            wrong_sum: 3_999_999_999,
            ..few
        };
        let broken = |tally| {
            let mut verdict = CampaignVerdict::default();
            judge(&mut verdict, tally);
            verdict.broken.len()
        };
        assert_eq!((broken(&few), broken(&many)), (1, 0));
    }
}
