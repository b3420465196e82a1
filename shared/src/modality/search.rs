//! The search for where something is strongest: near the strongest that is known it may be stronger
//! still.

use super::{Modality, Sought};
use crate::places::{Aim, Places};
use crate::units::{Displacement, Millis};
use heapless::Vec;

/// Where the robot has not been is looked at if it is this near to the best that it knows,
/// millimeters.
const NEAR_MM: u32 = 1_000;
/// A position is reached within this, millimeters.
const REACHED_MM: u32 = 150;
/// What has not been reached after this time is given up, milliseconds.
const PATIENCE_MS: u32 = 40_000;
/// Around a position that the robot has come to for so long it knows what is open, milliseconds.
const SETTLED_MS: u32 = 3_000;
/// Positions that were tried, at most: the oldest is tried again.
const TRIED: usize = 16;

/// What is looked at around the best that is known.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Search {
    target: Option<Target>,
    tried: Vec<Displacement, TRIED>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Target {
    position: Displacement,
    since: Millis,
}

impl Search {
    /// Where a robot that looks for something is to be led. It goes to where it has not been if
    /// that is near to the best that it knows, or if it knows nothing; otherwise to the best.
    pub fn aim<
        const COMPONENTS: usize,
        const SENSED: usize,
        const SECTORS: usize,
        const RECORDS: usize,
    >(
        &mut self,
        modality: &Modality<COMPONENTS, SENSED>,
        sought: &Sought<COMPONENTS>,
        places: &Places<SECTORS, RECORDS>,
        now: Millis,
    ) -> Aim {
        let best = modality.recall(sought, places.here());
        let Some(best) = best.filter(|best| sought.is_found_in(&best.values)) else {
            self.target = None;
            return Aim::Everywhere;
        };
        if !sought.is_greatest() {
            return Aim::Position(best.at);
        }
        let is_here = |position: Displacement| {
            let away = position.minus(places.here());
            away.is_shorter_than(REACHED_MM)
        };
        let is_near = |position: Displacement| position.minus(best.at).is_shorter_than(NEAR_MM);
        if let Some(Target { position, since }) = self.target {
            let is_over = is_here(position) || now.after(since) >= PATIENCE_MS;
            if !is_over && is_near(position) {
                return Aim::Position(position);
            }
            if is_over {
                if self.tried.is_full() {
                    self.tried.remove(0);
                }
                // There is room.
                let _ = self.tried.push(position);
            }
        }
        let is_tried = |position: Displacement| {
            let mut tried = self.tried.iter();
            tried.any(|tried| tried.minus(position).is_shorter_than(REACHED_MM))
        };
        let ends = places.frontiers().map(|(_, end)| end);
        let untried = ends.filter(|end| is_near(*end) && !is_tried(*end));
        let next = untried.min_by_key(|end| end.minus(best.at).squared_mm2());
        self.target = next.map(|position| Target {
            position,
            since: now,
        });
        match next {
            Some(position) => Aim::Position(position),
            None if now.after(best.first) < SETTLED_MS => Aim::Everywhere,
            None => Aim::Position(best.at),
        }
    }
}
