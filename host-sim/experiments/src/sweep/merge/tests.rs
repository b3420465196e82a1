use super::*;
use std::fs;
use tempfile::TempDir;

fn file(folder: &TempDir, name: &str, head: &str, numbers: &[u64], tail: &str) -> PathBuf {
    let columns = ["world".to_owned()].into_iter();
    let header = ResultsHeader::new(head, "00", 6, columns);
    let rows: String = numbers
        .iter()
        .map(|number| format!("{number},w\n"))
        .collect();
    let path = folder.path().join(name);
    fs::write(&path, format!("{}{rows}{tail}", header.text())).expect("a file");
    path
}

fn merged(paths: &[PathBuf]) -> Result<String, String> {
    let mut merged = merge(paths).map_err(|error| error.to_string())?;
    let mut text = merged.header().text().to_owned();
    merged
        .rows(&mut |row| {
            text += std::str::from_utf8(row).expect("text");
            Ok::<_, BadInput>(())
        })
        .map_err(|error| error.to_string())?;
    Ok(text)
}

#[test]
fn shards_in_any_order_make_the_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = file(&folder, "whole", "s", &[0, 1, 2, 3, 4, 5], "");
    let shards = [
        file(&folder, "b", "s", &[1, 3, 5], ""),
        file(&folder, "e", "s", &[], ""),
        file(&folder, "a", "s", &[0, 2, 4], ""),
    ];
    let text = merged(&shards).expect("all there");
    assert_eq!(text, fs::read_to_string(&whole).expect("text"));
    assert_eq!(merged(&[whole]), Ok(text));
}

#[test]
fn gaps_doubles_and_strangers_are_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let part = |name: &str, numbers: &[u64], tail: &str| file(&folder, name, "s", numbers, tail);
    let even = part("even", &[0, 2, 4], "");
    let say = |other: PathBuf| merged(&[even.clone(), other]).expect_err("not a whole sweep");
    for (other, words) in [
        (
            part("gap", &[1, 5], ""),
            ["episode 3 of 6 is missing", "even, "],
        ),
        (
            part("short", &[1, 3], ""),
            ["episode 5 of 6 is missing", "short"],
        ),
        (
            part("double", &[1, 2, 3, 5], ""),
            ["episode 2 is in ", "double"],
        ),
        (
            part("last", &[1, 3, 5, 5], ""),
            ["last: episode 5 follows", "episode 5"],
        ),
        (
            part("mixed", &[3, 1, 5], ""),
            ["episode 1 of 6 is missing", "mixed"],
        ),
        (
            part("more", &[1, 3, 5, 6], ""),
            ["more: episode 6 is not one of", "sweep's 6"],
        ),
        (
            part("torn", &[1, 3], "5,\"w\n"),
            ["torn: the row after episode 3", "is torn"],
        ),
        (
            part("bad", &[1, 3], "x,w\n"),
            ["bad: the row after episode 3", "not a row"],
        ),
        (
            file(&folder, "foreign", "t", &[1, 3, 5], ""),
            ["foreign: holds results of another", "sweep t"],
        ),
        (
            folder.path().join("none"),
            ["none: there is no such file", "none"],
        ),
    ] {
        let error = say(other);
        assert!(
            words.iter().all(|word| error.contains(word)),
            "{words:?}: {error}"
        );
    }
    // The only possible duplicate of episode 0 is itself.
    let error = merged(&[even.clone(), even.clone()]).expect_err("twice the same");
    assert!(error.contains("episode 0 is in "), "{error}");
}
