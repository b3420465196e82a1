//! The scenes of the behaviors: worlds, measure and required value.

use arena::loaders::rooms;
use arena::sonar::SonarModel;
use arena::world::{Point, World};
use sim::episode::EpisodeReport;

/// A behavior, its worlds and its required value.
pub struct BehaviorScene {
    /// Name of the behavior; in a `seek` scene the robot finds the place of a demonstrated
    /// situation.
    pub behavior: &'static str,
    /// Description of the worlds.
    pub place: &'static str,
    /// Number of decisions.
    pub steps: u32,
    /// Description of the measure.
    pub measure: &'static str,
    /// Required value; empty = none.
    pub required: &'static str,
    /// Sonar model of the scene; overrides that of the measurement.
    pub sonar: Option<SonarModel>,
    /// Start position after exploring, by the episode's seed; `None` = the behavior's default.
    pub set_down: Option<fn(u64) -> Point>,
    make: fn(u64) -> World,
    value: fn(&EpisodeReport) -> f64,
}

/// All scenes, in the order of the table.
pub static SCENES: &[BehaviorScene] = &[
    BehaviorScene::new("avoid", "12 boxes", World::random).requires(
        clean,
        "clean rooms",
        "≥ 0.995",
    ),
    BehaviorScene::new("avoid", "12 boxes", World::random).requires(area, "area m²", "≥ 18.8"),
    BehaviorScene::new("avoid-right", "one obstacle", rooms::one_obstacle).requires(
        success,
        "passed on its left",
        "≥ 0.80",
    ),
    BehaviorScene::new("wall-right", "plain room", rooms::plain)
        .requires(success, "error m", "≤ 0.20"),
    BehaviorScene::new("wall-right", "five boxes", rooms::boxes)
        .requires(success, "error m", "≤ 0.20"),
    BehaviorScene::new("wall-right", "corridor", rooms::corridor)
        .requires(success, "error m", "≤ 0.20"),
    BehaviorScene::new("wall-left", "plain room", rooms::plain)
        .requires(success, "error m", "≤ 0.20"),
    BehaviorScene::new("wall-left", "five boxes", rooms::boxes)
        .requires(success, "error m", "≤ 0.20"),
    BehaviorScene::new("wall-left", "corridor", rooms::corridor)
        .requires(success, "error m", "≤ 0.20"),
    BehaviorScene::new("nest", "4 m × 4 m", rooms::small).requires(success, "reached", "≥ 0.98"),
    BehaviorScene::new("nest", "4 m × 4 m, noisy sonars", rooms::small)
        .requires(success, "reached", "≥ 0.80")
        .with_sonar(SonarModel::Nomad),
    BehaviorScene::new("nest", "six boxes", rooms::six_boxes)
        .requires(success, "reached", "≥ 0.80"),
    BehaviorScene::new("nest", "six boxes", rooms::six_boxes).requires(distance, "distance m", ""),
    BehaviorScene::new("seek", "4 m × 4 m", rooms::small).requires(success, "reached", "≥ 0.98"),
    BehaviorScene::new("seek", "six boxes", rooms::six_boxes)
        .requires(success, "reached", "≥ 0.80"),
    BehaviorScene::new("follow", "plain room", rooms::plain)
        .requires(success, "share of 300 s", "≥ 0.80")
        .lasting(400),
    BehaviorScene::new("follow", "five boxes", rooms::boxes)
        .requires(success, "share of 300 s", "≥ 0.80")
        .lasting(400),
    BehaviorScene::new(
        "avoid-right,wall-right,nest",
        "room with an exit",
        rooms::with_exit,
    )
    .requires(success, "goals reached", "")
    .set_down_at(rooms::inside),
];

/// Scenes in worlds of twelve other kinds (corridors, mazes, halls …), on which nothing was tuned.
pub static OTHER_KINDS: &[BehaviorScene] = &[
    BehaviorScene::new("avoid", "other kinds", World::random2).requires(clean, "clean worlds", ""),
    BehaviorScene::new("avoid", "other kinds", World::random2).requires(area, "area m²", ""),
    BehaviorScene::new("wall-right", "other kinds", World::random2)
        .requires(success, "error m", ""),
    BehaviorScene::new("nest", "other kinds", World::random2).requires(success, "reached", ""),
];

fn clean(report: &EpisodeReport) -> f64 {
    f64::from(u8::from(report.contacts == 0))
}

fn area(report: &EpisodeReport) -> f64 {
    report.coverage_m2
}

fn success(report: &EpisodeReport) -> f64 {
    report.success
}

fn distance(report: &EpisodeReport) -> f64 {
    report.distance_m
}

impl BehaviorScene {
    const fn new(behavior: &'static str, place: &'static str, make: fn(u64) -> World) -> Self {
        Self {
            behavior,
            place,
            steps: 1_000,
            measure: "",
            required: "",
            sonar: None,
            set_down: None,
            make,
            value: success,
        }
    }

    const fn requires(
        mut self,
        value: fn(&EpisodeReport) -> f64,
        measure: &'static str,
        required: &'static str,
    ) -> Self {
        self.value = value;
        self.measure = measure;
        self.required = required;
        self
    }

    const fn lasting(mut self, steps: u32) -> Self {
        self.steps = steps;
        self
    }

    const fn with_sonar(mut self, sonar: SonarModel) -> Self {
        self.sonar = Some(sonar);
        self
    }

    const fn set_down_at(mut self, place: fn(u64) -> Point) -> Self {
        self.set_down = Some(place);
        self
    }

    /// The scene's measure for an episode.
    #[must_use]
    pub fn value(&self, report: &EpisodeReport) -> f64 {
        (self.value)(report)
    }

    /// World number `index` of the scene.
    #[must_use]
    pub fn world(&self, index: u64) -> World {
        (self.make)(index)
    }

    /// Behavior and place in one line.
    #[must_use]
    pub fn title(&self) -> String {
        format!("{}, {}", self.behavior, self.place)
    }
}

/// The scenes whose behavior contains `text`; all scenes without it.
#[must_use]
pub fn scenes_named(text: Option<&str>) -> Vec<&'static BehaviorScene> {
    let named = |scene: &&BehaviorScene| text.is_none_or(|text| scene.behavior.contains(text));
    SCENES.iter().filter(named).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::behavior::Behavior;

    #[test]
    fn every_scene_names_a_behavior_and_every_behavior_has_a_scene() {
        for scene in SCENES {
            let known = scene.behavior == "seek" || scene.behavior.parse::<Behavior>().is_ok();
            assert!(known, "{}", scene.behavior);
            assert!(!scene.measure.is_empty(), "{}", scene.title());
        }
        for name in Behavior::NAMES {
            let scene = SCENES.iter().find(|scene| scene.behavior == name);
            assert!(scene.is_some(), "{name}");
        }
    }
}
