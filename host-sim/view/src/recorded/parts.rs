//! What of a recording is shown.

use super::Recorded;
use crate::seen::{meters, millimeters, plan_seen, pose_seen, ring, xy};
use crate::snapshot::{Counts, Now, Part, Ring, Scene, Short, Showable, Snapshot, Xy};
use crate::source::Source as _;
use amp::config::Choice;
use amp::controller::{Decision, Mode};
use amp::fixed::Weight;
use amp::planner::difference;
use amp::units::{Displacement, Range};
use arena::robot::COLLISION_RADIUS_M;
use arena::sonar::{RingGeometry, SonarModel};
use remote::log::Ending;
use sim::behavior::Behavior;
use std::sync::Arc;

impl Recorded {
    pub(super) fn parts(&mut self) -> Snapshot {
        self.shown.revision += 1;
        let revision = self.shown.revision;
        let mut parts: Vec<Arc<dyn Showable>> = vec![self.scene(revision)];
        let (mind, learns) = (self.playing.replayer.controller(), self.learns());
        let learned = learns || mind.state().has_learned();
        let knowing = &mut self.shown.knowing;
        parts.extend(knowing.parts(revision, mind.state(), mind.config(), learned));
        let heard = self.playing.heard.parts();
        Snapshot {
            parts,
            now: Box::new(self.now()),
            trail: self.tape.trail.parts().chain(heard).collect(),
            revision,
        }
    }

    pub(super) fn learns(&self) -> bool {
        matches!(
            self.playing.replayer.controller().state().mode(),
            Mode::Learn { .. }
        )
    }

    fn scene(&mut self, revision: u64) -> Arc<Part<Scene>> {
        let changes = self.playing.scene_changes;
        if let Some((_, scene)) = self.shown.scene.as_ref().filter(|(of, _)| *of == changes) {
            return Arc::clone(scene);
        }
        let scene = Arc::new(Part::new("scene", 0, revision, self.scene_now()));
        self.shown.scene = Some((changes, Arc::clone(&scene)));
        scene
    }

    fn scene_now(&self) -> Scene {
        let (playing, setup) = (&self.playing, &self.playing.setup);
        let config = playing.replayer.controller().config();
        let [low, high] = self.tape.bounds;
        let sonar = setup.sonar.parse().unwrap_or(SonarModel::Nomad);
        let about = |name: &&str| [(*name).to_owned(), Behavior::about(name).to_owned()];
        Scene {
            world: setup.world.clone(),
            bounds: [xy(low), xy(high)],
            shapes: playing.shapes.to_vec(),
            start: xy(playing.start.unwrap_or_default()),
            radii_m: [COLLISION_RADIUS_M, RingGeometry::default().face_radius_m].map(Short),
            half_angle_rad: Short(sonar.config().half_angle_rad),
            near_far_m: [config.encoding.near_mm, config.encoding.far_mm].map(millimeters),
            step_m: millimeters(config.robot.step_mm),
            seed: setup.seed.to_string(),
            preset: setup.preset.clone(),
            sonar: setup.sonar.clone(),
            turret: setup.turret.clone(),
            moves: setup.explore_moves,
            mind: "from the log".to_owned(),
            recalls: config.planning.choice == Choice::Recall,
            abilities: self.abilities(),
            behaviors: Behavior::NAMES.iter().map(about).collect(),
            worlds: vec![setup.world.clone()],
            presets: vec![setup.preset.clone()],
        }
    }

    fn now(&self) -> Now {
        let playing = &self.playing;
        let mind = playing.replayer.controller();
        let (config, state) = (mind.config(), mind.state());
        let decision = playing.decision;
        let plan = decision.and_then(|decision| decision.plan);
        let moved = |way: fn(&Decision<16>) -> Displacement| {
            decision
                .as_ref()
                .map_or(Xy::default(), |it| meters(way(it)))
        };
        let perceived = || {
            let range = |range: Option<f64>| range.map(|m| Range::from_mm((m * 1e3) as u16));
            playing.ranges_m.map(|m| config.encoding.value(range(m)))
        };
        let situation = decision.map_or_else(perceived, |decision| decision.situation);
        let nest = playing.nest.map_or([Weight::ZERO; 16], |(nest, _)| nest);
        let place = playing
            .nest
            .map_or(playing.pose.position, |(_, place)| place);
        let goal = playing.goal.as_ref();
        let (mode, done) = self.mode();
        let piece = playing.starts.checked_sub(1);
        let piece = piece.and_then(|start| self.tape.starts.get(start).copied());
        Now {
            time_s: Short(playing.time_s),
            step_s: Short(playing.step_s),
            pose: pose_seen(playing.pose),
            heard_at: pose_seen(playing.heard_at),
            mode,
            why: playing.difference.clone(),
            note: self.note(),
            resumes: false,
            done: Short(done),
            ranges_m: playing.ranges_m.map(|range| range.map(Short)),
            on: std::array::from_fn(|sensor| mind.enabled().contains(sensor)),
            situation: ring(&situation),
            changed: self.changed(),
            plan: plan.map(|plan| plan_seen(&plan, state)),
            wanted_m: moved(|decision| decision.wanted),
            allowed_m: moved(|decision| decision.allowed),
            touched: playing.touched,
            goal: goal.map_or_else(Default::default, |goal| goal.seen(config, &nest, place)),
            counts: Counts {
                distance_m: Short(playing.distance_m),
                coverage_m2: Some(Short(playing.coverage.area_m2())),
                ..playing.counts.clone()
            },
            shield: config.shield.is_some(),
            online: config.online.is_some(),
            leader: playing.leader.map(xy),
            link: None,
            pace: Default::default(),
            trail: [piece.unwrap_or(0), self.tape.trail.ends()[1]],
            at: Some(playing.decided),
            heard: playing.heard.ends(),
        }
    }

    fn note(&self) -> Option<String> {
        let over = self.is_over() && self.playing.difference.is_none();
        over.then(|| match &self.tape.ending {
            Ending::Complete => "The recording ends here".to_owned(),
            ending => format!("The recording ends here, {ending}"),
        })
    }

    fn changed(&self) -> Option<Ring> {
        let (now, before) = (
            self.playing.decision.as_ref()?,
            self.playing.before.as_ref()?,
        );
        Some(ring(&difference(&now.situation, before)))
    }

    /// What the robot does, and how much of it is done.
    fn mode(&self) -> (&'static str, f64) {
        let moves = f64::from(self.playing.setup.explore_moves.max(1));
        match self.playing.replayer.controller().state().mode() {
            Mode::Idle => ("idle", 0.0),
            Mode::Explore { left } => ("explore", 1.0 - f64::from(*left) / moves),
            Mode::Learn { .. } => ("learn", 0.5),
            Mode::Seek { .. } => ("seek", 0.0),
            Mode::Stopped(_) => ("stopped", 0.0),
        }
    }
}
