//! Builds the snapshot of a Nomad.

use super::{NomadActivity, WatchedNomad};
use crate::dto::{displacements, millimeters, plan_dto, pose_dto, ring, xy};
use crate::snapshot::{
    DriveCounts, LiveState, PartMessage, RingValues, Rounded, SceneDto, Snapshot, SnapshotPart,
};
use crate::source::ViewSource as _;
use amp::config::PlannerKind;
use amp::planner::difference;
use arena::robot::COLLISION_RADIUS_M;
use arena::sonar::{RingGeometry, SonarModel};
use sim::behavior::Behavior;
use std::sync::Arc;

impl WatchedNomad {
    pub(super) fn parts(&mut self) -> Snapshot {
        self.cache.revision += 1;
        let revision = self.cache.revision;
        let mut parts: Vec<Arc<dyn PartMessage>> = vec![self.scene(revision)];
        let learned = self.knows_maps();
        if let Some(known) = &self.controller.known {
            let knowledge = &mut self.cache.knowledge;
            parts.extend(knowledge.parts(revision, known, &self.config, learned));
        }
        Snapshot {
            parts,
            now: Box::new(self.now()),
            trail: self.trail.parts().chain(self.echo_trail.parts()).collect(),
            revision,
        }
    }

    fn scene(&mut self, revision: u64) -> Arc<SnapshotPart<SceneDto>> {
        if let Some(scene) = &self.cache.scene {
            return Arc::clone(scene);
        }
        let scene = Arc::new(SnapshotPart::new("scene", 0, revision, self.scene_now()));
        self.cache.scene = Some(Arc::clone(&scene));
        scene
    }

    fn scene_now(&self) -> SceneDto {
        let (start, config) = (&self.start, &self.config);
        let place = self
            .nest
            .map_or(self.decided_at.position, |(_, place)| place);
        let about = |name: &&str| [(*name).to_owned(), Behavior::about(name).to_owned()];
        // There is no robot to follow.
        let names = Behavior::NAMES.iter().filter(|name| **name != "follow");
        SceneDto {
            robot: None,
            sensors: None,
            world: format!("Nomad at {}", start.name),
            bounds: self.bounds.map(xy),
            shapes: Vec::new(),
            sources: Vec::new(),
            start: xy(place),
            radii_m: [COLLISION_RADIUS_M, RingGeometry::default().face_radius_m].map(Rounded),
            half_angle_rad: Rounded(SonarModel::Nomad.config().half_angle_rad),
            near_far_m: [config.encoding.near_mm, config.encoding.far_mm].map(millimeters),
            step_m: millimeters(config.robot.step_mm),
            seed: start.seed.to_string(),
            preset: start.preset.clone(),
            sonar: "the robot's own".to_owned(),
            turret: "held".to_owned(),
            moves: start.explore_moves,
            controller: self.controller.name.clone(),
            recalls: config.planning.planner == PlannerKind::Recall,
            abilities: self.abilities(),
            behaviors: names.map(about).collect(),
            worlds: Vec::new(),
            presets: vec![start.preset.clone()],
        }
    }

    fn now(&self) -> LiveState {
        let pose = self.session.pose();
        let busy = matches!(self.activity, NomadActivity::Explore | NomadActivity::Seek);
        let (situation, scan_pose) = match &self.decision {
            Some(decision) if busy => (decision.situation, self.decided_at),
            _ => (self.perceived(), pose),
        };
        let (mode, progress) = self.mode();
        LiveState {
            time_s: Rounded(self.time_s),
            step_s: Rounded(0.1),
            pose: pose_dto(pose),
            scan_pose: pose_dto(scan_pose),
            mode,
            why: self.failure.clone(),
            note: self.note.clone(),
            resumes: self.activity == NomadActivity::Stopped
                && self.interrupted != NomadActivity::Idle,
            progress: Rounded(progress),
            ranges_m: self.session.ranges_m().map(|range| range.map(Rounded)),
            enabled: std::array::from_fn(|sensor| self.config.enabled.contains(sensor)),
            situation: ring(&situation),
            counts: self.counts(),
            shield: self.config.shield.is_some(),
            online: self.config.online.is_some(),
            link: Some(self.addresses()),
            trail: self.trail.ends(),
            echo_trail: self.echo_trail.ends(),
            ..self.decision_state()
        }
    }

    /// The fields of the latest decision and its goal.
    fn decision_state(&self) -> LiveState {
        let plan = self.decision.and_then(|decision| decision.plan);
        let known = self.controller.known.as_deref();
        let [wanted_m, allowed_m] = displacements(self.decision.as_ref());
        let nest_place = self
            .nest
            .map_or(self.session.pose().position, |(_, place)| place);
        LiveState {
            changed: self.changed(),
            plan: plan.and_then(|plan| Some(plan_dto(&plan, known?))),
            wanted_m,
            allowed_m,
            touched: self.open.is_some_and(|open| open.touched),
            goal: self.goal.to_dto(&self.config, &self.nest(), nest_place),
            ..LiveState::default()
        }
    }

    /// Addresses of the controller, if it is remote, and of the robot.
    fn addresses(&self) -> String {
        match self.controller.is_local {
            true => self.start.name.clone(),
            false => format!("{} and {}", self.controller.name, self.start.name),
        }
    }

    fn changed(&self) -> Option<RingValues> {
        let (now, before) = (self.decision.as_ref()?, self.before.as_ref()?);
        Some(ring(&difference(&now.situation, before)))
    }

    fn mode(&self) -> (&'static str, f64) {
        let moves = f64::from(self.start.explore_moves.max(1));
        match self.activity {
            _ if self.failure.is_some() => ("failed", 0.0),
            NomadActivity::Idle => ("idle", 0.0),
            NomadActivity::Explore => ("explore", f64::from(self.explored[0]) / moves),
            NomadActivity::Learn => ("learn", 0.5),
            NomadActivity::Seek => ("seek", 0.0),
            NomadActivity::Stopped => ("stopped", 0.0),
        }
    }

    fn counts(&self) -> DriveCounts {
        let [steps, contacts, shielded, at_goal] = self.steps;
        DriveCounts {
            explored: self.explored,
            steps,
            contacts,
            shielded,
            at_goal,
            distance_m: Rounded(self.distance_m),
            clearance_m: None,
            coverage_m2: None,
        }
    }
}
