//! Rules of the layout: dependencies between crates, length of files, head of each file.
//!
//! `UPDATE_GOLDEN=1 cargo test -p tests --test all layout::` rewrites the table in
//! docs/architecture.md.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use tests::root;

/// Each package and the packages of this workspace that it may depend on, tests excluded.
const MAY_KNOW: [(&str, &[&str]); 13] = [
    ("shared/som", &[]),
    ("shared", &["tinysom"]),
    ("firmware", &["amp"]),
    ("host-sim/files", &[]),
    ("host-sim/arena", &["files"]),
    ("host-sim/sim", &["amp", "arena", "files"]),
    ("host-sim/remote", &["amp", "arena", "files", "sim"]),
    ("host-sim/nomad200", &["amp", "arena", "remote", "sim"]),
    ("host-sim/plots", &["arena", "files", "sim"]),
    (
        "host-sim/datasets",
        &["arena", "files", "plots", "sim", "tinysom"],
    ),
    (
        "host-sim/experiments",
        &[
            "amp", "arena", "datasets", "files", "plots", "sim", "tinysom",
        ],
    ),
    (
        "host-sim/view",
        &["amp", "arena", "files", "nomad200", "remote", "sim"],
    ),
    (
        "host-sim",
        &[
            "amp",
            "arena",
            "datasets",
            "experiments",
            "files",
            "nomad200",
            "plots",
            "remote",
            "sim",
            "tinysom",
            "view",
        ],
    ),
];

/// Longest file in lines of production code.
const MAX_LINES: usize = 400;

/// The table must be rewritten when a file's length differs by more than this share.
const STALE_SHARE: f64 = 0.2;

/// One source file.
struct SourceFile {
    path: String,
    purpose: String,
    lines: usize,
    explains_length: bool,
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Packages of this workspace that a manifest depends on, tests excluded.
fn dependencies(folder: &str) -> Vec<String> {
    let manifest = text(&root().join(folder).join("Cargo.toml"));
    let manifest: toml::Table = manifest.parse().expect("a manifest");
    let ours = [
        "amp",
        "tinysom",
        "firmware",
        "host-sim",
        "files",
        "arena",
        "sim",
        "remote",
        "nomad200",
        "plots",
        "datasets",
        "experiments",
        "view",
    ];
    let table = manifest.get("dependencies").and_then(toml::Value::as_table);
    let names = table.into_iter().flatten().map(|(name, _)| name.clone());
    names.filter(|name| ours.contains(&name.as_str())).collect()
}

#[test]
fn every_crate_knows_only_what_lies_below_it() {
    for (folder, may_know) in MAY_KNOW {
        for name in dependencies(folder) {
            assert!(
                may_know.contains(&name.as_str()),
                "{folder} must not depend on {name}"
            );
        }
    }
}

#[test]
fn the_list_of_crates_is_complete() {
    let manifest: toml::Table = text(&root().join("Cargo.toml"))
        .parse()
        .expect("a manifest");
    let members = manifest["workspace"]["members"].as_array().expect("a list");
    for member in members.iter().filter_map(toml::Value::as_str) {
        let is_listed = MAY_KNOW.iter().any(|(folder, _)| *folder == member);
        let is_elsewhere = member.starts_with("firmware/") || member == "tests";
        assert!(
            is_listed || is_elsewhere,
            "{member} is in no row of MAY_KNOW"
        );
    }
}

/// All source files of a folder, in order, without tests and benchmarks.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = fs::read_dir(folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .map(|entry| entry.expect("an entry").path())
        .collect();
    entries.sort();
    for path in entries {
        let name = path
            .file_name()
            .and_then(|name| name.to_str())
            .unwrap_or("");
        let is_apart = ["target", "tests", "benches", "goldens", "fuzz", "chip"].contains(&name);
        if path.is_dir() && !is_apart {
            sources(&path, found);
        } else if name.ends_with(".rs") && name != "tests.rs" && name != "fixture.rs" {
            found.push(path);
        }
    }
}

fn source(path: &Path) -> SourceFile {
    let text = text(path);
    let is_head = |line: &&str| line.starts_with("//!");
    let head: Vec<&str> = text
        .lines()
        .take_while(is_head)
        .map(|line| line.trim_start_matches("//!").trim())
        .collect();
    let first: Vec<&str> = head
        .iter()
        .copied()
        .take_while(|line| !line.is_empty())
        .collect();
    let paragraph = first.join(" ");
    let end = paragraph.find(". ").map_or(paragraph.len(), |at| at + 1);
    let production = text.find("\n#[cfg(test)]\nmod ").unwrap_or(text.len());
    SourceFile {
        path: path
            .strip_prefix(root())
            .expect("inside the project")
            .to_string_lossy()
            .replace('\\', "/"),
        // Links of rustdoc have no target on a page.
        purpose: paragraph[..end]
            .trim_end_matches([':', '.'])
            .replace("[`", "`")
            .replace("`]", "`"),
        lines: text[..production].lines().count(),
        explains_length: head.iter().any(|line| line.contains("this file's length")),
    }
}

fn all() -> Vec<SourceFile> {
    let mut found = Vec::new();
    for folder in ["shared", "firmware", "host-sim"] {
        sources(&root().join(folder), &mut found);
    }
    let is_source = |path: &&PathBuf| path.components().any(|part| part.as_os_str() == "src");
    found
        .iter()
        .filter(is_source)
        .map(|path| source(path))
        .collect()
}

#[test]
fn no_file_is_long_without_saying_why() {
    let long: Vec<_> = all()
        .into_iter()
        .filter(|file| !file.explains_length && file.lines > MAX_LINES)
        .map(|file| format!("{}: {} lines", file.path, file.lines))
        .collect();
    assert!(long.is_empty(), "{long:#?}");
}

/// Longest line of a comment, columns.
const MAX_COLUMNS: usize = 100;

/// Comments wider than that, drawings in fences and tables aside: path, line, columns.
fn wide_comments(path: &Path) -> Vec<(PathBuf, usize, usize)> {
    let mut is_drawing = false;
    let mut found = Vec::new();
    for (index, line) in text(path).lines().enumerate() {
        let comment = line.trim_start();
        if !comment.starts_with("//") {
            is_drawing = false;
            continue;
        }
        is_drawing ^= comment.contains("```");
        let columns = line.chars().count();
        let is_table = comment.contains("| ");
        if !is_drawing && !is_table && columns > MAX_COLUMNS {
            found.push((path.to_path_buf(), index + 1, columns));
        }
    }
    found
}

#[test]
fn no_comment_is_wider_than_a_screen() {
    let mut files = Vec::new();
    for folder in ["shared", "firmware", "host-sim", "tests/src", "tests/tests"] {
        sources(&root().join(folder), &mut files);
    }
    let wide: Vec<_> = files.iter().flat_map(|path| wide_comments(path)).collect();
    assert!(wide.is_empty(), "{wide:#?}");
}

#[test]
fn every_file_says_what_it_is_for() {
    for file in all() {
        assert!(!file.purpose.is_empty(), "{} has no head", file.path);
    }
}

/// The table of files, a section per package.
fn table(files: &[SourceFile]) -> String {
    let mut packages: BTreeMap<&str, Vec<&SourceFile>> = BTreeMap::new();
    for file in files {
        let package = file.path.split("/src").next().unwrap_or("");
        packages.entry(package).or_default().push(file);
    }
    let mut table = String::new();
    for (package, files) in packages {
        let lines: usize = files.iter().map(|file| file.lines).sum();
        let _ = write!(
            table,
            "\n### {package}, {lines} lines\n\n| file | what it is for | lines |\n| --- | --- | --: |\n"
        );
        for file in files {
            let name = file
                .path
                .trim_start_matches(package)
                .trim_start_matches("/src/");
            let purpose = file.purpose.replace('|', "\\|");
            let _ = writeln!(
                table,
                "| [{name}](../{}) | {purpose} | {} |",
                file.path, file.lines
            );
        }
    }
    table
}

const BEGIN: &str = "<!-- files: written by tests/tests/layout.rs -->\n";

#[test]
fn the_page_on_architecture_lists_every_file() {
    let path = root().join("docs/architecture.md");
    let page = text(&path);
    let (before, listed) = page.split_once(BEGIN).expect("the place of the table");
    let files = all();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        fs::write(&path, format!("{before}{BEGIN}{}", table(&files))).expect("written");
        return;
    }
    let hint = "UPDATE_GOLDEN=1 cargo test -p tests --test all layout::";
    for file in &files {
        let place = format!("](../{}) | ", file.path);
        let row = listed.lines().find(|line| line.contains(&place));
        let row = row.unwrap_or_else(|| panic!("{} is not listed: {hint}", file.path));
        let cells: Vec<_> = row.rsplit(" | ").collect();
        let lines: f64 = cells[0].trim_end_matches(" |").parse().expect("a number");
        let drift = (lines - file.lines as f64).abs();
        assert!(drift <= 20.0 + STALE_SHARE * lines, "{row}: {hint}");
        assert!(
            row.contains(&file.purpose.replace('|', "\\|")),
            "{row}: {hint}"
        );
    }
    let rows = listed.lines().filter(|line| line.contains("](../")).count();
    assert_eq!(rows, files.len(), "files that are gone are listed: {hint}");
}
