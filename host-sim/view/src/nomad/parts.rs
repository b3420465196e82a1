//! What of a watched Nomad is shown.

use super::{Doing, WatchedNomad};
use crate::seen::{meters, millimeters, plan_seen, pose_seen, ring, xy};
use crate::snapshot::{Counts, Now, Part, Ring, Scene, Short, Showable, Snapshot, Xy};
use crate::source::Source as _;
use amp::config::Choice;
use amp::controller::Decision;
use amp::planner::difference;
use amp::units::Displacement;
use arena::robot::COLLISION_RADIUS_M;
use arena::sonar::{RingGeometry, SonarModel};
use sim::behavior::Behavior;
use std::sync::Arc;

impl WatchedNomad {
    pub(super) fn parts(&mut self) -> Snapshot {
        self.shown.revision += 1;
        let revision = self.shown.revision;
        let mut parts: Vec<Arc<dyn Showable>> = vec![self.scene(revision)];
        let learned = self.knows_maps();
        if let Some(known) = &self.mind.known {
            let knowing = &mut self.shown.knowing;
            parts.extend(knowing.parts(revision, known, &self.config, learned));
        }
        Snapshot {
            parts,
            now: Box::new(self.now()),
            trail: self.trail.parts().chain(self.heard.parts()).collect(),
            revision,
        }
    }

    fn scene(&mut self, revision: u64) -> Arc<Part<Scene>> {
        if let Some(scene) = &self.shown.scene {
            return Arc::clone(scene);
        }
        let scene = Arc::new(Part::new("scene", 0, revision, self.scene_now()));
        self.shown.scene = Some(Arc::clone(&scene));
        scene
    }

    fn scene_now(&self) -> Scene {
        let (start, config) = (&self.start, &self.config);
        let place = self
            .nest
            .map_or(self.decided_at.position, |(_, place)| place);
        let about = |name: &&str| [(*name).to_owned(), Behavior::about(name).to_owned()];
        // Another robot to be followed is not known here.
        let names = Behavior::NAMES.iter().filter(|name| **name != "follow");
        Scene {
            world: format!("Nomad at {}", start.name),
            bounds: self.bounds.map(xy),
            shapes: Vec::new(),
            start: xy(place),
            radii_m: [COLLISION_RADIUS_M, RingGeometry::default().face_radius_m].map(Short),
            half_angle_rad: Short(SonarModel::Nomad.config().half_angle_rad),
            near_far_m: [config.encoding.near_mm, config.encoding.far_mm].map(millimeters),
            step_m: millimeters(config.robot.step_mm),
            seed: start.seed.to_string(),
            preset: start.preset.clone(),
            sonar: "the robot's own".to_owned(),
            turret: "held".to_owned(),
            moves: start.explore_moves,
            mind: self.mind.name.clone(),
            recalls: config.planning.choice == Choice::Recall,
            abilities: self.abilities(),
            behaviors: names.map(about).collect(),
            worlds: Vec::new(),
            presets: vec![start.preset.clone()],
        }
    }

    fn now(&self) -> Now {
        let pose = self.session.pose();
        let decision = self.decision;
        let busy = matches!(self.doing, Doing::Explore | Doing::Seek);
        let (situation, heard_at) = match &decision {
            Some(decision) if busy => (decision.situation, self.decided_at),
            _ => (self.perceived(), pose),
        };
        let plan = decision.and_then(|decision| decision.plan);
        let known = self.mind.known.as_deref();
        let plan = plan.and_then(|plan| Some(plan_seen(&plan, known?)));
        let place = self.nest.map_or(pose.position, |(_, place)| place);
        let moved = |way: fn(&Decision<16>) -> Displacement| {
            decision
                .as_ref()
                .map_or(Xy::default(), |it| meters(way(it)))
        };
        let (mode, done) = self.mode();
        let mind = (!self.mind.here).then(|| format!("{} and ", self.mind.name));
        Now {
            time_s: Short(self.time_s),
            step_s: Short(0.1),
            pose: pose_seen(pose),
            heard_at: pose_seen(heard_at),
            mode,
            why: self.failure.clone(),
            note: self.note.clone(),
            resumes: self.doing == Doing::Stopped && self.interrupted != Doing::Idle,
            done: Short(done),
            ranges_m: self.session.ranges_m().map(|range| range.map(Short)),
            on: std::array::from_fn(|sensor| self.config.believed.contains(sensor)),
            situation: ring(&situation),
            changed: self.changed(),
            plan,
            wanted_m: moved(|decision| decision.wanted),
            allowed_m: moved(|decision| decision.allowed),
            touched: self.open.is_some_and(|open| open.touched),
            goal: self.goal.seen(&self.config, &self.nest(), place),
            counts: self.counts(),
            shield: self.config.shield.is_some(),
            online: self.config.online.is_some(),
            leader: None,
            link: Some(format!("{}{}", mind.unwrap_or_default(), self.start.name)),
            pace: Default::default(),
            trail: self.trail.ends(),
            at: None,
            heard: self.heard.ends(),
        }
    }

    fn changed(&self) -> Option<Ring> {
        let (now, before) = (self.decision.as_ref()?, self.before.as_ref()?);
        Some(ring(&difference(&now.situation, before)))
    }

    fn mode(&self) -> (&'static str, f64) {
        let moves = f64::from(self.start.explore_moves.max(1));
        match self.doing {
            _ if self.failure.is_some() => ("failed", 0.0),
            Doing::Idle => ("idle", 0.0),
            Doing::Explore => ("explore", f64::from(self.explored[0]) / moves),
            Doing::Learn => ("learn", 0.5),
            Doing::Seek => ("seek", 0.0),
            Doing::Stopped => ("stopped", 0.0),
        }
    }

    fn counts(&self) -> Counts {
        let [steps, contacts, shielded, at_goal] = self.steps;
        Counts {
            explored: self.explored,
            steps,
            contacts,
            shielded,
            at_goal,
            distance_m: Short(self.distance_m),
            clearance_m: None,
            coverage_m2: None,
        }
    }
}
