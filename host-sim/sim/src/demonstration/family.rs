//! Kinds of goals, which are fitted apart.

use amp::goal::GoalFrame;

/// What a goal asks of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Family {
    /// The frame of its components.
    pub frame: GoalFrame,
    /// The robot may stand, or make shorter steps: the goal has no progress.
    pub stands: bool,
}

/// All of them.
pub const FAMILIES: [Family; 4] = {
    const fn family(frame: GoalFrame, stands: bool) -> Family {
        Family { frame, stands }
    }
    [
        family(GoalFrame::Travel, false),
        family(GoalFrame::Travel, true),
        family(GoalFrame::Ring, false),
        family(GoalFrame::Ring, true),
    ]
};

impl Family {
    /// Directions in which a situation may be seen.
    pub const fn directions(self) -> usize {
        match self.frame {
            GoalFrame::Ring => 1,
            GoalFrame::Travel => 16,
        }
    }
}
