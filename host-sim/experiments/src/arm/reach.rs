//! The arm of Coiton et al.: reaches random targets after random moves, beside other methods with
//! the same moves; then the same with a region that the hand must not enter.
//!
//! Y. Coiton, J. C. Gilhodes, J. L. Velay and J. P. Roll, "A neural network model for the
//! intersensory coordination involved in goal-directed movements", Biological Cybernetics 66, 1991,
//! 167–176.

use super::body::{ArmBody, View};
pub use super::method::ArmMethod;
use super::region::Region;
use super::{ReachGoal, Reacher, random_action};
use arena::noise::Noise;
use rayon::prelude::*;
use sim::statistics::{Mean, bootstrap, median};

/// A target is reached within this distance, in units of the reach or of the image's width.
pub const TOLERANCE: f64 = 0.02;
/// Moves to reach a target, at most.
pub const MAX_MOVES: u32 = 40;
/// Radius of the region to be avoided, in units of the reach.
pub const REGION_RADIUS: f64 = 0.15;
/// Positions of a move at which the hand and the elbow are looked at.
const PARTS: u32 = 10;
/// Start and target are at least so far from the region, in units of the reach.
const ROOM: f64 = 0.1;

/// What is in the way of the hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Obstruction {
    /// Nothing.
    None,
    /// A region between start and target, of which the method is not told.
    Untold,
    /// The same, which is part of the goal.
    Told,
}

/// What all seeds share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReachTrial {
    /// First seed.
    pub first_seed: u64,
    /// Number of seeds.
    pub seeds: u32,
    /// Random moves.
    pub explore_moves: u32,
    /// Targets, one after the other.
    pub targets: u32,
    /// What is in the way.
    pub obstruction: Obstruction,
}

/// One target.
#[derive(Debug, Clone, PartialEq)]
pub struct Reached {
    /// Distance of the hand from it at the end, in units of the reach or of the image's width.
    pub error: f64,
    /// Moves.
    pub moves: u32,
    /// The hand entered the region.
    pub hand_inside: bool,
    /// A link entered the region, or the hand.
    pub link_inside: bool,
}

impl Reached {
    /// Whether the hand is there.
    #[must_use]
    pub fn is_there(&self) -> bool {
        self.error <= TOLERANCE
    }
}

/// A reach with every posture, for a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// Postures, in radians.
    pub postures: Vec<Vec<f64>>,
    /// The hand at the target, m.
    pub target_m: [f64; 3],
    /// The region.
    pub region: Option<Region>,
}

/// A method in one trial, over all seeds.
#[derive(Debug, Clone, PartialEq)]
pub struct ReachRow {
    /// Targets of all seeds.
    pub count: usize,
    /// Share of the targets that were reached, with an interval over seeds and targets.
    pub reached: Mean,
    /// The same of the first tenth of the targets.
    pub reached_first: Mean,
    /// Mean final error.
    pub error: Mean,
    /// Median final error.
    pub median_error: f64,
    /// Moves of those that were reached.
    pub moves: Mean,
    /// Share of the reaches in which the hand entered the region.
    pub hand_inside: Mean,
    /// Share of the reaches in which any part of the arm did.
    pub link_inside: Mean,
}

/// An arm with a method, in one posture after the other.
pub(super) struct Arm<'b, const V: usize, const A: usize> {
    body: &'b ArmBody,
    reacher: Box<dyn Reacher<V, A> + 'b>,
    posture: [f64; A],
    noise: Noise,
}

impl<'b, const V: usize, const A: usize> Arm<'b, V, A> {
    /// Explores by random moves from the middle of all joints, and learns.
    pub(super) fn explored(
        body: &'b ArmBody,
        mut reacher: Box<dyn Reacher<V, A> + 'b>,
        moves: u32,
        seed: u64,
    ) -> Self {
        let mut noise = Noise::new(seed);
        let mut posture = body.middle();
        for _ in 0..moves {
            let next = body.moved(&posture, &random_action(&mut noise));
            let action = body.action(&posture, &next);
            reacher.explored(&body.situation(&posture), &action, &body.situation(&next));
            posture = next;
        }
        reacher.learn();
        Self {
            body,
            reacher,
            posture,
            noise: Noise::new(seed.wrapping_add(1 << 32)),
        }
    }

    /// A random target, and a region before it if there is to be one.
    fn goal(&mut self, obstruction: Obstruction) -> (ReachGoal<V>, Option<Region>) {
        loop {
            let posture: [f64; A] = self.body.random_posture(&mut self.noise);
            let hand_m = self.body.hand_m(&posture);
            let mut goal = ReachGoal {
                values: self.body.situation(&posture),
                sensed: self.body.view.values(),
                hand_m,
                avoided: None,
            };
            if obstruction == Obstruction::None {
                return (goal, None);
            }
            let now: [f64; V] = self.body.situation(&self.posture);
            let mut center = [0.0; 3];
            let ends = now.iter().zip(&goal.values).take(goal.sensed);
            for (part, (a, b)) in center.iter_mut().zip(ends) {
                *part = (a + b) / 2.0 + self.noise.uniform_in(-0.02, 0.02);
            }
            let region = Region {
                center,
                radius: REGION_RADIUS * self.unit(),
            };
            let room = ROOM * self.unit();
            let outside = |values: &[f64; V]| region.clearance(&values[..goal.sensed]) > room;
            if outside(&now) && outside(&goal.values) {
                goal.avoided = (obstruction == Obstruction::Told).then_some(region);
                return (goal, Some(region));
            }
        }
    }

    /// The reach or the image's width in units of the values.
    fn unit(&self) -> f64 {
        match self.body.view {
            View::Space | View::Plane => 0.5,
            View::Image(_) => 1.0,
        }
    }

    /// One target from where the arm is; `seen` is called with each posture.
    fn reach(&mut self, obstruction: Obstruction, mut seen: impl FnMut(&[f64; A])) -> Outcome<V> {
        let (goal, region) = self.goal(obstruction);
        self.reacher.begin(&goal);
        seen(&self.posture);
        let mut reached = Reached {
            error: 0.0,
            moves: 0,
            hand_inside: false,
            link_inside: false,
        };
        let mut situation: [f64; V] = self.body.situation(&self.posture);
        loop {
            reached.error = goal.distance(&situation) / self.unit();
            if reached.is_there() || reached.moves == MAX_MOVES {
                return Outcome {
                    reached,
                    goal,
                    region,
                };
            }
            let wanted = self.reacher.act(&situation);
            let next = self.body.moved(&self.posture, &wanted);
            if let Some(region) = region {
                self.look(&region, &next, &mut reached);
            }
            let action = self.body.action(&self.posture, &next);
            let after = self.body.situation(&next);
            self.reacher.moved(&situation, &action, &after);
            (self.posture, situation) = (next, after);
            reached.moves += 1;
            seen(&self.posture);
        }
    }

    /// Looks along a move whether hand or links enter the region.
    fn look(&self, region: &Region, next: &[f64; A], reached: &mut Reached) {
        let sensed = self.body.view.values();
        for part in 1..=PARTS {
            let share = f64::from(part) / f64::from(PARTS);
            let between: [f64; A] =
                std::array::from_fn(|j| self.posture[j] + (next[j] - self.posture[j]) * share);
            let chain = self.body.chain_m(&between);
            let inside = |point: [f64; 3]| region.clearance(&self.body.seen(point)[..sensed]) < 0.0;
            let hand = chain.last().copied().unwrap_or_default();
            reached.hand_inside |= inside(hand);
            let along = chain.windows(2).flat_map(|ends| {
                (0..=PARTS).map(move |part| {
                    let share = f64::from(part) / f64::from(PARTS);
                    [0, 1, 2].map(|i| ends[0][i] + (ends[1][i] - ends[0][i]) * share)
                })
            });
            reached.link_inside |= along.into_iter().any(inside);
        }
    }
}

/// One target, and what was asked.
struct Outcome<const V: usize> {
    reached: Reached,
    goal: ReachGoal<V>,
    region: Option<Region>,
}

/// All targets of each seed, of an arm with three joints or, in the plane, 2, 3, 5, 10 or 20.
/// `done` is called after each seed.
#[must_use]
pub fn reaches(
    body: &ArmBody,
    method: ArmMethod,
    trial: &ReachTrial,
    done: &(impl Fn() + Sync),
) -> Vec<Vec<Reached>> {
    match (body.view.values(), body.joints.len()) {
        (3, 3) => of_size::<6, 3>(body, method, trial, done),
        (2, 2) => of_size::<4, 2>(body, method, trial, done),
        (2, 3) => of_size::<5, 3>(body, method, trial, done),
        (2, 5) => of_size::<7, 5>(body, method, trial, done),
        (2, 10) => of_size::<12, 10>(body, method, trial, done),
        (2, 20) => of_size::<22, 20>(body, method, trial, done),
        _ => Vec::new(),
    }
}

fn of_size<const V: usize, const A: usize>(
    body: &ArmBody,
    method: ArmMethod,
    trial: &ReachTrial,
    done: &(impl Fn() + Sync),
) -> Vec<Vec<Reached>> {
    let seeds = trial.first_seed..trial.first_seed + u64::from(trial.seeds);
    let one = |seed| {
        let reacher = method.reacher::<V, A>(body, seed);
        let mut arm = Arm::explored(body, reacher, trial.explore_moves, seed);
        let targets = (0..trial.targets).map(|_| arm.reach(trial.obstruction, |_| {}).reached);
        let reached = targets.collect();
        done();
        reached
    };
    seeds.into_par_iter().map(one).collect()
}

/// The row of a method.
#[must_use]
pub fn row(seeds: &[Vec<Reached>]) -> ReachRow {
    let over = |value: &dyn Fn(&Reached) -> Option<f64>, first: bool| {
        let of_seed = |reached: &Vec<Reached>| {
            let count = if first {
                reached.len().div_ceil(10)
            } else {
                reached.len()
            };
            reached.iter().take(count).filter_map(value).collect()
        };
        bootstrap(&seeds.iter().map(of_seed).collect::<Vec<Vec<f64>>>())
    };
    let share = |is: bool| f64::from(u8::from(is));
    let all = seeds.iter().flatten();
    ReachRow {
        count: all.clone().count(),
        reached: over(&|r| Some(share(r.is_there())), false),
        reached_first: over(&|r| Some(share(r.is_there())), true),
        error: over(&|r| Some(r.error), false),
        median_error: median(all.map(|reached| reached.error).collect()),
        moves: over(&|r| r.is_there().then_some(f64::from(r.moves)), false),
        hand_inside: over(&|r| Some(share(r.hand_inside)), false),
        link_inside: over(&|r| Some(share(r.link_inside)), false),
    }
}

/// The maps' way to the first targets of a seed.
#[must_use]
pub fn trajectories(body: &ArmBody, trial: &ReachTrial, seed: u64) -> Vec<Trajectory> {
    let reacher = ArmMethod::Maps.reacher::<6, 3>(body, seed);
    let mut arm = Arm::explored(body, reacher, trial.explore_moves, seed);
    let one = |_| {
        let mut postures = Vec::new();
        let outcome = arm.reach(trial.obstruction, |posture| postures.push(posture.to_vec()));
        Trajectory {
            postures,
            target_m: outcome.goal.hand_m,
            region: outcome.region,
        }
    };
    (0..trial.targets).map(one).collect()
}
