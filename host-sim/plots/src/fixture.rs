//! A synthetic episode for the tests of the pictures: a robot with 16 transducers avoids obstacles.

use core::f64::consts::TAU;

use arena::world::{Point, Pose, Shape, World};
use sim::recording::{MapRecord, PlanTrace, Recording, Step};

const NEAR_M: f64 = 0.4;
const FAR_M: f64 = 1.4;
const RADIUS_M: f64 = 0.23;

/// Evenly spread bearings, rad.
pub fn ring(sensors: usize) -> Vec<f64> {
    (0..sensors)
        .map(|i| TAU * i as f64 / sensors as f64)
        .collect()
}

/// A map of the given grid whose values run from `low` to 1.
pub fn map(grid: [usize; 2], dimensions: usize, low: f64) -> MapRecord {
    let count = grid[0] * grid[1];
    let value = |i: usize, k: usize| low + (1.0 - low) * ((i * 7 + k * 5) % 11) as f64 / 10.0;
    let code: Vec<Vec<f64>> = (0..count)
        .map(|i| (0..dimensions).map(|k| value(i, k)).collect())
        .collect();
    let hits = (0..count).map(|i| (i * 5) % 13).collect();
    let u_matrix = (0..count)
        .map(|i| 0.1 + ((i * 3) % 7) as f64 / 10.0)
        .collect();
    MapRecord {
        grid,
        code,
        hits,
        u_matrix,
    }
}

/// A room of 8 m × 6 m with boxes, a post and a wall.
pub fn world() -> World {
    let p = Point::new;
    let solid = |x, y, w, h, angle| Shape::Box {
        center: p(x, y),
        size: p(w, h),
        angle,
    };
    let room = vec![
        p(0.0, 0.0),
        p(8.0, 0.0),
        p(8.0, 6.0),
        p(0.0, 6.0),
        p(0.0, 0.0),
    ];
    let shapes = vec![
        Shape::Wall { points: room },
        Shape::Wall {
            points: vec![p(5.2, 6.0), p(5.2, 4.3)],
        },
        solid(2.0, 4.3, 1.0, 0.7, 0.4),
        solid(6.3, 1.6, 0.8, 1.2, -0.2),
        solid(1.6, 1.5, 0.6, 0.6, 0.0),
        Shape::Circle {
            center: p(6.8, 4.2),
            radius: 0.35,
        },
        Shape::Circle {
            center: p(3.9, 1.3),
            radius: 0.25,
        },
    ];
    World::new("paper", Pose::new(p(4.0, 3.0), 0.0), shapes).expect("a possible world")
}

/// A whole episode: 100 random moves, 400 decisions, two maps of 4 × 4 neurons.
pub fn recording() -> Recording {
    let mut robot = FixtureRobot {
        world: world(),
        place: Point::new(4.0, 3.0),
        random: 7,
        time: 0.0,
    };
    let exploration: Vec<Step> = (0..100)
        .map(|_| {
            let direction = TAU * robot.chance();
            robot.step(direction, None)
        })
        .collect();
    robot.place = Point::new(4.0, 3.0);
    let situations: Vec<&[f64]> = exploration.iter().map(|step| &step.situation[..]).collect();
    let situation_map = trained(&situations);
    let seeking = seek(&mut robot, &situation_map);
    let (change_map, actions_m) = changes(&exploration);
    Recording {
        world: world(),
        behavior: "avoid".into(),
        parts: vec!["avoid".to_owned()],
        preset: "default".into(),
        seed: 7,
        bearings_rad: ring(16),
        near_m: NEAR_M,
        far_m: FAR_M,
        goal_place: None,
        robot_radius_m: RADIUS_M,
        exploration,
        has_toured: false,
        seeking,
        situation_map,
        change_map,
        actions_m,
    }
}

/// An episode without moves and without maps.
pub fn empty() -> Recording {
    let none = MapRecord {
        grid: [0, 0],
        code: vec![],
        hits: vec![],
        u_matrix: vec![],
    };
    Recording {
        exploration: vec![],
        seeking: vec![],
        situation_map: none.clone(),
        change_map: none,
        actions_m: vec![],
        ..recording()
    }
}

/// Fails unless `svg` is a well-formed SVG document.
pub fn assert_well_formed(svg: &str) {
    super::png::check(svg).unwrap_or_else(|error| panic!("{error}\n{svg}"));
}

struct FixtureRobot {
    world: World,
    place: Point,
    random: u64,
    time: f64,
}

impl FixtureRobot {
    /// A number in [0, 1) from a linear congruential generator.
    fn chance(&mut self) -> f64 {
        self.random = self
            .random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.random >> 40) as f64 / f64::from(1 << 24)
    }

    /// The distance to the first surface along a bearing, by ray marching.
    fn range(&self, bearing: f64) -> Option<f64> {
        let mut far = RADIUS_M;
        while far < 6.5 {
            let clear = self
                .world
                .clearance(self.place + Point::unit(bearing) * far);
            if clear < 0.01 {
                return Some(far - RADIUS_M);
            }
            far += clear.max(0.01);
        }
        None
    }

    /// One decision to move 0.25 m along `direction`, shortened before an obstacle.
    fn step(&mut self, direction: f64, plan: Option<PlanTrace>) -> Step {
        let ranges_m: Vec<Option<f64>> = ring(16)
            .into_iter()
            .map(|bearing| self.range(bearing))
            .collect();
        let value = |range: &Option<f64>| {
            range.map_or(0.0, |r| ((FAR_M - r) / (FAR_M - NEAR_M)).clamp(0.0, 1.0))
        };
        let along = Point::unit(direction);
        let free =
            |distance: &f64| self.world.clearance(self.place + along * *distance) > RADIUS_M + 0.03;
        let distance = (1..=25)
            .map(|cm| f64::from(cm) / 100.0)
            .take_while(free)
            .last()
            .unwrap_or(0.0);
        let step = Step {
            pose: Pose::new(self.place, 0.0),
            time_s: self.time,
            situation: ranges_m.iter().map(value).collect(),
            ranges_m,
            plan,
            commanded_m: [0.25 * along.x, 0.25 * along.y],
            executed_m: [distance * along.x, distance * along.y],
            touched: distance < 0.25 && self.chance() < 0.2,
            shielded: distance < 0.25,
            leader: None,
            part: 0,
        };
        self.place = self.place + along * distance;
        self.time += 1.5;
        step
    }
}

/// 400 decisions: straight in free space, else away from the nearest obstacle.
fn seek(robot: &mut FixtureRobot, map: &MapRecord) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    let mut direction: f64 = 0.3;
    for _ in 0..400 {
        let here = robot.step(0.0, None);
        robot.place = here.pose.position;
        let (at, strength) = here
            .situation
            .iter()
            .enumerate()
            .fold(
                (0, 0.0),
                |best, (i, &v)| if v > best.1 { (i, v) } else { best },
            );
        let toward = libm::cos(TAU * at as f64 / 16.0 - direction);
        if strength > 0.72 && toward > 0.1 {
            let side = libm::sin(direction - TAU * at as f64 / 16.0);
            direction += if side < 0.0 { -1.0 } else { 1.0 } * (1.1 + 0.5 * robot.chance());
        }
        let plan = PlanTrace {
            goal_neuron: 3,
            current_neuron: winner(map, &here.situation),
            subgoal_neuron: 7,
            wanted_change: here.situation.iter().map(|v| -0.4 * v).collect(),
            action_neuron: at,
            at_goal: strength == 0.0,
            reason: if strength == 0.0 {
                "goal held".into()
            } else {
                "nearer neighbor".into()
            },
        };
        let step = robot.step(direction, Some(plan));
        if step.shielded {
            direction += 2.0 + robot.chance();
        }
        steps.push(step);
    }
    steps
}

fn winner(map: &MapRecord, situation: &[f64]) -> usize {
    let away = |i: usize| -> f64 {
        map.code[i]
            .iter()
            .zip(situation)
            .map(|(a, b)| (a - b) * (a - b))
            .sum()
    };
    (0..map.code.len())
        .min_by(|&a, &b| away(a).total_cmp(&away(b)))
        .unwrap_or(0)
}

/// A map of 4 × 4 neurons after a few passes over the samples.
fn trained(samples: &[&[f64]]) -> MapRecord {
    let mut map = map([4, 4], samples[0].len(), 0.0);
    map.code
        .iter_mut()
        .enumerate()
        .for_each(|(i, code)| code.copy_from_slice(samples[i * 6]));
    map.hits.fill(0);
    for pass in 0..8 {
        for &sample in samples {
            let best = winner(&map, sample);
            map.hits[best] += usize::from(pass == 7);
            for i in 0..16 {
                let hops = (i % 4_usize).abs_diff(best % 4) + (i / 4).abs_diff(best / 4);
                let rate = 0.3 * libm::exp(-((hops * hops) as f64) * f64::from(pass + 1) / 4.0);
                map.code[i]
                    .iter_mut()
                    .zip(sample)
                    .for_each(|(code, value)| *code += rate * (value - *code));
            }
        }
    }
    map
}

/// The action map of an exploration: changes of situation, and the displacement nearest to each.
fn changes(steps: &[Step]) -> (MapRecord, Vec<[f64; 2]>) {
    let change = |pair: &[Step]| -> Vec<f64> {
        let mut sample = crate::draw::stretch::difference(&pair[0].situation, &pair[1].situation);
        sample.extend(pair[0].executed_m);
        sample
    };
    let samples: Vec<Vec<f64>> = steps.windows(2).map(change).collect();
    let mut map = trained(&samples.iter().map(|sample| &sample[..]).collect::<Vec<_>>());
    let actions = map.code.iter_mut().map(|code| {
        let action = code.split_off(16);
        [action[0], action[1]]
    });
    let actions = actions.collect();
    (map, actions)
}
