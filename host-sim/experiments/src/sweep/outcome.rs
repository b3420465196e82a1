//! Results of a sweep's episodes, grouped by the values of one option over all others.

use super::table::{ResultsTable, Texts};
use sim::statistics::{Mean, bootstrap, mean, wilson};
use std::collections::BTreeMap;

/// Largest number of values of an option that are distinguished.
const MAX_VALUES: usize = 40;
/// Text of an option that a point does not set.
const UNSET: &str = "unset";

/// An option that differs between episodes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SweptChoice {
    /// Its key.
    pub key: String,
    /// Its values: numbers ascending, then texts in order of appearance.
    pub values: Vec<String>,
    /// By row: index into `values`.
    pub of_row: Vec<usize>,
}

/// The options that vary, and the world if it does; then the keys omitted for too many values.
#[must_use]
pub fn swept_choices(table: &ResultsTable) -> (Vec<SweptChoice>, Vec<String>) {
    let world = table.texts("world").map(|texts| ("world", texts));
    let varies = |(_, texts): &(&str, &Texts)| texts.distinct.len() > 1;
    let (shown, left_out): (Vec<_>, Vec<_>) = table
        .choices()
        .chain(world)
        .filter(varies)
        .partition(|(_, texts)| texts.distinct.len() <= MAX_VALUES);
    let key = |(key, _): (&str, &Texts)| key.to_owned();
    (
        shown.into_iter().map(swept).collect(),
        left_out.into_iter().map(key).collect(),
    )
}

fn swept((key, texts): (&str, &Texts)) -> SweptChoice {
    let number = |text: &str| text.parse::<f64>().unwrap_or(f64::INFINITY);
    let mut order: Vec<_> = (0..texts.distinct.len()).collect();
    let text = |index: usize| texts.distinct.get(index).map_or("", String::as_str);
    // A stable sort: texts keep their order, after the numbers.
    order.sort_by(|&a, &b| number(text(a)).total_cmp(&number(text(b))));
    let value = |&index: &usize| match text(index) {
        "" => UNSET.to_owned(),
        text => text.to_owned(),
    };
    let place = |index: &usize| order.iter().position(|other| other == index).unwrap_or(0);
    SweptChoice {
        key: key.to_owned(),
        values: order.iter().map(value).collect(),
        of_row: texts.of_row.iter().map(place).collect(),
    }
}

/// Result of a group of episodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweepOutcome {
    /// Number of episodes.
    pub episodes: usize,
    /// Share of episodes without contact while seeking, with Wilson's interval.
    pub clean: Mean,
    /// The behavior's own measure, with a bootstrap interval over worlds and seeds.
    pub success: Mean,
    /// Mean distance traveled, meters.
    pub distance_m: f64,
}

impl SweepOutcome {
    /// Result of the rows that `wanted` accepts; `None` without such rows.
    #[must_use]
    pub fn of(table: &ResultsTable, wanted: impl Fn(usize) -> bool) -> Option<Self> {
        let rows: Vec<_> = (0..table.rows()).filter(|&row| wanted(row)).collect();
        if rows.is_empty() {
            return None;
        }
        let [contacts, distances, successes] =
            ["contacts", "distance_m", "success"].map(|name| table.numbers(name));
        let value = |column: &[f64], row: usize| column.get(row).copied().unwrap_or(0.0);
        let is_clean = |row: &&usize| value(contacts, **row) == 0.0;
        let worlds = table.texts("world");
        let mut by_world: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for &row in &rows {
            let world = worlds.and_then(|worlds| worlds.of_row.get(row).copied());
            let successes = value(successes, row);
            by_world
                .entry(world.unwrap_or(0))
                .or_default()
                .push(successes);
        }
        let driven = rows.iter().map(|&row| value(distances, row));
        Some(Self {
            episodes: rows.len(),
            clean: wilson(rows.iter().filter(is_clean).count(), rows.len()),
            success: bootstrap(&by_world.into_values().collect::<Vec<_>>()),
            distance_m: mean(driven),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::results::ResultsHeader;
    use super::*;

    fn table(rows: &[&str]) -> ResultsTable {
        let columns = [
            "config.far",
            "config.recall",
            "world",
            "contacts",
            "distance_m",
            "success",
        ];
        let columns = columns.map(str::to_owned).into_iter();
        let mut table = ResultsTable::new(ResultsHeader::new("s", "0", 9, columns));
        for (number, row) in rows.iter().enumerate() {
            let row = format!("{number},{row}");
            table.add(&row.split(',').collect::<Vec<_>>()).expect(&row);
        }
        table
    }

    #[test]
    fn values_come_in_their_order() {
        let table = table(&["10,a,w,0,1,1", "9,,w,0,1,1", ",a,w,1,3,0"]);
        let (choices, left_out) = swept_choices(&table);
        assert!(left_out.is_empty());
        let [far, recall] = &choices[..] else {
            panic!("{choices:?}")
        };
        assert_eq!(
            (&far.values[..], &far.of_row[..]),
            (&["9", "10", UNSET].map(str::to_owned)[..], &[1, 0, 2][..])
        );
        assert_eq!(
            (&recall.values[..], &recall.of_row[..]),
            (&["a", UNSET].map(str::to_owned)[..], &[0, 1, 0][..])
        );
    }

    #[test]
    fn too_many_values_are_left_out_by_name() {
        let rows: Vec<_> = (0..=MAX_VALUES)
            .map(|i| format!("{},t{i},v{},0,1,1", i % 3, i % 2))
            .collect();
        let rows: Vec<_> = rows.iter().map(String::as_str).collect();
        let (choices, left_out) = swept_choices(&table(&rows));
        assert_eq!(left_out, ["recall"]);
        let keys: Vec<_> = choices.iter().map(|choice| choice.key.as_str()).collect();
        assert_eq!(keys, ["far", "world"]);
    }

    #[test]
    fn figures_by_hand() {
        let table = table(&["1,a,v,0,1,1", "1,a,w,2,2,0", "2,a,w,0,6,0.5", "2,a,w,0,7,9"]);
        let found = SweepOutcome::of(&table, |row| row < 3).expect("three rows");
        assert_eq!((found.episodes, found.clean.mean), (3, 2.0 / 3.0));
        assert_eq!((found.success.mean, found.distance_m), (0.5, 3.0));
        assert_eq!(SweepOutcome::of(&table, |_| false), None);
    }
}
