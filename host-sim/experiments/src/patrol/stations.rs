//! Stations as all namers know them.

use super::{BITS, Namer};
use amp::sequence::{End, Pattern, SequenceMemory};
use amp::units::Displacement;

/// Presentations of the corrected rule, at most.
const PRESENTATIONS: u32 = 50;

/// What the robot keeps of a station.
#[derive(Debug, Clone, Copy)]
pub(super) struct Record {
    pub(super) code: Pattern<BITS>,
    pub(super) position: Displacement,
}

/// A sequence of stations as all namers know it.
pub(super) struct Stations {
    hebb: Box<SequenceMemory<BITS>>,
    corrected: Box<SequenceMemory<BITS>>,
    pub(super) records: Vec<Record>,
}

impl Stations {
    pub(super) fn of(records: Vec<Record>) -> Self {
        let codes: Vec<_> = records.iter().map(|record| record.code).collect();
        let mut hebb = Box::new(SequenceMemory::new());
        hebb.learn(&codes, End::Returns);
        let mut corrected = hebb.clone();
        for _ in 0..PRESENTATIONS {
            if corrected.correct(&codes, End::Returns) == 0 {
                break;
            }
        }
        Self {
            hebb,
            corrected,
            records,
        }
    }

    pub(super) fn after(&self, station: usize) -> usize {
        (station + 1) % self.records.len().max(1)
    }

    /// The station with the nearest code.
    fn nearest(&self, code: &Pattern<BITS>) -> usize {
        let all = self.records.iter().enumerate();
        let nearest = all.min_by_key(|(_, record)| record.code.distance(code));
        nearest.map_or(0, |(station, _)| station)
    }

    /// The next station. What the pair recalls is a situation: it stands for the station whose code
    /// is nearest.
    pub(super) fn name(
        &self,
        namer: Namer,
        code: &Pattern<BITS>,
        at: Displacement,
        pointer: usize,
    ) -> usize {
        match namer {
            Namer::Pair => self.nearest(&self.corrected.step(code)),
            Namer::PairHebb => self.nearest(&self.hebb.step(code)),
            Namer::Table => self.after(self.nearest(code)),
            Namer::Position => {
                let away_mm = |record: &Record| record.position.minus(at).length_mm();
                let all = self.records.iter().enumerate();
                let nearest = all.min_by_key(|(_, record)| away_mm(record));
                self.after(nearest.map_or(0, |(station, _)| station))
            }
            Namer::List => pointer,
        }
    }
}
