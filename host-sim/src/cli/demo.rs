//! `host-sim demo`: the paper's experiment with its pictures; the default command.

use super::output::{bar, prepare};
use super::run::Preset;
use super::{CliError, summary, table};
use arena::sonar::SonarModel;
use arena::world::World;
use clap::Args;
use files::error::BadInput;
use sim::behavior::Behavior;
use sim::episode::{self, Phase, Setup};
use std::io::Write;
use std::path::PathBuf;

/// Flags of the `demo` command.
#[derive(Debug, Clone, Args)]
pub struct DemoArgs {
    /// Folder for the pictures and the page
    #[arg(long, value_name = "DIR", default_value = "out/demo")]
    out: PathBuf,
    /// Seed of all randomness
    #[arg(long, value_name = "SEED", default_value_t = DEMO_SEED)]
    seed: u64,
}

const DEMO_SEED: u64 = 6;

impl Default for DemoArgs {
    fn default() -> Self {
        Self {
            out: "out/demo".into(),
            seed: DEMO_SEED,
        }
    }
}

/// Steps after exploring: several times the length of the path in Fig. 5.
const STEPS: u32 = 300;

const NEXT: [&str; 6] = [
    "cargo run --release -- run --world random:7 --out out/room",
    "cargo run --release -- run --world random:1..=1000 --shield off --json",
    "cargo run --release -- run --world random:1..=100 --preset touzet --shield off",
    "cargo run --release -- run --sonar nomad",
    "cargo run --release -- worlds",
    "cargo run --release -- --help",
];

/// Runs the demo.
///
/// # Errors
/// When the folder cannot be written, or standard output is closed.
pub fn demo(args: &DemoArgs, out: &mut impl Write) -> Result<(), CliError> {
    prepare(&args.out)?;
    let world = World::paper()?;
    let preset = Preset::Default;
    let setup = Setup {
        config: preset.config(),
        preset: preset.name().to_owned(),
        behavior: Behavior::Avoid,
        explore_moves: 100,
        steps: STEPS,
        seed: args.seed,
        sonar: SonarModel::Ideal,
        turret: preset.turret(),
        robot: None,
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: true,
    };
    let progress = bar(1, "");
    let episode = episode::run(&world, &setup, |phase, done, total| {
        progress.set_prefix(match phase {
            Phase::Explore => "explore",
            Phase::Learn => "learn",
            Phase::Seek => "avoid",
        });
        progress.set_length(u64::from(total));
        progress.set_position(u64::from(done));
    })
    .map_err(|failure| BadInput::new(failure.to_string()))?;
    progress.set_prefix("draw");
    let rows = summary::rows(&episode.report);
    let mut files = Vec::new();
    if let Some(recording) = &episode.recording {
        files = plots::demo::write(&args.out, recording, &rows, &NEXT)?;
    }
    progress.finish_and_clear();
    print(out, &rows, &files)
}

fn print(
    out: &mut impl Write,
    rows: &[(String, String)],
    files: &[PathBuf],
) -> Result<(), CliError> {
    writeln!(
        out,
        "A Nomad 200 explored with 100 random moves, learned two maps of 16 neurons and avoided obstacles:\n"
    )?;
    let cells: Vec<_> = rows
        .iter()
        .map(|(label, value)| vec![label.clone(), value.clone()])
        .collect();
    out.write_all(table::plain(&["", "result"], &cells, &[]).as_bytes())?;
    if let Some(page) = files.last() {
        writeln!(
            out,
            "\nPictures: open {} in a browser ({} files beside it)",
            page.display(),
            files.len() - 1
        )?;
    }
    writeln!(out, "\nWhat to try next:")?;
    for command in NEXT {
        writeln!(out, "  {command}")?;
    }
    Ok(())
}
