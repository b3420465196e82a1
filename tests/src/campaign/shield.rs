//! With the shield on, the robot touches nothing by its own motion, and it still moves.
//!
//! A *cell* is one combination of behavior, sonar model and turret mode; episodes cycle through the
//! cells, each round with its own seed and random room. Random moves count as well. A second set of
//! worlds: the built-in ones and rooms with thin walls.

use super::{CampaignVerdict, ProgressCallback, grouped};
use amp::config::Config;
use arena::noise::Noise;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::{Point, Pose, Shape, World};
use experiments::behaviors::shown_place;
use files::error::BadInput;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{Setup, run as run_episode};
use sim::error::EpisodeError;
use std::f64::consts::TAU;

/// Cells: 8 behaviors, 2 sonar models, 2 turret modes.
pub const CELLS: u64 = 32;
/// Episodes of a full campaign: 313 per cell.
pub const COUNT: u64 = 313 * CELLS;
/// Decisions of an episode after its random moves.
const STEPS: u32 = 1_000;
/// Least mean distance of an episode, m: over all, and in each cell with enough episodes.
///
/// In 313 episodes per cell the means were 205 m and, where a robot stands in its nest, 47 m. The
/// mean of a few is meaningless.
const MIN_MEAN_M: f64 = 100.0;
const MIN_CELL_M: f64 = 20.0;
const ENOUGH: u64 = 100;
/// A chain of three behaviors.
const CHAIN: &str = "avoid-right,wall-right,nest";
/// Free-standing thin walls in a room.
const THIN_WALLS: usize = 10;
/// Half of such a room, m.
const HALF_M: f64 = 4.0;
/// Free space around the start, m.
const FREE_M: f64 = 1.0;

/// The set of worlds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Worlds {
    /// Rooms with 12 boxes.
    Random,
    /// Built-in worlds and rooms with thin walls, in turn.
    Others,
}

/// Result of one cell.
#[derive(Debug, Clone, Default)]
struct ShieldCell {
    episodes: u64,
    explore_contacts: u64,
    contacts: u64,
    touched_by: u64,
    distance_m: f64,
    success: f64,
    clearance_m: Option<f64>,
    touched: Vec<String>,
}

/// Runs `count` episodes with this configuration of the robot.
///
/// # Errors
/// A controller that refuses a command or makes no decision; a built-in world that cannot be read.
pub fn run(
    seed: u64,
    count: u64,
    worlds: Worlds,
    config: &Config<16>,
    progress: ProgressCallback<'_>,
) -> Result<CampaignVerdict, String> {
    let one = |number: u64| {
        let world =
            world(worlds, seed.wrapping_add(number / CELLS)).map_err(|why| why.to_string())?;
        let cell = episode(&world, seed, number, config).map_err(|why| {
            let (behavior, sonar, turret) = parts(number);
            let [behavior, sonar, turret] = [name(behavior), sonar.name(), turret.name()];
            let seed = seed.wrapping_add(number / CELLS);
            let world = world.name();
            format!("{behavior}, {sonar}, {turret}, seed {seed}, {world}: {why}")
        })?;
        progress(1);
        Ok((number, cell))
    };
    let all: Result<Vec<_>, String> = (0..count).into_par_iter().map(one).collect();
    let mut cells = vec![ShieldCell::default(); CELLS as usize];
    for (number, episode) in all? {
        cells[(number % CELLS) as usize].add(episode);
    }
    Ok(verdict(&cells))
}

/// Behavior, sonar model and turret mode of a cell.
fn parts(number: u64) -> (usize, SonarModel, TurretMode) {
    let cell = number % CELLS;
    let sonar = [SonarModel::Ideal, SonarModel::Nomad][(cell / 2 % 2) as usize];
    let turret = [TurretMode::Held, TurretMode::Follow][(cell % 2) as usize];
    ((cell / 4) as usize, sonar, turret)
}

/// Name of a behavior by its index in the table.
fn name(behavior: usize) -> &'static str {
    let others = ["seek", CHAIN];
    let mut names = Behavior::NAMES.iter().chain(&others);
    names.nth(behavior).copied().unwrap_or(CHAIN)
}

fn episode(
    world: &World,
    seed: u64,
    number: u64,
    config: &Config<16>,
) -> Result<ShieldCell, EpisodeError> {
    let (behavior, sonar, turret) = parts(number);
    let seed = seed.wrapping_add(number / CELLS);
    let behavior = match name(behavior) {
        "seek" => shown_place(world, config, None, seed),
        name => name.parse().unwrap_or(Behavior::Avoid),
    };
    let setup = Setup {
        config: config.clone(),
        preset: String::new(),
        behavior,
        explore_moves: 100,
        steps: STEPS,
        seed,
        sonar,
        turret,
        robot: None,
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: false,
    };
    let report = run_episode(world, &setup, |_, _, _| {})?.report;
    let touched = report.contacts + report.explore_contacts > 0;
    Ok(ShieldCell {
        episodes: 1,
        explore_contacts: report.explore_contacts.into(),
        contacts: report.contacts.into(),
        touched_by: report.touched_by.into(),
        distance_m: report.distance_m,
        success: report.success,
        clearance_m: Some(report.min_clearance_m),
        touched: touched
            .then(|| format!("{} seed {seed}", report.world))
            .into_iter()
            .collect(),
    })
}

fn world(worlds: Worlds, seed: u64) -> Result<World, BadInput> {
    let names = World::builtin_names();
    let kinds = names.len() as u64 + 1;
    match (worlds, names.get((seed % kinds) as usize)) {
        (Worlds::Random, _) => Ok(World::random(seed)),
        (Worlds::Others, Some(name)) => World::builtin(name),
        (Worlds::Others, None) => thin_walls(seed),
    }
}

/// A room of 8 m × 8 m with free-standing walls without thickness, 0.3 to 1.5 m long, at any angle.
fn thin_walls(seed: u64) -> Result<World, BadInput> {
    let mut noise = Noise::new(seed);
    let mut shapes = vec![Shape::room(Point::new(HALF_M, HALF_M))];
    while shapes.len() <= THIN_WALLS {
        let mut within = |half: f64| noise.uniform_in(-half, half);
        let center = Point::new(within(HALF_M - 1.0), within(HALF_M - 1.0));
        let half = Point::unit(noise.uniform_in(0.0, TAU)) * noise.uniform_in(0.15, 0.75);
        if center.length() >= FREE_M + half.length() {
            shapes.push(Shape::Wall {
                points: vec![center - half, center + half],
            });
        }
    }
    World::new(format!("thin-walls:{seed}"), Pose::default(), shapes)
}

impl ShieldCell {
    fn add(&mut self, other: Self) {
        self.episodes += other.episodes;
        self.explore_contacts += other.explore_contacts;
        self.contacts += other.contacts;
        self.touched_by += other.touched_by;
        self.distance_m += other.distance_m;
        self.success += other.success;
        let least = [self.clearance_m, other.clearance_m].into_iter().flatten();
        self.clearance_m = least.reduce(f64::min);
        self.touched.extend(other.touched);
    }

    fn mean_way_m(&self) -> f64 {
        self.distance_m / self.episodes.max(1) as f64
    }

    fn row(&self, [behavior, sonar, turret]: [&str; 3]) -> [String; 10] {
        let mean =
            |sum: f64, digits: usize| format!("{:.digits$}", sum / self.episodes.max(1) as f64);
        [
            behavior.to_owned(),
            sonar.to_owned(),
            turret.to_owned(),
            self.episodes.to_string(),
            self.explore_contacts.to_string(),
            self.contacts.to_string(),
            self.touched_by.to_string(),
            mean(self.distance_m, 1),
            mean(self.success, 3),
            format!("{:.3}", self.clearance_m.unwrap_or(0.0)),
        ]
    }
}

fn verdict(cells: &[ShieldCell]) -> CampaignVerdict {
    let mut verdict = CampaignVerdict::default();
    let heads = [
        "behavior",
        "sonar",
        "turret",
        "episodes",
        "contacts exploring",
        "contacts",
        "touched by",
        "distance m",
        "success",
        "least clearance m",
    ];
    let mut all = ShieldCell::default();
    let mut rows = Vec::new();
    for (number, cell) in (0..).zip(cells).filter(|(_, cell)| cell.episodes > 0) {
        let (behavior, sonar, turret) = parts(number);
        let words = [name(behavior), sonar.name(), turret.name()];
        let way_m = cell.mean_way_m();
        let moves = cell.episodes < ENOUGH || way_m >= MIN_CELL_M;
        verdict.require(moves, format!("{}: {way_m:.1} m", words.join(", ")));
        rows.push(cell.row(words));
        all.add(cell.clone());
    }
    let way_m = all.mean_way_m();
    let moves = way_m >= MIN_MEAN_M;
    verdict.require(moves, format!("the robot hardly moves: {way_m:.1} m"));
    rows.push(all.row(["all", "", ""]));
    verdict.table(heads, &rows);
    verdict.say(format_args!(
        "\n{} episodes, {} with a contact of the robot's own",
        grouped(all.episodes),
        grouped(all.touched.len() as u64)
    ));
    for touched in &all.touched {
        verdict.require(false, format!("the robot touched something in {touched}"));
    }
    verdict
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thin_walls_leave_the_start_free() {
        for seed in 0..50 {
            let world = thin_walls(seed).expect("a room");
            assert!(world.clearance(Point::default()) >= FREE_M);
            assert_eq!(world.segments().count(), 4 + THIN_WALLS);
        }
    }

    #[test]
    fn a_robot_that_stands_is_found() {
        let cells = |episodes: u64, standing: usize| {
            let way = |cell| if cell == standing { 2.9 } else { 200.0 };
            let cell = |cell| ShieldCell {
                episodes,
                distance_m: way(cell) * episodes as f64,
                ..ShieldCell::default()
            };
            (0..CELLS as usize).map(cell).collect::<Vec<_>>()
        };
        assert!(verdict(&cells(ENOUGH, CELLS as usize)).broken.is_empty());
        assert_eq!(verdict(&cells(ENOUGH, 21)).broken.len(), 1);
        // Too few for a verdict.
        assert!(verdict(&cells(ENOUGH - 1, 21)).broken.is_empty());
        let stands = ShieldCell {
            episodes: 1,
            distance_m: 49.0,
            ..ShieldCell::default()
        };
        assert_eq!(verdict(&[stands]).broken.len(), 1);
    }

    #[test]
    fn every_cell_is_another() {
        let cells: std::collections::HashSet<_> = (0..CELLS)
            .map(|cell| {
                let (behavior, sonar, turret) = parts(cell);
                (name(behavior), sonar.name(), turret.name())
            })
            .collect();
        assert_eq!(cells.len(), 32);
    }
}
