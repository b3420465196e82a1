//! Finds the bearings that make readings after turns most similar, in steps short enough for the
//! ticks of a microcontroller.

use super::costs::{Costs, Means};
use super::front::Front;
use super::{BINS, Calibration, KnownBearings};
use crate::actuation::{Actuation, ONE_Q12};
use crate::fixed::Mask;
use crate::units::Bearing;

/// Sensors that the growth of a solution starts from, at most.
const STARTS: u8 = 6;
/// Rounds in which each sensor takes its best bearing, the others as they are, at most.
const SWEEPS: u8 = 6;
/// Bearings are improved in steps of a bin divided by this.
const PARTS_OF_BIN: usize = 8;

/// What was learned of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LearnedBody<const BEAMS: usize> {
    /// Bearing of each sensor, from where the body goes ahead; `None` = dead.
    pub bearings: [Option<Bearing>; BEAMS],
    /// What its base makes of its commands. Left and right may be exchanged in the base and so in
    /// all bearings: nothing in a room tells which is which.
    pub actuation: Actuation,
}

/// What comes next. Solutions are grown from several sensors, and the cheapest is kept. At first it
/// is all zeros, as a body in static memory has to be.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(u8)]
enum Step {
    /// Nothing: not begun, or over.
    Idle,
    /// The average dissimilarities of a sensor.
    Means { sensor: u8 },
    /// The best bearing of a sensor that has none; the surest one is placed next.
    Grow {
        sensor: u8,
        surest: Option<(i32, u8, Bearing)>,
    },
    /// A better bearing of a sensor, the others as they are.
    Sweep {
        sensor: u8,
        round: u8,
        is_better: bool,
    },
    /// The cost of the solution.
    Compare,
    /// Which way is ahead.
    Ahead(Front),
}

/// Solves a [`Calibration`] step by step. Readings may go on meanwhile.
#[derive(Debug, Clone, PartialEq)]
pub struct Solver<const BEAMS: usize> {
    step: Step,
    /// Whether the base is learned as well.
    learns_actuation: bool,
    alive: Mask,
    /// True turn of what the base takes for 4 096.
    turn_q12: u16,
    means: Means<BEAMS>,
    /// Sensors that keep the bearing that is known; of all others it is found.
    fixed: Mask,
    /// Solutions grown so far.
    starts: u8,
    bearings: [Option<Bearing>; BEAMS],
    best: (i32, [Option<Bearing>; BEAMS]),
}

impl<const BEAMS: usize> Default for Solver<BEAMS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const BEAMS: usize> Solver<BEAMS> {
    /// Nothing to solve.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            step: Step::Idle,
            learns_actuation: false,
            alive: Mask::NONE,
            turn_q12: 0,
            means: [[0; BEAMS]; BEAMS],
            fixed: Mask::NONE,
            starts: 0,
            bearings: [None; BEAMS],
            best: (0, [None; BEAMS]),
        }
    }

    /// Begins anew. With `learns_actuation` it asks what the base makes of its commands as well;
    /// otherwise the base is taken to do what it is told.
    pub fn begin(&mut self, calibration: &Calibration<BEAMS>, learns_actuation: bool) {
        self.learns_actuation = learns_actuation;
        self.alive = calibration.alive();
        self.turn_q12 = if learns_actuation {
            calibration.full_turn.turn_q12()
        } else {
            ONE_Q12
        };
        self.fixed = Mask::NONE;
        self.starts = 0;
        self.best = (i32::MAX, [None; BEAMS]);
        self.step = Step::Means { sensor: 0 };
    }

    /// Begins anew, for the sensors alone whose bearing is not known; nothing else is learned.
    pub fn begin_with(&mut self, calibration: &Calibration<BEAMS>, known: &KnownBearings<BEAMS>) {
        self.begin(calibration, false);
        self.turn_q12 = known.turn_q12;
        self.bearings = known.bearings;
        let sensors = known.bearings.iter().enumerate();
        self.fixed = sensors
            .filter(|(_, bearing)| bearing.is_some())
            .fold(Mask::NONE, |mask, (sensor, _)| mask.with(sensor));
    }

    /// Whether it seeks some sensors, where others look being known.
    #[must_use]
    pub fn seeks_some(&self) -> bool {
        self.fixed != Mask::NONE
    }

    /// Ends it before it is over.
    pub fn stop(&mut self) {
        self.step = Step::Idle;
    }

    /// Whether steps are left.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.step != Step::Idle
    }

    /// Takes a step, at most 0.4 million instructions of a Cortex-M4. Returns what was
    /// learned with the last one.
    pub fn advance(&mut self, calibration: &Calibration<BEAMS>) -> Option<LearnedBody<BEAMS>> {
        let costs = Costs {
            calibration,
            means: &self.means,
            turn_q12: self.turn_q12,
        };
        match self.step {
            Step::Idle => return None,
            Step::Means { sensor } => {
                if let Some(means) = self.means.get_mut(usize::from(sensor)) {
                    *means = calibration.means_of(sensor.into());
                    self.step = Step::Means { sensor: sensor + 1 };
                } else if self.seeks_some() {
                    self.step = GROW;
                } else {
                    self.step = self.next_start();
                }
            }
            Step::Grow { sensor, surest } => {
                let open = self.next_of(sensor, |bearing| bearing.is_none());
                self.step = match (open, surest) {
                    (Some(sensor), _) => {
                        let (cost, bearing) = costs.best(&self.bearings, sensor.into(), all());
                        let is_surer = surest.is_none_or(|(least, ..)| cost < least);
                        Step::Grow {
                            sensor: sensor + 1,
                            surest: if is_surer {
                                Some((cost, sensor, bearing))
                            } else {
                                surest
                            },
                        }
                    }
                    (None, Some((_, sensor, bearing))) => {
                        self.place(sensor, bearing);
                        GROW
                    }
                    (None, None) => sweep(0),
                };
            }
            Step::Sweep {
                sensor,
                round,
                is_better,
            } => {
                self.step = match self.next_of(sensor, |bearing| bearing.is_some()) {
                    Some(sensor) if self.fixed.contains(sensor.into()) => Step::Sweep {
                        sensor: sensor + 1,
                        round,
                        is_better,
                    },
                    Some(sensor) => {
                        let (_, near) = costs.best(&self.bearings, sensor.into(), all());
                        let (_, bearing) = costs.best(&self.bearings, sensor.into(), around(near));
                        let is_new = self.place(sensor, bearing);
                        Step::Sweep {
                            sensor: sensor + 1,
                            round,
                            is_better: is_better || is_new,
                        }
                    }
                    None if is_better && round + 1 < SWEEPS => sweep(round + 1),
                    None => Step::Compare,
                };
            }
            Step::Compare => {
                let placed = self.bearings.iter().enumerate();
                let placed = placed.filter_map(|(sensor, bearing)| Some((sensor, (*bearing)?)));
                let cost = placed.fold(0_i32, |sum, (sensor, bearing)| {
                    sum.saturating_add(costs.at(&self.bearings, sensor, bearing))
                });
                if cost < self.best.0 {
                    self.best = (cost, self.bearings);
                }
                if self.seeks_some() {
                    self.step = Step::Idle;
                    return Some(self.found_of_some());
                }
                self.step = self.next_start();
            }
            Step::Ahead(mut front) => {
                front.improve(&calibration.slopes, &calibration.fits, &self.best.1);
                self.step = Step::Ahead(front);
                if front.is_found() {
                    self.step = Step::Idle;
                    return Some(self.learned(calibration, front));
                }
            }
        }
        None
    }

    /// Solves a calibration at once.
    #[must_use]
    pub fn solve(calibration: &Calibration<BEAMS>, learns_actuation: bool) -> LearnedBody<BEAMS> {
        let mut solver = Self::new();
        solver.begin(calibration, learns_actuation);
        loop {
            if let Some(learned) = solver.advance(calibration) {
                return learned;
            }
        }
    }

    /// Begins to grow a solution from the next sensor.
    fn next_start(&mut self) -> Step {
        let first = self.alive.indices(BEAMS).nth(self.starts.into());
        let Some(first) = first.filter(|_| self.starts < STARTS) else {
            return Step::Ahead(Front::UNKNOWN);
        };
        self.starts += 1;
        self.bearings = [None; BEAMS];
        self.place(first as u8, Bearing::ZERO);
        GROW
    }

    /// The first sensor alive from `sensor` on whose bearing is so.
    fn next_of(&self, sensor: u8, is_so: impl Fn(Option<Bearing>) -> bool) -> Option<u8> {
        let first = usize::from(sensor);
        let mut alive = self.alive.indices(BEAMS).filter(|s| *s >= first);
        let found = alive.find(|s| is_so(self.bearings.get(*s).copied().flatten()));
        found.map(|sensor| sensor as u8)
    }

    /// Gives a sensor a bearing; returns whether it had another.
    fn place(&mut self, sensor: u8, bearing: Bearing) -> bool {
        let own = self.bearings.get_mut(usize::from(sensor));
        own.is_some_and(|own| own.replace(bearing) != Some(bearing))
    }

    /// The bearings that were not known.
    fn found_of_some(&self) -> LearnedBody<BEAMS> {
        let mut bearings = self.bearings;
        for sensor in self.fixed.indices(BEAMS) {
            if let Some(bearing) = bearings.get_mut(sensor) {
                *bearing = None;
            }
        }
        LearnedBody {
            bearings,
            actuation: Actuation::EXACT,
        }
    }

    fn learned(&self, calibration: &Calibration<BEAMS>, front: Front) -> LearnedBody<BEAMS> {
        let turn = front.turn();
        let (_, bearings) = self.best;
        LearnedBody {
            bearings: bearings.map(|bearing| bearing.map(|bearing| bearing.plus(turn))),
            actuation: if self.learns_actuation {
                Actuation {
                    front: calibration.front(),
                    length_q12: front.length_q12(),
                    turn_q12: self.turn_q12,
                }
            } else {
                Actuation::EXACT
            },
        }
    }
}

/// The first step towards the next sensor of a solution.
const GROW: Step = Step::Grow {
    sensor: 0,
    surest: None,
};

/// The first step of a round.
const fn sweep(round: u8) -> Step {
    Step::Sweep {
        sensor: 0,
        round,
        is_better: false,
    }
}

/// The bearings of all bins.
fn all() -> impl Iterator<Item = Bearing> {
    (0..BINS).map(|bin| Bearing::of_place(bin, BINS))
}

/// The bearings less than a bin from one, in parts of a bin.
fn around(bearing: Bearing) -> impl Iterator<Item = Bearing> {
    const PARTS: usize = BINS * PARTS_OF_BIN;
    let first = bearing.minus(Bearing::of_place(PARTS_OF_BIN - 1, PARTS));
    (0..2 * PARTS_OF_BIN - 1).map(move |part| first.plus(Bearing::of_place(part, PARTS)))
}
