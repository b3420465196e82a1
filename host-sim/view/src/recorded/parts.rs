//! Builds the snapshot of a log.

use super::WatchedLog;
use crate::dto::{
    beams, displacements, found, millimeters, plan_dto, pose_dto, ring, ring_ranges, xy,
};
use crate::snapshot::{
    DriveCounts, LiveState, PartMessage, RingValues, Rounded, SceneDto, Snapshot, SnapshotPart,
};
use crate::source::ViewSource as _;
use amp::config::PlannerKind;
use amp::controller::Mode;
use amp::fixed::Weight;
use amp::planner::difference;
use amp::scan::Situation;
use amp::units::Range;
use arena::robot::COLLISION_RADIUS_M;
use arena::sonar::{RingGeometry, SonarModel};
use remote::log::{Ending, RobotRecord};
use sim::behavior::Behavior;
use std::sync::Arc;

impl WatchedLog {
    pub(super) fn parts(&mut self) -> Snapshot {
        self.cache.revision += 1;
        let revision = self.cache.revision;
        let mut parts: Vec<Arc<dyn PartMessage>> = vec![self.scene(revision)];
        let (controller, learns) = (self.playback.replayer.controller(), self.learns());
        let learned = learns || controller.state().has_learned();
        let knowledge = &mut self.cache.knowledge;
        parts.extend(knowledge.parts(revision, controller.state(), controller.config(), learned));
        parts.extend(self.places(revision));
        let echo_trail = self.playback.echo_trail.parts();
        Snapshot {
            parts,
            now: Box::new(self.now()),
            trail: self.timeline.trail.parts().chain(echo_trail).collect(),
            revision,
        }
    }

    pub(super) fn learns(&self) -> bool {
        matches!(
            self.playback.replayer.controller().state().mode(),
            Mode::Learn { .. }
        )
    }

    fn places(&mut self, revision: u64) -> Option<Arc<dyn PartMessage>> {
        let playback = &self.playback;
        let controller = playback.replayer.controller().as_turret()?;
        let sought = playback.sought;
        let remembered = sought.map_or_else(Vec::new, |goal| controller.senses().remembered(goal));
        let places = playback.seen_places()?.dto(&remembered);
        let kept = &mut self.cache.places;
        Some(SnapshotPart::kept(kept, "places", revision, places))
    }

    fn scene(&mut self, revision: u64) -> Arc<SnapshotPart<SceneDto>> {
        let changes = self.playback.scene_changes;
        if let Some((_, scene)) = self.cache.scene.as_ref().filter(|(of, _)| *of == changes) {
            return Arc::clone(scene);
        }
        let scene = Arc::new(SnapshotPart::new("scene", 0, revision, self.scene_now()));
        self.cache.scene = Some((changes, Arc::clone(&scene)));
        scene
    }

    fn scene_now(&self) -> SceneDto {
        let (playback, setup) = (&self.playback, &self.playback.setup);
        let config = playback.replayer.controller().config();
        let [low, high] = self.timeline.bounds;
        let sonar = setup.sonar.parse().unwrap_or(SonarModel::Nomad);
        let about = |name: &&str| [(*name).to_owned(), Behavior::about(name).to_owned()];
        let robot = setup.robot.as_ref();
        let (radius_m, face_radius_m, half_angle_rad) = match robot {
            None => (
                COLLISION_RADIUS_M,
                RingGeometry::default().face_radius_m,
                sonar.config().half_angle_rad,
            ),
            Some(robot) => (robot.radius_m, robot.face_radius_m, robot.half_cone_rad),
        };
        let sensors = |robot: &RobotRecord| {
            let sensors = robot.sensors.iter();
            sensors.map(|sensor| sensor.map(Rounded)).collect()
        };
        SceneDto {
            robot: robot.map(|robot| robot.name.clone()),
            sensors: robot.map(|robot| sensors(robot)),
            world: setup.world.clone(),
            bounds: [xy(low), xy(high)],
            shapes: playback.shapes.to_vec(),
            sources: playback.sources.to_vec(),
            start: xy(playback.start.unwrap_or_default()),
            radii_m: [radius_m, face_radius_m].map(Rounded),
            half_angle_rad: Rounded(half_angle_rad),
            near_far_m: [config.encoding.near_mm, config.encoding.far_mm].map(millimeters),
            step_m: millimeters(config.robot.step_mm),
            seed: setup.seed.to_string(),
            preset: setup.preset.clone(),
            sonar: setup.sonar.clone(),
            turret: setup.turret.clone(),
            moves: setup.explore_moves,
            controller: "from the log".to_owned(),
            recalls: config.planning.planner == PlannerKind::Recall,
            abilities: self.abilities(),
            behaviors: Behavior::NAMES.iter().map(about).collect(),
            worlds: vec![setup.world.clone()],
            presets: vec![setup.preset.clone()],
        }
    }

    fn now(&self) -> LiveState {
        let playback = &self.playback;
        let controller = playback.replayer.controller();
        let (config, turret) = (controller.config(), controller.as_turret());
        let robot = playback.setup.robot.as_ref();
        let count = robot.map(|robot| robot.sensors.len());
        let (mode, progress) = self.mode();
        let start = playback.starts.checked_sub(1);
        let first_chunk = start.and_then(|start| self.timeline.starts.get(start).copied());
        LiveState {
            time_s: Rounded(playback.time_s),
            step_s: Rounded(playback.step_s),
            pose: pose_dto(playback.pose),
            scan_pose: pose_dto(playback.scan_pose),
            mode,
            why: playback.difference.clone(),
            note: self.note(),
            progress: Rounded(progress),
            ranges_m: ring_ranges(turret, &playback.ranges_m),
            beams_m: count.map(|count| beams(&playback.ranges_m, count)),
            found: turret.and_then(|turret| Some(found(&turret.known_body(), count?))),
            thinks: (playback.seen_places()).and_then(|places| places.thinks()),
            way: playback.way(),
            enabled: std::array::from_fn(|sensor| controller.enabled().contains(sensor)),
            counts: DriveCounts {
                distance_m: Rounded(playback.distance_m),
                coverage_m2: Some(Rounded(playback.coverage.area_m2())),
                ..playback.counts.clone()
            },
            shield: config.shield.is_some(),
            online: config.online.is_some(),
            leader: playback.leader.map(xy),
            trail: [first_chunk.unwrap_or(0), self.timeline.trail.ends()[1]],
            at: Some(playback.decided),
            echo_trail: playback.echo_trail.ends(),
            ..self.decision_state()
        }
    }

    /// The fields of the latest decision and its goal.
    fn decision_state(&self) -> LiveState {
        let playback = &self.playback;
        let controller = playback.replayer.controller();
        let (config, state) = (controller.config(), controller.state());
        let decision = playback.decision;
        let plan = decision.and_then(|decision| decision.plan);
        let [wanted_m, allowed_m] = displacements(decision.as_ref());
        let situation = decision.map_or_else(|| self.perceived(), |decision| decision.situation);
        let nest = playback.nest.map_or([Weight::ZERO; 16], |(nest, _)| nest);
        let place = playback
            .nest
            .map_or(playback.pose.position, |(_, place)| place);
        let goal = playback.goal.as_ref();
        LiveState {
            situation: ring(&situation),
            changed: self.changed(),
            plan: plan.map(|plan| plan_dto(&plan, state)),
            wanted_m,
            allowed_m,
            touched: playback.touched,
            goal: goal.map_or_else(Default::default, |goal| goal.to_dto(config, &nest, place)),
            ..LiveState::default()
        }
    }

    /// The latest ranges as a situation; only a decision reads that off what a body hears.
    fn perceived(&self) -> Situation<16> {
        if self.playback.setup.robot.is_some() {
            return [Weight::ZERO; 16];
        }
        let encoding = self.playback.replayer.controller().config().encoding;
        let range = |range: Option<f64>| range.map(|m| Range::from_mm((m * 1e3) as u16));
        self.playback.ranges_m.map(|m| encoding.value(range(m)))
    }

    fn note(&self) -> Option<String> {
        let over = self.is_over() && self.playback.difference.is_none();
        over.then(|| match &self.timeline.ending {
            Ending::Complete => "The recording ends here".to_owned(),
            ending => format!("The recording ends here, {ending}"),
        })
    }

    fn changed(&self) -> Option<RingValues> {
        let (now, before) = (
            self.playback.decision.as_ref()?,
            self.playback.before.as_ref()?,
        );
        Some(ring(&difference(&now.situation, before)))
    }

    /// The mode, and its progress.
    fn mode(&self) -> (&'static str, f64) {
        let moves = f64::from(self.playback.setup.explore_moves.max(1));
        match self.playback.replayer.controller().state().mode() {
            Mode::Idle => ("idle", 0.0),
            Mode::Explore { left } => ("explore", 1.0 - f64::from(*left) / moves),
            Mode::Learn { .. } => ("learn", 0.5),
            Mode::Seek { .. } => ("seek", 0.0),
            Mode::Stopped(_) => ("stopped", 0.0),
            Mode::Babble { left } => ("babble", 1.0 - f64::from(*left) / moves),
            Mode::Calibrate => ("calibrate", 0.5),
        }
    }
}
