//! Converts maps, memory, plans and worlds into the values that viewers receive.

use super::snapshot::{
    MapDto, Maps, MemoryRow, PartMessage, PlanDto, RingValues, Rounded, SensorDto, ShapeDto,
    SnapshotPart, SourceDto, Xy,
};
use amp::action_map::Effect;
use amp::config::Config;
use amp::controller::Decision;
use amp::fixed::{Scalar, to_weight16};
use amp::memory::{Sample, from_bytes};
use amp::planner::{Plan, difference};
use amp::scan::Situation;
use amp::som::{Grid, Som};
use amp::turret::BodySpec;
use amp::units::Displacement;
use arena::sources::{LAMP_M, Sources, hex};
use arena::world::{Point, Pose, Shape};
use sim::pilot::SimState;
use sim::turret_pilot::TurretController;
use std::sync::Arc;

/// Maps and memory as parts, rebuilt after a change.
#[derive(Default)]
pub(super) struct KnowledgeParts {
    maps: Option<Arc<SnapshotPart<Maps>>>,
    memory: Option<Arc<SnapshotPart<Vec<MemoryRow>>>>,
    samples: usize,
}

impl KnowledgeParts {
    /// Marks the maps as changed.
    pub fn invalidate_maps(&mut self) {
        self.maps = None;
    }

    /// Marks everything as changed.
    pub fn invalidate(&mut self) {
        (self.maps, self.memory) = (None, None);
    }

    /// Number of samples in the latest parts.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// The parts; without `learned` the maps are empty.
    pub fn parts(
        &mut self,
        revision: u64,
        known: &SimState,
        config: &Config<16>,
        learned: bool,
    ) -> [Arc<dyn PartMessage>; 2] {
        let samples = known.memory().samples();
        if samples.len() != self.samples {
            self.invalidate();
            self.samples = samples.len();
        }
        let maps = self.maps.get_or_insert_with(|| {
            let value = if learned {
                maps(known, config)
            } else {
                Maps::default()
            };
            Arc::new(SnapshotPart::new("maps", 0, revision, value))
        });
        let memory = self.memory.get_or_insert_with(|| {
            let rows = samples.iter().map(row).collect();
            Arc::new(SnapshotPart::new("memory", 0, revision, rows))
        });
        [Arc::clone(maps) as _, Arc::clone(memory) as _]
    }
}

/// A shape of the world.
pub(super) fn shape_dto(shape: &Shape) -> ShapeDto {
    match shape {
        Shape::Wall { points } => ShapeDto::Wall(points.iter().copied().map(xy).collect()),
        Shape::Outline { from, to } => ShapeDto::Wall([*from, *to].map(xy).to_vec()),
        Shape::Box {
            center,
            size,
            angle,
        } => ShapeDto::Box(Shape::box_corners(*center, *size, *angle).map(xy).to_vec()),
        Shape::Circle { center, radius } => ShapeDto::Circle(xy(*center), Rounded(*radius)),
    }
}

/// The sources of a world: colored floor, scents, lamps.
pub(super) fn source_dtos(sources: &Sources) -> Vec<SourceDto> {
    let floor = sources.floor.iter().map(|patch| SourceDto {
        kind: "floor",
        at: xy(patch.center),
        reach_m: Rounded(0.0),
        outline: Shape::box_corners(patch.center, patch.size, patch.angle)
            .map(xy)
            .to_vec(),
        color: Some(hex(patch.color)),
    });
    let point = |kind, at, reach_m| SourceDto {
        kind,
        at: xy(at),
        reach_m: Rounded(reach_m),
        outline: Vec::new(),
        color: None,
    };
    let scents = sources.scents.iter();
    let scents = scents.map(|scent| point("scent", scent.position, scent.reach_m));
    let lights = sources.lights.iter();
    let lights = lights.map(|light| point("light", light.position, LAMP_M));
    floor.chain(scents).chain(lights).collect()
}

/// The ranges that the controller reads its situation off, meters: those of a ring, or of the ring
/// of sectors of a body.
pub(super) fn ring_ranges(
    turret: Option<&TurretController>,
    ranges_m: &[Option<f64>; 16],
) -> [Option<Rounded>; 16] {
    match turret {
        None => ranges_m.map(|range| range.map(Rounded)),
        Some(turret) => turret.ring().map(|range| Some(millimeters(range?.as_mm()))),
    }
}

/// The ranges of a body's first sensors, meters.
pub(super) fn beams(ranges_m: &[Option<f64>; 16], count: usize) -> Vec<Option<Rounded>> {
    let ranges = ranges_m.iter().take(count);
    ranges.map(|range| range.map(Rounded)).collect()
}

/// Where the controller takes the sensors to stand and look; `None` for those that it does not use.
pub(super) fn found(body: &BodySpec<16>, count: usize) -> Vec<Option<SensorDto>> {
    let dto = |sensor: usize| {
        let mount = body
            .mounts
            .get(sensor)
            .filter(|_| body.enabled.contains(sensor))?;
        let [x, y] = [mount.position.dx_mm, mount.position.dy_mm].map(|mm| f64::from(mm) / 1e3);
        let turns = f64::from(mount.axis.as_turns()) / 65_536.0;
        Some([x, y, turns * std::f64::consts::TAU].map(Rounded))
    };
    (0..count).map(dto).collect()
}

fn maps(known: &SimState, config: &Config<16>) -> Maps {
    let (situations, actions) = (known.situations(), known.actions());
    let rows: Vec<_> = known
        .memory()
        .samples()
        .iter()
        .map(|sample| best_neurons(known, config, sample))
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
        let code = [to_weight16(code[0]), to_weight16(code[1])];
        meters(config.action_code.decode(code, config.robot.step_mm))
    };
    Maps {
        grid: [situations.grid().columns(), situations.grid().rows()],
        learned: true,
        situations: map_dto(situations, hits(0)),
        changes: map_dto(actions.changes(), hits(1)),
        actions_m: actions.actions().code().iter().map(decode).collect(),
        rows,
    }
}

/// The best neurons for a sample in both maps.
fn best_neurons(known: &SimState, config: &Config<16>, sample: &Sample<16>) -> [usize; 2] {
    let (before, mask_before) = from_bytes(&sample.before);
    let (after, mask_after) = from_bytes(&sample.after);
    let displacement = match config.learning.learn_from {
        amp::config::LearnFrom::Commanded => sample.commanded,
        amp::config::LearnFrom::Executed => sample.executed,
    };
    let effect = Effect {
        change: difference(&after, &before),
        action: config
            .action_code
            .encode(displacement, config.robot.step_mm),
        mask: mask_before.and(mask_after),
    };
    let action = known
        .actions()
        .bmu(&effect, config.learning.action_weight_q8);
    [known.situations().bmu(&after, mask_after), action]
}

fn map_dto(map: &Som<16, 16>, hits: Vec<u32>) -> MapDto {
    let distances = map.u_matrix();
    MapDto {
        code: map.code().iter().map(|row| shorts(row)).collect(),
        hits,
        u_matrix: distances
            .iter()
            .map(|&u| Rounded(f64::from(u) / 8_192.0))
            .collect(),
    }
}

/// A plan with its walk over the maps.
pub(super) fn plan_dto(plan: &Plan<16>, known: &SimState) -> PlanDto {
    let [goal, current, intermediate, action] = [
        plan.goal_neuron,
        plan.current_neuron,
        plan.subgoal_neuron,
        plan.action_neuron,
    ]
    .map(usize::from);
    let changes = known.actions().changes();
    PlanDto {
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

/// The shortest walk over direct neighbors; among equals the neurons most like the goal.
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
        match grid.neighbors(at).min_by_key(|&k| far(k)) {
            Some(next) => at = next,
            None => break,
        }
        walk.push(at);
    }
    walk
}

pub(super) fn row(sample: &Sample<16>) -> MemoryRow {
    let values = |bytes: &[u8; 16]| {
        let value = |byte: u8| (byte < 255).then(|| Rounded(f64::from(byte) / 254.0));
        bytes.map(value)
    };
    MemoryRow {
        before: values(&sample.before),
        after: values(&sample.after),
        moved_m: meters(sample.executed),
    }
}

fn shorts<T: Scalar>(weights: &[T]) -> Vec<Rounded> {
    weights
        .iter()
        .map(|weight| Rounded(weight.to_weight32().to_num()))
        .collect()
}

/// One value per transducer.
pub(super) fn ring(values: &Situation<16>) -> RingValues {
    values.map(|value| Rounded(value.to_num()))
}

pub(super) fn pose_dto(pose: Pose) -> [Rounded; 3] {
    [pose.position.x, pose.position.y, pose.heading].map(Rounded)
}

pub(super) fn xy(point: Point) -> Xy {
    [point.x, point.y].map(Rounded)
}

pub(super) fn millimeters(mm: u16) -> Rounded {
    Rounded(f64::from(mm) / 1e3)
}

/// The wanted and the allowed displacement of a decision; zero without one.
pub(super) fn displacements(decision: Option<&Decision<16>>) -> [Xy; 2] {
    decision.map_or_else(Default::default, |decision| {
        [decision.wanted, decision.allowed].map(meters)
    })
}

pub(super) fn meters(displacement: Displacement) -> Xy {
    [displacement.dx_mm, displacement.dy_mm].map(|mm| Rounded(f64::from(mm) / 1e3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_walk_goes_over_neighbors_to_the_goal() {
        let map = Som::<16, 16>::zeroed(Grid::rectangle(4, 4));
        let walk = walk(&map, 0, 15);
        assert_eq!(
            (walk.first(), walk.last(), walk.len()),
            (Some(&0), Some(&15), 7)
        );
        assert!(
            walk.windows(2)
                .all(|pair| map.grid().are_neighbors(pair[0], pair[1]))
        );
        assert_eq!(super::walk(&map, 5, 5), [5]);
        assert_eq!(super::walk(&map, 99, 5), [99]);
    }
}
