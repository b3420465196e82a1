//! What of a simulation is shown.

use super::{Doing, Simulator};
use crate::robot::{COLLISION_RADIUS_M, TurretMode};
use crate::scenes::Behavior;
use crate::sonar::RingGeometry;
use crate::view::snapshot::{
    Counts, MapSeen, Maps, Now, Part, PlanSeen, Ring, Row, Scene, ShapeSeen, Short, Showable,
    Snapshot, Xy,
};
use crate::view::source::Abilities;
use crate::world::{Point, Pose, Shape, World};
use amp::action_map::Effect;
use amp::config::{Choice, Config};
use amp::fixed::{Scalar, coarse};
use amp::memory::{Sample, from_bytes};
use amp::planner::{Plan, difference};
use amp::scan::Situation;
use amp::som::{Grid, Som};
use amp::units::Displacement;
use std::sync::Arc;

impl Simulator {
    pub(super) fn parts(&mut self) -> Snapshot {
        self.shown.revision += 1;
        let revision = self.shown.revision;
        if let Err(failure) = self.mind.known() {
            self.fail(failure.to_string());
        }
        let mut parts: Vec<Arc<dyn Showable>> = vec![self.scene(revision)];
        parts.extend(self.maps_and_memory(revision));
        Snapshot {
            parts,
            now: Box::new(self.now()),
            trail: self.trail.parts().collect(),
            revision,
        }
    }

    fn scene(&mut self, revision: u64) -> Arc<Part<Scene>> {
        if let Some(scene) = &self.shown.scene {
            return Arc::clone(scene);
        }
        let scene = Arc::new(Part::new("scene", 0, revision, scene(self)));
        self.shown.scene = Some(Arc::clone(&scene));
        scene
    }

    fn maps_and_memory(&mut self, revision: u64) -> Vec<Arc<dyn Showable>> {
        let samples = self
            .mind
            .known()
            .map_or(0, |known| known.memory().samples().len());
        if samples != self.shown.samples {
            (self.shown.memory, self.shown.maps) = (None, None);
            self.shown.samples = samples;
        }
        let shows_maps = self.learnt || self.doing == Doing::Learn;
        let config = self.config.clone();
        let Ok(known) = self.mind.known() else {
            return Vec::new();
        };
        let maps = self.shown.maps.get_or_insert_with(|| {
            let seen = if shows_maps {
                maps(known, &config)
            } else {
                Maps::default()
            };
            Arc::new(Part::new("maps", 0, revision, seen))
        });
        let memory = self.shown.memory.get_or_insert_with(|| {
            let rows = known.memory().samples().iter().map(row).collect();
            Arc::new(Part::new("memory", 0, revision, rows))
        });
        vec![Arc::clone(maps) as _, Arc::clone(memory) as _]
    }

    fn now(&mut self) -> Now {
        let pose = self.body.pose();
        let (situation, ranges_m, heard_at) = match (&self.decision, self.is_busy()) {
            (Some(decision), true) => (decision.situation, self.ranges_m, self.heard_at),
            _ => (self.perceived(), self.body.look(), pose),
        };
        let decision = self.decision;
        let plan = decision.and_then(|decision| decision.plan);
        let plan = plan.and_then(|plan| Some(plan_seen(&plan, self.mind.known().ok()?)));
        let (mode, done) = self.mode();
        let nest = self.nest();
        let start = self.nest.map_or(pose.position, |(_, place)| place);
        let moved = |way: fn(&amp::controller::Decision<16>) -> Displacement| {
            decision
                .as_ref()
                .map_or(Xy::default(), |decision| meters(way(decision)))
        };
        Now {
            time_s: Short(self.body.time_s()),
            step_s: Short(self.step_s),
            pose: pose_seen(pose),
            heard_at: pose_seen(heard_at),
            mode,
            why: self.failure.clone(),
            resumes: self.doing == Doing::Stopped && self.interrupted != Doing::Idle,
            done: Short(done),
            ranges_m: ranges_m.map(|range| range.map(Short)),
            on: std::array::from_fn(|sensor| self.config.believed.contains(sensor)),
            situation: ring(&situation),
            changed: self.changed(),
            plan,
            wanted_m: moved(|decision| decision.wanted),
            allowed_m: moved(|decision| decision.allowed),
            touched: self.touched,
            goal: self.goal.seen(&self.config, &nest, start),
            counts: self.counts(),
            shield: self.config.shield.is_some(),
            online: self.config.online.is_some(),
            leader: self.body.leader().map(xy),
            link: (!self.mind.is_here()).then(|| self.mind.name()),
            pace: Default::default(),
            trail: self.trail.ends(),
        }
    }

    fn changed(&self) -> Option<Ring> {
        let (now, before) = (self.decision.as_ref()?, self.before.as_ref()?);
        Some(ring(&difference(&now.situation, before)))
    }

    /// What the robot does, and how much of it is done.
    fn mode(&self) -> (&'static str, f64) {
        let moves = f64::from(self.start.setup.explore_moves);
        match self.doing {
            _ if self.failure.is_some() => ("failed", 0.0),
            Doing::Idle => ("idle", 0.0),
            Doing::Explore => ("explore", f64::from(self.explored.steps) / moves),
            Doing::Learn => ("learn", f64::from(self.learning) / learning_ticks(self)),
            Doing::Seek => ("seek", 0.0),
            Doing::Stopped => ("stopped", 0.0),
        }
    }

    fn counts(&self) -> Counts {
        let (explored, seeking) = (&self.explored, &self.seeking);
        Counts {
            explored: [explored.steps, explored.contacts],
            steps: seeking.steps,
            contacts: seeking.contacts,
            shielded: seeking.shield_stops,
            at_goal: seeking.goal_steps,
            distance_m: Short(seeking.distance_m),
            clearance_m: seeking.min_clearance_m.map(Short),
            coverage_m2: Short(seeking.coverage_m2()),
        }
    }
}

/// About how many ticks learning takes.
fn learning_ticks(simulator: &Simulator) -> f64 {
    let learning = &simulator.config.learning;
    let samples = simulator.shown.samples.max(1) as f64;
    let presentations = f64::from(learning.epochs) * samples;
    (presentations / f64::from(learning.slice.max(1))).max(1.0)
}

fn scene(simulator: &Simulator) -> Scene {
    let (world, setup) = (simulator.body.world(), &simulator.start.setup);
    let config = &simulator.config;
    let (low, high) = world.bounds();
    let about = |name: &str| [name.to_owned(), Behavior::about(name).to_owned()];
    let mut worlds: Vec<_> = World::builtin_names()
        .iter()
        .map(|&name| name.to_owned())
        .collect();
    if !worlds.contains(&simulator.start.named) {
        worlds.push(simulator.start.named.clone());
    }
    Scene {
        world: simulator.start.named.clone(),
        bounds: [xy(low), xy(high)],
        shapes: world.shapes().iter().map(shape_seen).collect(),
        start: xy(world.start().position),
        radii_m: [COLLISION_RADIUS_M, RingGeometry::default().face_radius_m].map(Short),
        half_angle_rad: Short(setup.sonar.config().half_angle_rad),
        near_far_m: [config.encoding.near_mm, config.encoding.far_mm].map(millimeters),
        step_m: millimeters(config.robot.step_mm),
        seed: setup.seed.to_string(),
        preset: setup.preset.clone(),
        sonar: setup.sonar.name().to_owned(),
        turret: match setup.turret {
            TurretMode::Held => "held".to_owned(),
            TurretMode::Follow => "follow".to_owned(),
        },
        moves: setup.explore_moves,
        mind: simulator.mind.name(),
        recalls: config.planning.choice == Choice::Recall,
        abilities: Abilities {
            drive: true,
            pace: true,
            carry: true,
            reset: true,
            configure: true,
            save: true,
            load: simulator.mind.is_here(),
        },
        behaviors: Behavior::NAMES.iter().map(|name| about(name)).collect(),
        worlds,
        presets: simulator
            .start
            .presets
            .iter()
            .map(|preset| preset.name.to_owned())
            .collect(),
    }
}

fn shape_seen(shape: &Shape) -> ShapeSeen {
    match shape {
        Shape::Wall { points } => ShapeSeen::Wall(points.iter().copied().map(xy).collect()),
        Shape::Outline { from, to } => ShapeSeen::Wall([*from, *to].map(xy).to_vec()),
        Shape::Box {
            center,
            size,
            angle,
        } => ShapeSeen::Box(Shape::box_corners(*center, *size, *angle).map(xy).to_vec()),
        Shape::Circle { center, radius } => ShapeSeen::Circle(xy(*center), Short(*radius)),
    }
}

fn maps(known: &crate::pilot::SimState, config: &Config<16>) -> Maps {
    let (situations, actions) = (known.situations(), known.actions());
    let rows: Vec<_> = known
        .memory()
        .samples()
        .iter()
        .map(|sample| answering(known, config, sample))
        .collect();
    let hits = |map: usize| {
        let mut hits = vec![0; 16];
        for row in &rows {
            if let Some(hits) = hits.get_mut(row[map]) {
                *hits += 1;
            }
        }
        hits
    };
    let decode = |code: &[_; 2]| {
        let code = [coarse(code[0]), coarse(code[1])];
        meters(config.action_code.decode(code, config.robot.step_mm))
    };
    Maps {
        grid: [situations.grid().columns(), situations.grid().rows()],
        learnt: true,
        situations: map_seen(situations, hits(0)),
        changes: map_seen(actions.changes(), hits(1)),
        actions_m: actions.actions().code().iter().map(decode).collect(),
        rows,
    }
}

/// The neurons that answer to a sample in either map.
fn answering(
    known: &crate::pilot::SimState,
    config: &Config<16>,
    sample: &Sample<16>,
) -> [usize; 2] {
    let ((before, believed), (after, too)) =
        (from_bytes(&sample.before), from_bytes(&sample.after));
    let taught = match config.learning.taught {
        amp::config::Taught::Commanded => sample.commanded,
        amp::config::Taught::Executed => sample.executed,
    };
    let effect = Effect {
        change: difference(&after, &before),
        action: config.action_code.encode(taught, config.robot.step_mm),
        mask: believed.and(too),
    };
    let action = known
        .actions()
        .winner(&effect, config.learning.action_weight_q8);
    [known.situations().winner(&after, too), action]
}

fn map_seen(map: &Som<16, 16>, hits: Vec<u32>) -> MapSeen {
    let distances = map.u_matrix();
    MapSeen {
        code: map.code().iter().map(|row| shorts(row)).collect(),
        hits,
        u_matrix: distances
            .iter()
            .map(|&u| Short(f64::from(u) / 8_192.0))
            .collect(),
    }
}

fn plan_seen(plan: &Plan<16>, known: &crate::pilot::SimState) -> PlanSeen {
    let [goal, current, intermediate, action] = [
        plan.goal_neuron,
        plan.current_neuron,
        plan.intermediate_neuron,
        plan.action_neuron,
    ]
    .map(usize::from);
    let changes = known.actions().changes();
    PlanSeen {
        goal,
        current,
        intermediate,
        walk: walk(known.situations(), current, goal),
        action,
        wanted: ring(&plan.wanted),
        known: ring(&changes.code_vector(action.min(changes.code().len() - 1))),
        at_goal: plan.at_goal,
        why: plan.why.to_string(),
    }
}

/// From one neuron to another over direct neighbours, fewest steps, by those most like the goal.
fn walk(map: &Som<16, 16>, from: usize, to: usize) -> Vec<usize> {
    let grid: Grid = map.grid();
    let mut walk = vec![from];
    if from >= grid.len() || to >= grid.len() {
        return walk;
    }
    let goal = map.code_vector(to);
    let mut at = from;
    while at != to && walk.len() <= grid.len() {
        let far = |k: usize| {
            (
                grid.hops(k, to),
                map.distance(k, &goal, amp::fixed::Mask::ALL),
            )
        };
        match grid.neighbours(at).min_by_key(|&k| far(k)) {
            Some(next) => at = next,
            None => break,
        }
        walk.push(at);
    }
    walk
}

fn row(sample: &Sample<16>) -> Row {
    let values = |bytes: &[u8; 16]| {
        let value = |byte: u8| (byte < 255).then(|| Short(f64::from(byte) / 254.0));
        bytes.map(value)
    };
    Row {
        before: values(&sample.before),
        after: values(&sample.after),
        moved_m: meters(sample.executed),
    }
}

fn shorts<T: Scalar>(weights: &[T]) -> Vec<Short> {
    weights
        .iter()
        .map(|weight| Short(weight.fine().to_num()))
        .collect()
}

fn ring(values: &Situation<16>) -> Ring {
    values.map(|value| Short(value.to_num()))
}

fn pose_seen(pose: Pose) -> [Short; 3] {
    [pose.position.x, pose.position.y, pose.heading].map(Short)
}

fn xy(point: Point) -> Xy {
    [point.x, point.y].map(Short)
}

fn millimeters(mm: u16) -> Short {
    Short(f64::from(mm) / 1e3)
}

fn meters(way: Displacement) -> Xy {
    [way.dx_mm, way.dy_mm].map(|mm| Short(f64::from(mm) / 1e3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_walk_goes_over_neighbours_to_the_goal() {
        let map = Som::<16, 16>::zeroed(Grid::rectangle(4, 4));
        let walk = walk(&map, 0, 15);
        assert_eq!(
            (walk.first(), walk.last(), walk.len()),
            (Some(&0), Some(&15), 7)
        );
        assert!(
            walk.windows(2)
                .all(|pair| map.grid().are_neighbours(pair[0], pair[1]))
        );
        assert_eq!(super::walk(&map, 5, 5), [5]);
        assert_eq!(super::walk(&map, 99, 5), [99]);
    }
}
