//! What each choice of a sweep is worth: the episodes by its values, all other choices together.

use super::CHOICE_PREFIX;
use super::table::Table;
use sim::statistics::{Mean, bootstrap, quantile, wilson};
use std::collections::BTreeMap;

/// Most values of a key that are told apart; more numbers than that are put together, more texts left out.
const MAX_VALUES: usize = 12;
/// Stretches that many numbers are put into.
const STRETCHES: usize = 8;

/// Something that is not the same in all episodes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Key {
    /// Its name.
    pub name: String,
    /// Its values, or stretches of them.
    pub values: Vec<String>,
    /// Which of them each row has.
    pub of_row: Vec<usize>,
}

/// The choices that vary, and the world if there are a few. Then the keys left out: their values are texts, and too many.
#[must_use]
pub fn keys(table: &Table) -> (Vec<Key>, Vec<String>) {
    let (mut keys, mut left_out) = (Vec::new(), Vec::new());
    let is_choice = |name: &&String| name.starts_with(CHOICE_PREFIX);
    for name in table.names().iter().filter(is_choice) {
        let (texts, of_row) = table.texts(name);
        let name = name.trim_start_matches(CHOICE_PREFIX);
        let numbers = texts
            .iter()
            .filter(|text| !text.is_empty())
            .map(|text| text.parse::<f64>());
        let numbers: Result<Vec<_>, _> = numbers.collect();
        match (texts.len(), numbers) {
            (0 | 1, _) => {}
            (_, Ok(numbers)) => keys.push(of_numbers(name, numbers, texts, of_row)),
            (..=MAX_VALUES, Err(_)) => keys.push(of_texts(name, texts, of_row)),
            (_, Err(_)) => left_out.push(name.to_owned()),
        }
    }
    let (worlds, of_row) = table.texts("world");
    if (2..=MAX_VALUES).contains(&worlds.len()) {
        keys.push(of_texts("world", worlds, of_row));
    }
    (keys, left_out)
}

/// What stands where a point leaves a choice to the preset.
const OPEN: &str = "unset";

fn of_texts(name: &str, texts: &[String], of_row: &[u32]) -> Key {
    let shown = |text: &String| {
        if text.is_empty() {
            OPEN.to_owned()
        } else {
            text.clone()
        }
    };
    Key {
        name: name.to_owned(),
        values: texts.iter().map(shown).collect(),
        of_row: of_row.iter().map(|&text| text as usize).collect(),
    }
}

/// Numbers in their order, each by itself or in stretches with equally many values.
fn of_numbers(name: &str, mut numbers: Vec<f64>, texts: &[String], of_row: &[u32]) -> Key {
    numbers.sort_by(f64::total_cmp);
    let stretches = if numbers.len() > MAX_VALUES {
        STRETCHES
    } else {
        numbers.len()
    };
    let place = |text: &String| match text.parse::<f64>() {
        Ok(number) => {
            numbers.partition_point(|&other| other < number) * stretches / numbers.len().max(1)
        }
        Err(_) => stretches,
    };
    let places: Vec<_> = texts.iter().map(place).collect();
    let mut values = vec![(f64::INFINITY, f64::NEG_INFINITY); stretches];
    for number in &numbers {
        if let Some((low, high)) = values.get_mut(place(&number.to_string())) {
            (*low, *high) = (low.min(*number), high.max(*number));
        }
    }
    let stretch = |&(low, high): &(f64, f64)| {
        if low == high {
            low.to_string()
        } else {
            format!("{} to {}", brief(low), brief(high))
        }
    };
    let open = texts.iter().any(String::is_empty).then(|| OPEN.to_owned());
    Key {
        name: name.to_owned(),
        values: values.iter().map(stretch).chain(open).collect(),
        of_row: of_row
            .iter()
            .map(|&text| places.get(text as usize).copied().unwrap_or(0))
            .collect(),
    }
}

/// Three significant digits.
fn brief(number: f64) -> f64 {
    format!("{number:.2e}").parse().unwrap_or(number)
}

/// What some episodes came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// How many episodes.
    pub episodes: usize,
    /// Share of those without contact while seeking, with its interval by Wilson's score.
    pub clean: Mean,
    /// The behavior's own measure, its interval by the bootstrap over worlds and seeds.
    pub success: Mean,
    /// Way, meters: the quantiles 5, 25, 50, 75 and 95 %.
    pub distance_m: [f64; 5],
    /// The way of each episode, meters, rising.
    pub distances_m: Vec<f64>,
}

impl Found {
    /// Of the rows that `wanted` takes; `None` if it takes none.
    #[must_use]
    pub fn of(table: &Table, wanted: impl Fn(usize) -> bool) -> Option<Self> {
        let [contacts, distances, successes] =
            ["contacts", "distance_m", "success"].map(|name| table.numbers(name));
        let (_, worlds) = table.texts("world");
        let rows: Vec<_> = (0..table.rows()).filter(|&row| wanted(row)).collect();
        if rows.is_empty() {
            return None;
        }
        let value = |column: &[f64], row: usize| column.get(row).copied().unwrap_or(0.0);
        let clean = rows
            .iter()
            .filter(|&&row| value(contacts, row) == 0.0)
            .count();
        let mut by_world: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
        for &row in &rows {
            let world = worlds.get(row).copied().unwrap_or(0);
            by_world
                .entry(world)
                .or_default()
                .push(value(successes, row));
        }
        let mut distances_m: Vec<_> = rows.iter().map(|&row| value(distances, row)).collect();
        distances_m.sort_by(f64::total_cmp);
        Some(Self {
            episodes: rows.len(),
            clean: wilson(clean, rows.len()),
            success: bootstrap(&by_world.into_values().collect::<Vec<_>>()),
            distance_m: [0.05, 0.25, 0.5, 0.75, 0.95].map(|share| quantile(&distances_m, share)),
            distances_m,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::results::Header;
    use super::*;
    use std::path::Path;

    fn table(rows: &[&str]) -> Table {
        let columns = [
            "config.far",
            "config.recall",
            "world",
            "contacts",
            "distance_m",
            "success",
        ];
        let mut table = Table::new(Header::new(
            "s",
            "0",
            9,
            columns.map(str::to_owned).into_iter(),
        ));
        for (number, row) in rows.iter().enumerate() {
            let row = format!("{number},{row}");
            table.add(Path::new("t"), row.split(',')).expect(&row);
        }
        table
    }

    #[test]
    fn values_come_in_their_order() {
        let table = table(&["10,a,w,0,1,1", "9,,w,0,1,1", ",a,w,1,3,0"]);
        let (keys, left_out) = keys(&table);
        assert!(left_out.is_empty());
        let [far, recall] = &keys[..] else {
            panic!("{keys:?}")
        };
        assert_eq!(
            (&far.values[..], &far.of_row[..]),
            (&["9", "10", OPEN].map(str::to_owned)[..], &[1, 0, 2][..])
        );
        assert_eq!(
            (&recall.values[..], &recall.of_row[..]),
            (&["a", OPEN].map(str::to_owned)[..], &[0, 1, 0][..])
        );
    }

    #[test]
    fn many_numbers_are_put_into_stretches_and_many_texts_left_out() {
        let rows: Vec<_> = (0..32)
            .map(|i| format!("{},t{i},w,0,1,1", 31 - i))
            .collect();
        let rows: Vec<_> = rows.iter().map(String::as_str).collect();
        let (keys, left_out) = keys(&table(&rows));
        assert_eq!(left_out, ["recall"]);
        let [far] = &keys[..] else { panic!("{keys:?}") };
        assert_eq!(
            (
                far.values.len(),
                far.values[0].as_str(),
                far.values[7].as_str()
            ),
            (8, "0 to 3", "28 to 31")
        );
        for stretch in 0..8 {
            assert_eq!(far.of_row.iter().filter(|&&of| of == stretch).count(), 4);
        }
        assert_eq!((far.of_row[0], far.of_row[31]), (7, 0));
    }

    #[test]
    fn figures_by_hand() {
        let table = table(&["1,a,v,0,1,1", "1,a,w,2,2,0", "2,a,w,0,3,0.5", "2,a,w,0,7,9"]);
        let found = Found::of(&table, |row| row < 3).expect("three rows");
        assert_eq!((found.episodes, found.clean.mean), (3, 2.0 / 3.0));
        assert_eq!((found.success.mean, found.distance_m[2]), (0.5, 2.0));
        assert_eq!(found.distances_m, [1.0, 2.0, 3.0]);
        assert_eq!(Found::of(&table, |_| false), None);
    }
}
