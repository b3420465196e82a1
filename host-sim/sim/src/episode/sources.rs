//! What is sought in other modalities: where it truly is, and a source for worlds that have none.

use super::drive::EpisodeRunner;
use super::places;
use super::{Seeds, Setup};
use crate::behavior::Behavior;
use crate::error::EpisodeError;
use crate::pilot::Pilot;
use crate::robot::AnyRobot;
use crate::senses::{Sense, SenseGoal};
use arena::noise::Noise;
use arena::robot::BaseLimits;
use arena::sources::{FloorPatch, Light, SCENT_REACH_M, Scent, Sensed, named_color};
use arena::world::{Point, World};
use files::error::BadInput;

/// Within this distance the robot is at a source, m.
const SOURCE_RADIUS_M: f64 = 0.6;
/// Side of the patch on the floor of a world that has none of a color, m.
const PATCH_M: f64 = 1.0;
/// What differs by so much has become something else.
const OTHER: f64 = 0.25;

/// The world with what an episode's behavior seeks, by the episode's seed; `None` if it has all.
///
/// # Errors
/// When the world cannot have it.
pub fn completed_world(world: &World, setup: &Setup) -> Result<Option<World>, EpisodeError> {
    let robot = setup.robot.as_ref();
    let limits = robot.map_or_else(BaseLimits::default, AnyRobot::limits);
    let noise = Noise::new(Seeds::of(setup.seed).sources);
    let completed = with_missing_sources(world, &setup.behavior, limits.radius_m, noise);
    completed.map_err(|why| EpisodeError::World(why.to_string()))
}

/// The world with a source of each thing sought that it has none of, at random places that the
/// robot can reach; `None` if it has all.
///
/// # Errors
/// As [`World::with_sources`].
pub fn with_missing_sources(
    world: &World,
    behavior: &Behavior,
    radius_m: f64,
    mut noise: Noise,
) -> Result<Option<World>, BadInput> {
    let mut sources = world.sources().clone();
    for goal in behavior.sense_goals() {
        let mut place = || places::elsewhere(world, radius_m, world.start().position, &mut noise);
        match goal {
            SenseGoal::Scent | SenseGoal::Before(Sense::Scent) if sources.scents.is_empty() => {
                sources.scents.push(Scent {
                    position: place(),
                    reach_m: SCENT_REACH_M,
                });
            }
            SenseGoal::Light | SenseGoal::Before(Sense::Light) if sources.lights.is_empty() => {
                sources.lights.push(Light {
                    position: place(),
                    brightness: 1.0,
                    until_s: None,
                });
            }
            SenseGoal::Floor(name) => {
                let color = named_color(name)?;
                if !sources.floor.iter().any(|patch| patch.color == color) {
                    sources.floor.push(FloorPatch {
                        center: place(),
                        size: Point::new(PATCH_M, PATCH_M),
                        angle: 0.0,
                        color,
                    });
                }
            }
            _ => {}
        }
    }
    if sources == *world.sources() {
        return Ok(None);
    }
    world.clone().with_sources(sources).map(Some)
}

impl EpisodeRunner<'_> {
    /// The position that is sought: of several the nearest.
    pub(super) fn sought(&self, goal: SenseGoal) -> Point {
        let here = self.body.pose().position;
        let candidates = self.candidates(goal);
        let nearest = candidates.into_iter().min_by(|one, other| {
            let away = |place: &Point| place.distance(here);
            away(one).total_cmp(&away(other))
        });
        nearest.unwrap_or(here)
    }

    fn candidates(&self, goal: SenseGoal) -> Vec<Point> {
        let sources = self.body.world().sources();
        match goal {
            SenseGoal::Scent => sources.scents.iter().map(|scent| scent.position).collect(),
            SenseGoal::Light => {
                let lights = || sources.lights.iter();
                let most = lights().map(|light| light.brightness).fold(0.0, f64::max);
                let brightest = lights().filter(|light| light.brightness >= most);
                brightest.map(|light| light.position).collect()
            }
            SenseGoal::Floor(name) => {
                let color = named_color(name).ok();
                let patches = sources.floor.iter();
                let colored = patches.filter(|patch| Some(patch.color) == color);
                colored.map(|patch| patch.center).collect()
            }
            SenseGoal::Before(sense) => self.before(sense).into_iter().collect(),
        }
    }

    /// Where the robot was before this became as it is now.
    fn before(&self, sense: Sense) -> Option<Point> {
        let now = self.body.sensed();
        let differs = |then: &Sensed| match sense {
            Sense::Scent => (then.scent - now.scent).abs() >= OTHER,
            Sense::Light => (then.light - now.light).abs() >= OTHER,
            Sense::Floor => {
                let mut pairs = then.floor.iter().zip(now.floor);
                pairs.any(|(then, now)| (then - now).abs() >= OTHER)
            }
        };
        let mut backward = self.sensed.iter().rev();
        backward
            .find(|(_, then)| differs(then))
            .map(|(place, _)| *place)
    }

    /// Whether the robot is at what is sought.
    pub(super) fn is_at(&self, goal: SenseGoal) -> bool {
        let here = self.body.pose().position;
        let is_near = |place: &Point| place.distance(here) <= SOURCE_RADIUS_M;
        match goal {
            SenseGoal::Scent | SenseGoal::Light => self.candidates(goal).iter().any(is_near),
            SenseGoal::Floor(name) => {
                named_color(name).is_ok_and(|color| color == self.body.sensed().floor)
            }
            SenseGoal::Before(_) => self.measure.sought.as_ref().is_some_and(is_near),
        }
    }

    /// The pilot senses what is here.
    pub(super) fn sense(&mut self, pilot: &mut impl Pilot) {
        if self.body.world().sources().is_empty() {
            return;
        }
        let place = self.body.pose().position;
        self.sensed.push((place, self.body.sensed()));
        let readings = self.body.read();
        pilot.sense(self.body.now(), &readings);
    }
}
