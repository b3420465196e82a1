//! Something less in the place of the maps, for the claims that two maps and their neighborhood are
//! what makes the behaviors possible ([`crate::controls`]).

use super::PaperReading;
use super::any_ring::MOVES;
use super::measure::{ProgressListener, Size};
use crate::controls::{
    ControlMeasure, ControlRow, ControlTrial, Results, Slot, Training, WorldSet, better,
    episodes_per_row, measure as measure_row, measures,
};
use arena::sonar::SonarModel;
use sim::error::EpisodeError;
use sim::statistics::Mean;

/// The two maps, learning online as in the presets.
const MAPS: ControlRow = ControlRow {
    name: "two maps",
    training: Training::Maps,
    slot: Slot::Trained,
    online: true,
};

/// What stands in their place.
const CONTROLS: [ControlRow; 3] = [
    ControlRow {
        name: "g",
        slot: Slot::Cosine { gain: 1.0 },
        online: false,
        ..MAPS
    },
    ControlRow {
        name: "g/2",
        slot: Slot::Cosine { gain: 0.5 },
        online: false,
        ..MAPS
    },
    ControlRow {
        name: "vector quantization",
        training: Training::Quantization,
        ..MAPS
    },
];

/// A preset and what is left of it.
pub struct ReducedReading {
    /// Name of the preset.
    pub preset: &'static str,
    /// One cosine that nobody learned in place of the action map, with the slope that follows from
    /// the configuration and with half of it.
    pub cosines: [Reduced; 2],
    /// Maps trained without a neighborhood.
    pub quantization: Reduced,
}

/// What one control does, by measure.
pub struct Reduced {
    /// Name of the control.
    pub name: &'static str,
    /// One per measure.
    pub figures: Vec<ReducedFigure>,
}

/// A measure of the maps and of a control.
#[derive(Clone, Copy)]
pub struct ReducedFigure {
    /// The measure.
    pub measure: ControlMeasure,
    /// The maps.
    pub maps: Mean,
    /// The control.
    pub control: Mean,
    /// Whether the maps are better (1), worse (−1), or neither, paired by world and seed.
    pub maps_are: i8,
}

/// Measures both readings, on all cores: avoidance in half of the rooms, the other behaviors in
/// `size.worlds` × `size.seeds` episodes each. The rings of both keep their bearing; where a ring
/// turns, changes are not linear in the move and no cosine can stand in for the map.
///
/// # Errors
/// When an episode fails.
pub(super) fn measure(
    size: Size,
    readings: [&PaperReading; 2],
    progress: &impl ProgressListener,
) -> Result<[ReducedReading; 2], EpisodeError> {
    let rows = 1 + CONTROLS.len() as u64;
    let parts = readings.map(|reading| parts(size, reading));
    let episodes = parts
        .iter()
        .flatten()
        .map(|part| episodes_per_row(&part.0, &part.1));
    progress.begin("controls", rows * episodes.sum::<u64>());
    let [first, second] = parts;
    Ok([
        reduced(readings[0].name, &first, progress)?,
        reduced(readings[1].name, &second, progress)?,
    ])
}

/// Measures with their worlds and conditions.
type Part = (Vec<ControlMeasure>, ControlTrial);

fn parts(size: Size, reading: &PaperReading) -> [Part; 2] {
    let avoids = |measure: &ControlMeasure| measure.scene.behavior == "avoid";
    let (avoidance, others) = measures(WorldSet::Rooms).into_iter().partition(avoids);
    let trial = |worlds, seeds| ControlTrial {
        first: size.seed,
        worlds,
        seeds,
        explore_moves: MOVES,
        preset: reading.name,
        config: reading.config.clone(),
        sonar: SonarModel::Ideal,
        neurons: 16,
    };
    [
        (avoidance, trial(size.rooms.div_ceil(2), 1)),
        (others, trial(size.worlds, size.seeds)),
    ]
}

fn reduced(
    preset: &'static str,
    parts: &[Part; 2],
    progress: &impl ProgressListener,
) -> Result<ReducedReading, EpisodeError> {
    let of_row = |row: &ControlRow| {
        let mut results = Vec::new();
        for (measures, trial) in parts {
            results.extend(measure_row(row, measures, trial, &|| progress.done())?);
        }
        Ok(results)
    };
    let maps = of_row(&MAPS)?;
    let against = |row: &ControlRow| Ok(compared(row.name, parts, &maps, &of_row(row)?));
    let [cosine, half, quantization] = &CONTROLS;
    Ok(ReducedReading {
        preset,
        cosines: [against(cosine)?, against(half)?],
        quantization: against(quantization)?,
    })
}

fn compared(
    name: &'static str,
    parts: &[Part; 2],
    maps: &[Results],
    control: &[Results],
) -> Reduced {
    let measures = parts.iter().flat_map(|(measures, _)| measures);
    let figures = measures.zip(maps.iter().zip(control));
    let figures = figures.map(|(measure, (maps, control))| ReducedFigure {
        measure: *measure,
        maps: maps.mean(),
        control: control.mean(),
        maps_are: better(measure, maps.less(control)),
    });
    Reduced {
        name,
        figures: figures.collect(),
    }
}
