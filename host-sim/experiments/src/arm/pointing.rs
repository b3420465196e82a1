//! Pointing (section 5.3): an eye of two joints looks at a target, and an arm of two joints points
//! at what is looked at. Each has a couple of maps, learned from random moves.
//!
//! The eye's situation is the image of a point and the eye's joints; its goal is the image in the
//! middle. While the arm moves at random, the eye looks at the hand after each move. So the arm's
//! situation is the eye's joints and its own; its goal is the posture that the eye had when it
//! looked at the target. Then the hand is on the line of sight.

use super::body::{ArmBody, Vector, distance, dot, unit};
use super::reach::ArmMethod;
use super::{ReachGoal, Reacher, random_action};
use arena::noise::Noise;
use rayon::prelude::*;
use sim::statistics::{Mean, bootstrap, median};

/// The eye from the arm's shoulder, m.
const EYE_M: Vector = [0.0, 0.2, 0.3];
/// Width of the image in units of the focal length: 100° wide.
const IMAGE_WIDTH: f64 = 2.4;
/// A point is looked at within this distance from the middle, in widths of the image.
const LOOKED_AT: f64 = 0.002;
/// Moves to look at a point, at most.
const LOOKS: u32 = 20;
/// The eye's random moves look at another point after so many.
const MOVES_PER_POINT: u32 = 5;
/// Pointing ends when the eye's posture is so near to the wanted one, in units of its values.
const POINTED_AT: f64 = 0.002;
/// Moves of the arm to point, at most.
pub const MAX_MOVES: u32 = 20;
/// Pointing succeeds within this angle, degrees.
pub const TOLERANCE_DEG: f64 = 1.0;

/// Values of a situation of eye or arm, and actuators of each.
const VALUES: usize = 4;
const JOINTS: usize = 2;

/// How the arm is moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointingMethod {
    /// From the random moves of the arm.
    Learned(ArmMethod),
    /// The intersection of the line of sight with the sphere of the hand.
    Analytic,
}

impl PointingMethod {
    /// All methods, in the order of the table.
    pub const ALL: [Self; 7] = [
        Self::Learned(ArmMethod::Maps),
        Self::Learned(ArmMethod::FrozenMaps),
        Self::Learned(ArmMethod::LocalOnline),
        Self::Learned(ArmMethod::NearestEight),
        Self::Learned(ArmMethod::Nearest),
        Self::Learned(ArmMethod::Random),
        Self::Analytic,
    ];

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Learned(ArmMethod::LocalOnline) => "least squares on 8 samples, remembering on",
            Self::Learned(method) => method.name(),
            Self::Analytic => "known geometry",
        }
    }
}

/// What all seeds share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PointingTrial {
    /// First seed.
    pub first_seed: u64,
    /// Number of seeds.
    pub seeds: u32,
    /// Random moves of the eye, and as many of the arm.
    pub explore_moves: u32,
    /// Targets, one after the other.
    pub targets: u32,
}

/// One target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pointed {
    /// Angle at the eye between hand and target, degrees.
    pub error_deg: f64,
    /// Angle at the eye between its line of sight and the target when it looked there, degrees.
    pub look_error_deg: f64,
    /// Moves of the arm.
    pub moves: u32,
}

/// A method over all seeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointingRow {
    /// Targets of all seeds.
    pub count: usize,
    /// Share within [`TOLERANCE_DEG`], with an interval over seeds and targets.
    pub pointed: Mean,
    /// Mean angle error, degrees.
    pub error_deg: Mean,
    /// Median angle error, degrees.
    pub median_error_deg: f64,
    /// Mean angle error of the eye alone, degrees.
    pub look_error_deg: Mean,
    /// Moves of the arm.
    pub moves: Mean,
}

/// An eye that learned to look.
struct Eye {
    body: ArmBody,
    reacher: Box<dyn Reacher<VALUES, JOINTS>>,
    angles: [f64; JOINTS],
}

impl Eye {
    /// Learns from random moves before points that stand still.
    fn explored(moves: u32, seed: u64) -> Self {
        let body = ArmBody::eye();
        let mut eye = Self {
            reacher: Box::new(super::maps::Maps::<VALUES, JOINTS, 16>::new(4, true, seed)),
            angles: body.middle(),
            body,
        };
        let mut noise = Noise::new(seed);
        let mut point_m = random_target(&mut noise);
        for number in 0..moves {
            if number % MOVES_PER_POINT == 0 {
                point_m = random_target(&mut noise);
            }
            let (before, action, after) = eye.turn(&random_action(&mut noise), point_m);
            eye.reacher.explored(&before, &action, &after);
        }
        eye.reacher.learn();
        eye
    }

    /// Turns while it sees a point; returns the situations and what was executed.
    fn turn(&mut self, wanted: &[f64; JOINTS], point_m: Vector) -> Taken {
        let before = self.situation(point_m);
        let next = self.body.moved(&self.angles, wanted);
        let action = self.body.action(&self.angles, &next);
        self.angles = next;
        (before, action, self.situation(point_m))
    }

    /// Looks at a point; returns its posture as values.
    fn look_at(&mut self, point_m: Vector) -> [f64; JOINTS] {
        let goal = ReachGoal {
            values: [0.5; VALUES],
            sensed: 2,
            hand_m: point_m,
            avoided: None,
        };
        self.reacher.begin(&goal);
        for _ in 0..LOOKS {
            let situation = self.situation(point_m);
            if goal.distance(&situation) <= LOOKED_AT {
                break;
            }
            let wanted = self.reacher.act(&situation);
            let (before, action, after) = self.turn(&wanted, point_m);
            self.reacher.moved(&before, &action, &after);
        }
        let [.., pan, tilt] = self.body.situation::<VALUES>(&self.angles);
        [pan, tilt]
    }

    /// Image of a point, right and up, then the eye's joints.
    fn situation(&self, point_m: Vector) -> [f64; VALUES] {
        let [forward, left, up] = self.axes();
        let from = to_eye(point_m);
        let depth = dot(from, forward).max(0.05);
        let image = |axis: Vector, sign: f64| {
            let at = 0.5 + sign * dot(from, axis) / depth / IMAGE_WIDTH;
            at.clamp(0.0, 1.0)
        };
        let [.., pan, tilt] = self.body.situation::<VALUES>(&self.angles);
        [image(left, -1.0), image(up, 1.0), pan, tilt]
    }

    /// Forward, left and up.
    fn axes(&self) -> [Vector; 3] {
        let [pan, tilt] = self.angles;
        let (sin, cos) = (libm::sin(pan), libm::cos(pan));
        let (down, level) = (libm::sin(tilt), libm::cos(tilt));
        [
            [cos * level, sin * level, -down],
            [-sin, cos, 0.0],
            [cos * down, sin * down, level],
        ]
    }

    /// Angle between the line of sight and a point, degrees.
    fn error_deg(&self, point_m: Vector) -> f64 {
        let [forward, ..] = self.axes();
        angle_deg(forward, to_eye(point_m))
    }
}

/// Before, action, after.
type Taken = ([f64; VALUES], [f64; JOINTS], [f64; VALUES]);

fn to_eye(point_m: Vector) -> Vector {
    [0, 1, 2].map(|i| point_m[i] - EYE_M[i])
}

fn angle_deg(a: Vector, b: Vector) -> f64 {
    // The chord is exact for small angles, where the cosine is not.
    let chord = distance(unit(a), unit(b)) / 2.0;
    2.0 * libm::asin(chord.min(1.0)).to_degrees()
}

/// A target 1 to 3 m before the eye, up to 40° to each side and 25° up and down.
fn random_target(noise: &mut Noise) -> Vector {
    let pan = noise.uniform_in(-40.0, 40.0).to_radians();
    let tilt = noise.uniform_in(-25.0, 25.0).to_radians();
    let far_m = noise.uniform_in(1.0, 3.0);
    let level_m = far_m * libm::cos(tilt);
    [
        EYE_M[0] + level_m * libm::cos(pan),
        EYE_M[1] + level_m * libm::sin(pan),
        EYE_M[2] - far_m * libm::sin(tilt),
    ]
}

/// The posture of the arm that brings the hand onto the line of sight to a target.
fn analytic(body: &ArmBody, target_m: Vector) -> [f64; JOINTS] {
    let sight = unit(to_eye(target_m));
    let along = dot(EYE_M, sight);
    let inside = dot(EYE_M, EYE_M) - body.reach_m() * body.reach_m();
    let far_m = -along + (along * along - inside).max(0.0).sqrt();
    let hand = [0, 1, 2].map(|i| EYE_M[i] + far_m * sight[i]);
    let level_m = libm::hypot(hand[0], hand[1]);
    [
        libm::atan2(hand[1], hand[0]),
        -libm::atan2(hand[2], level_m),
    ]
}

/// Eye and arm together.
struct Pointer<'b> {
    eye: Eye,
    body: &'b ArmBody,
    /// `None` = by the known geometry.
    reacher: Option<Box<dyn Reacher<VALUES, JOINTS> + 'b>>,
    angles: [f64; JOINTS],
}

impl<'b> Pointer<'b> {
    /// The eye learns to look; then the arm moves at random, and the eye looks at the hand.
    fn explored(body: &'b ArmBody, method: PointingMethod, moves: u32, seed: u64) -> Self {
        let mut pointer = Self {
            eye: Eye::explored(moves, seed),
            body,
            reacher: match method {
                PointingMethod::Learned(method) => Some(method.reacher(body, seed)),
                PointingMethod::Analytic => None,
            },
            angles: body.middle(),
        };
        let mut noise = Noise::new(seed.wrapping_add(1 << 33));
        if pointer.reacher.is_some() {
            for _ in 0..moves {
                let (before, action, after) = pointer.swing(&random_action(&mut noise));
                if let Some(reacher) = &mut pointer.reacher {
                    reacher.explored(&before, &action, &after);
                }
            }
        }
        if let Some(reacher) = &mut pointer.reacher {
            reacher.learn();
        }
        pointer
    }

    /// Moves the arm; the eye looks at the hand before and after.
    fn swing(&mut self, wanted: &[f64; JOINTS]) -> Taken {
        let before = self.situation();
        let next = self.body.moved(&self.angles, wanted);
        let action = self.body.action(&self.angles, &next);
        self.angles = next;
        (before, action, self.situation())
    }

    /// The eye looks at the hand: its joints, then the arm's.
    fn situation(&mut self) -> [f64; VALUES] {
        let [pan, tilt] = self.eye.look_at(self.body.hand_m(&self.angles));
        let [.., first, second] = self.body.situation::<VALUES>(&self.angles);
        [pan, tilt, first, second]
    }

    fn point_at(&mut self, target_m: Vector) -> Pointed {
        let [pan, tilt] = self.eye.look_at(target_m);
        let look_error_deg = self.eye.error_deg(target_m);
        let mut moves = 0;
        if let Some(reacher) = &mut self.reacher {
            let goal = ReachGoal {
                values: [pan, tilt, 0.5, 0.5],
                sensed: 2,
                hand_m: target_m,
                avoided: None,
            };
            reacher.begin(&goal);
            let mut situation = self.situation();
            while moves < MAX_MOVES && goal.distance(&situation) > POINTED_AT {
                let Some(reacher) = &mut self.reacher else {
                    break;
                };
                let wanted = reacher.act(&situation);
                let (before, action, after) = self.swing(&wanted);
                if let Some(reacher) = &mut self.reacher {
                    reacher.moved(&before, &action, &after);
                }
                (situation, moves) = (after, moves + 1);
            }
        } else {
            let to = analytic(self.body, target_m);
            while moves < MAX_MOVES && self.angles != to {
                let action = self.body.action(&self.angles, &to);
                let next = self.body.moved(&self.angles, &action);
                let is_last = action.iter().all(|share| share.abs() < 1.0);
                self.angles = if is_last { to } else { next };
                moves += 1;
            }
        }
        let hand_m = self.body.hand_m(&self.angles);
        Pointed {
            error_deg: angle_deg(to_eye(hand_m), to_eye(target_m)),
            look_error_deg,
            moves,
        }
    }
}

/// All targets of each seed. `done` is called after each seed.
#[must_use]
pub fn pointings(
    method: PointingMethod,
    trial: &PointingTrial,
    done: &(impl Fn() + Sync),
) -> Vec<Vec<Pointed>> {
    let body = ArmBody::pointing();
    let seeds = trial.first_seed..trial.first_seed + u64::from(trial.seeds);
    let one = |seed: u64| {
        let mut pointer = Pointer::explored(&body, method, trial.explore_moves, seed);
        let mut noise = Noise::new(seed.wrapping_add(1 << 34));
        let targets = (0..trial.targets).map(|_| pointer.point_at(random_target(&mut noise)));
        let pointed = targets.collect();
        done();
        pointed
    };
    seeds.into_par_iter().map(one).collect()
}

/// The row of a method.
#[must_use]
pub fn row(seeds: &[Vec<Pointed>]) -> PointingRow {
    let over = |value: &dyn Fn(&Pointed) -> f64| {
        let of_seed = |pointed: &Vec<Pointed>| pointed.iter().map(value).collect();
        bootstrap(&seeds.iter().map(of_seed).collect::<Vec<Vec<f64>>>())
    };
    let all = seeds.iter().flatten();
    PointingRow {
        count: all.clone().count(),
        pointed: over(&|p| f64::from(u8::from(p.error_deg <= TOLERANCE_DEG))),
        error_deg: over(&|p| p.error_deg),
        median_error_deg: median(all.map(|pointed| pointed.error_deg).collect()),
        look_error_deg: over(&|p| p.look_error_deg),
        moves: over(&|p| f64::from(p.moves)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_analytic_posture_is_on_the_line_of_sight() {
        let (body, mut noise) = (ArmBody::pointing(), Noise::new(1));
        for _ in 0..200 {
            let target_m = random_target(&mut noise);
            let hand_m = body.hand_m(&analytic(&body, target_m));
            assert!(angle_deg(to_eye(hand_m), to_eye(target_m)) < 1e-6);
        }
    }

    #[test]
    fn an_eye_learns_to_look_and_an_arm_to_point() {
        let (body, maps) = (
            ArmBody::pointing(),
            PointingMethod::Learned(ArmMethod::Maps),
        );
        let mut pointer = Pointer::explored(&body, maps, 100, 1);
        let mut noise = Noise::new(2);
        let errors: Vec<_> = (0..40)
            .map(|_| pointer.point_at(random_target(&mut noise)))
            .collect();
        let within = |most: f64| errors.iter().filter(|p| p.error_deg < most).count();
        assert!(within(1.0) >= 36, "{errors:?}");
        assert!(errors.iter().all(|p| p.look_error_deg < 1.0), "{errors:?}");
    }
}
