//! `host-sim worlds`: lists and draws worlds.

use super::output::prepare;
use super::run::sources;
use super::{CliError, table};
use arena::world::World;
use clap::Args;
use files::error::BadInput;
use std::io::Write;
use std::path::PathBuf;

/// Flags of the `worlds` command.
#[derive(Debug, Clone, Args)]
pub struct WorldsArgs {
    /// Worlds to list and draw, named as for `run` [default: the built-in ones and three random
    /// rooms]
    #[arg(long = "world", value_name = "WORLD")]
    worlds: Vec<String>,
    /// Folder for the picture
    #[arg(long, value_name = "DIR", default_value = "out/worlds")]
    out: PathBuf,
}

/// Largest number of worlds in one picture.
const MAX_WORLDS: usize = 100;

/// Lists the worlds and draws them.
///
/// # Errors
/// Worlds that cannot be loaded, a folder that cannot be written, a closed pipe.
pub fn worlds(args: &WorldsArgs, out: &mut impl Write) -> Result<(), CliError> {
    let mut names = args.worlds.clone();
    if names.is_empty() {
        names = World::builtin_names()
            .iter()
            .map(|name| (*name).to_owned())
            .collect();
        names.push("random:1..=3".to_owned());
    }
    let sources = sources(&names)?;
    if sources.len() > MAX_WORLDS {
        return Err(BadInput::new(format!(
            "--world names {} worlds, a picture holds at most {MAX_WORLDS}",
            sources.len()
        ))
        .into());
    }
    let mut worlds = Vec::new();
    for source in &sources {
        worlds.push(source.load()?);
    }
    prepare(&args.out)?;
    let rows: Vec<_> = worlds.iter().map(row).collect();
    let heads = [
        "world",
        "size m",
        "surfaces",
        "start m",
        "clearance at start m",
        "symmetry order",
    ];
    out.write_all(table::plain(&heads, &rows, &[2, 4, 5]).as_bytes())?;

    let all: Vec<_> = worlds.iter().collect();
    let svg = plots::worlds("Worlds", &all);
    let [picture, _] = plots::save_picture(&args.out, "worlds", &svg)?;
    writeln!(out, "\nPicture: {}", picture.display())?;
    Ok(())
}

fn row(world: &World) -> Vec<String> {
    let (least, greatest) = world.bounds();
    let start = world.start().position;
    vec![
        world.name().to_owned(),
        format!("{:.1} × {:.1}", greatest.x - least.x, greatest.y - least.y),
        world.segments().count().to_string(),
        format!("({:.2}, {:.2})", start.x, start.y),
        format!("{:.2}", world.clearance(start)),
        world.symmetry_order().to_string(),
    ]
}
