//! Errands in many worlds: whether a robot finds the way, whether the second time is shorter, and
//! what it does when something stands in its way now and then.

use amp::config::Config;
use arena::loaders::WorldSource;
use arena::noise::Noise;
use arena::robot::TurretMode;
use arena::route::{self, route};
use arena::sonar::SonarModel;
use arena::world::{Point, World};
use files::error::BadInput;
use rayon::prelude::*;
use serde::Serialize;
use sim::behavior::Behavior;
use sim::episode::{self, Errand, ErrandPlan, Obstacle, Period, Setup};
use sim::error::EpisodeError;
use sim::robot::AnyRobot;
use sim::statistics::{Mean, bootstrap, mean, median, wilson};
use sim::turret_pilot::TurretController;

/// Radius of the obstacle, m: with the body's, more than half a door.
const OBSTACLE_M: f64 = 0.25;
/// The obstacle leaves so much room beside the body, m: at the places, and on the way around it.
const ROOM_M: f64 = 0.15;
/// Positions of the obstacle that are tried are so far apart, m.
const APART_M: f64 = 0.3;
/// Places are so far apart, m, if the world has room.
const PLACES_APART_M: f64 = 2.0;
/// Random places that are tried.
const DRAWS: u32 = 50;
/// Shorter ways tell little of the robot's, m.
const SHORT_M: f64 = 0.5;

/// What all worlds share.
#[derive(Debug, Clone)]
pub struct ErrandTrial {
    /// Seed of all randomness in each world.
    pub seed: u64,
    /// Places in each world, beside home.
    pub places: u32,
    /// What a period is.
    pub period: Period,
    /// Number of periods.
    pub periods: u32,
    /// The obstacle comes and goes after so many periods; `None` = no obstacle.
    pub change_every: Option<u32>,
    /// Random moves before the first errand.
    pub explore_moves: u16,
    /// Decisions of one errand, at most.
    pub steps: u32,
    /// The robot.
    pub robot: AnyRobot,
    /// Its sonars.
    pub sonar: SonarModel,
    /// The controller's configuration.
    pub config: Config<16>,
}

/// The errands in one world.
#[derive(Debug, Clone)]
pub struct WorldErrands {
    /// The world.
    pub world: String,
    /// All that were ended.
    pub errands: Vec<Errand>,
    /// Why they ended early.
    pub stopped: Option<EpisodeError>,
}

/// One drive and its world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Drive<'e> {
    /// The world.
    pub world: &'e str,
    /// The drive.
    #[serde(flatten)]
    pub errand: &'e Errand,
}

impl WorldErrands {
    /// All drives.
    pub fn drives(&self) -> impl Iterator<Item = Drive<'_>> {
        let world = &self.world;
        let drives = self.errands.iter();
        drives.map(move |errand| Drive { world, errand })
    }
}

/// What was done in one period in all worlds.
#[derive(Debug, Clone, PartialEq)]
pub struct PeriodSummary {
    /// Errands.
    pub errands: usize,
    /// Of those, with the obstacle in the world.
    pub obstructed: usize,
    /// Share that ended at their places, with Wilson's interval.
    pub there: Mean,
    /// Share that ended elsewhere, though the robot thought that it was there.
    pub elsewhere: Mean,
    /// The way in units of the shortest, of those that ended there: the mean of each world's
    /// median, with an interval over the worlds.
    pub way: Mean,
    /// The way, m: mean over all, with an interval over the worlds.
    pub distance_m: Mean,
    /// Errands with a contact.
    pub touched: usize,
    /// How far the robot was from where it thought it was, m: median.
    pub error_m: f64,
    /// Places that it knew at the end of an errand: mean, with an interval over the worlds.
    pub known: Mean,
}

/// Goes on errands in all worlds, on all cores. `done` is called after each world.
///
/// # Errors
/// When a world cannot be loaded, or a controller refuses a command or is silent before its first
/// errand.
pub fn measure(
    trial: &ErrandTrial,
    worlds: &[WorldSource],
    done: &(impl Fn() + Sync),
) -> Result<Vec<WorldErrands>, BadInput> {
    let one = |source: &WorldSource| {
        let world = source.load()?;
        let failed = |why| BadInput::new(format!("world {}: {why}", world.name()));
        let errands = in_world(trial, &world).map_err(failed);
        done();
        errands
    };
    worlds.par_iter().map(one).collect()
}

fn in_world(trial: &ErrandTrial, world: &World) -> Result<WorldErrands, EpisodeError> {
    let radius_m = trial.robot.model().radius_m;
    let places = places(world, radius_m, trial.places, trial.seed);
    let plan = ErrandPlan {
        period: trial.period,
        periods: trial.periods,
        steps: trial.steps,
        obstacle: trial.change_every.and_then(|every| {
            let center = in_the_way(world, radius_m, &places)?;
            Some(Obstacle {
                center,
                radius_m: OBSTACLE_M,
                every,
            })
        }),
        places,
    };
    let setup = Setup {
        config: trial.robot.config(trial.config.clone()),
        preset: "default".to_owned(),
        behavior: Behavior::Avoid,
        explore_moves: trial.explore_moves,
        steps: 1,
        seed: trial.seed,
        sonar: trial.sonar,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        turret: TurretMode::Held,
        robot: Some(trial.robot.clone()),
        set_down: None,
        record: false,
    };
    let mut controller = TurretController::new(setup.config.clone(), &trial.robot);
    let (errands, stopped) = episode::errands(world, &setup, &mut controller, &plan)?;
    Ok(WorldErrands {
        world: world.name().to_owned(),
        errands,
        stopped,
    })
}

/// Random places that the robot can reach, apart from each other and from its start where the world
/// has room.
pub(crate) fn places(world: &World, radius_m: f64, count: u32, seed: u64) -> Vec<Point> {
    let home = world.start().position;
    let mut noise = Noise::new(seed);
    let mut places: Vec<Point> = Vec::new();
    for _ in 0..count {
        let draws = (0..DRAWS).map(|_| episode::elsewhere(world, radius_m, home, &mut noise));
        let apart_m = |place: &Point| {
            let others = places.iter().chain([&home]);
            let nearest = others.map(|other| other.distance(*place));
            nearest.fold(PLACES_APART_M, f64::min)
        };
        let best = draws.max_by(|one, other| apart_m(one).total_cmp(&apart_m(other)));
        places.extend(best);
    }
    places
}

/// Where an obstacle on the shortest ways makes the round longest, and leaves a way to each place;
/// `None` if it always closes one.
fn in_the_way(world: &World, radius_m: f64, places: &[Point]) -> Option<Point> {
    let home = world.start().position;
    let stops: Vec<_> = [home].into_iter().chain(places.iter().copied()).collect();
    let round = |world: &World| -> Option<(f64, Vec<Point>)> {
        let mut corners = Vec::new();
        let next = stops.iter().cycle().skip(1);
        for (from, to) in stops.iter().zip(next) {
            corners.extend(route(world, *from, *to, radius_m + ROOM_M).ok().flatten()?);
        }
        Some((route::length(&corners), corners))
    };
    let (free_m, corners) = round(world)?;
    let keeps_off = |center: &Point| {
        let nearest = stops.iter().map(|stop| stop.distance(*center));
        nearest.fold(f64::INFINITY, f64::min) > OBSTACLE_M + radius_m + ROOM_M
    };
    let candidates = corners.windows(2).flat_map(|ends| {
        let way = ends[1] - ends[0];
        let count = (way.length() / APART_M) as usize;
        (0..=count).map(move |part| ends[0] + way * ((part as f64 + 0.5) / (count as f64 + 1.0)))
    });
    let lengths = candidates.filter(keeps_off).filter_map(|center| {
        let (length_m, _) = round(&world.with_post(center, OBSTACLE_M))?;
        Some((length_m, center))
    });
    let longest = lengths.max_by(|one, other| one.0.total_cmp(&other.0));
    longest
        .filter(|(length_m, _)| *length_m > free_m)
        .map(|(_, center)| center)
}

/// One summary for each period.
#[must_use]
pub fn summarize(trial: &ErrandTrial, worlds: &[WorldErrands]) -> Vec<PeriodSummary> {
    let all = 0..trial.periods;
    all.map(|period| summary(period, worlds)).collect()
}

fn summary(period: u32, worlds: &[WorldErrands]) -> PeriodSummary {
    let of_world = |world: &WorldErrands| -> Vec<Errand> {
        let errands = world.errands.iter();
        errands.filter(|e| e.period == period).cloned().collect()
    };
    let worlds: Vec<_> = worlds.iter().map(of_world).collect();
    let worlds: Vec<_> = worlds
        .iter()
        .filter(|errands| !errands.is_empty())
        .collect();
    let all: Vec<_> = worlds.iter().copied().flatten().collect();
    let count = |is: fn(&Errand) -> bool| all.iter().filter(|errand| is(errand)).count();
    let share = |is: fn(&Errand) -> bool| wilson(count(is), all.len());
    let over_worlds = |value: &dyn Fn(&[Errand]) -> Option<f64>| {
        let values = worlds.iter().filter_map(|errands| value(errands));
        bootstrap(&values.map(|value| vec![value]).collect::<Vec<_>>())
    };
    PeriodSummary {
        errands: all.len(),
        obstructed: count(|errand| errand.is_obstructed),
        there: share(|errand| errand.is_there),
        elsewhere: share(|errand| errand.has_ended && !errand.is_there),
        way: over_worlds(&|errands| {
            let ways: Vec<_> = errands.iter().filter_map(way).collect();
            (!ways.is_empty()).then(|| median(ways))
        }),
        distance_m: over_worlds(&|errands| Some(mean(errands.iter().map(|e| e.distance_m)))),
        touched: count(|errand| errand.contacts > 0),
        error_m: median(all.iter().map(|errand| errand.error_m).collect()),
        known: over_worlds(&|errands| Some(mean(errands.iter().map(|e| e.known as f64)))),
    }
}

/// The way in units of the shortest.
fn way(errand: &Errand) -> Option<f64> {
    let shortest_m = errand.shortest_m.filter(|length_m| *length_m >= SHORT_M)?;
    errand.is_there.then(|| errand.distance_m / shortest_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use arena::world::{Pose, Shape};

    /// Two rooms and two doors between them.
    fn rooms() -> World {
        let wall = |points: &[(f64, f64)]| Shape::Wall {
            points: points.iter().map(|(x, y)| Point::new(*x, *y)).collect(),
        };
        let hall = [
            (-4.0, -3.0),
            (4.0, -3.0),
            (4.0, 3.0),
            (-4.0, 3.0),
            (-4.0, -3.0),
        ];
        let shapes = vec![
            wall(&hall),
            wall(&[(0.0, -3.0), (0.0, -0.7)]),
            wall(&[(0.0, 0.3), (0.0, 1.7)]),
            wall(&[(0.0, 2.7), (0.0, 3.0)]),
        ];
        let start = Pose::new(Point::new(-2.0, -0.2), 0.0);
        World::new("rooms", start, shapes).expect("a world")
    }

    #[test]
    fn the_obstacle_closes_the_nearer_door() {
        let center = in_the_way(&rooms(), 0.25, &[Point::new(2.0, -0.2)]).expect("an obstacle");
        assert!(
            center.x.abs() < 0.8 && (center.y + 0.2).abs() < 0.3,
            "{center:?}"
        );
    }

    #[test]
    fn the_obstacle_does_not_close_the_only_door() {
        let bar = Shape::Wall {
            points: vec![Point::new(0.0, 1.7), Point::new(0.0, 2.7)],
        };
        let shapes = [rooms().shapes().to_vec(), vec![bar]].concat();
        let world = World::new("a door", rooms().start(), shapes).expect("a world");
        let center = in_the_way(&world, 0.25, &[Point::new(2.0, -0.2)]);
        // Beside the door there is room for it, and a way around.
        assert!(
            center.is_none_or(|center| center.x.abs() > 0.5),
            "{center:?}"
        );
    }

    #[test]
    fn places_are_apart_and_the_same_for_the_same_seed() {
        let all = places(&rooms(), 0.25, 4, 1);
        assert_eq!(all, places(&rooms(), 0.25, 4, 1));
        assert_ne!(all, places(&rooms(), 0.25, 4, 2));
        let home = rooms().start().position;
        for (index, place) in all.iter().enumerate() {
            let others = all[..index].iter().chain([&home]);
            assert!(others.map(|o| o.distance(*place)).all(|m| m > 1.9));
        }
    }

    #[test]
    fn a_period_sums_up_its_errands() {
        let errand = |period: u32, is_there: bool, distance_m: f64| Errand {
            period,
            place: 0,
            is_obstructed: period == 1,
            has_ended: true,
            is_there,
            shortest_m: Some(2.0),
            distance_m,
            took_s: 10.0,
            contacts: u32::from(!is_there),
            error_m: 0.1,
            known: 20,
        };
        let world = |errands: &[Errand]| WorldErrands {
            world: "a".to_owned(),
            errands: errands.to_vec(),
            stopped: None,
        };
        let worlds = [
            world(&[
                errand(0, true, 4.0),
                errand(1, true, 3.0),
                errand(1, false, 9.0),
            ]),
            world(&[errand(0, true, 2.0)]),
        ];
        let [first, second] = [0, 1].map(|period| summary(period, &worlds));
        assert_eq!((first.errands, first.obstructed), (2, 0));
        assert_eq!((first.there.mean, first.way.mean), (1.0, 1.5));
        assert_eq!((second.errands, second.obstructed), (2, 2));
        assert_eq!((second.there.mean, second.elsewhere.mean), (0.5, 0.5));
        // Of those that were there.
        assert_eq!((second.way.mean, second.distance_m.mean), (1.5, 6.0));
        assert_eq!(second.touched, 1);
    }
}
