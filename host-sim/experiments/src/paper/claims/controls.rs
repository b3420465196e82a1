//! Claims of sections 2.3 and 2.4: the neighborhood, and two maps. Measured by taking them away.

use super::{Claim, ClaimVerdict};
use crate::paper::controls::{Reduced, ReducedFigure, ReducedReading};
use crate::paper::measure::Measured;

/// "It adds a neighborhood property between the clusters (this unique property explains its
/// thousands of applications)."
pub(super) fn neighborhood(measured: &Measured) -> Claim {
    let readings = measured.reduced.iter();
    let met: Vec<_> = readings
        .flat_map(|reading| wins_over_all(&[&reading.quantization]))
        .collect();
    Claim::new(
        "2.3",
        "a clustering technique that adds a neighborhood property between the clusters",
    )
    .holds_if(
        "the property is needed: the maps do better in every measure (paired, 95 % interval) than \
         vector quantization, as many code vectors trained alike without neighbors",
    )
    .measured(
        by_reading(measured, |reading| against(&reading.quantization)),
        sample(measured),
    )
    .verdict(ClaimVerdict::of(&met))
}

/// "Using two self-organizing maps, we are able to provide the flexibility that is currently
/// missing in goal seeking robot learning methods."
pub(super) fn two_maps(measured: &Measured) -> Claim {
    let readings = measured.reduced.iter();
    let met: Vec<_> = readings
        .flat_map(|reading| wins_over_all(&reading.cosines.each_ref()))
        .collect();
    Claim::new(
        "2.4",
        "using two self-organizing maps, we are able to provide the flexibility that is currently \
         missing",
    )
    .holds_if(
        "they are needed: the maps do better in every measure (paired, 95 % interval) than one \
         cosine that nobody learned in place of the action map, with the slope that follows from \
         the configuration (g) and with half of it (g/2, found by trying)",
    )
    .measured(
        by_reading(measured, |reading| {
            reading.cosines.each_ref().map(against).join(", ")
        }),
        sample(measured),
    )
    .verdict(ClaimVerdict::of(&met))
}

/// By measure, whether the maps do better than each of the controls.
fn wins_over_all(controls: &[&Reduced]) -> Vec<bool> {
    let count = controls.iter().map(|control| control.figures.len()).min();
    let wins = |measure: usize| {
        let is_better = |control: &&Reduced| control.figures[measure].maps_are > 0;
        controls.iter().all(is_better)
    };
    (0..count.unwrap_or(0)).map(wins).collect()
}

fn by_reading(measured: &Measured, text: impl Fn(&ReducedReading) -> String) -> String {
    let readings = measured.reduced.iter();
    let texts = readings.map(|reading| format!("{}: {}", reading.preset, text(reading)));
    texts.collect::<Vec<_>>().join("; ")
}

/// Where the maps do better and where worse than a control, with the figures of both.
fn against(control: &Reduced) -> String {
    let of = |sign: i8| {
        let figures = control.figures.iter();
        let texts: Vec<_> = figures
            .filter(|figure| figure.maps_are == sign)
            .map(figures_of_both)
            .collect();
        match texts.len() {
            0 => "0".to_owned(),
            count => format!("{count} ({})", texts.join(", ")),
        }
    };
    format!(
        "of {} measures {} better than {}, {} worse",
        control.figures.len(),
        of(1),
        control.name,
        of(-1)
    )
}

/// "area 21.6 against 20.1 m²".
fn figures_of_both(figure: &ReducedFigure) -> String {
    let name = figure.measure.name;
    let (name, unit) = name.rsplit_once(", ").unwrap_or((name, ""));
    let digits = if figure.measure.is_error { 3 } else { 1 };
    let (maps, control) = (figure.maps.mean, figure.control.mean);
    format!("{name} {maps:.digits$} against {control:.digits$} {unit}")
}

fn sample(measured: &Measured) -> String {
    let size = measured.size;
    format!(
        "avoidance in {} rooms, along a wall in three scenes, to the nest and after a leader {} \
         episodes each, default and probe",
        size.rooms.div_ceil(2),
        size.worlds * size.seeds
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::controls::{WorldSet, measures};
    use sim::statistics::Mean;

    /// A control beside which the maps are so in the first measures.
    fn control(maps_are: [i8; 3]) -> Reduced {
        let mean = |mean| Mean {
            mean,
            interval: [mean, mean],
        };
        let figures = measures(WorldSet::Rooms).into_iter().zip(maps_are);
        Reduced {
            name: "g",
            figures: figures
                .map(|(measure, maps_are)| ReducedFigure {
                    measure,
                    maps: mean(0.5),
                    control: mean(0.25),
                    maps_are,
                })
                .collect(),
        }
    }

    #[test]
    fn better_and_worse_measures_are_told_with_the_figures_of_both() {
        assert_eq!(
            against(&control([0, 1, -1])),
            "of 3 measures 1 (area 0.5 against 0.2 m²) better than g, 1 (wall error plain 0.500 \
             against 0.250 m) worse"
        );
    }

    #[test]
    fn a_measure_counts_where_the_maps_win_over_all_controls() {
        let [first, second] = [[1, 1, -1], [1, 0, 1]].map(control);
        assert_eq!(wins_over_all(&[&first, &second]), [true, false, false]);
        assert_eq!(wins_over_all(&[&first]), [true, true, false]);
    }
}
