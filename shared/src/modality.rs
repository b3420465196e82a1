//! Another modality than the ring: a scent, the brightness, the color of the floor (the paper's
//! §5.2).
//!
//! Whatever is perceived is recorded with its two coordinates, space and time. They are what links
//! records of different modalities, and only when something is looked for: what smells strongest
//! recalls a position, to which the memory of [places](crate::places) knows the way; what was
//! perceived last before it got dark recalls a time, and so another position.
//!
//! Each modality has a map of its own situations. It is the index of the records: when there is no
//! room for another, one goes whose neuron stands for the most, so that what is rare stays.
//!
//! A change of such a situation tells nothing of the action that brought it: where it smells
//! stronger depends on where the source is. What the action map tells of the ring, the positions of
//! the records tell here.

use crate::fixed::Mask;
use crate::memory::{self, SituationBytes};
use crate::som::{Grid, Neighborhood, Som, Update};
use crate::units::{Displacement, Millis};
use heapless::Vec;

mod search;

pub use search::Search;

/// Neurons of the map of a modality, on a grid of 4 × 4.
pub const NEURONS: usize = 16;
/// The greatest value of a component.
pub const MAX_VALUE: u8 = 254;
/// Positions nearer to each other are one, millimeters.
const SPACING_MM: u32 = 250;
/// A robot so near to a position is there, millimeters.
const THERE_MM: u32 = 100;
/// Values that differ by less are the same.
const SAME: u8 = 32;
/// Values that differ by so much are those of different things.
const DIFFERENT: u8 = 64;
/// Values that differ by no more are alike.
const ALIKE: u8 = 24;
/// Values that deviate by more from what is sought are something else.
const OTHER: u8 = 40;
/// A component below this is nothing.
const MIN_VALUE: u8 = 16;
/// The share of a neuron's way to what is perceived, at least, 1/65 536, and that of its neighbors
/// in it.
const MIN_RATE_Q16: u32 = 3_277;
const NEIGHBORS_Q16: u32 = 16_384;

/// What was perceived, where and when.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record<const COMPONENTS: usize> {
    /// Each component, 0 … [`MAX_VALUE`].
    pub values: SituationBytes<COMPONENTS>,
    /// Where, from the start.
    pub at: Displacement,
    /// When at first.
    pub first: Millis,
    /// When last.
    pub last: Millis,
    /// Neuron of the map that stood for it when it was recorded.
    pub neuron: u8,
    /// Something else is perceived there now.
    pub is_past: bool,
}

/// What is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sought<const COMPONENTS: usize> {
    /// Where this component is greatest.
    Most(u8),
    /// Where such values are perceived.
    Alike(SituationBytes<COMPONENTS>),
}

impl<const COMPONENTS: usize> Sought<COMPONENTS> {
    /// How far values are from it, 0 … [`MAX_VALUE`].
    #[must_use]
    pub fn deviation(&self, values: &SituationBytes<COMPONENTS>) -> u8 {
        let component = |index: u8| values.get(usize::from(index)).copied().unwrap_or(0);
        match self {
            Self::Most(index) => MAX_VALUE.saturating_sub(component(*index)),
            Self::Alike(wanted) => difference(wanted, values).saturating_sub(ALIKE),
        }
    }

    /// Whether these values show anything of it.
    fn is_found_in(&self, values: &SituationBytes<COMPONENTS>) -> bool {
        let most = match self {
            Self::Most(_) => MAX_VALUE - MIN_VALUE,
            Self::Alike(_) => OTHER,
        };
        self.deviation(values) <= most
    }

    /// Whether more of it may be anywhere.
    const fn is_greatest(&self) -> bool {
        matches!(self, Self::Most(_))
    }
}

/// One modality: at most `RECORDS` records of `COMPONENTS` values each, and their map.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Modality<const COMPONENTS: usize, const RECORDS: usize> {
    map: Som<NEURONS, COMPONENTS>,
    /// Records of which the map has learned.
    learned: u16,
    records: Vec<Record<COMPONENTS>, RECORDS>,
}

impl<const COMPONENTS: usize, const RECORDS: usize> Default for Modality<COMPONENTS, RECORDS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const COMPONENTS: usize, const RECORDS: usize> Modality<COMPONENTS, RECORDS> {
    /// Nothing perceived yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            map: Som::zeroed(Grid::rectangle(4, 4)),
            learned: 0,
            records: Vec::new(),
        }
    }

    /// Forgets all.
    pub fn forget(&mut self) {
        self.records.clear();
        self.map.clear();
        self.learned = 0;
    }

    /// The records, in no particular order.
    #[must_use]
    pub fn records(&self) -> &[Record<COMPONENTS>] {
        &self.records
    }

    /// The robot perceives this here and now. One record stands for all positions that are nearer
    /// than 0.25 m and show about the same; its values follow what is perceived within 0.1 m.
    /// Where something else is perceived there than before, that was so in the past.
    pub fn perceive(&mut self, values: &SituationBytes<COMPONENTS>, at: Displacement, now: Millis) {
        let values = values.map(|value| value.min(MAX_VALUE));
        let is_same = |record: &&mut Record<COMPONENTS>| {
            record.at.minus(at).is_shorter_than(SPACING_MM)
                && difference(&record.values, &values) < SAME
        };
        let same = self.records.iter_mut().filter(is_same);
        let nearest = same.min_by_key(|record| record.at.minus(at).squared_mm2());
        let is_known = nearest.is_some();
        if let Some(record) = nearest {
            if record.at.minus(at).is_shorter_than(THERE_MM) {
                for (kept, value) in record.values.iter_mut().zip(&values) {
                    *kept = kept.midpoint(*value);
                }
            }
            (record.last, record.is_past) = (now, false);
        }
        for other in &mut self.records {
            let is_here = other.at.minus(at).is_shorter_than(THERE_MM);
            other.is_past |= is_here && difference(&other.values, &values) >= DIFFERENT;
        }
        if is_known {
            return;
        }
        let neuron = self.learn(&values);
        if self.records.is_full() {
            self.forget_one(now);
        }
        // There is room now, if there is any at all.
        let _ = self.records.push(Record {
            values,
            at,
            first: now,
            last: now,
            neuron,
            is_past: false,
        });
    }

    /// Adds a record of before, as long as there is room. The map learns of it as of a new one, and
    /// finds its neuron.
    pub fn restore(&mut self, record: Record<COMPONENTS>) {
        if self.records.is_full() {
            return;
        }
        let values = record.values.map(|value| value.min(MAX_VALUE));
        let neuron = self.learn(&values);
        let _ = self.records.push(Record {
            values,
            neuron,
            ..record
        });
    }

    /// The map learns of a new record, and returns its neuron. The first ones make the neurons;
    /// later it learns less and less of each.
    fn learn(&mut self, values: &SituationBytes<COMPONENTS>) -> u8 {
        let (values, _) = memory::from_bytes(values);
        let learned = usize::from(self.learned);
        let neuron = if learned < NEURONS {
            self.map.set_code_vector(learned, &values);
            learned
        } else {
            let rate = (65_536 * 4_u32).checked_div(self.learned.into());
            let rate = rate.unwrap_or(0).max(MIN_RATE_Q16);
            let update = Update::from_q16(Neighborhood::Direct, rate, NEIGHBORS_Q16);
            self.map.train_step(&values, Mask::ALL, &update)
        };
        self.learned = self.learned.saturating_add(1);
        neuron as u8
    }

    /// The oldest of those whose neuron stands for the most records: what is rare stays, and what
    /// is past, which time may ask for.
    fn forget_one(&mut self, now: Millis) {
        let mut counts = [0_u16; NEURONS];
        for record in &self.records {
            if let Some(count) = counts.get_mut(usize::from(record.neuron)) {
                *count = count.saturating_add(1);
            }
        }
        let worth = |(_, record): &(usize, &Record<COMPONENTS>)| {
            let count = counts.get(usize::from(record.neuron)).copied();
            (count, now.after(record.last))
        };
        let least = self.records.iter().enumerate().max_by_key(worth);
        let least = least.map(|(index, _)| index);
        if let Some(index) = least.filter(|index| *index < self.records.len()) {
            self.records.swap_remove(index);
        }
    }

    /// The record of what is perceived nearest to what is sought; of several that are as near to
    /// it the one that is nearest to the robot.
    #[must_use]
    pub fn recall(
        &self,
        sought: &Sought<COMPONENTS>,
        here: Displacement,
    ) -> Option<&Record<COMPONENTS>> {
        let present = self.records.iter().filter(|record| !record.is_past);
        present.min_by_key(|record| {
            let distance = record.at.minus(here).squared_mm2();
            (sought.deviation(&record.values), distance)
        })
    }

    /// What was perceived last of what differs from this: if it is dark now, the light before.
    #[must_use]
    pub fn recall_before(
        &self,
        values: &SituationBytes<COMPONENTS>,
        now: Millis,
    ) -> Option<&Record<COMPONENTS>> {
        let others = self.records.iter();
        let others = others.filter(|record| difference(&record.values, values) >= DIFFERENT);
        others.min_by_key(|record| now.after(record.last))
    }
}

/// The greatest difference of a component.
fn difference<const COMPONENTS: usize>(
    one: &SituationBytes<COMPONENTS>,
    other: &SituationBytes<COMPONENTS>,
) -> u8 {
    let pairs = one.iter().zip(other);
    let differences = pairs.map(|(one, other)| one.abs_diff(*other));
    differences.max().unwrap_or(0)
}

#[cfg(test)]
mod tests;
