//! Writes the page of figures, and reads it back: rows that are not measured again keep their
//! value.

use crate::list::FigureList;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A figure with its origin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeasuredFigure {
    /// Value with unit.
    pub value: String,
    /// YYYY-MM-DD.
    pub day: String,
    /// Short hash; `+` with uncommitted changes.
    pub commit: String,
    /// Processor, cores, compiler.
    pub machine: String,
    /// The command that printed it.
    pub command: String,
}

/// All figures by name.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Page {
    /// Figures by the name of their row.
    pub measured: BTreeMap<String, MeasuredFigure>,
}

const HEAD: &str = "# Figures\n\n\
    Written by `cargo run -p tests --bin figures`, which runs each command and extracts its figures from the output. \
    Figures that miss their target are listed like the others. Instructions are exact and the same on every machine; \
    times and derived figures are for the named machine.\n";
const TABLE: &str = "| figure | value | target | measured | commit | machine | command |\n\
    | --- | ---: | ---: | --- | --- | --- | --- |\n";
const MACHINES: &str = "## Machines\n";

impl Page {
    /// The page as Markdown, in the order of `list`.
    pub fn text(&self, list: &FigureList) -> String {
        let mut machines: Vec<&str> = self.measured.values().map(|m| m.machine.as_str()).collect();
        machines.sort_unstable();
        machines.dedup();
        let mut text = HEAD.to_string();
        let mut group = "";
        for command in &list.commands {
            if command.group != group {
                group = &command.group;
                let _ = write!(text, "\n## {group}\n\n{TABLE}");
            }
            for row in &command.row {
                let aim = escaped(&row.aim);
                let line = match self.measured.get(&row.what) {
                    Some(found) => found.line(&machines, &row.what, &aim),
                    None => format!(
                        "| {} | not measured | {aim} | | | | `{}` |\n",
                        escaped(&row.what),
                        escaped(&command.run)
                    ),
                };
                text += &line;
            }
        }
        let _ = write!(text, "\n{MACHINES}\n");
        for (index, machine) in machines.iter().enumerate() {
            let _ = writeln!(text, "{}. {machine}", index + 1);
        }
        text
    }

    /// Reads the output of [`Page::text`]; skips all other lines.
    pub fn parse(text: &str) -> Self {
        let (rows, machines) = text.split_once(MACHINES).unwrap_or((text, ""));
        let machine = |line: &str| line.split_once(". ").map(|(_, name)| name.to_string());
        let machines: Vec<_> = machines.lines().filter_map(machine).collect();
        let measured = rows
            .lines()
            .filter_map(|line| parsed(line, &machines))
            .collect();
        Self { measured }
    }
}

impl MeasuredFigure {
    fn line(&self, machines: &[&str], what: &str, aim: &str) -> String {
        let machine = machines.iter().position(|&name| name == self.machine);
        let machine = machine.map_or(0, |index| index + 1);
        let (what, value, command) = (escaped(what), escaped(&self.value), escaped(&self.command));
        let Self { day, commit, .. } = self;
        format!("| {what} | {value} | {aim} | {day} | {commit} | {machine} | `{command}` |\n")
    }
}

fn escaped(text: &str) -> String {
    text.replace('|', "\\|")
}

/// A row's cells; `None` for any other line.
fn parsed(line: &str, machines: &[String]) -> Option<(String, MeasuredFigure)> {
    let line = line.replace("\\|", "\u{0}");
    let line = line.strip_prefix("| ")?.strip_suffix(" |")?;
    let cells: Vec<_> = line
        .split(" | ")
        .map(|cell| cell.replace('\u{0}', "|"))
        .collect();
    let [what, value, _, day, commit, machine, command] = cells.as_slice() else {
        return None;
    };
    let machine = machines.get(machine.parse::<usize>().ok()?.checked_sub(1)?)?;
    let measured = MeasuredFigure {
        value: value.clone(),
        day: day.clone(),
        commit: commit.clone(),
        machine: machine.clone(),
        command: command.trim_matches('`').into(),
    };
    Some((what.clone(), measured))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list() -> FigureList {
        toml::from_str(
            r#"
            [[command]]
            group = "Speed"
            run = "bench | tail"
            [[command.row]]
            what = "steps"
            find = "(x)"
            [[command.row]]
            what = "looks | more"
            find = "(y)"
            aim = "≥ 3"
            "#,
        )
        .expect("a list")
    }

    fn measured(value: &str, machine: &str) -> MeasuredFigure {
        MeasuredFigure {
            value: value.into(),
            day: "2026-01-02".into(),
            commit: "abc+".into(),
            machine: machine.into(),
            command: "bench | tail".into(),
        }
    }

    #[test]
    fn a_page_is_read_back_as_it_was_written() {
        let page = Page {
            measured: BTreeMap::from([
                ("steps".into(), measured("3 per second", "one, 2 cores")),
                ("looks | more".into(), measured("4", "another")),
            ]),
        };
        let text = page.text(&list());
        assert_eq!(Page::parse(&text), page, "{text}");
    }

    #[test]
    fn what_was_never_measured_says_so_and_is_read_as_nothing() {
        let text = Page::default().text(&list());
        assert!(
            text.contains("| looks \\| more | not measured | ≥ 3 |"),
            "{text}"
        );
        assert_eq!(Page::parse(&text), Page::default());
    }
}
