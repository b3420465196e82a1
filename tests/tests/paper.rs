//! The `paper` command: facts that hold for every seed, and same bytes with any number of threads.

use std::ffi::OsStr;
use tests::{Program, host_sim, root, words};

const SMALL: &str = "paper --rooms 3 --worlds 1 --seeds 1 --times 2 --draws 2 --out page";

/// Standard output and files of a small run with this number of threads.
fn made(threads: &str, flags: &str) -> (String, Vec<(String, Vec<u8>)>) {
    let program: Program = host_sim!();
    let mut command = program.command(&words(&format!("{SMALL} {flags}")));
    let output = command
        .env("RAYON_NUM_THREADS", OsStr::new(threads))
        .output()
        .expect("the program starts");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    let stdout = String::from_utf8(output.stdout).expect("text");
    (stdout, program.files("page"))
}

fn text<'a>(files: &'a [(String, Vec<u8>)], name: &str) -> &'a str {
    let (_, bytes) = files
        .iter()
        .find(|(file, _)| file == name)
        .unwrap_or_else(|| panic!("{name} is missing"));
    std::str::from_utf8(bytes).expect("text")
}

#[test]
fn the_page_is_whole_and_the_same_on_any_number_of_threads() {
    let (stdout, files) = made("1", "");
    let (again, twice) = made("3", "");
    assert_eq!(stdout, again);
    let names: Vec<_> = files.iter().map(|(name, _)| name.as_str()).collect();
    let figures = [
        "figure-1",
        "figure-2",
        "figure-3",
        "figure-3-literal",
        "figure-4",
        "figure-5",
        "figure-5-literal",
    ];
    let mut wanted: Vec<_> = ["claims.csv", "claims.md", "index.html"]
        .map(str::to_owned)
        .to_vec();
    for figure in figures {
        wanted.extend(["png", "svg"].map(|ending| format!("{figure}.{ending}")));
    }
    wanted.sort_unstable();
    assert_eq!(names, wanted);
    for (one, other) in files.iter().zip(&twice) {
        assert!(one == other, "{} differs", one.0);
    }
    let page = text(&files, "index.html");
    for figure in figures {
        assert!(
            page.contains(&format!("<img src=\"{figure}.svg\"")),
            "{figure}"
        );
    }
    assert!(
        !page.contains("http"),
        "the page needs nothing from elsewhere"
    );
    claims(&stdout, &files);
}

/// Checks the rows of the table that hold for all rooms.
fn claims(stdout: &str, files: &[(String, Vec<u8>)]) {
    let table = text(files, "claims.md");
    let rows: Vec<Vec<&str>> = table
        .lines()
        .skip(2)
        .map(|line| line.trim_matches('|').split(" | ").map(str::trim).collect())
        .collect();
    assert!(rows.len() >= 30, "{} claims", rows.len());
    let page = text(files, "index.html");
    assert_eq!(page.matches("<tr><td>").count(), rows.len());
    assert_eq!(text(files, "claims.csv").lines().count(), rows.len() + 1);
    let verdicts = [
        "holds",
        "holds partly",
        "does not hold",
        "not testable here",
    ];
    let row = |words: &str| -> &Vec<&str> {
        let found = rows.iter().find(|row| row[1].contains(words));
        found.unwrap_or_else(|| panic!("{words} is not in the table"))
    };
    for row in &rows {
        assert_eq!(row.len(), 6, "{row:?}");
        assert!(verdicts.contains(&row[5]), "{row:?}");
        assert!(stdout.contains(row[1]) && !row[3].is_empty(), "{row:?}");
        assert!(
            row[5] == "not testable here" || !row[2].is_empty(),
            "{row:?}"
        );
        assert!(
            !row[3].contains("NaN") && !row[3].contains("inf "),
            "{row:?}"
        );
    }
    let docs = std::fs::read_to_string(root().join("docs/paper.md")).expect("docs/paper.md");
    for row in &rows {
        assert!(docs.contains(row[1]), "docs/paper.md lacks {}", row[1]);
    }
    // Properties of the method, not of the rooms.
    for (words, verdict) in [
        ("each neuron represents 1/32", "holds"),
        ("neurons code preferably these 2 regions", "holds"),
        ("devoid of input points", "holds"),
        ("larger fields of attraction", "holds"),
        ("extremely few similar ones", "holds"),
        ("need no learning iterations", "holds partly"),
    ] {
        assert_eq!(row(words)[5], verdict, "{:?}", row(words));
    }
    let beside = row("best results achieved with reinforcement learning")[3];
    for method in ["default", "touzet", "q-table", "q-som", "q-two-soms"] {
        assert!(beside.contains(method), "{beside}");
    }
    for words in ["using two self-organizing maps", "a neighborhood property"] {
        let [_, _, _, measured, ..] = row(words)[..] else {
            panic!("six columns")
        };
        for preset in ["default: of 7 measures", "probe: of 7 measures"] {
            assert!(measured.contains(preset), "{measured}");
        }
    }
    let at_once = row("another behavior instantaneously");
    let unchanged = at_once[3]
        .matches("nothing learned or moved in 100.0 %")
        .count();
    assert_eq!(unchanged, 3, "{at_once:?}");
}
