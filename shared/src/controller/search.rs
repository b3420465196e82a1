//! Progress towards a place, and when the robot wanders because there is none.

use super::tracked::Tracked;
use crate::config::{Config, Wander};
use crate::fixed::Mask;
use crate::goal::Goal;
use crate::planner::NEXT_COURSE;
use crate::scan::Situation;

/// How the search for a place goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SearchProgress {
    /// Least deviation since the last wandering, if there was a decision.
    nearest: i64,
    begun: bool,
    /// Decisions since it was reached.
    since: u8,
    /// Decisions for which the robot still wanders.
    left: u8,
}

impl SearchProgress {
    /// Nothing tried yet.
    pub(super) const NEW: Self = Self {
        nearest: 0,
        begun: false,
        since: 0,
        left: 0,
    };

    /// Counts a decision taken at this deviation from the goal; true when the robot begins to
    /// wander with it. Nearer means by a fiftieth: a robot that trembles before a local optimum
    /// does not come nearer.
    pub(super) fn is_stuck(&mut self, deviation: i64, wander: Wander) -> bool {
        if self.left > 0 {
            self.left -= 1;
            if self.left == 0 {
                *self = Self::NEW;
            }
            return false;
        }
        let nearer = self.nearest.saturating_sub(self.nearest / 50);
        if !self.begun || deviation < nearer {
            self.begun = true;
            self.nearest = deviation;
            self.since = 0;
            return false;
        }
        self.since = self.since.saturating_add(1);
        let stuck = self.since > wander.patience && wander.moves > 0;
        if stuck {
            self.left = wander.moves;
        }
        stuck
    }

    /// Whether the robot wanders now.
    pub(super) const fn wanders(&self) -> bool {
        self.left > 0
    }
}

/// The goal of a robot that wanders, instead of its own: obstacle avoidance on another course.
/// `None` if it does not wander.
pub(super) fn wandering_goal<const SENSORS: usize>(
    config: &Config<SENSORS>,
    enabled: Mask,
    situation: &Situation<SENSORS>,
    goal: &Goal<SENSORS>,
    search: &mut SearchProgress,
    course: &mut Tracked,
) -> Option<Goal<SENSORS>> {
    let wander = config.planning.wander?;
    if !goal.is_place() {
        return None;
    }
    let deviation = goal.cost(0, enabled, situation, i64::MAX);
    if goal.is_met_by(deviation, goal.asked(0, enabled)) {
        *search = SearchProgress::NEW;
    } else if search.is_stuck(deviation, wander) {
        let onward = course.now().with_length(config.robot.step_mm);
        *course = Tracked::new(onward.rotated(NEXT_COURSE.direction()));
    }
    search.wanders().then(|| Goal::avoiding(config))
}

#[cfg(test)]
mod tests {
    use super::*;

    const WANDER: Wander = Wander {
        patience: 2,
        moves: 3,
    };

    #[test]
    fn a_robot_that_comes_no_nearer_wanders_for_a_while() {
        let mut search = SearchProgress::NEW;
        let approach = [1_000, 900, 899, 898].map(|d| search.is_stuck(d, WANDER));
        assert_eq!(approach, [false; 4]);
        assert!(search.is_stuck(897, WANDER) && search.wanders());
        let wandering = [0; 3].map(|_| {
            assert!(!search.is_stuck(2_000, WANDER));
            search.wanders()
        });
        assert_eq!(wandering, [true, true, false]);
        assert!(!search.is_stuck(5_000, WANDER) && !search.wanders());
    }

    #[test]
    fn coming_nearer_is_never_stuck() {
        let mut search = SearchProgress::NEW;
        assert!((0..30).all(|step| !search.is_stuck(1_000_000 >> (step / 2), WANDER)));
    }

    #[test]
    fn nearer_is_nearer_by_a_fiftieth() {
        let stuck = |second: i64| {
            let mut search = SearchProgress::NEW;
            [1_000, second, second, second].map(|d| search.is_stuck(d, WANDER))
        };
        assert_eq!(stuck(980), [false, false, false, true]);
        assert_eq!(stuck(979), [false; 4]);
        assert_eq!(stuck(1_000), [false, false, false, true]);
    }

    #[test]
    fn who_may_not_wander_is_never_stuck() {
        let mut search = SearchProgress::NEW;
        let still = Wander {
            patience: 0,
            moves: 0,
        };
        assert!((0..9).all(|_| !search.is_stuck(1_000, still)) && !search.wanders());
        let at_once = Wander {
            patience: 0,
            moves: 1,
        };
        assert!(search.is_stuck(1_000, at_once) && search.wanders());
        assert!(!search.is_stuck(1_000, at_once) && !search.wanders());
    }
}
