//! Builds the snapshot of a board.

use super::WatchedBoard;
use crate::dto::{displacements, millimeters, plan_dto, ring};
use crate::snapshot::{LiveState, Rounded, SceneDto, SnapshotPart};
use crate::source::ViewSource as _;
use amp::config::PlannerKind;
use amp::planner::difference;
use amp::wire::message::ModeReport;
use arena::world::Point;
use sim::behavior::Behavior;
use std::sync::Arc;

impl WatchedBoard {
    pub(super) fn scene(&mut self) -> Arc<SnapshotPart<SceneDto>> {
        if let Some(scene) = &self.scene {
            return Arc::clone(scene);
        }
        let config = &self.config;
        let names = Behavior::NAMES.iter().filter(|name| **name != "follow");
        let about = |name: &&str| [(*name).to_owned(), Behavior::about(name).to_owned()];
        let scene = SceneDto {
            world: format!("board at {}", self.name),
            near_far_m: [config.encoding.near_mm, config.encoding.far_mm].map(millimeters),
            step_m: millimeters(config.robot.step_mm),
            seed: self.seed.to_string(),
            preset: "the board's own".to_owned(),
            sonar: "the board's own".to_owned(),
            turret: "as it is".to_owned(),
            moves: self.explore_moves,
            controller: self.name.clone(),
            recalls: config.planning.planner == PlannerKind::Recall,
            abilities: self.abilities(),
            behaviors: names.map(about).collect(),
            ..SceneDto::default()
        };
        let scene = Arc::new(SnapshotPart::new("scene", 0, self.revision, scene));
        self.scene = Some(Arc::clone(&scene));
        scene
    }

    pub(super) fn now(&self) -> LiveState {
        let decision = self.decision;
        let plan = decision.and_then(|decision| decision.plan);
        let [wanted_m, allowed_m] = displacements(decision.as_ref());
        let changed = decision.zip(self.before);
        let (mode, progress) = self.mode_and_progress();
        LiveState {
            time_s: Rounded(self.time_s),
            mode,
            why: self.failure.clone(),
            note: self.note.clone(),
            resumes: mode == "stopped",
            progress: Rounded(progress),
            enabled: std::array::from_fn(|sensor| self.config.enabled.contains(sensor)),
            situation: decision.map_or_else(Default::default, |it| ring(&it.situation)),
            changed: changed.map(|(now, before)| ring(&difference(&now.situation, &before))),
            plan: plan.map(|plan| plan_dto(&plan, &self.known)),
            wanted_m,
            allowed_m,
            goal: self
                .goal
                .to_dto(&self.config, &self.nest(), Point::default()),
            counts: self.counts.clone(),
            shield: self.config.shield.is_some(),
            online: self.config.online.is_some(),
            link: Some(self.name.clone()),
            trail: self.trail.ends(),
            ..LiveState::default()
        }
    }

    fn mode_and_progress(&self) -> (&'static str, f64) {
        let moves = f64::from(self.explore_moves.max(1));
        match self.mode {
            _ if self.failure.is_some() => ("failed", 0.0),
            ModeReport::Idle => ("idle", 0.0),
            ModeReport::Explore { left } => ("explore", 1.0 - f64::from(left) / moves),
            ModeReport::Learn => ("learn", 0.5),
            ModeReport::Seek => ("seek", 0.0),
            ModeReport::Stopped(_) => ("stopped", 0.0),
            ModeReport::Babble { left } => ("babble", 1.0 - f64::from(left) / moves),
            ModeReport::Calibrate => ("calibrate", 0.5),
        }
    }
}
