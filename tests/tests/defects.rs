//! `tests/defects.toml` matches the present code; `tests/extra defects` checks that the defects are
//! detected.

use std::collections::HashSet;
use tests::defects::{builds, list};
use tests::root;

#[test]
fn every_place_to_break_stands_in_its_file_once() {
    let defects = list().expect("a list");
    assert!(defects.len() > 50, "{} defects", defects.len());
    let mut wrong = Vec::new();
    for defect in &defects {
        let text = std::fs::read_to_string(root().join(&defect.file));
        let named = |why: String| format!("{}: {why}", defect.what);
        match text {
            Ok(text) => wrong.extend(defect.put_into(&text).err().map(named)),
            Err(error) => wrong.push(named(format!("{}: {error}", defect.file.display()))),
        }
        wrong.extend(builds(&defect.check).err().map(named));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Two defects with the same description would be ambiguous in the table.
#[test]
fn every_defect_has_words_of_its_own() {
    let defects = list().expect("a list");
    let mut seen = HashSet::new();
    for defect in &defects {
        assert!(seen.insert(&defect.what), "twice: {}", defect.what);
    }
}

/// The rows are printed by `tests/extra defects`, which checks the detection.
#[test]
fn the_published_table_has_every_defect() {
    let page = std::fs::read_to_string(root().join("docs/defects.md")).expect("the page");
    let lines = page.lines();
    let rows: HashSet<&str> = lines.filter(|line| line.ends_with("| yes |")).collect();
    let defects = list().expect("a list");
    let expected = defects.iter().map(|defect| defect.row(true));
    let missing: Vec<_> = expected
        .filter(|row| !rows.contains(row.as_str()))
        .collect();
    assert!(
        missing.is_empty(),
        "docs/defects.md lacks\n{}",
        missing.join("\n")
    );
    assert_eq!(rows.len(), defects.len(), "docs/defects.md has more");
}
