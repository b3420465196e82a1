//! Draws the learning curves of methods with several numbers of moves, next to the controller.

use super::tables::{ComparisonTables, MethodLine};
use experiments::compare::{ComparedMethod, MOVES, MethodFigures};
use plots::{CurveKey, Curves, curves};
use sim::statistics::Mean;

/// A measure in the picture: its name, its largest value, and its accessor.
type Drawn = (&'static str, f64, fn(&MethodFigures) -> Mean);

const ANY: f64 = f64::INFINITY;

/// Measures without the shield.
const BARE: [Drawn; 3] = [
    ("steps with contact %", 100.0, |figures| {
        figures.contact_percent
    }),
    ("clean rooms %", 100.0, |figures| figures.clean_percent),
    ("coverage m²", ANY, |figures| figures.coverage_m2),
];

/// Measures with the shield, which prevents contacts.
const SHIELDED: [Drawn; 3] = [
    ("distance m", ANY, |figures| figures.distance_m),
    ("least clearance m", ANY, |figures| figures.clearance_m),
    ("coverage m²", ANY, |figures| figures.coverage_m2),
];

/// An SVG document; `None` if no method with several numbers of moves was compared.
pub fn picture(report: &ComparisonTables) -> Option<String> {
    let all = report.by_shield().next()?;
    let first = all.iter().find(|line| line.method.learns_by_reward())?;
    let moves = budgets(all, first.method);
    let names: Vec<ComparedMethod> = [ComparedMethod::Default, ComparedMethod::Probe]
        .into_iter()
        .chain(
            ComparedMethod::ALL
                .into_iter()
                .filter(|method| method.learns_by_reward()),
        )
        .filter(|method| !budgets(all, *method).is_empty())
        .collect();
    let name = |method: &ComparedMethod| {
        if method.learns_by_reward() {
            (method.name().to_owned(), false)
        } else {
            (format!("{}, {MOVES} moves", method.name()), true)
        }
    };
    let key = CurveKey {
        subtitle: "Mean and 95 % interval by number of learning moves".to_owned(),
        along: "learning moves".to_owned(),
        ticks: moves.iter().map(u32::to_string).enumerate().collect(),
        names: names.iter().map(name).collect(),
    };
    let panels: Vec<_> = report
        .by_shield()
        .flat_map(|lines| panels(lines, &names, moves.len()))
        .collect();
    Some(curves("Q-learning beside two maps", &key, &panels))
}

fn budgets(lines: &[MethodLine], method: ComparedMethod) -> Vec<u32> {
    let own = lines.iter().filter(|line| line.method == method);
    own.map(|line| line.moves).collect()
}

/// The panels of one condition, each with `places` numbers of moves.
fn panels(lines: &[MethodLine], names: &[ComparedMethod], places: usize) -> [Curves; 3] {
    let shield = lines.first().is_some_and(|line| line.shield);
    let (title, drawn) = if shield {
        ("with the shield", SHIELDED)
    } else {
        ("the methods alone", BARE)
    };
    drawn.map(|(measure, most, value)| {
        // A method with a single number of moves is drawn as a level.
        let of_method = |method: &ComparedMethod| {
            let own = lines.iter().filter(|line| line.method == *method);
            let means = own.map(|line| value(&line.figures));
            means.cycle().take(places).collect()
        };
        Curves {
            title: title.to_owned(),
            measure: measure.to_owned(),
            within: [0.0, most],
            lines: names.iter().map(of_method).collect(),
        }
    })
}
