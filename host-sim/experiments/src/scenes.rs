//! The behaviors' scenes: where each is tried, what is measured and what is asked.

use arena::rooms;
use arena::sonar::SonarModel;
use arena::world::{Point, World};
use sim::episode::EpisodeReport;

/// A behavior, its worlds and what it is to reach.
pub struct Scene {
    /// The behavior's name; `seek` is to find a place whose situation was shown.
    pub behavior: &'static str,
    /// What the worlds are.
    pub place: &'static str,
    /// Decisions.
    pub steps: u32,
    /// What the measure is.
    pub measure: &'static str,
    /// What is asked of it; empty = nothing.
    pub asked: &'static str,
    /// Sonars that belong to the scene, whatever else is measured with.
    pub sonar: Option<SonarModel>,
    /// Where the robot is set down after exploring, by the episode's seed; `None` = where its behavior says.
    pub set_down: Option<fn(u64) -> Point>,
    make: fn(u64) -> World,
    value: fn(&EpisodeReport) -> f64,
}

/// All scenes, in the table's order.
pub static SCENES: &[Scene] = &[
    Scene::new("avoid", "12 boxes", World::random).asks(clean, "clean rooms", "≥ 0.995"),
    Scene::new("avoid", "12 boxes", World::random).asks(area, "area m²", "≥ 18.8"),
    Scene::new("avoid-right", "one obstacle", rooms::one_obstacle).asks(
        success,
        "passed on its left",
        "≥ 0.80",
    ),
    Scene::new("wall-right", "plain room", rooms::plain).asks(success, "error m", "≤ 0.20"),
    Scene::new("wall-right", "five boxes", rooms::boxes).asks(success, "error m", "≤ 0.20"),
    Scene::new("wall-right", "corridor", rooms::corridor).asks(success, "error m", "≤ 0.20"),
    Scene::new("wall-left", "plain room", rooms::plain).asks(success, "error m", "≤ 0.20"),
    Scene::new("wall-left", "five boxes", rooms::boxes).asks(success, "error m", "≤ 0.20"),
    Scene::new("wall-left", "corridor", rooms::corridor).asks(success, "error m", "≤ 0.20"),
    Scene::new("nest", "4 m × 4 m", rooms::small).asks(success, "reached", "≥ 0.98"),
    Scene::new("nest", "4 m × 4 m, noisy sonars", rooms::small)
        .asks(success, "reached", "≥ 0.80")
        .with_sonar(SonarModel::Nomad),
    Scene::new("nest", "six boxes", rooms::six_boxes).asks(success, "reached", "≥ 0.80"),
    Scene::new("nest", "six boxes", rooms::six_boxes).asks(way, "way m", ""),
    Scene::new("seek", "4 m × 4 m", rooms::small).asks(success, "reached", "≥ 0.98"),
    Scene::new("seek", "six boxes", rooms::six_boxes).asks(success, "reached", "≥ 0.80"),
    Scene::new("follow", "plain room", rooms::plain)
        .asks(success, "share of 300 s", "≥ 0.80")
        .lasting(400),
    Scene::new("follow", "five boxes", rooms::boxes)
        .asks(success, "share of 300 s", "≥ 0.80")
        .lasting(400),
    Scene::new(
        "avoid-right,wall-right,nest",
        "room with an exit",
        rooms::with_exit,
    )
    .asks(success, "goals reached", "")
    .set_down_at(rooms::inside),
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

fn way(report: &EpisodeReport) -> f64 {
    report.distance_m
}

impl Scene {
    const fn new(behavior: &'static str, place: &'static str, make: fn(u64) -> World) -> Self {
        Self {
            behavior,
            place,
            steps: 1_000,
            measure: "",
            asked: "",
            sonar: None,
            set_down: None,
            make,
            value: success,
        }
    }

    const fn asks(
        mut self,
        value: fn(&EpisodeReport) -> f64,
        measure: &'static str,
        asked: &'static str,
    ) -> Self {
        self.value = value;
        self.measure = measure;
        self.asked = asked;
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

    /// The scene's measure of an episode.
    #[must_use]
    pub fn value(&self, report: &EpisodeReport) -> f64 {
        (self.value)(report)
    }

    /// The scene's world number `index`.
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

/// The scenes whose behavior contains a text; all without one.
#[must_use]
pub fn scenes_named(text: Option<&str>) -> Vec<&'static Scene> {
    let named = |scene: &&Scene| text.is_none_or(|text| scene.behavior.contains(text));
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
