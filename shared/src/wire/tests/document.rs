//! PROTOCOL.md describes the messages of the grammar, all of them and nothing else.

use crate::parameters::{Parameter, Unit};
use std::format;
use std::string::{String, ToString as _};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::vec::Vec;

/// PROTOCOL.md as it is now.
pub(crate) static DOCUMENT: LazyLock<String> =
    LazyLock::new(|| std::fs::read_to_string(PATH).unwrap());
const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/PROTOCOL.md");
const GRAMMAR: &str = include_str!("../schema.txt");

/// Compares a block of the document, by its language, with what it should hold; `UPDATE_GOLDEN=1` writes it anew.
pub(crate) fn check_block(language: &str, wanted: &str) {
    // Several blocks of one file may be written at once.
    static FILE: Mutex<()> = Mutex::new(());
    let _alone = FILE.lock().unwrap_or_else(PoisonError::into_inner);
    let text = std::fs::read_to_string(PATH).unwrap();
    let begin = format!("```{language}\n");
    let (before, rest) = text.split_once(&begin).expect("the block's begin");
    let (documented, after) = rest.split_once("```").expect("the block's end");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(PATH, format!("{before}{begin}{wanted}```{after}")).unwrap();
        return;
    }
    assert_eq!(documented, wanted, "UPDATE_GOLDEN=1 writes it anew");
}

/// A field with its type or a variant with its number, under its path from the symbol on.
type Entry = (String, String);

/// Splits where `is_separator` holds outside all brackets.
fn split(text: &str, is_separator: fn(char) -> bool) -> Vec<&str> {
    let mut depth = 0;
    let parts = text.split(|c| {
        match c {
            '(' | '[' | '<' => depth += 1,
            ')' | ']' | '>' => depth -= 1,
            _ => {}
        }
        depth == 0 && is_separator(c)
    });
    parts
        .map(str::trim)
        .filter(|part| !part.is_empty())
        .collect()
}

/// The entries of a structure's fields.
fn fields(path: &str, text: &str) -> Vec<Entry> {
    let mut entries = Vec::new();
    for field in split(text, char::is_whitespace) {
        let Some((name, kind)) = field.split_once(':') else {
            continue;
        };
        let path = format!("{path}.{name}");
        match kind
            .strip_prefix('(')
            .and_then(|kind| kind.strip_suffix(')'))
        {
            Some(variants) => {
                entries.push((path.clone(), "enum".into()));
                entries.extend(body(&path, variants));
            }
            None => entries.push((path, kind.into())),
        }
    }
    entries
}

/// The entries of what stands behind a symbol: variants or fields.
fn body(path: &str, text: &str) -> Vec<Entry> {
    if !text.starts_with(|c: char| c.is_ascii_digit()) {
        return fields(path, text);
    }
    let variant = |text: &str| {
        let (number, rest) = text.split_once(' ').expect("a number and a name");
        let (name, rest) = rest.split_once(' ').unwrap_or((rest, ""));
        let path = format!("{path}.{name}");
        let mut entries = std::vec![(path.clone(), number.to_string())];
        entries.extend(fields(&path, rest));
        entries
    };
    let variants = split(text, |c| c == '|').into_iter();
    variants.flat_map(variant).collect()
}

fn of_grammar(grammar: &str) -> Vec<Entry> {
    let lines = grammar.lines().filter(|line| !line.starts_with('#'));
    let text: String = lines.map(|line| format!("\n{line}")).collect();
    let joined = text.replace("\n  ", "  ");
    let symbols = joined.lines().filter_map(|line| line.split_once(" = "));
    let entries = symbols.flat_map(|(symbol, text)| body(symbol.trim(), text.trim()));
    entries.collect()
}

/// The section under a heading of the second level.
fn section(title: &str) -> &'static str {
    let (_, rest) = DOCUMENT
        .split_once(&format!("\n## {title}\n"))
        .expect(title);
    rest.split("\n## ").next().unwrap_or(rest)
}

/// The cells of a table's row, without backquotes.
fn cells(row: &str) -> Vec<String> {
    let row = row.trim().trim_matches('|').replace('`', "");
    row.split('|').map(|cell| cell.trim().to_string()).collect()
}

/// Rows of the tables of fields, each behind its symbol.
fn rows() -> Vec<(String, Vec<String>)> {
    let mut symbol = "";
    let mut rows = Vec::new();
    for line in section("Fields").lines() {
        if let Some(heading) = line.strip_prefix("### ") {
            symbol = heading;
        } else if line.starts_with("| `") {
            rows.push((symbol.to_string(), cells(line)));
        }
    }
    rows
}

#[test]
fn every_field_and_variant_is_documented_once_and_no_other() {
    let documented = rows().into_iter().map(|(symbol, cells)| {
        assert!(cells.len() >= 3, "{symbol} {cells:?}");
        (format!("{symbol}.{}", cells[0]), cells[1].clone())
    });
    let mut documented: Vec<_> = documented.collect();
    let mut wanted = of_grammar(GRAMMAR);
    assert!(wanted.len() > 290, "{} entries", wanted.len());
    documented.sort();
    wanted.sort();
    let lacking: Vec<_> = wanted
        .iter()
        .filter(|entry| !documented.contains(entry))
        .collect();
    let surplus: Vec<_> = documented
        .iter()
        .filter(|entry| !wanted.contains(entry))
        .collect();
    assert!(
        lacking.is_empty() && surplus.is_empty(),
        "lacking {lacking:?}, surplus {surplus:?}"
    );
    assert_eq!(documented, wanted, "one of them is there twice");
}

/// The unit that a field's name or type asks for.
fn unit(name: &str, kind: &str) -> Option<&'static str> {
    let by_name = [
        ("_mm_s2", "mm/s²"),
        ("_mm_s", "mm/s"),
        ("_mm", "mm"),
        ("_ms", "ms"),
        ("_q16", "2⁻¹⁶"),
        ("_q14", "2⁻¹⁴"),
        ("_q8", "2⁻⁸"),
    ];
    let found = by_name.iter().find(|(end, _)| name.ends_with(end));
    let weight = kind.contains("weight").then_some("2⁻¹³");
    found.map(|(_, unit)| *unit).or(weight)
}

#[test]
fn every_number_has_its_unit() {
    for (symbol, cells) in rows() {
        let [name, kind, documented, meaning] = &cells[..] else {
            continue;
        };
        let first = documented.split(',').next();
        if let Some(unit) = unit(name, kind) {
            assert_eq!(first, Some(unit), "{symbol}.{name}");
        }
        let integers = ["u8", "u16", "u32", "u64", "i16", "i32"];
        if integers.iter().any(|integer| kind.contains(integer)) {
            assert_ne!(first, Some("–"), "{symbol}.{name}");
        }
        assert!(!meaning.is_empty(), "{symbol}.{name}");
    }
}

#[test]
fn the_table_of_parameters_holds_their_units_and_ranges() {
    let rows = section("Parameters").lines().map(cells);
    let rows = rows.filter(|cells| cells[0].parse::<u8>().is_ok());
    let rows: Vec<_> = rows.map(|cells| cells[..5].to_vec()).collect();
    let wanted = Parameter::ALL
        .iter()
        .enumerate()
        .map(|(number, parameter)| {
            let spec = parameter.spec();
            let unit = match spec.unit {
                Unit::Count => "count".into(),
                unit => unit.to_string(),
            };
            let (least, greatest) = (spec.least.to_string(), spec.greatest.to_string());
            std::vec![
                number.to_string(),
                parameter.name().into(),
                unit,
                least,
                greatest
            ]
        });
    assert_eq!(rows, wanted.collect::<Vec<_>>());
}

/// The bytes in front of two blanks, line by line.
#[test]
fn the_frame_taken_apart_is_the_example() {
    let (_, block) = DOCUMENT.split_once("```bytes\n").expect("a block of bytes");
    let (block, _) = block.split_once("```").expect("the block's end");
    let bytes = block.lines().filter_map(|line| line.split("  ").next());
    let whole = bytes.collect::<Vec<_>>().join(" ");
    let example = format!("to mind, scan\n{whole}\n");
    assert!(DOCUMENT.contains(&example), "{whole}");
}
