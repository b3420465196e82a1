//! Sweeps: same results as `run`, with any kill and any number of shards.

use rand_core::{Rng as _, SeedableRng as _};
use rand_xoshiro::SplitMix64;
use serde::Deserialize;
use std::fs;
use std::process::{Command, Stdio};
use std::time::Duration;
use tests::{Program, ProgramOutput, host_sim, root, words};

/// Twelve kinds of episodes.
const KINDS: &str = r#"
worlds = ["room", "random:2"]
behaviors = ["avoid", "wall-left"]
seeds = [1, 5]
[fixed]
steps = 25
explore = 30
[grid]
far = [2.5]
[[list]]
preset = "touzet"
shield = false
[[list]]
tolerance = 0.1
sonar = "nomad"
"#;

/// Many short ones.
const MANY: &str = r#"
name = "many"
worlds = ["random:1..=10"]
seeds = "1..=5"
[fixed]
steps = 5
explore = 10
epochs = 2
[grid]
far = [1.5, 2.5, 3.5]
"#;
const MANY_COUNT: usize = 150;

fn with(text: &str) -> Program {
    let program = host_sim!();
    program.put("sweep.toml", text);
    program
}

fn read(program: &Program, name: &str) -> String {
    fs::read_to_string(program.folder().join(name)).unwrap_or_default()
}

/// All rows of MANY, from one run.
fn reference() -> String {
    let program = with(MANY);
    let _ = program.ok("sweep sweep.toml --out all.csv");
    let all = read(&program, "all.csv");
    assert_eq!(all.lines().count(), 2 + MANY_COUNT);
    all
}

/// The sentence of a refusal.
fn refused(output: &ProgramOutput) -> &str {
    assert_eq!(output.code, Some(2), "{}", output.stderr);
    assert_eq!(output.stderr.lines().count(), 1, "{}", output.stderr);
    output.stderr.trim_start_matches("host-sim: ").trim_end()
}

#[test]
fn every_row_is_what_run_prints() {
    let program = with(KINDS);
    let _ = program.ok("sweep sweep.toml --out all.csv");
    let text = read(&program, "all.csv");
    let mut lines = text.lines().skip(1);
    let heads: Vec<_> = lines.next().expect("the columns").split(',').collect();
    let mut count = 0;
    for (number, line) in lines.enumerate() {
        // No field of these has a comma.
        let row: Vec<_> = line.split(',').collect();
        let field = |name: &str| {
            let place = heads.iter().position(|head| *head == name);
            *row.get(place.expect(name)).expect(name)
        };
        assert_eq!(field("episode"), number.to_string());
        let mut run = format!(
            "run --json --steps 25 --explore 30 --world {} --behavior {} --seed {}",
            field("world"),
            field("behavior"),
            field("seed")
        );
        for head in heads.iter().filter(|head| head.starts_with("config.")) {
            let key = head.trim_start_matches("config.");
            match (key, field(head)) {
                (_, "") => {}
                ("preset" | "shield" | "sonar", value) => run += &format!(" --{key} {value}"),
                (_, value) => run += &format!(" --set {key}={value}"),
            }
        }
        let json = program.ok(&run);
        let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        for (name, value) in json.as_object().expect("an object") {
            // What a behavior has no figure of is an empty cell.
            let value = match value {
                serde_json::Value::Null => String::new(),
                serde_json::Value::String(text) => text.clone(),
                figure => figure.to_string(),
            };
            assert_eq!(field(name), value, "{name} of {run}");
        }
        count += 1;
    }
    assert_eq!(count, 3 * 2 * 2 * 2);
}

#[test]
fn killed_at_any_moment_it_goes_on_where_it_was() {
    let all = reference();
    let program = with(MANY);
    let mut random = SplitMix64::seed_from_u64(1);
    let (mut kills, mut within) = (0, 0);
    loop {
        let mut child = program
            .command(&words("sweep sweep.toml --out part.csv --threads 2"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        // The first ones and every second one are killed at work: they have just added a row.
        let mut most_us = 60_000;
        if kills < 6 || kills % 2 == 0 {
            let length =
                || fs::metadata(program.folder().join("part.csv")).map_or(0, |file| file.len());
            let before = length();
            while length() <= before && child.try_wait().expect("a child").is_none() {
                std::thread::sleep(Duration::from_micros(100));
            }
            most_us = 1_000;
        }
        std::thread::sleep(Duration::from_micros(random.next_u64() % most_us));
        // SIGKILL; without effect if the process has already ended.
        child.kill().expect("a signal");
        let done = child.wait().expect("an end").success();
        let part = read(&program, "part.csv");
        assert!(all.starts_with(&part), "after {kills} kills: {part}");
        if done {
            break;
        }
        kills += 1;
        within += usize::from(part.len() > 200 && part.len() < all.len());
        assert!(kills < 2_000, "it never comes to an end");
    }
    assert_eq!(read(&program, "part.csv"), all);
    assert!(within >= 3, "of {kills} kills only {within} hit it at work");
    // Nothing is left to run.
    let again = program.run(&words("sweep sweep.toml --out part.csv"));
    assert!(again.stderr.contains("0 episodes in") && again.stderr.contains("150 already done"));
    assert_eq!(read(&program, "part.csv"), all);
}

#[test]
fn shards_merge_into_the_bytes_of_the_whole() {
    let all = reference();
    let program = with(MANY);
    for (shard, threads) in [("0/3", 1), ("1/3", 2), ("2/3", 3)] {
        let _ = program.ok(&format!(
            "sweep sweep.toml --shard {shard} --threads {threads}"
        ));
    }
    let files = [2, 0, 1].map(|shard| format!("out/sweep/many.{shard}-of-3.csv"));
    assert_eq!(program.ok(&format!("merge {}", files.join(" "))), all);

    let merge = |files: &[&str]| program.run(&[&["merge"], files].concat());
    let [last, first, middle] = files.each_ref().map(String::as_str);
    let gap = merge(&[first, last]);
    assert!(
        refused(&gap).starts_with("episode 1 of 150 is missing in out/sweep/many.0-of-3.csv, ")
    );
    let double = merge(&[first, middle, last, middle]);
    assert!(
        refused(&double).contains("many.1-of-3.csv: episode 1 is in out/sweep/many.1-of-3.csv")
    );
    program.put("other.toml", MANY.replace("epochs = 2", "epochs = 3"));
    let _ = program.ok("sweep other.toml --shard 2/3 --out other.csv");
    let foreign = merge(&[first, middle, "other.csv"]);
    assert!(refused(&foreign).starts_with("other.csv: holds results of another sweep"));
    for output in [gap, double, foreign] {
        assert_eq!(output.stdout, "");
    }
    // A sweep does not resume in the file of another sweep or shard.
    let other = program.run(&words("sweep other.toml --out out/sweep/many.0-of-3.csv"));
    assert!(refused(&other).contains("another sweep"));
    let shard = program.run(&words(
        "sweep sweep.toml --shard 1/3 --out out/sweep/many.0-of-3.csv",
    ));
    assert!(refused(&shard).contains("row 1 holds episode 0, but shard 1/3"));
}

#[test]
fn schedulers_name_the_shard() {
    let program = with(MANY);
    for (variables, line, words) in [
        (
            [
                ("SLURM_ARRAY_TASK_ID", "1"),
                ("SLURM_ARRAY_TASK_COUNT", "4"),
            ],
            "",
            "shard 1/4 has 38 episodes",
        ),
        (
            [("JOB_COMPLETION_INDEX", "3"), ("SWEEP_SHARDS", "4")],
            "",
            "shard 3/4 has 37 episodes",
        ),
        (
            [("JOB_COMPLETION_INDEX", "3"), ("SWEEP_SHARDS", "4")],
            "--shard 0/2",
            "shard 0/2 has 75 episodes",
        ),
    ] {
        let mut command =
            program.command(&tests::words(&format!("sweep sweep.toml --dry-run {line}")));
        let output = command
            .envs(variables)
            .output()
            .expect("the program starts");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(text.contains(words), "{text}");
        assert!(
            text.contains("3 points × 1 behaviors × 10 worlds × 5 seeds"),
            "{text}"
        );
    }
    let mut command = program.command(&words("sweep sweep.toml --dry-run"));
    let output = command
        .env("JOB_COMPLETION_INDEX", "0")
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("SWEEP_SHARDS is not"));
    assert!(program.files("out").is_empty());
}

#[test]
fn a_full_disk_is_told_and_nothing_is_lost() {
    let all = reference();
    let program = with(MANY);
    let binary = env!("CARGO_BIN_EXE_host-sim-under-test");
    // File size limit of eight blocks of 512 bytes; a write beyond it is an error, not a signal.
    let script =
        format!("trap '' XFSZ; ulimit -f 8; exec {binary} sweep sweep.toml --out part.csv");
    let output = Command::new("sh")
        .args(["-c", &script])
        .current_dir(program.folder())
        .output()
        .expect("a shell");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(
        error.starts_with("host-sim: part.csv: cannot be written: "),
        "{error}"
    );
    assert_eq!(error.lines().count(), 1, "{error}");
    let part = read(&program, "part.csv");
    assert!(part.len() > 2_000 && all.starts_with(&part));
    let _ = program.ok("sweep sweep.toml --out part.csv");
    assert_eq!(read(&program, "part.csv"), all);
}

#[test]
fn gnu_parallel_shares_it_out() {
    let all = reference();
    let program = with(MANY);
    let binary = env!("CARGO_BIN_EXE_host-sim-under-test");
    let output = Command::new("parallel")
        .args(["--will-cite", "--jobs", "2", binary, "sweep", "sweep.toml"])
        .args([
            "--threads",
            "1",
            "--shard",
            "{}/4",
            ":::",
            "0",
            "1",
            "2",
            "3",
        ])
        .current_dir(program.folder())
        .stdin(Stdio::null())
        .output()
        .expect("GNU parallel is there: apt-get install -y --no-install-recommends parallel");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    let files: Vec<_> = (0..4)
        .map(|shard| format!("out/sweep/many.{shard}-of-4.csv"))
        .collect();
    assert_eq!(program.ok(&format!("merge {}", files.join(" "))), all);
}

#[test]
fn pictures_are_drawn_of_a_sweeps_results() {
    let program = with(KINDS);
    let _ = program.ok("sweep sweep.toml --out all.csv");
    let text = program.ok("plot all.csv --out drawn");
    assert!(text.contains("touzet"), "{text}");
    assert!(text.contains("without contact %"), "{text}");
    let files = program.files("drawn");
    let count = |end: &str| files.iter().filter(|(name, _)| name.ends_with(end)).count();
    let names: Vec<_> = files.iter().map(|(name, _)| name.as_str()).collect();
    for choice in ["far", "preset", "shield", "tolerance", "sonar", "world"] {
        assert!(
            names.contains(&format!("{choice}.svg").as_str()),
            "{names:?}"
        );
    }
    assert_eq!((count(".svg"), count(".png")), (6, 6), "{names:?}");
}

#[derive(Deserialize)]
struct IndexedJob {
    spec: JobSpec,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct JobSpec {
    completions: u64,
    completion_mode: String,
    template: Template,
}

#[derive(Deserialize)]
struct Template {
    spec: Pod,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Pod {
    restart_policy: String,
    containers: Vec<Container>,
}

#[derive(Deserialize)]
struct Container {
    args: Vec<String>,
    env: Vec<Variable>,
}

#[derive(Deserialize)]
struct Variable {
    name: String,
    value: String,
}

/// The documentation's manifest has consistent numbers of shards; it was not run on a cluster.
#[test]
fn the_manifests_shards_are_its_completions() {
    let text = fs::read_to_string(root().join("docs/sweep/job.yaml")).expect("the manifest");
    let job: IndexedJob = serde_saphyr::from_str(&text).expect("a Job");
    assert_eq!(job.spec.completion_mode, "Indexed");
    assert_eq!(job.spec.template.spec.restart_policy, "OnFailure");
    let container = &job.spec.template.spec.containers[0];
    let shards = container
        .env
        .iter()
        .find(|variable| variable.name == "SWEEP_SHARDS");
    assert_eq!(
        shards.expect("SWEEP_SHARDS").value,
        job.spec.completions.to_string()
    );
    assert_eq!(container.args[0], "sweep");
}
