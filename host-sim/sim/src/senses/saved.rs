//! What was perceived beside ranges, to be saved and restored.

use super::{RECORDS, Senses};
use amp::modality::{Modality, Record};
use amp::units::{Displacement, Millis};
use serde::{Deserialize, Serialize};

/// A record. When it was is told by how long ago: the clock begins anew with the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct SavedRecord<V> {
    values: V,
    at: Displacement,
    first_ago_ms: u32,
    last_ago_ms: u32,
    is_past: bool,
}

/// All records, in the frame of the places with which they are saved. The maps learn of them anew.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SavedSenses {
    scent: Vec<SavedRecord<[u8; 1]>>,
    light: Vec<SavedRecord<[u8; 1]>>,
    floor: Vec<SavedRecord<[u8; 3]>>,
}

impl Senses {
    /// All records, as old as they were when the sensors were read last.
    #[must_use]
    pub fn saved(&self) -> SavedSenses {
        SavedSenses {
            scent: saved(&self.scent, self.now),
            light: saved(&self.light, self.now),
            floor: saved(&self.floor, self.now),
        }
    }

    /// Replaces all records by those.
    pub fn restore(&mut self, saved: &SavedSenses, now: Millis) {
        self.forget();
        self.now = now;
        restore(&mut self.scent, &saved.scent, now);
        restore(&mut self.light, &saved.light, now);
        restore(&mut self.floor, &saved.floor, now);
    }
}

fn saved<const COMPONENTS: usize>(
    modality: &Modality<COMPONENTS, RECORDS>,
    now: Millis,
) -> Vec<SavedRecord<[u8; COMPONENTS]>> {
    let records = modality.records().iter();
    let saved = records.map(|record| SavedRecord {
        values: record.values,
        at: record.at,
        first_ago_ms: now.after(record.first),
        last_ago_ms: now.after(record.last),
        is_past: record.is_past,
    });
    saved.collect()
}

fn restore<const COMPONENTS: usize>(
    modality: &mut Modality<COMPONENTS, RECORDS>,
    saved: &[SavedRecord<[u8; COMPONENTS]>],
    now: Millis,
) {
    for record in saved {
        modality.restore(Record {
            values: record.values,
            at: record.at,
            first: now.minus_ms(record.first_ago_ms),
            last: now.minus_ms(record.last_ago_ms),
            neuron: 0,
            is_past: record.is_past,
        });
    }
}
