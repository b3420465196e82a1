//! The pictures of a sweep: one for each choice, one for each pair of choices.

use super::Sweep;
use experiments::sweep::{Found, Key};
use plots::{Figure, ForestColumn, ForestSection, HeatAxis, HeatMap, Mark, forest, heat_maps};
use sim::statistics::Mean;

/// Choices whose pairs are drawn.
const MAX_PAIRED: usize = 4;

/// All of them, with what the page says about each.
pub(super) fn pictures(sweep: &Sweep<'_>) -> Vec<(Figure, String)> {
    let mut pictures = Vec::new();
    for (key, found) in sweep.keys.iter().zip(&sweep.found) {
        let title = format!("What {} is worth", key.name);
        let svg = forest(
            &title,
            &format!("{}: all other choices together", sweep.title),
            &sections(sweep, key, found),
        );
        pictures.push((figure(&key.name, &title, BY_KEY), svg));
    }
    let paired = sweep.keys.get(..MAX_PAIRED).unwrap_or(&sweep.keys);
    for (index, down) in paired.iter().enumerate() {
        for along in paired.iter().skip(index + 1) {
            let title = format!("{} and {} together", down.name, along.name);
            let svg = heat_maps(
                &title,
                [&axis(down), &axis(along)],
                &maps(sweep, down, along),
            );
            let name = format!("{}-{}", down.name, along.name);
            pictures.push((figure(&name, &title, BY_PAIR), svg));
        }
    }
    pictures
}

const BY_KEY: &str = "Each value's episodes, all other choices together: the share without contact (interval by Wilson's score, \
                      episodes taken as independent), the behavior's own measure (interval by the bootstrap over worlds \
                      and seeds), the way.";
const BY_PAIR: &str = "Means of the episodes that have both values; an empty cell has none.";

fn figure(name: &str, title: &str, caption: &str) -> Figure {
    let tame = |c: char| {
        if c.is_ascii_alphanumeric() || c == '.' {
            c
        } else {
            '-'
        }
    };
    Figure {
        file: format!("{}.svg", name.chars().map(tame).collect::<String>()),
        title: title.to_owned(),
        caption: vec![caption.to_owned()],
    }
}

fn heading((behavior, unit): &(String, String)) -> String {
    format!("{behavior} (success: {unit})")
}

fn sections(sweep: &Sweep<'_>, key: &Key, found: &[Vec<Option<Found>>]) -> Vec<ForestSection> {
    let section = |(behavior, found): (&(String, String), &Vec<Option<Found>>)| {
        let count = |found: &Option<Found>| found.as_ref().map_or(0, |found| found.episodes);
        let counts = found.iter().map(|found| format!("n={}", count(found)));
        let column = |name: &str, within: [f64; 2], mark: fn(&Found) -> Mark| ForestColumn {
            name: name.to_owned(),
            within,
            marks: found
                .iter()
                .map(|found| found.as_ref().map_or(Mark::Nothing, mark))
                .collect(),
        };
        ForestSection {
            title: heading(behavior),
            labels: key.values.iter().cloned().zip(counts).collect(),
            columns: vec![
                column("without contact, %", [0.0, 100.0], |found| {
                    Mark::Interval(percent(found.clean))
                }),
                column("success", [0.0, f64::INFINITY], |found| {
                    Mark::Interval(found.success)
                }),
                column("distance, m", [0.0, f64::INFINITY], |found| {
                    Mark::Spread(found.distance_m, found.distances_m.clone())
                }),
            ],
        }
    };
    sweep.behaviors.iter().zip(found).map(section).collect()
}

fn percent(share: Mean) -> Mean {
    Mean {
        mean: share.mean * 100.0,
        interval: share.interval.map(|end| end * 100.0),
    }
}

fn axis(key: &Key) -> HeatAxis {
    HeatAxis {
        name: key.name.clone(),
        labels: key.values.clone(),
    }
}

/// Sums over the episodes of a cell: how many, without contact (%), success, way.
type Sums = [f64; 4];

fn maps(sweep: &Sweep<'_>, down: &Key, along: &Key) -> Vec<(String, Vec<HeatMap>)> {
    let behaviors = sweep.behaviors.iter().enumerate();
    let section = |(place, behavior): (usize, &(String, String))| {
        let sums = sums(sweep, down, along, place);
        let map = |name: &str, decimals: usize, measure: usize| HeatMap {
            name: name.to_owned(),
            decimals,
            cells: sums
                .iter()
                .map(|row| row.iter().map(|sums| mean(sums, measure)).collect())
                .collect(),
        };
        let maps = [
            ("without contact, %", 0, 1),
            ("success", 2, 2),
            ("distance, m", 0, 3),
        ];
        let maps = maps.map(|(name, decimals, measure)| map(name, decimals, measure));
        (heading(behavior), maps.into())
    };
    behaviors.map(section).collect()
}

fn mean(sums: &Sums, measure: usize) -> Option<f64> {
    let sum = sums.get(measure).copied().unwrap_or(0.0);
    (sums[0] > 0.0).then(|| sum / sums[0])
}

fn sums(sweep: &Sweep<'_>, down: &Key, along: &Key, behavior: usize) -> Vec<Vec<Sums>> {
    let mut sums = vec![vec![[0.0; 4]; along.values.len()]; down.values.len()];
    let results = sweep.results;
    let (_, behaviors) = results.texts("behavior");
    let measures = ["contacts", "success", "distance_m"].map(|name| results.numbers(name));
    for (row, _) in behaviors
        .iter()
        .enumerate()
        .filter(|(_, of)| **of as usize == behavior)
    {
        let place = down.of_row.get(row).zip(along.of_row.get(row));
        let cell = place.and_then(|(down, along)| sums.get_mut(*down)?.get_mut(*along));
        let [contacts, success, distance] =
            measures.map(|column| column.get(row).copied().unwrap_or(0.0));
        let clean = if contacts == 0.0 { 100.0 } else { 0.0 };
        if let Some(cell) = cell {
            for (sum, value) in cell.iter_mut().zip([1.0, clean, success, distance]) {
                *sum += value;
            }
        }
    }
    sums
}
