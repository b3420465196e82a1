//! `host-sim capture`: writes the situation at a pose as a goal file.

use super::CliError;
use super::robot::NamedRobotArgs;
use super::run::{Preset, SonarChoice};
use arena::loaders::parse_worlds;
use arena::robot::COLLISION_RADIUS_M;
use arena::world::{MAX_COORDINATE_M, Point, Pose, World};
use clap::Args;
use files::error::BadInput;
use sim::episode::perceive;
use sim::goal_file;
use sim::settings;
use std::io::Write;
use std::path::PathBuf;
use std::str::FromStr;

/// Flags of the `capture` command.
#[derive(Debug, Clone, Args)]
pub struct CaptureArgs {
    /// World, named as for `run`: a FILE, random:SEED, random2:SEED, or a built-in name
    #[arg(long, value_name = "WORLD", default_value = "paper")]
    world: String,
    /// Position of the robot, meters, and bearing of its ring, degrees [default: the world's start;
    /// without DEG the start's bearing]
    #[arg(long, value_name = "X,Y[,DEG]", value_parser = <CapturePose as FromStr>::from_str, allow_hyphen_values = true)]
    at: Option<CapturePose>,
    /// Sonar model
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// Seed of the sonars' noise
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Preset of the controller's options, which define the scale of the situation
    #[arg(long, value_name = "NAME", default_value = "default", value_enum)]
    preset: Preset,
    /// Change one option (see `host-sim settings`); may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    #[command(flatten)]
    robot: NamedRobotArgs,
    /// The file to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

/// A position, and a bearing if one is given.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CapturePose {
    place: Point,
    bearing: Option<f64>,
}

impl FromStr for CapturePose {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        let number = |text: &str| {
            let number = text.trim().parse().ok();
            number.filter(|number: &f64| number.abs() <= MAX_COORDINATE_M)
        };
        let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
        match numbers.as_deref() {
            Some([x, y]) => Ok(Self {
                place: Point::new(*x, *y),
                bearing: None,
            }),
            Some([x, y, degrees]) => Ok(Self {
                place: Point::new(*x, *y),
                bearing: Some(degrees.to_radians()),
            }),
            _ => Err(BadInput::new(format!(
                "\"{text}\" is not a place: X,Y in meters or X,Y,DEG"
            ))),
        }
    }
}

/// Captures the situation and writes the file, completely or not at all.
///
/// # Errors
/// A world that cannot be loaded, a position where the robot does not fit, a file that cannot be
/// written, a closed pipe.
pub fn capture(args: &CaptureArgs, out: &mut impl Write) -> Result<(), CliError> {
    let mut config = args.preset.config();
    settings::apply(&mut config, &args.sets)?;
    let robot = args.robot.find(false)?;
    if let Some(robot) = &robot {
        config = robot.config(config);
    }
    let world = only_world(&args.world)?;
    let radius_m = robot
        .as_ref()
        .map_or(COLLISION_RADIUS_M, |robot| robot.model().radius_m);
    let pose = pose(&world, radius_m, args.at)?;
    let sonar = args.sonar.into();
    let (situation, known) = perceive(&world, pose, robot.as_ref(), sonar, args.seed, &config);
    let remark = format!(
        "Captured in the world {} with the sonars {} {}.",
        world.name().replace(char::is_control, " "),
        sonar.name(),
        goal_file::scale(config.encoding),
    );
    let text = goal_file::text(&situation, known, pose.position, &remark);
    goal_file::write(&args.out, &text)?;
    let Point { x, y } = pose.position;
    let file = args.out.display();
    Ok(writeln!(
        out,
        "{file}: what the robot perceives at ({x}, {y}) in {}\nGo there: host-sim run{} --world {} --behavior seek:{file}",
        world.name(),
        args.robot.flags(),
        args.world
    )?)
}

fn only_world(name: &str) -> Result<World, BadInput> {
    match parse_worlds(name)?.as_slice() {
        [source] => source.load(),
        sources => Err(BadInput::new(format!(
            "--world {name}: a place is in one world, not in {}",
            sources.len()
        ))),
    }
}

fn pose(world: &World, radius_m: f64, at: Option<CapturePose>) -> Result<Pose, BadInput> {
    let start = world.start();
    let Some(CapturePose { place, bearing }) = at else {
        return Ok(start);
    };
    let (low, high) = world.bounds();
    let within = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
    let outside = !within(place.x, low.x, high.x) || !within(place.y, low.y, high.y);
    if outside || world.is_inside(place) || world.clearance(place) < radius_m {
        return Err(BadInput::new(format!(
            "--at {},{}: there is no room for the robot in the world {}",
            place.x,
            place.y,
            world.name()
        )));
    }
    Ok(Pose::new(place, bearing.unwrap_or(start.heading)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_read_or_refused_by_name() {
        let at: CapturePose = "-1.5, 2,90".parse().unwrap();
        assert_eq!(at.place, Point::new(-1.5, 2.0));
        assert!((at.bearing.unwrap() - core::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!("1,2".parse::<CapturePose>().unwrap().bearing, None);
        for wrong in ["", "1", "1,2,3,4", "1,x", "nan,0", "1e9,0", "1;2"] {
            let why = wrong.parse::<CapturePose>().unwrap_err().to_string();
            assert!(why.contains(&format!("\"{wrong}\"")), "{why}");
        }
    }
}
