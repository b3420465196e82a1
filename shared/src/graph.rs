//! The graph of traversed situations: which neuron of the situation map followed which, and by what
//! displacement.
//!
//! The grid of a map says which situations are alike, not which one a move leads to. A *passage* is
//! what was driven: the robot came from neuron `before`, was at another, and left it for `to`. It
//! keeps the mean displacement from the entry into the neuron to the exit, and that of the last
//! move alone. Where the robot came from says where in the neuron's region it entered, so the
//! same displacement leads to the same exit; a neuron alone does not say that.
//!
//! A plan is the cheapest chain of passages to the goal neuron, each continued by one that came
//! from its own neuron (value iteration; R. Bellman, *Dynamic Programming*, 1957). A passage costs
//! its mean number of moves over the share of the aims that it fulfilled; one that fails too often
//! is forgotten. Two places that look alike are one neuron here: the graph cannot tell them apart,
//! and what it forgets then is a passage of one of the two.

use crate::units::Displacement;

/// Passages out of one neuron that are kept; a further one replaces the rarest.
const PASSAGES: usize = 16;
/// No neuron.
const NOWHERE: u8 = u8::MAX;
/// Moves after which an aim that has not left its neuron has failed.
pub const MAX_LEG: u8 = 13;
/// A mean counts the latest traversals about equally, and older ones ever less.
const AVERAGED: i32 = 8;
/// Aims after which a passage may be forgotten, and above which they are halved.
const LEAST_TRIES: u8 = 3;
const MOST_TRIES: u8 = 20;
/// Traversals above which all of a neuron's are halved.
const MOST_TRAVERSALS: u8 = 60;
/// Cost above that of any chain.
const UNREACHABLE: u32 = u32::MAX / 2;
/// Moves that a passage costs at least and at most, in 1/16.
const MOVES_Q4: [i32; 2] = [16, 256];

/// What was driven from one neuron to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Passage {
    /// The neuron before the one that it leaves.
    before: u8,
    /// The neuron that it enters.
    to: u8,
    /// Traversals, decayed; 0 = the slot is free.
    traversals: u8,
    /// Aims at it, decayed.
    tries: u8,
    /// Of `tries`: the neuron that followed was `to`.
    hits: u8,
    /// Mean number of moves, in 1/16.
    moves_q4: i32,
    /// Mean displacement from the entry to the exit.
    whole: Displacement,
    /// Mean displacement of the move that left the neuron.
    last: Displacement,
}

impl Passage {
    const FREE: Self = Self {
        before: NOWHERE,
        to: NOWHERE,
        traversals: 0,
        tries: 0,
        hits: 0,
        moves_q4: 0,
        whole: Displacement::ZERO,
        last: Displacement::ZERO,
    };

    const fn is_used(&self) -> bool {
        self.traversals > 0
    }

    fn traversed(&mut self, moves: u8, whole: Displacement, last: Displacement) {
        let count = i32::from(self.traversals).saturating_add(1).min(AVERAGED);
        let towards = |mean: Displacement, new: Displacement| Displacement {
            dx_mm: mixed(mean.dx_mm.into(), new.dx_mm.into(), count) as i16,
            dy_mm: mixed(mean.dy_mm.into(), new.dy_mm.into(), count) as i16,
        };
        self.whole = towards(self.whole, whole);
        self.last = towards(self.last, last);
        self.moves_q4 = mixed(self.moves_q4, i32::from(moves) << 4, count);
        self.traversals = self.traversals.saturating_add(1);
    }

    /// Counts an aim; forgets the passage where less than a third succeeded.
    fn tried(&mut self, hit: bool) {
        self.tries = self.tries.saturating_add(1);
        self.hits = self.hits.saturating_add(u8::from(hit));
        let fails = u16::from(self.hits).saturating_mul(3) < u16::from(self.tries);
        if self.tries >= LEAST_TRIES && fails {
            *self = Self::FREE;
        } else if self.tries > MOST_TRIES {
            (self.tries, self.hits) = (self.tries >> 1, self.hits >> 1);
        }
    }

    /// Expected moves if each failed aim is repeated, in 1/16; half a success is added, so that an
    /// untried passage is neither sure nor impossible.
    fn cost(&self) -> u32 {
        let [least, most] = MOVES_Q4;
        let moves = self.moves_q4.clamp(least, most).unsigned_abs();
        let share_q8 = (u32::from(self.hits) << 8).saturating_add(128)
            / u32::from(self.tries).saturating_add(1);
        (moves << 8) / share_q8.max(4)
    }
}

/// The mean moved by 1/`count` of the way to a new value.
fn mixed(mean: i32, new: i32, count: i32) -> i32 {
    let step = new.wrapping_sub(mean).checked_div(count);
    mean.wrapping_add(step.unwrap_or(0))
}

/// Where the robot is to go next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Aim {
    /// The neuron that is to follow.
    pub to: u8,
    /// The direction to take, in the ring's frame.
    pub way: Displacement,
}

/// The passages of a map of `NEURONS` neurons (at most 255), and the leg under way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraversedGraph<const NEURONS: usize> {
    passages: [[Passage; PASSAGES]; NEURONS],
    /// The neuron before the present one.
    before: u8,
    /// The present neuron; [`NOWHERE`] at first.
    at: u8,
    /// Moves since it was entered, and their sum.
    moves: u8,
    gone: Displacement,
    /// The neuron aimed at, if there is one.
    aim: Option<u8>,
    /// Moves since then.
    aimed: u8,
}

impl<const NEURONS: usize> TraversedGraph<NEURONS> {
    /// Nothing traversed.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            passages: [[Passage::FREE; PASSAGES]; NEURONS],
            before: NOWHERE,
            at: NOWHERE,
            moves: 0,
            gone: Displacement::ZERO,
            aim: None,
            aimed: 0,
        }
    }

    /// The robot may be elsewhere: what follows is no traversal from here.
    pub const fn interrupt(&mut self) {
        (self.before, self.at, self.aim) = (NOWHERE, NOWHERE, None);
        (self.moves, self.gone) = (0, Displacement::ZERO);
    }

    /// Whether the next observation is where a leg begins.
    #[must_use]
    pub const fn is_interrupted(&self) -> bool {
        self.at == NOWHERE
    }

    /// Learns that a move (in the ring's frame, millimeters) ended at a neuron.
    pub fn observe(&mut self, neuron: usize, moved: Displacement) {
        let to = u8::try_from(neuron).unwrap_or(NOWHERE);
        if self.at == NOWHERE {
            self.at = to;
            return;
        }
        self.moves = self.moves.saturating_add(1);
        self.gone = self.gone.plus(moved);
        self.aimed = self.aimed.saturating_add(1);
        let has_left = to != self.at;
        if let Some(aim) = self.aim
            && (has_left || self.aimed >= MAX_LEG)
        {
            self.aim = None;
            let before = self.before;
            if let Some(passage) = self.find(before, aim) {
                passage.tried(has_left && aim == to);
            }
        }
        if has_left {
            self.enter(to, moved);
        }
    }

    fn find(&mut self, before: u8, to: u8) -> Option<&mut Passage> {
        let here = self.passages.get_mut(usize::from(self.at))?;
        let mut used = here.iter_mut().filter(|passage| passage.is_used());
        used.find(|passage| passage.before == before && passage.to == to)
    }

    fn enter(&mut self, to: u8, moved: Displacement) {
        let (before, moves, gone) = (self.before, self.moves, self.gone);
        if self.find(before, to).is_none()
            && let Some(here) = self.passages.get_mut(usize::from(self.at))
            && let Some(rarest) = here.iter_mut().min_by_key(|passage| passage.traversals)
        {
            *rarest = Passage {
                before,
                to,
                ..Passage::FREE
            };
            // A free slot counts as used from its first traversal on.
            rarest.traversed(moves, gone, moved);
        } else if let Some(passage) = self.find(before, to) {
            passage.traversed(moves, gone, moved);
        }
        if let Some(here) = self.passages.get_mut(usize::from(self.at))
            && here.iter().any(|one| one.traversals > MOST_TRAVERSALS)
        {
            for passage in here.iter_mut().filter(|passage| passage.traversals > 1) {
                passage.traversals >>= 1;
            }
        }
        (self.before, self.at) = (self.at, to);
        (self.moves, self.gone) = (0, Displacement::ZERO);
    }

    /// What to do on the way to a goal neuron; `None` at it, and where no chain of passages leads
    /// there. An aim is kept, even for another goal, until its neuron is left or [`MAX_LEG`] moves
    /// are over. `step_mm` is the length of the way.
    pub fn aim(&mut self, goal: usize, step_mm: u16) -> Option<Aim> {
        if usize::from(self.at) == goal {
            self.aim = None;
            return None;
        }
        if self.aim.is_none() {
            self.aim = self.first_of_chain(goal);
            self.aimed = 0;
        }
        let (before, gone) = (self.before, self.gone);
        let passage = *self.find(before, self.aim?)?;
        let left = Displacement::saturating(
            i32::from(passage.whole.dx_mm).wrapping_sub(gone.dx_mm.into()),
            i32::from(passage.whole.dy_mm).wrapping_sub(gone.dy_mm.into()),
        );
        let is_on = !left.is_shorter_than(u32::from(step_mm / 2)) && !left.opposes(passage.last);
        let way = if is_on { left } else { passage.last };
        Some(Aim {
            to: passage.to,
            way: way.with_length(step_mm),
        })
    }

    /// The neuron that begins the cheapest chain of passages to the goal neuron.
    fn first_of_chain(&self, goal: usize) -> Option<u8> {
        let mut costs = [[UNREACHABLE; PASSAGES]; NEURONS];
        for _ in 0..NEURONS {
            let mut changed = false;
            for (neuron, passages) in self.passages.iter().enumerate() {
                if neuron == goal {
                    continue;
                }
                for (slot, passage) in passages.iter().enumerate() {
                    let rest = self.rest(&costs, neuron, passage, goal);
                    let cost = rest.saturating_add(passage.cost());
                    let known = costs.get_mut(neuron).and_then(|row| row.get_mut(slot));
                    if let Some(known) = known
                        && passage.is_used()
                        && cost < *known
                    {
                        (*known, changed) = (cost, true);
                    }
                }
            }
            if !changed {
                break;
            }
        }
        let here = usize::from(self.at);
        let pairs = self.passages.get(here)?.iter().zip(costs.get(here)?);
        let ways = pairs.filter(|(passage, cost)| {
            passage.is_used() && passage.before == self.before && **cost < UNREACHABLE
        });
        ways.min_by_key(|(_, cost)| **cost)
            .map(|(passage, _)| passage.to)
    }

    /// Least cost from where a passage out of `neuron` ends.
    fn rest(
        &self,
        costs: &[[u32; PASSAGES]; NEURONS],
        neuron: usize,
        passage: &Passage,
        goal: usize,
    ) -> u32 {
        let to = usize::from(passage.to);
        if to == goal {
            return 0;
        }
        let next = self.passages.get(to).into_iter().flatten();
        let next = next.zip(costs.get(to).into_iter().flatten());
        let on = next.filter(|(next, _)| next.is_used() && usize::from(next.before) == neuron);
        on.map(|(_, cost)| *cost).min().unwrap_or(UNREACHABLE)
    }
}

impl<const NEURONS: usize> Default for TraversedGraph<NEURONS> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
