//! Baseline: VFH+; a histogram over directions has openings, the cheapest candidate is driven.
//!
//! I. Ulrich, J. Borenstein, *VFH+: reliable obstacle avoidance for fast mobile robots*, IEEE
//! International Conference on Robotics and Automation, 1998, 1572–1577. See [`VfhPlus`].

use super::certainty_grid::{CELL_M, CertaintyGrid, REACH_M, SIDE};
use arena::robot::COLLISION_RADIUS_M;
use arena::world::{Point, wrap_angle};
use sim::ring_pilot::{Perception, Policy, STEP_M, Steerable};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Sectors of the histograms, 5° each.
pub const SECTORS: usize = 72;
const SECTOR: f64 = TAU / SECTORS as f64;

/// The method's constants; the defaults were tuned in rooms that no comparison uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VfhPlusTuning {
    /// Distance to keep from obstacles, m: each cell is enlarged by the robot's radius and this.
    pub safety_m: f64,
    /// A cell with one echo at this distance or nearer blocks a sector, m.
    pub blocked_m: f64,
    /// A sector becomes free below the value of a cell with one echo at this distance, m; at least
    /// `blocked_m`.
    pub free_m: f64,
    /// Openings wider than this have candidates at their edges, in sectors.
    pub wide: usize,
    /// Cost weights: difference from the target, from the heading, from the last direction.
    pub weights: [f64; 3],
    /// The shortest step, as a share of a whole step.
    pub slowest: f64,
    /// Radius of the tightest turn, m; 0 = turns on the spot.
    pub turning_radius_m: f64,
}

impl Default for VfhPlusTuning {
    fn default() -> Self {
        Self {
            safety_m: 0.05,
            blocked_m: 0.5,
            free_m: 1.4,
            wide: 8,
            weights: [5.0, 2.0, 2.0],
            slowest: 1.0,
            turning_radius_m: 0.0,
        }
    }
}

impl VfhPlusTuning {
    /// The constants found with or without the shield. The shield keeps its own margin, which makes
    /// narrower openings useless.
    #[must_use]
    pub fn of(shield: bool) -> Self {
        let free = Self::default();
        match shield {
            true => Self {
                safety_m: 0.2,
                blocked_m: 0.6,
                ..free
            },
            false => free,
        }
    }
}

/// A robot driven by VFH+. Points that the paper leaves open:
///
/// * The Nomad steers on the spot: the mask equals the binary histogram unless
///   [`VfhPlusTuning::turning_radius_m`] is set.
/// * Thresholds are distances: that of a cell with one echo that has just the threshold's value.
/// * Without a target, the heading replaces it in the cost.
/// * If every direction is blocked, the robot takes the direction with the lowest value at the
///   least speed.
/// * The step shrinks with the value of its direction, as the speed in J. Borenstein, Y. Koren,
///   *The vector field histogram*, IEEE Transactions on Robotics and Automation 7(3), 1991,
///   278–288.
#[derive(Debug, Clone)]
pub struct VfhPlus {
    tuning: VfhPlusTuning,
    grid: CertaintyGrid,
    blocked: [bool; SECTORS],
    target: Option<f64>,
    /// Direction of the last step, rad in the frame of the pose.
    course: f64,
    /// Direction of the last decision, rad in the frame of the pose.
    chosen: f64,
}

/// An occupied cell as an entry of the histogram.
#[derive(Debug, Clone, Copy)]
struct Obstacle {
    offset: Point,
    bearing: f64,
    /// Half the angle to which it is enlarged.
    enlarged: f64,
    magnitude: f64,
}

impl VfhPlus {
    /// A robot that starts along `course` (rad from the ring's x axis) and has no target.
    #[must_use]
    pub fn new(tuning: VfhPlusTuning, course: f64) -> Self {
        Self {
            tuning,
            grid: CertaintyGrid::default(),
            blocked: [false; SECTORS],
            target: None,
            course,
            chosen: course,
        }
    }

    /// Radius of an enlarged cell, m.
    fn enlargement(&self) -> f64 {
        COLLISION_RADIUS_M + self.tuning.safety_m
    }

    fn obstacles(&self, place: Point) -> Vec<Obstacle> {
        let inside = |(offset, count): (Point, u8)| {
            let distance = offset.length();
            (distance < REACH_M).then(|| {
                let ratio = self.enlargement() / distance;
                Obstacle {
                    offset,
                    bearing: offset.angle(),
                    enlarged: if ratio < 1.0 {
                        libm::asin(ratio)
                    } else {
                        FRAC_PI_2
                    },
                    magnitude: magnitude(count, distance),
                }
            })
        };
        self.grid.occupied(place).filter_map(inside).collect()
    }

    /// Stage 1: the primary polar histogram.
    fn primary(obstacles: &[Obstacle]) -> [f64; SECTORS] {
        let mut histogram = [0.0; SECTORS];
        for obstacle in obstacles {
            let end = |angle: f64| angle / SECTOR;
            let right = libm::ceil(end(obstacle.bearing - obstacle.enlarged)) as i32;
            let left = libm::floor(end(obstacle.bearing + obstacle.enlarged)) as i32;
            for sector in right..=left {
                let sector = sector.rem_euclid(SECTORS as i32) as usize;
                if let Some(sum) = histogram.get_mut(sector) {
                    *sum += obstacle.magnitude;
                }
            }
        }
        histogram
    }

    /// Stage 2: between the two thresholds a sector keeps its state.
    fn update_blocked(&mut self, primary: &[f64; SECTORS]) {
        let blocks = magnitude(3, self.tuning.blocked_m.min(REACH_M));
        let frees = magnitude(3, self.tuning.free_m.min(REACH_M));
        for (blocked, &sum) in self.blocked.iter_mut().zip(primary) {
            *blocked = sum >= blocks || (*blocked && sum >= frees);
        }
    }

    /// Stage 3: directions that a turn cannot reach without a collision are blocked.
    fn masked(&self, obstacles: &[Obstacle]) -> [bool; SECTORS] {
        let radius = self.tuning.turning_radius_m;
        if radius <= 0.0 {
            return self.blocked;
        }
        let ahead = Point::unit(self.course);
        let aside = Point::new(-ahead.y, ahead.x) * radius;
        // Largest turn to the left and to the right.
        let (mut left, mut right) = (PI, PI);
        for obstacle in obstacles {
            let turn = wrap_angle(obstacle.bearing - self.course);
            let reach = radius + self.enlargement();
            if turn >= 0.0 && obstacle.offset.distance(aside) < reach {
                left = left.min(turn);
            }
            if turn <= 0.0 && obstacle.offset.distance(-aside) < reach {
                right = right.min(-turn);
            }
        }
        let mut masked = self.blocked;
        for (sector, blocked) in masked.iter_mut().enumerate() {
            let turn = wrap_angle(middle(sector) - self.course);
            *blocked |= turn > left || turn < -right;
        }
        masked
    }

    /// Stage 4: the cheapest candidate; `None` where every direction is blocked.
    fn choose(&self, blocked: &[bool; SECTORS]) -> Option<f64> {
        let target = self.target.unwrap_or(self.course);
        let [to_target, to_course, to_last] = self.tuning.weights;
        let cost = |candidate: &f64| {
            to_target * difference(*candidate, target)
                + to_course * difference(*candidate, self.course)
                + to_last * difference(*candidate, self.chosen)
        };
        candidates(blocked, self.tuning.wide, target)
            .into_iter()
            .min_by(|a, b| cost(a).total_cmp(&cost(b)))
    }

    fn step(&self, direction: f64, primary: &[f64; SECTORS]) -> f64 {
        let most = magnitude(3, self.tuning.blocked_m.min(REACH_M));
        let sum = primary.get(sector_of(direction)).copied().unwrap_or(0.0);
        STEP_M * (1.0 - sum / most).max(self.tuning.slowest)
    }
}

impl Policy for VfhPlus {
    fn decide(&mut self, perceived: &Perception) -> Point {
        self.grid.hear(perceived);
        let obstacles = self.obstacles(perceived.pose.position);
        let primary = Self::primary(&obstacles);
        self.update_blocked(&primary);
        let least = || {
            let sums = primary.iter().enumerate();
            let least = sums.min_by(|a, b| a.1.total_cmp(b.1));
            middle(least.map_or(0, |(sector, _)| sector))
        };
        let direction = self.choose(&self.masked(&obstacles)).unwrap_or_else(least);
        (self.course, self.chosen) = (direction, direction);
        let step = self.step(direction, &primary);
        Point::unit(direction - perceived.pose.heading) * step
    }

    fn bytes(&self) -> usize {
        size_of_val(self) + (SIDE * SIDE) as usize
    }
}

impl Steerable for VfhPlus {
    fn steer(&mut self, target: Option<f64>) {
        self.target = target;
    }
}

/// Magnitude of a cell: its squared certainty times a − b d², where a − b d² is 1 at the window's
/// rim (b = 1, d in cells).
fn magnitude(count: u8, distance_m: f64) -> f64 {
    let cells = |m: f64| (m / CELL_M) * (m / CELL_M);
    f64::from(count) * f64::from(count) * (1.0 + cells(REACH_M) - cells(distance_m))
}

/// Center of a sector, rad.
fn middle(sector: usize) -> f64 {
    sector as f64 * SECTOR
}

/// The sector whose center is nearest to a direction.
fn sector_of(direction: f64) -> usize {
    libm::rint(direction / SECTOR).rem_euclid(SECTORS as f64) as usize % SECTORS
}

/// The angle between two directions, 0 … π.
fn difference(a: f64, b: f64) -> f64 {
    wrap_angle(a - b).abs()
}

/// Candidate directions: the middle of narrow openings; of wide ones both edges, half a wide
/// opening inside, and the target if it lies between these.
fn candidates(blocked: &[bool; SECTORS], wide: usize, target: f64) -> Vec<f64> {
    let Some(first) = blocked.iter().position(|&blocked| blocked) else {
        return vec![target];
    };
    let mut candidates = Vec::new();
    let mut begin = None;
    // One turn from a blocked sector back to it: no opening is split.
    for place in first..=first + SECTORS {
        let is_blocked = blocked.get(place % SECTORS).copied().unwrap_or(true);
        match (begin, is_blocked) {
            (None, false) => begin = Some(place),
            (Some(right), true) => {
                add_opening(right, place - 1, wide, target, &mut candidates);
                begin = None;
            }
            _ => {}
        }
    }
    candidates
}

/// The candidates of the opening from sector `right` to sector `left`, counted counter-clockwise.
fn add_opening(right: usize, left: usize, wide: usize, target: f64, candidates: &mut Vec<f64>) {
    let (right, left) = (middle(right), middle(left));
    let half = wide as f64 * SECTOR / 2.0;
    if left - right <= 2.0 * half {
        candidates.push(wrap_angle((right + left) / 2.0));
        return;
    }
    let (low, high) = (right + half, left - half);
    candidates.extend([wrap_angle(low), wrap_angle(high)]);
    let inside = (target - low).rem_euclid(TAU);
    if inside <= high - low {
        candidates.push(wrap_angle(target));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arena::robot::TurretMode;
    use arena::sonar::SonarModel;
    use arena::world::World;
    use sim::episode::{Body, drive_pilot};
    use sim::ring_pilot::RingPilot;

    /// 1 m away, enlarged to ±32°: no sector's center lies on its edge.
    fn obstacle(bearing: f64) -> Obstacle {
        Obstacle {
            offset: Point::unit(bearing),
            bearing,
            enlarged: 32.0_f64.to_radians(),
            magnitude: magnitude(3, 1.0),
        }
    }

    fn blocking(places: impl Iterator<Item = usize>) -> [bool; SECTORS] {
        let mut blocked = [false; SECTORS];
        places.for_each(|place| blocked[place % SECTORS] = true);
        blocked
    }

    fn degrees(candidates: &[f64]) -> Vec<i32> {
        let whole = |angle: &f64| libm::rint(angle.to_degrees()) as i32;
        candidates.iter().map(whole).collect()
    }

    #[test]
    fn a_cell_weighs_by_certainty_and_distance() {
        // c² at the edge; 1 m of 16 nearer: 9 · (1 + 256 − 100).
        assert!((magnitude(3, REACH_M) - 9.0).abs() < 1e-9);
        assert!((magnitude(3, 1.0) - 9.0 * 157.0).abs() < 1e-9);
        assert!((magnitude(15, 1.0) - 225.0 * 157.0).abs() < 1e-9);
    }

    #[test]
    fn an_obstacle_blocks_the_sectors_it_is_enlarged_to() {
        let sums = VfhPlus::primary(&[obstacle(0.0), obstacle(0.0)]);
        for (sector, sum) in sums.iter().enumerate() {
            // ±32° are six sectors of 5° to either side.
            let expected = if sector <= 6 || sector >= 66 {
                2.0
            } else {
                0.0
            };
            assert_eq!(*sum, expected * magnitude(3, 1.0), "{sector}");
        }
    }

    #[test]
    fn between_the_thresholds_a_sector_stays_what_it_was() {
        let mut vfh = VfhPlus::new(
            VfhPlusTuning {
                blocked_m: 0.8,
                free_m: 1.0,
                ..VfhPlusTuning::default()
            },
            0.0,
        );
        let mut heard = |distance: f64| {
            vfh.update_blocked(&[magnitude(3, distance); SECTORS]);
            vfh.blocked[0]
        };
        let between = 0.9;
        assert!(!heard(between) && heard(0.7) && heard(between));
        assert!(!heard(1.1) && !heard(between));
    }

    #[test]
    fn candidates_are_those_of_the_paper() {
        // Blocked except for ±10°: the middle of a narrow opening.
        let narrow = blocking(3..70);
        assert_eq!(degrees(&candidates(&narrow, 16, PI)), [0]);
        // Free except for ±30°: the edges of a wide opening, 40° inside, and the target between
        // them.
        let wide = blocking(66..79);
        assert_eq!(degrees(&candidates(&wide, 16, 0.0)), [75, -75]);
        assert_eq!(degrees(&candidates(&wide, 16, 1.6)), [75, -75, 92]);
        assert_eq!(degrees(&candidates(&[false; SECTORS], 16, 1.0)), [57]);
        assert!(candidates(&[true; SECTORS], 16, 1.0).is_empty());
    }

    #[test]
    fn the_cost_prefers_the_target_and_then_the_course() {
        let tuning = VfhPlusTuning {
            wide: 16,
            ..VfhPlusTuning::default()
        };
        let mut vfh = VfhPlus::new(tuning, -0.3);
        let wide = blocking(66..79);
        vfh.steer(Some(0.0));
        // Both edges are equally far from the target: the heading decides.
        assert_eq!(
            vfh.choose(&wide).map(|direction| degrees(&[direction])),
            Some(vec![-75])
        );
        vfh.steer(Some(0.3));
        assert_eq!(
            vfh.choose(&wide).map(|direction| degrees(&[direction])),
            Some(vec![75])
        );
    }

    #[test]
    fn what_cannot_be_turned_to_is_masked() {
        let mut tuning = VfhPlusTuning::default();
        let left = obstacle(1.0);
        let free = |tuning: VfhPlusTuning| {
            let vfh = VfhPlus::new(tuning, 0.0);
            let masked = vfh.masked(&[left]);
            move |angle: f64| !masked[sector_of(angle)]
        };
        let on_the_spot = free(tuning);
        assert!(on_the_spot(0.5) && on_the_spot(1.5) && on_the_spot(-1.5));
        // The circle around (0, 1 m) hits the obstacle 1 m away at 57°, the circle around (0, −1 m)
        // does not.
        tuning.turning_radius_m = 1.0;
        let in_a_curve = free(tuning);
        assert!(in_a_curve(0.5) && !in_a_curve(1.5) && in_a_curve(-1.5));
    }

    #[test]
    fn it_goes_where_it_is_steered_and_touches_nothing() {
        let world = World::random(20_001);
        let drive = |target: Option<f64>, steps: u32| {
            let mut pilot = RingPilot::new(VfhPlus::new(VfhPlusTuning::default(), 0.0), None);
            pilot.policy_mut().steer(target);
            let body = Body::new(&world, SonarModel::Ideal, TurretMode::Held, 1);
            let tally = drive_pilot(&world, &mut pilot, body, steps).expect("it drives");
            assert_eq!(tally.contacts, 0, "{target:?}");
            pilot.pose().position
        };
        // Everything is more than 1 m from the start.
        for target in [0.0, 1.0, -2.0] {
            let direction = drive(Some(target), 2);
            assert!(difference(direction.angle(), target) < 0.2, "{direction:?}");
            drive(Some(target), 100);
        }
        drive(None, 300);
    }
}
