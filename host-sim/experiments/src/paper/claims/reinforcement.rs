//! Claims of section 3 about reinforcement learning: quality, and number of moves.

use super::{Claim, ClaimVerdict, percents};
use crate::compare::{ComparedMethod, ComparisonRow};
use crate::paper::measure::{LEARNING_MOVES, Measured};

/// Share of clean episodes in %, contacts per 100 m.
fn figures(row: &ComparisonRow) -> (f64, f64) {
    let figures = row.figures();
    (figures.clean_percent.mean, figures.contacts_per_100_m.mean)
}

fn of(measured: &Measured, method: ComparedMethod) -> impl Iterator<Item = &ComparisonRow> {
    let rows = measured.compared.iter();
    rows.filter(move |row| row.method == method)
}

/// Results of a method by learning moves: "q-table 77.0 / 89.0 % (2.10 / 0.50 contacts per 100 m)".
fn by_moves(measured: &Measured, method: ComparedMethod) -> String {
    let (clean, contacts): (Vec<_>, Vec<_>) = of(measured, method)
        .map(figures)
        .map(|(clean, contacts)| (format!("{clean:.0}"), format!("{contacts:.2}")))
        .unzip();
    let (clean, contacts) = (clean.join(" / "), contacts.join(" / "));
    format!(
        "{} {clean} % ({contacts} contacts per 100 m)",
        method.name()
    )
}

/// Best share of clean episodes of any learner, over the numbers of moves that `counts` accepts.
fn cleanest(measured: &Measured, counts: impl Fn(u32) -> bool) -> f64 {
    let learners = measured.compared.iter();
    let learners = learners.filter(|row| row.method.learns_by_reward() && counts(row.moves));
    learners.map(|row| figures(row).0).fold(0.0, f64::max)
}

fn presets(measured: &Measured) -> Vec<(ComparedMethod, f64)> {
    let presets = [
        ComparedMethod::Default,
        ComparedMethod::Probe,
        ComparedMethod::Touzet,
    ];
    let clean = |method| of(measured, method).map(|row| figures(row).0).sum();
    presets.map(|method| (method, clean(method))).into()
}

fn sample(measured: &Measured) -> String {
    let (worlds, seeds) = (measured.size.worlds, measured.size.seeds);
    let moves = LEARNING_MOVES.map(|moves| moves.to_string()).join(" / ");
    format!("{worlds} rooms × {seeds} seeds, 1000 decisions each; learners after {moves} moves")
}

/// "Of a similar quality as the best results achieved with reinforcement learning."
pub(super) fn similar_quality(measured: &Measured) -> Claim {
    let best = cleanest(measured, |_| true);
    let presets = presets(measured);
    let ours: Vec<_> = presets
        .iter()
        .map(|(method, clean)| format!("{} {clean:.0} %", method.name()))
        .collect();
    let learners = [
        ComparedMethod::QTable,
        ComparedMethod::QSom,
        ComparedMethod::QTwoSoms,
    ];
    let theirs = learners.map(|method| by_moves(measured, method)).join(", ");
    let verdicts: Vec<_> = presets.iter().map(|(_, clean)| *clean >= best).collect();
    Claim::new(
        "3",
        "of a similar quality as the best results achieved with reinforcement learning",
    )
    .holds_if(
        "as many episodes without contact as the best Q-learner here after any number of moves",
    )
    .measured(
        format!(
            "episodes without contact after 100 moves: {}; {theirs}; more in `host-sim compare`",
            ours.join(", ")
        ),
        sample(measured),
    )
    .verdict(ClaimVerdict::of(&verdicts))
}

/// "100 moves (compared to 200 minimum for Q-learning)."
pub(super) fn fewer_moves(measured: &Measured) -> Claim {
    let after_100 = cleanest(measured, |moves| moves <= 100);
    let after_200 = cleanest(measured, |moves| moves <= 200);
    let presets = presets(measured);
    let verdicts: Vec<_> = presets
        .iter()
        .map(|(_, clean)| *clean > after_100)
        .collect();
    let ours: Vec<_> = presets
        .iter()
        .map(|(method, clean)| format!("{} {clean:.0} %", method.name()))
        .collect();
    Claim::new("3", "100 moves, compared to 200 minimum for Q-learning")
        .holds_if(
            "after 100 moves more episodes without contact than any Q-learner here after as many",
        )
        .measured(
            format!(
                "after 100 moves: {}, the best Q-learner {}; the best after 200: {}",
                ours.join(", "),
                percents(after_100),
                percents(after_200)
            ),
            sample(measured),
        )
        .verdict(ClaimVerdict::of(&verdicts))
}
