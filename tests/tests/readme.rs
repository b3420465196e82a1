//! The README's commands run as printed, and its links have targets.
//!
//! Lines of `sh` blocks that start with `cargo run` or `host-sim` run in an empty folder with
//! `host-sim/worlds` and `docs`. A comment with minutes or hours marks a long run: only its command
//! line is parsed, with `--help`.

use std::fs;
use std::path::Path;
use tests::{host_sim, root, words};

fn readme() -> String {
    fs::read_to_string(root().join("README.md")).expect("README.md")
}

/// A command of the README: its arguments, and whether it takes minutes.
struct Printed {
    line: String,
    args: Vec<String>,
    long: bool,
}

/// The commands in the fenced `sh` blocks; a backslash at the end continues a line.
fn commands(text: &str) -> Vec<Printed> {
    let mut inside = false;
    let mut block = String::new();
    for line in text.lines() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            inside = !inside && ["sh", "bash", "console"].contains(&language.trim());
        } else if inside {
            block += line.trim_start().trim_start_matches("$ ");
            block += "\n";
        }
    }
    let block = block.replace("\\\n", " ");
    block.lines().filter_map(command).collect()
}

fn command(line: &str) -> Option<Printed> {
    let (typed, comment) = line.split_once(" #").unwrap_or((line, ""));
    let typed = typed.split(['|', '>']).next().unwrap_or_default();
    let words = words(typed);
    let args = match words.first().map(String::as_str) {
        Some("cargo")
            if words
                .get(1)
                .is_some_and(|word| word == "run" || word == "demo") =>
        {
            if words.iter().any(|word| word == "--example") {
                return None;
            }
            let own = words.iter().position(|word| word == "--");
            own.map_or(Vec::new(), |at| words[at + 1..].to_vec())
        }
        Some(program) if program.ends_with("host-sim") => words[1..].to_vec(),
        _ => return None,
    };
    Some(Printed {
        line: line.to_owned(),
        args,
        long: ["minute", "hour"].iter().any(|word| comment.contains(word)),
    })
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder of the repository") {
        let path = entry.expect("an entry").path();
        let target = to.join(path.file_name().expect("a name"));
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).expect("a copy");
        }
    }
}

#[test]
fn its_commands_run() {
    let program = host_sim!();
    for folder in ["host-sim/worlds", "docs"] {
        copy(&root().join(folder), &program.folder().join(folder));
    }
    let printed = commands(&readme());
    assert!(printed.len() >= 3, "{} commands found", printed.len());
    for Printed {
        line,
        mut args,
        long,
    } in printed
    {
        if long {
            args.push("--help".to_owned());
        }
        let output = program.run(&args);
        assert_eq!(output.code, Some(0), "{line}\n{}", output.stderr);
    }
}

#[test]
fn its_links_lead_somewhere() {
    let text = readme();
    let mut found = 0;
    let sources = text
        .split("src=\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next());
    let links = text
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next());
    for link in links.chain(sources) {
        let path = link.split(['#', ' ']).next().unwrap_or_default();
        if path.is_empty() || path.contains("://") || path.starts_with("mailto:") {
            continue;
        }
        found += 1;
        assert!(root().join(path).exists(), "the README links to {path}");
    }
    assert!(found >= 1, "the README links to nothing");
}

#[test]
fn commands_are_told_from_text() {
    let text = "```sh\ncargo run --release\n$ cargo run --release -- run --world 'a b' \\\n  --json > x  # 2 minutes\n\
                tests/run\nhost-sim worlds # list\n```\n```toml\ncargo run\n```\n";
    let found: Vec<_> = commands(text)
        .into_iter()
        .map(|c| (c.args.join("|"), c.long))
        .collect();
    let wanted = [
        ("", false),
        ("run|--world|a b|--json", true),
        ("worlds", false),
    ];
    assert_eq!(found, wanted.map(|(args, long)| (args.to_owned(), long)));
}
