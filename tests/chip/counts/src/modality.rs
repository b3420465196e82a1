//! Counts what another modality costs a robot with 256 records of three components.

use crate::stopwatch::{InstructionStats, Stopwatch};
use amp::modality::{Modality, Search, Sought};
use amp::places::Places;
use amp::units::{Displacement, Millis};
use core::hint::black_box;

/// Instructions by kind of call.
#[derive(Default)]
pub struct ModalityCounts {
    /// Something is perceived.
    pub perceive: InstructionStats,
    /// The same with as many records as there is room for.
    pub full: InstructionStats,
    /// Where a robot that looks for something is to be led.
    pub aim: InstructionStats,
}

/// A robot that drives in rows of 20 positions, 0.4 m apart.
pub fn records(watch: &Stopwatch) -> ModalityCounts {
    let mut counts = ModalityCounts::default();
    let mut modality = Modality::<3, 256>::new();
    let places = Places::<16, 256>::new();
    let mut search = Search::default();
    for step in 0..300_u16 {
        let here = Displacement {
            dx_mm: 400 * (step % 20) as i16,
            dy_mm: 400 * (step / 20) as i16,
        };
        let values = [step as u8, (step * 7) as u8, (step * 13) as u8];
        let now = Millis::from_ms(1_000 * u32::from(step));
        let (instructions, ()) = watch.count(|| {
            black_box(&mut modality).perceive(black_box(&values), here, now);
        });
        match step {
            256.. => counts.full.add(instructions),
            _ => counts.perceive.add(instructions),
        }
        let sought = Sought::Most(0);
        let (instructions, _) =
            watch.count(|| search.aim(black_box(&modality), &sought, &places, now));
        counts.aim.add(instructions);
    }
    counts
}
