//! Goals that are far away (section 5.2), in an eighth as many worlds as there are rooms, of twelve
//! other kinds: led by a memory of places, and by the goal situation alone.

use super::measure::{MeasureError, ProgressListener, Size};
use super::{PaperReading, STEPS, rooms};
use arena::robot_model::RobotModel;
use arena::sources::{Light, Sources};
use arena::world::World;
use files::error::BadInput;
use rayon::prelude::*;
use sim::behavior::{Behavior, TOUR_STEPS, Tour};
use sim::episode::{EpisodeReport, Setup, run};
use sim::error::EpisodeError;
use sim::robot::{AnyRobot, Ranges};
use sim::senses::{Sense, SenseGoal};

/// Reports by world. The Nomad's ring is read through points.
pub struct FarGoals {
    /// Home after a tour, by a chain of sub-goals.
    pub led: Vec<EpisodeReport>,
    /// The same by the situation of the start alone.
    pub alone: Vec<EpisodeReport>,
    /// The nest after a tour, set down elsewhere.
    pub carried: Vec<EpisodeReport>,
    /// The nest without a tour, set down elsewhere.
    pub new: Vec<EpisodeReport>,
    /// Where it smells strongest, after a tour.
    pub scent: Vec<EpisodeReport>,
    /// Where it was before it got dark, after a tour.
    pub dark: Vec<EpisodeReport>,
}

/// The lamp at the start goes out then, s: soon after the random moves.
const DARK_S: f64 = 120.0;

/// Measures all worlds, on all cores.
///
/// # Errors
/// When the Nomad cannot be read through points, or an episode fails.
pub(super) fn measure(
    size: Size,
    reading: &PaperReading,
    progress: &impl ProgressListener,
) -> Result<FarGoals, MeasureError> {
    let worlds = u64::from(size.rooms.div_ceil(8));
    progress.begin("far goals", 6 * worlds);
    let robot = nomad()?;
    let drives = |behavior: Behavior, is_led: bool| -> Result<Vec<_>, EpisodeError> {
        let robot = robot.clone().led(is_led);
        let one = |number: u64| {
            let seed = size.seed.wrapping_add(number);
            let setup = rooms::setup(reading, behavior.clone(), seed, 2 * STEPS);
            let setup = Setup {
                config: robot.config(setup.config),
                robot: Some(robot.clone()),
                record: false,
                ..setup
            };
            let world = lit(World::random2(number.wrapping_add(1)))?;
            let episode = run(&world, &setup, |_, _, _| {});
            progress.done();
            episode.map(|episode| episode.report)
        };
        (0..worlds).into_par_iter().map(one).collect()
    };
    let tour = Tour::of(TOUR_STEPS);
    Ok(FarGoals {
        led: drives(Behavior::Home { tour }, true)?,
        alone: drives(Behavior::Home { tour }, false)?,
        carried: drives(
            Behavior::Nest {
                tour,
                is_turned: false,
            },
            true,
        )?,
        new: drives(Behavior::NEST, true)?,
        scent: drives(sought(SenseGoal::Scent), true)?,
        dark: drives(sought(SenseGoal::Before(Sense::Light)), true)?,
    })
}

/// After a tour.
fn sought(goal: SenseGoal) -> Behavior {
    Behavior::Sense {
        goal,
        tour: Tour::of(TOUR_STEPS),
    }
}

/// The world with a lamp over its start.
fn lit(world: World) -> Result<World, EpisodeError> {
    let lamp = Light {
        position: world.start().position,
        brightness: 1.0,
        until_s: Some(DARK_S),
    };
    let lit = world.with_sources(Sources {
        lights: vec![lamp],
        ..Sources::default()
    });
    lit.map_err(|why| EpisodeError::World(why.to_string()))
}

/// The Nomad, without a guard.
fn nomad() -> Result<AnyRobot, BadInput> {
    AnyRobot::new(RobotModel::find("nomad200")?, Ranges::Own, false)
}
