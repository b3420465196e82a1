//! Claims of section 5.2, the paper's outlook: records carry space and time, and a goal that is far
//! away becomes a sequence of sub-goals.

use super::{Claim, ClaimVerdict, percents};
use crate::paper::measure::Measured;
use sim::episode::EpisodeReport;
use sim::statistics::median;

/// The claims of this section, in order.
pub(super) fn claims(measured: &Measured) -> Vec<Claim> {
    vec![
        modalities(measured),
        space_and_time(measured),
        other_records(measured),
        sub_goals(measured),
    ]
}

fn modalities(measured: &Measured) -> Claim {
    let scent = &measured.far_goals.scent;
    let found = reached(scent);
    Claim::new("5.2", "each sensory modality will be taken care of by a couple of SOMs")
        .holds_if("after a tour the source of a scent is found in ≥ 95 % of the worlds; a scent has a map of situations only: where it is stronger, no action tells")
        .measured(format!("after a tour of 500 steps {}", percents(found)), worlds(scent))
        .verdict(partly_if(found >= 95.0))
}

fn space_and_time(measured: &Measured) -> Claim {
    let dark = &measured.far_goals.dark;
    let found = reached(dark);
    Claim::new("5.2", "space and time … must therefore be part of any stored record")
        .holds_if("a lamp goes out, and after a tour the robot is back where it was before in ≥ 95 % of the worlds")
        .measured(format!("after a tour of 500 steps {}", percents(found)), worlds(dark))
        .verdict(ClaimVerdict::of(&[found >= 95.0]))
}

fn partly_if(holds: bool) -> ClaimVerdict {
    match holds {
        true => ClaimVerdict::Partly,
        false => ClaimVerdict::DoesNotHold,
    }
}

fn other_records(measured: &Measured) -> Claim {
    let far = &measured.far_goals;
    let found = [&far.carried, &far.new].map(|reports| reached(reports));
    Claim::new("5.2", "coordinates will then be used to retrieve other records")
        .holds_if("set down elsewhere after a tour, the place is found in ≥ 95 % of the worlds by its position")
        .measured(
            format!(
                "after a tour of 500 steps {}, without a tour, by the situation, {}",
                percents(found[0]),
                percents(found[1])
            ),
            worlds(&far.carried),
        )
        .verdict(partly_if(found[0] >= 95.0))
}

fn sub_goals(measured: &Measured) -> Claim {
    let far = &measured.far_goals;
    let [led, alone] = [&far.led, &far.alone].map(|reports| (reached(reports), ways(reports)));
    Claim::new("5.2", "generating automatically a sequence of sub-goals")
        .holds_if("back at the start after a tour of 500 steps in ≥ 95 % of the worlds, on a median way ≤ 1.1 times the shortest")
        .measured(
            format!(
                "by sub-goals {} ({:.2} times the shortest way), by the goal alone {} ({:.2} times)",
                percents(led.0),
                led.1,
                percents(alone.0),
                alone.1
            ),
            worlds(&far.led),
        )
        .verdict(ClaimVerdict::of(&[led.0 >= 95.0 && led.1 <= 1.1]))
}

fn worlds(reports: &[EpisodeReport]) -> String {
    format!("default, {} worlds of 12 other kinds each", reports.len())
}

/// Share of the worlds in which it was there at the end, %.
fn reached(reports: &[EpisodeReport]) -> f64 {
    let count = reports
        .iter()
        .filter(|report| report.success == 1.0)
        .count();
    100.0 * count as f64 / reports.len().max(1) as f64
}

/// What it drove in units of the shortest way, of those that arrived from 0.5 m on: the median.
fn ways(reports: &[EpisodeReport]) -> f64 {
    let arrived = reports.iter().filter(|report| report.success == 1.0);
    let ratio = |report: &EpisodeReport| {
        let shortest_m = report.shortest_m.filter(|m| *m >= 0.5)?;
        Some(report.distance_m / shortest_m)
    };
    median(arrived.filter_map(ratio).collect())
}
