//! The command line: parses arguments, runs commands, prints results.
//!
//! Results go to standard output, progress and times to standard error. Exit code 0: success; 1: a
//! comparison differs; 2: bad input, with one sentence that names the file, key or value. A closed
//! pipe ends the program quietly.

mod ablation;
mod arm;
mod barn;
mod behaviors;
mod bodies;
mod bridge;
mod capture;
mod compare;
mod controls;
mod demo;
mod demonstrations;
mod errands;
mod faults;
mod goal;
mod graph;
mod learn;
mod link;
mod log;
mod neurons;
mod nomad;
mod output;
mod paper;
mod patrol;
mod preset;
mod remote;
mod repetition;
mod rivals;
mod robot;
mod run;
mod sequence;
mod setup;
mod summary;
mod sweep;
mod sweep_plot;
mod table;
mod view;
mod worlds;

use clap::{CommandFactory, Parser, Subcommand};
use files::error::BadInput;
use std::io::{self, Write};
use std::process::ExitCode;

pub use run::{RunArgs, SonarChoice};

/// Description in the help.
const ABOUT: &str = "A simulated Nomad 200 learns from 100 random moves and then pursues any goal";

const LONG_ABOUT: &str = "A simulated Nomad 200 with a ring of 16 sonars explores with 100 random moves, learns two \
self-organizing maps of 16 neurons from them, and from then on pursues any goal situation. The controller is the crate \
that runs on the microcontroller.\n\nWithout a command: the demo. It explores, learns and avoids obstacles in the \
arena of the paper's Fig. 5 and writes its pictures to out/demo/.";

#[derive(Debug, Parser)]
#[command(name = "host-sim", version, about = ABOUT, long_about = LONG_ABOUT)]
struct Cli {
    #[command(subcommand)]
    command: Option<CliCommand>,
}

#[derive(Debug, Subcommand)]
enum CliCommand {
    /// Explore, learn and avoid in the paper's arena, with pictures in out/demo/ (the default)
    Demo(demo::DemoArgs),
    /// Run episodes in any worlds: a table, or one JSON object per world
    Run(RunArgs),
    /// Run many episodes: options × worlds × behaviors × seeds, in shards; resumes an interrupted
    /// sweep
    Sweep(sweep::SweepArgs),
    /// Merge the results of a sweep's shards, if none is missing or duplicate
    Merge(sweep::MergeArgs),
    /// Draw the results of a sweep: the outcome by the values of each option
    Plot(sweep_plot::PlotArgs),
    /// Talk to a controller on a chip: print its messages, command it, read and write its state
    Link(link::LinkArgs),
    /// Drive a Nomad 200, real or simulated, over the robot's own protocol
    Bridge(bridge::BridgeArgs),
    /// Simulate a Nomad 200 for any program written for the robot
    Nomad(nomad::NomadArgs),
    /// Train a self-organizing map on any CSV file and report its errors
    Som(datasets::som::SomArgs),
    /// Learn both maps from a logged run of a real robot and test what they recall
    Learn(datasets::learn::LearnArgs),
    /// Drive the worlds of the BARN navigation benchmark: success and score
    Barn(barn::BarnArgs),
    /// List and draw worlds
    Worlds(worlds::WorldsArgs),
    /// List the options of the controller: the keys of --set, with the presets' values
    Settings,
    /// Measure the effect of each option, changed one at a time over many random rooms
    Ablation(ablation::AblationArgs),
    /// Measure what is left of every behavior with something trivial in place of the action map
    Controls(controls::ControlsArgs),
    /// List the behaviors with measured results, without and with the shield
    Behaviors(behaviors::BehaviorsArgs),
    /// Measure robots whose sensors stand anywhere on their bodies
    Bodies(bodies::BodiesArgs),
    /// Write the situation at a pose: a goal for `run --behavior seek:FILE` and `link goal FILE`
    Capture(capture::CaptureArgs),
    /// Measure goals learned from demonstrations, beside goals and rules written by hand
    Demonstrations(demonstrations::DemonstrationsArgs),
    /// Print the goal of a behavior as a file, for `run --goal FILE` and `link goal FILE`, or learn
    /// one from a demonstration
    Goal(goal::GoalArgs),
    /// Measure whether the neuron aimed at is reached, and the nest found, by preset
    Graph(graph::GraphArgs),
    /// Measure whether a behavior improves by repetition, compared with frozen maps
    Repetition(repetition::RepetitionArgs),
    /// Send a robot from place to place, again and again, while its world changes
    Errands(errands::ErrandsArgs),
    /// Recall sequences of patterns by a pair of associative memories, and by simpler methods
    Sequence(sequence::SequenceArgs),
    /// Show a robot a round of stations, and measure whether it goes on by itself
    Patrol(patrol::PatrolArgs),
    /// Measure the effect of a faulty sonar, and the time until its detection
    Faults(faults::FaultsArgs),
    /// Print the content of a log that `run --log FILE.mcap` wrote
    Log(log::LogArgs),
    /// Replay a log: does the controller decide the same, bit for bit? (exit code 1 if not)
    Replay(log::ReplayArgs),
    /// Redraw the paper's figures and measure its claims one by one
    Paper(paper::PaperArgs),
    /// Compare the controller with other methods: hand-written rules, lazy samples, Q-learning
    Compare(compare::CompareArgs),
    /// Arms instead of a mobile base: reach for targets after random moves, around a region
    Arm(arm::ArmArgs),
    /// Compare the controller with other models and quantizers, from the same random moves
    Rivals(rivals::RivalsArgs),
    /// Show a running robot in a browser, with its maps and decisions, and steer it
    View(view::ViewArgs),
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

/// Why a command failed.
#[derive(Debug)]
pub enum CliError {
    /// The input was bad.
    Bad(BadInput),
    /// Standard output could not be written.
    Output(io::Error),
    /// A comparison found a difference.
    Differs(String),
}

impl From<BadInput> for CliError {
    fn from(error: BadInput) -> Self {
        Self::Bad(error)
    }
}

impl From<io::Error> for CliError {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

/// Runs the program with the arguments of the process.
#[must_use]
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let mut out = io::BufWriter::new(io::stdout().lock());
    let done = execute(cli.command, &mut out).and_then(|()| Ok(out.flush()?));
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(CliError::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            ExitCode::SUCCESS
        }
        Err(CliError::Output(error)) => complain(&format!("standard output: {error}")),
        Err(CliError::Differs(sentence)) => {
            eprintln!("host-sim: {sentence}");
            ExitCode::FAILURE
        }
        Err(CliError::Bad(error)) => {
            // Output before the error consists of complete lines: print it.
            let _ = out.flush();
            complain(&error.to_string())
        }
    }
}

fn complain(sentence: &str) -> ExitCode {
    eprintln!("host-sim: {sentence}");
    ExitCode::from(2)
}

fn execute(command: Option<CliCommand>, out: &mut impl Write) -> Result<(), CliError> {
    match command {
        None => demo::demo(&demo::DemoArgs::default(), out),
        Some(CliCommand::Demo(args)) => demo::demo(&args, out),
        Some(CliCommand::Run(args)) => run::run(&args, out),
        Some(CliCommand::Sweep(args)) => sweep::sweep(&args, out),
        Some(CliCommand::Merge(args)) => sweep::merge(&args, out),
        Some(CliCommand::Plot(args)) => sweep_plot::plot(&args, out),
        Some(CliCommand::Link(args)) => link::link(&args, out),
        Some(CliCommand::Bridge(args)) => bridge::bridge(&args, out),
        Some(CliCommand::Nomad(args)) => nomad::nomad(&args, out),
        Some(CliCommand::Som(args)) => run_som(&args, out),
        Some(CliCommand::Learn(args)) => learn::learn(&args, out),
        Some(CliCommand::Barn(args)) => barn::barn(&args, out),
        Some(CliCommand::Worlds(args)) => worlds::worlds(&args, out),
        Some(CliCommand::Settings) => settings(out),
        Some(CliCommand::Ablation(args)) => ablation::ablation(&args, out),
        Some(CliCommand::Controls(args)) => controls::controls(&args, out),
        Some(CliCommand::Behaviors(args)) => behaviors::behaviors(&args, out),
        Some(CliCommand::Capture(args)) => capture::capture(&args, out),
        Some(CliCommand::Goal(args)) => goal::goal(&args, out),
        Some(CliCommand::Graph(args)) => graph::graph(&args, out),
        Some(CliCommand::Demonstrations(args)) => demonstrations::demonstrations(&args, out),
        Some(CliCommand::Repetition(args)) => repetition::repetition(&args, out),
        Some(CliCommand::Errands(args)) => errands::errands(&args, out),
        Some(CliCommand::Sequence(args)) => sequence::sequence(&args, out),
        Some(CliCommand::Patrol(args)) => patrol::patrol(&args, out),
        Some(CliCommand::Faults(args)) => faults::faults(&args, out),
        Some(CliCommand::Bodies(args)) => bodies::bodies(&args, out),
        Some(CliCommand::Log(args)) => log::log(&args, out),
        Some(CliCommand::Replay(args)) => log::replay(&args, out),
        Some(CliCommand::Paper(args)) => paper::paper(&args, out),
        Some(CliCommand::Compare(args)) => compare::compare(&args, out),
        Some(CliCommand::Arm(args)) => arm::arm(&args, out),
        Some(CliCommand::Rivals(args)) => rivals::rivals(&args, out),
        Some(CliCommand::View(args)) => view::view(&args, out),
        Some(CliCommand::Completions { shell }) => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "host-sim", &mut script);
            Ok(out.write_all(&script)?)
        }
    }
}

fn run_som(args: &datasets::som::SomArgs, out: &mut impl Write) -> Result<(), CliError> {
    Ok(writeln!(out, "{}", datasets::som::run(args)?)?)
}

fn settings(out: &mut impl Write) -> Result<(), CliError> {
    let presets = [
        run::Preset::Default,
        run::Preset::Probe,
        run::Preset::Touzet,
    ];
    let configs = presets.map(run::Preset::config);
    let rows: Vec<_> = sim::settings::SETTINGS
        .iter()
        .map(|setting| {
            let values = configs
                .iter()
                .map(|config| sim::settings::text(setting, config));
            let key = [setting.key.to_owned()].into_iter();
            key.chain(values).chain([setting.help.to_owned()]).collect()
        })
        .collect();
    let [default, probe, touzet] = presets.map(run::Preset::name);
    let heads = ["key", default, probe, touzet, "meaning"];
    Ok(out.write_all(table::plain(&heads, &rows, &[]).as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }
}
