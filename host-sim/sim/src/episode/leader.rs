//! The second robot: a disc of the Nomad's size that drives the Braitenberg rule at 0.15 m/s.
//!
//! It has an exact ring of its own, which detects walls and the robot, and it stops before it
//! touches the robot. In the robot's world it is a post: it returns echoes, and touching it is a
//! contact.

use crate::braitenberg::{Braitenberg, BraitenbergTuning};
use crate::pilot::Pilot as _;
use crate::ring_pilot::RingPilot;
use amp::controller::{Event, Progress};
use amp::units::{Bearing, Displacement, Millis, Range};
use arena::noise::Noise;
use arena::robot::COLLISION_RADIUS_M;
use arena::sonar::{RING_PERIOD_S, Ring, SonarModel};
use arena::world::{Point, Pose, World};

/// Its speed, m/s.
pub const LEADER_M_S: f64 = 0.15;
/// Distance from the robot at the start, m between centers.
const AHEAD_M: f64 = 1.0;
/// Least gap to the robot, m.
const GAP_M: f64 = 0.02;

/// A robot to follow.
#[derive(Debug)]
pub struct Leader {
    position: Point,
    pilot: RingPilot<Braitenberg>,
    ring: Ring,
    /// Simulated time that it has not driven yet, s.
    unsimulated_s: f64,
    /// Gap at which it waits, m.
    gap_m: f64,
}

impl Leader {
    /// Starts about 1 m from `robot`, in the direction with the most room that is nearest to
    /// straight ahead.
    #[must_use]
    pub fn ahead_of(robot: Pose, world: &World) -> Self {
        let turned = |eighth: i32| robot.heading + f64::from(eighth) * std::f64::consts::FRAC_PI_4;
        let place = |eighth: i32| robot.position + Point::unit(turned(eighth)) * AHEAD_M;
        let room = |eighth: &i32| {
            let way = world.sweep(robot.position, place(*eighth), COLLISION_RADIUS_M);
            way.min_clearance_m.min(0.3) * f64::from(u8::from(!way.touched()))
        };
        let best = [0, 1, -1, 2, -2, 3, -3, 4]
            .into_iter()
            .reduce(|best, other| {
                if room(&other) > room(&best) + 1e-9 {
                    other
                } else {
                    best
                }
            });
        let course = turned(best.unwrap_or(0));
        Self {
            position: place(best.unwrap_or(0)),
            pilot: RingPilot::new(
                Braitenberg::towards(BraitenbergTuning::default(), course),
                None,
            ),
            // An exact ring draws no noise.
            ring: Ring::new(SonarModel::Ideal, &mut Noise::new(0)),
            unsimulated_s: 0.0,
            gap_m: GAP_M,
        }
    }

    /// A leader that drives straight on and ignores everything.
    #[cfg(test)]
    pub(super) fn blind(position: Point, course: f64) -> Self {
        let ignores_echoes = BraitenbergTuning {
            push: 0.0,
            ..BraitenbergTuning::default()
        };
        Self {
            position,
            pilot: RingPilot::new(Braitenberg::towards(ignores_echoes, course), None),
            ring: Ring::new(SonarModel::Ideal, &mut Noise::new(0)),
            unsimulated_s: 0.0,
            gap_m: f64::NEG_INFINITY,
        }
    }

    /// Its center.
    #[must_use]
    pub fn position(&self) -> Point {
        self.position
    }

    /// Drives for `dt_s`, one step per ring period. It waits while the robot is in its way. Returns
    /// whether a step touched the robot.
    pub fn advance(&mut self, dt_s: f64, world: &World, robot: Point) -> bool {
        self.unsimulated_s += dt_s;
        let mut touched = false;
        while self.unsimulated_s >= RING_PERIOD_S {
            self.unsimulated_s -= RING_PERIOD_S;
            touched |= self.step(world, robot);
        }
        touched
    }

    /// Returns whether the step touched the robot.
    fn step(&mut self, world: &World, robot: Point) -> bool {
        let with_robot = world.with_post(robot, COLLISION_RADIUS_M);
        let mut ranges = [None; 16];
        let pose = Pose::new(self.position, 0.0);
        self.ring.scan(&with_robot, &pose, &mut ranges);
        let mut wanted = None;
        for (sensor, range) in ranges.iter().enumerate() {
            let range = range.map(|m: f64| Range::from_mm((m * 1e3) as u16));
            let sensor = sensor as u8;
            let echo = Event::Echo { sensor, range };
            wanted = wanted.or(self.pilot.handle(Millis::from_ms(0), echo).motion);
        }
        let Some(motion) = wanted else { return false };
        let way = Point::new(
            f64::from(motion.displacement.dx_mm),
            f64::from(motion.displacement.dy_mm),
        );
        let step = way * (LEADER_M_S * RING_PERIOD_S / way.length().max(1.0));
        let to = self.position + step;
        let near = to.distance(robot) < 2.0 * COLLISION_RADIUS_M + self.gap_m;
        let nearer = to.distance(robot) < self.position.distance(robot);
        let from = self.position;
        if !(near && nearer) {
            let sweep = world.sweep(self.position, to, COLLISION_RADIUS_M);
            self.position =
                self.position + step * (sweep.traveled_m / step.length().max(1e-9)).min(1.0);
        }
        let ended = Event::Odometry {
            motion: motion.id,
            moved: Displacement::ZERO,
            turned: Bearing::ZERO,
            progress: Progress::Ended,
        };
        let _ = self.pilot.handle(Millis::from_ms(0), ended);
        touches(from, self.position, robot)
    }
}

/// Whether a disc that moves straight touches a disc of the same size. A disc at rest touches
/// nothing.
fn touches(from: Point, to: Point, other: Point) -> bool {
    let (way, there) = (to - from, other - from);
    let length_squared = way.dot(way);
    if length_squared == 0.0 {
        return false;
    }
    let share = (there.dot(way) / length_squared).clamp(0.0, 1.0);
    // A motion away from the other disc touches it at the start only, which does not count.
    share > 0.0 && (way * share).distance(there) < 2.0 * COLLISION_RADIUS_M
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_touches_on_its_way_only() {
        let touched = |from: [f64; 2], to: [f64; 2]| {
            let [from, to] = [from, to].map(|[x, y]| Point::new(x, y));
            touches(from, to, Point::default())
        };
        // Radii of 0.269 m: 0.538 m between the centers.
        assert!(touched([0.6, 0.0], [0.537, 0.0]));
        assert!(!touched([0.6, 0.0], [0.539, 0.0]));
        // Past the other disc.
        assert!(touched([-0.1, 0.537], [0.1, 0.537]));
        assert!(!touched([-0.1, 0.539], [0.1, 0.539]));
        // Away from it, or at rest.
        assert!(!touched([0.5, 0.0], [0.6, 0.0]));
        assert!(!touched([0.5, 0.0], [0.5, 0.0]));
    }

    #[test]
    fn a_blind_leader_reports_when_it_touches_the_robot() {
        let world = World::builtin("room").unwrap();
        let robot = Point::default();
        let mut leader = Leader::blind(Point::new(0.8, 0.0), std::f64::consts::PI);
        let mut touches = [false; 12];
        for touched in &mut touches {
            *touched = leader.advance(RING_PERIOD_S, &world, robot);
        }
        // From 0.8 m in steps of 96 mm: within 0.538 m in the third step, past the center in the
        // ninth.
        let wanted: [bool; 12] = std::array::from_fn(|step| (2..9).contains(&step));
        assert_eq!(touches, wanted);
    }

    #[test]
    fn a_leader_drives_at_its_speed_and_never_into_the_robot() {
        for seed in 0..10 {
            let world = World::random(seed);
            let robot = world.start();
            let mut leader = Leader::ahead_of(robot, &world);
            assert!(leader.position().distance(robot.position) > 0.9);
            let mut way = 0.0;
            for _ in 0..200 {
                let before = leader.position();
                leader.advance(0.5, &world, robot.position);
                way += before.distance(leader.position());
                let gap = leader.position().distance(robot.position);
                assert!(gap > 2.0 * COLLISION_RADIUS_M, "{seed}: {gap}");
            }
            assert!((5.0..=15.1).contains(&way), "{seed}: {way}");
        }
    }
}
