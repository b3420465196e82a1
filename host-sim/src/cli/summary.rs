//! Tables of episodes' metrics.

use super::table::plain;
use sim::episode::EpisodeReport;

/// One episode as (label, value) rows.
pub(super) fn rows(report: &EpisodeReport) -> Vec<(String, String)> {
    let share = f64::from(report.goal_steps) / f64::from(report.steps.max(1)) * 100.0;
    let rows = [
        ("world", report.world.clone()),
        ("behavior", report.behavior.clone()),
        (
            "random moves",
            format!(
                "{} ({} touched something)",
                report.explore_moves, report.explore_contacts
            ),
        ),
        ("steps", report.steps.to_string()),
        ("steps with contact", report.contacts.to_string()),
        ("distance", format!("{:.1} m", report.distance_m)),
        (
            "least clearance",
            format!("{:.3} m", report.min_clearance_m),
        ),
        ("area swept", format!("{:.1} m²", report.coverage_m2)),
        ("goal held", format!("{share:.1} % of the steps")),
        (
            "shortened by the shield",
            format!("{} steps", report.shield_stops),
        ),
        ("simulated time", format!("{:.0} s", report.time_s)),
        (
            "success",
            format!("{:.4} ({})", report.success, report.success_unit),
        ),
    ];
    rows.map(|(label, value)| (label.to_owned(), value)).into()
}

/// The table of all worlds, with means if there are several.
pub(super) fn table(reports: &[EpisodeReport]) -> String {
    let heads = [
        "world",
        "explore contacts",
        "contacts",
        "distance m",
        "clearance m",
        "coverage m²",
        "goal %",
        "shield stops",
        "time s",
        "success",
    ];
    let mut rows: Vec<_> = reports
        .iter()
        .map(|report| cells(&report.world, &figures(report)))
        .collect();
    let count = reports.len() as f64;
    let mut tail = String::new();
    if reports.len() > 1 {
        let mut means = [0.0; 9];
        for report in reports {
            for (mean, figure) in means.iter_mut().zip(figures(report)) {
                *mean += figure / count;
            }
        }
        rows.push(cells("mean", &means));
        tail = worlds_without_contact(reports);
    }
    let right: Vec<_> = (1..heads.len()).collect();
    plain(&heads, &rows, &right) + &tail
}

fn worlds_without_contact(reports: &[EpisodeReport]) -> String {
    let clean = reports.iter().filter(|report| report.contacts == 0).count();
    let untouched = reports
        .iter()
        .filter(|report| report.explore_contacts == 0)
        .count();
    format!(
        "\n{clean} of {} worlds without contact while seeking ({:.1} %), {untouched} without contact while exploring\n",
        reports.len(),
        100.0 * clean as f64 / reports.len() as f64
    )
}

fn figures(report: &EpisodeReport) -> [f64; 9] {
    [
        f64::from(report.explore_contacts),
        f64::from(report.contacts),
        report.distance_m,
        report.min_clearance_m,
        report.coverage_m2,
        f64::from(report.goal_steps) / f64::from(report.steps.max(1)) * 100.0,
        f64::from(report.shield_stops),
        report.time_s,
        report.success,
    ]
}

fn cells(name: &str, figures: &[f64; 9]) -> Vec<String> {
    let digits = [2, 2, 1, 3, 1, 1, 1, 0, 4];
    let short = |value: f64, digits: usize| {
        let text = format!("{value:.digits$}");
        // A whole number needs no decimals; a mean of counts does.
        if value.fract() == 0.0 && digits == 2 {
            format!("{value:.0}")
        } else {
            text
        }
    };
    let mut row = vec![name.to_owned()];
    row.extend(
        figures
            .iter()
            .zip(digits)
            .map(|(&value, digits)| short(value, digits)),
    );
    row
}
