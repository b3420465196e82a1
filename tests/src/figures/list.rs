//! Reads `tests/figures.toml`: commands, and the figures in their output.

use regex::Regex;
use serde::Deserialize;
use std::path::Path;

/// All measurements, in the order of the page.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureList {
    /// Commands, in groups.
    #[serde(rename = "command")]
    pub commands: Vec<MeasuredCommand>,
}

/// A shell command, run in the workspace's folder.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuredCommand {
    /// Section of its figures.
    pub group: String,
    /// The command for `sh -c`.
    pub run: String,
    /// The figures in its output.
    pub row: Vec<FigureRow>,
}

/// A figure.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureRow {
    /// Name of the row.
    pub what: String,
    /// A regular expression; its groups are the figure.
    pub find: String,
    /// The figure as text, `$1` for the first group and so on; default `$1`.
    #[serde(default = "first_group")]
    pub show: String,
    /// Target value.
    #[serde(default)]
    pub aim: String,
    /// Of all matches, use the one whose first group is the greatest number; else the first.
    #[serde(default)]
    pub greatest: bool,
}

fn first_group() -> String {
    "$1".into()
}

impl FigureList {
    /// Reads the file; an error names the file and the line.
    pub fn read(path: &Path) -> Result<Self, String> {
        let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let text = std::fs::read_to_string(path).map_err(|error| failed(&error))?;
        toml::from_str(&text).map_err(|error| failed(&error))
    }
}

impl MeasuredCommand {
    /// Whether its group or command contains one of the words.
    pub fn is_meant(&self, words: &[String]) -> bool {
        let has =
            |word: &String| self.group.contains(word.as_str()) || self.run.contains(word.as_str());
        words.is_empty() || words.iter().any(has)
    }
}

impl FigureRow {
    /// The figure in `output`.
    pub fn value(&self, output: &str) -> Result<String, String> {
        let find = Regex::new(&self.find).map_err(|error| format!("{}: {error}", self.what))?;
        let mut all = find.captures_iter(output);
        let found = match self.greatest {
            true => all.max_by(|a, b| number(&a[1]).total_cmp(&number(&b[1]))),
            false => all.next(),
        };
        let found =
            found.ok_or_else(|| format!("{}: nothing printed matches {}", self.what, self.find))?;
        let group = |index| found.get(index).map_or("", |group| group.as_str());
        let mut value = self.show.clone();
        for index in (1..found.len()).rev() {
            value = value.replace(&format!("${index}"), &grouped(group(index)));
        }
        Ok(value)
    }
}

/// Parses a number with optional digit groups; NaN if it is none.
fn number(text: &str) -> f64 {
    text.replace(' ', "").parse().unwrap_or(f64::NAN)
}

/// Groups the digits of a whole number with at least five digits; other texts stay unchanged.
fn grouped(text: &str) -> String {
    if text.len() < 5 || !text.bytes().all(|byte| byte.is_ascii_digit()) {
        return text.into();
    }
    let mut groups: Vec<&str> = Vec::new();
    let mut rest = text;
    while rest.len() > 3 {
        let (before, last) = rest.split_at(rest.len() - 3);
        groups.push(last);
        rest = before;
    }
    groups.push(rest);
    groups.reverse();
    groups.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(find: &str) -> FigureRow {
        FigureRow {
            what: "steps".into(),
            find: find.into(),
            show: "$1".into(),
            aim: String::new(),
            greatest: false,
        }
    }

    #[test]
    fn a_figure_is_found_and_grouped() {
        let output = "steps | 12 | 39883162 |\n";
        let row = row(r"steps \| \d+ \| (\d+)");
        assert_eq!(row.value(output), Ok("39 883 162".into()));
        assert!(row.value("nothing").is_err());
    }

    #[test]
    fn the_greatest_of_many_is_found() {
        let output = "peak 900\npeak 1200\npeak 1100";
        let row = row(r"peak (\d+)");
        assert_eq!(row.value(output), Ok("900".into()));
        let row = FigureRow {
            greatest: true,
            ..row
        };
        assert_eq!(row.value(output), Ok("1200".into()));
    }

    #[test]
    fn the_list_is_readable_and_names_each_row_once() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("figures.toml");
        let list = FigureList::read(&path).expect("it is there");
        let rows: Vec<_> = list
            .commands
            .iter()
            .flat_map(|command| &command.row)
            .collect();
        for row in &rows {
            assert!(Regex::new(&row.find).is_ok(), "{}", row.what);
            assert_eq!(
                rows.iter().filter(|r| r.what == row.what).count(),
                1,
                "{}",
                row.what
            );
        }
    }
}
