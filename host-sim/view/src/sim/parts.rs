//! Builds the snapshot of the simulator.

use super::{Simulator, SimulatorActivity};
use crate::dto::{
    beams, displacements, found, millimeters, plan_dto, pose_dto, ring, ring_ranges, shape_dto,
    source_dtos, xy,
};
use crate::snapshot::{
    DriveCounts, GoalDto, LiveState, PartMessage, RingValues, Rounded, SceneDto, SensorDto,
    Snapshot, SnapshotPart,
};
use crate::source::ViewSource as _;
use amp::config::PlannerKind;
use amp::planner::difference;
use arena::robot_model::SensorMount;
use arena::sonar::RingGeometry;
use arena::world::World;
use sim::behavior::Behavior;
use sim::robot::AnyRobot;
use std::sync::Arc;

impl Simulator {
    pub(super) fn parts(&mut self) -> Snapshot {
        self.cache.revision += 1;
        let revision = self.cache.revision;
        if let Err(failure) = self.controller.pilot().cached_state() {
            self.fail(failure.to_string());
        }
        let mut parts: Vec<Arc<dyn PartMessage>> = vec![self.scene(revision)];
        parts.extend(self.maps_and_memory(revision));
        parts.extend(self.places(revision));
        Snapshot {
            parts,
            now: Box::new(self.now()),
            trail: self.trail.parts().collect(),
            revision,
        }
    }

    fn scene(&mut self, revision: u64) -> Arc<SnapshotPart<SceneDto>> {
        if let Some(scene) = &self.cache.scene {
            return Arc::clone(scene);
        }
        let scene = Arc::new(SnapshotPart::new("scene", 0, revision, scene(self)));
        self.cache.scene = Some(Arc::clone(&scene));
        scene
    }

    fn maps_and_memory(&mut self, revision: u64) -> Vec<Arc<dyn PartMessage>> {
        let learned = self.learned || self.activity == SimulatorActivity::Learn;
        let Ok(known) = self.controller.pilot().cached_state() else {
            return Vec::new();
        };
        let parts = self
            .cache
            .knowledge
            .parts(revision, known, &self.config, learned);
        parts.into()
    }

    fn now(&mut self) -> LiveState {
        let pose = self.body.pose();
        let (situation, ranges_m, scan_pose) = match (&self.decision, self.is_busy()) {
            (Some(decision), true) => (decision.situation, self.ranges_m, self.scan_pose),
            _ => (self.perceived(), self.body.look(), pose),
        };
        let (mode, progress) = self.mode();
        let robot = self.start.setup.robot.as_ref();
        let count = robot.map(|robot| robot.mounts().len());
        let way = self.way();
        let turret = self.controller.inner().as_turret();
        LiveState {
            time_s: Rounded(self.body.time_s()),
            step_s: Rounded(self.step_s),
            pose: pose_dto(pose),
            scan_pose: pose_dto(scan_pose),
            thinks: self.thinks(),
            way,
            mode,
            why: self.failure.clone(),
            note: self.note.clone(),
            resumes: self.activity == SimulatorActivity::Stopped
                && self.interrupted != SimulatorActivity::Idle,
            progress: Rounded(progress),
            ranges_m: ring_ranges(turret, &ranges_m),
            beams_m: count.map(|count| beams(&ranges_m, count)),
            found: turret.and_then(|turret| Some(found(&turret.known_body(), count?))),
            enabled: std::array::from_fn(|sensor| {
                self.controller.inner().enabled().contains(sensor)
            }),
            situation: ring(&situation),
            shown: self.recorder.state(),
            counts: self.counts(),
            shield: self.config.shield.is_some(),
            online: self.config.online.is_some(),
            sensed: self.sensed(),
            leader: self.body.leader().map(xy),
            link: (!self.controller.inner().is_local()).then(|| self.controller.inner().name()),
            trail: self.trail.ends(),
            ..self.decision_state()
        }
    }

    /// The fields of the latest decision and its goal.
    fn decision_state(&mut self) -> LiveState {
        let plan = self.decision.and_then(|decision| decision.plan);
        let known = self.controller.pilot().cached_state().ok();
        let plan = plan.and_then(|plan| Some(plan_dto(&plan, known?)));
        let [wanted_m, allowed_m] = displacements(self.decision.as_ref());
        let goal = self.goal.to_dto(&self.config, &self.nest(), self.home());
        LiveState {
            changed: self.changed(),
            plan,
            wanted_m,
            allowed_m,
            touched: self.touched,
            goal: GoalDto {
                tour: self.goal.tour(self.seeking.steps),
                ..goal
            },
            ..LiveState::default()
        }
    }

    fn changed(&self) -> Option<RingValues> {
        let (now, before) = (self.decision.as_ref()?, self.before.as_ref()?);
        Some(ring(&difference(&now.situation, before)))
    }

    /// The mode, and its progress.
    fn mode(&self) -> (&'static str, f64) {
        let moves = f64::from(self.start.setup.explore_moves);
        match self.activity {
            _ if self.failure.is_some() => ("failed", 0.0),
            SimulatorActivity::Idle => ("idle", 0.0),
            SimulatorActivity::Babble => {
                let moves = f64::from(self.start.setup.calibration_moves().max(1));
                let left = self.controller.inner().babble_moves_left();
                (
                    "babble",
                    left.map_or(0.5, |left| 1.0 - f64::from(left) / moves),
                )
            }
            SimulatorActivity::Calibrate => ("calibrate", 0.5),
            SimulatorActivity::Explore => ("explore", f64::from(self.explored.steps) / moves),
            SimulatorActivity::Learn => ("learn", f64::from(self.learning) / learning_ticks(self)),
            SimulatorActivity::Seek => ("seek", 0.0),
            SimulatorActivity::Stopped => ("stopped", 0.0),
        }
    }

    fn counts(&self) -> DriveCounts {
        let (explored, seeking) = (&self.explored, &self.seeking);
        DriveCounts {
            explored: [explored.steps, explored.contacts],
            steps: seeking.steps,
            contacts: seeking.contacts,
            shielded: seeking.shield_stops,
            at_goal: seeking.goal_steps,
            distance_m: Rounded(seeking.distance_m),
            clearance_m: seeking.min_clearance_m.map(Rounded),
            coverage_m2: Some(Rounded(seeking.coverage_m2())),
        }
    }
}

/// Approximate number of ticks that learning takes.
fn learning_ticks(simulator: &Simulator) -> f64 {
    let learning = &simulator.config.learning;
    let samples = simulator.cache.knowledge.samples().max(1) as f64;
    let presentations = f64::from(learning.epochs) * samples;
    (presentations / f64::from(learning.slice.max(1))).max(1.0)
}

fn scene(simulator: &Simulator) -> SceneDto {
    let (world, setup) = (simulator.body.world(), &simulator.start.setup);
    let config = &simulator.config;
    let (low, high) = world.bounds();
    let robot = setup.robot.as_ref();
    let (face_radius_m, half_angle_rad) = match robot {
        None => (
            RingGeometry::default().face_radius_m,
            setup.sonar.config().half_angle_rad,
        ),
        Some(robot) => (
            f64::from(robot.body().points.face_radius_mm) / 1e3,
            robot.sensing(setup.sonar).half_angle_rad,
        ),
    };
    let led = ["home", "scent:strongest", "light:strongest", "floor:red"];
    let led = led.into_iter().filter(|_| simulator.has_places());
    let names = Behavior::NAMES.into_iter().chain(led);
    let about = |name: &str| {
        let kind = name.split(':').next().unwrap_or(name);
        [name.to_owned(), Behavior::about(kind).to_owned()]
    };
    let mut worlds: Vec<_> = World::builtin_names()
        .iter()
        .map(|&name| name.to_owned())
        .collect();
    if !worlds.contains(&simulator.start.named) {
        worlds.push(simulator.start.named.clone());
    }
    SceneDto {
        world: simulator.start.named.clone(),
        bounds: [xy(low), xy(high)],
        shapes: world.shapes().iter().map(shape_dto).collect(),
        sources: source_dtos(world.sources()),
        start: xy(world.start().position),
        radii_m: [simulator.body.radius_m(), face_radius_m].map(Rounded),
        half_angle_rad: Rounded(half_angle_rad),
        robot: robot.map(|robot| robot.model().name.clone()),
        sensors: robot.map(sensors),
        near_far_m: [config.encoding.near_mm, config.encoding.far_mm].map(millimeters),
        step_m: millimeters(config.robot.step_mm),
        seed: setup.seed.to_string(),
        preset: setup.preset.clone(),
        sonar: setup.sonar.name().to_owned(),
        turret: setup.turret.name().to_owned(),
        moves: setup.explore_moves,
        controller: simulator.controller.inner().name(),
        recalls: config.planning.planner == PlannerKind::Recall,
        abilities: simulator.abilities(),
        behaviors: names.map(about).collect(),
        worlds,
        presets: simulator
            .start
            .presets
            .iter()
            .map(|preset| preset.name.to_owned())
            .collect(),
    }
}

/// Where a robot's sensors stand and look, in the order of the controller's inputs.
fn sensors(robot: &AnyRobot) -> Vec<SensorDto> {
    let mounts = robot.mounts().into_iter();
    let dto = |mount: SensorMount| {
        let SensorMount {
            position,
            bearing_rad,
            ..
        } = mount;
        [position.x, position.y, bearing_rad].map(Rounded)
    };
    mounts.map(dto).collect()
}
