//! Records a demonstration: one step from each decision to the next.

use super::ShownStep;
use amp::fixed::Mask;
use amp::scan::Situation;
use amp::units::{Bearing, Displacement};

/// Collects the steps of a demonstration.
#[derive(Debug, Clone, Default)]
pub struct DemonstrationRecorder {
    shown: Vec<ShownStep>,
    /// The step whose motion is under way; `None` where it is not demonstrated.
    open: Option<ShownStep>,
    /// The last displacement that was not zero, in the ring's frame at the last decision.
    course: Displacement,
}

impl DemonstrationRecorder {
    /// The robot has decided. Since the decision before it went `moved`, in the ring's frame at
    /// that decision, and the ring turned by `turned`. The step that begins is part of the
    /// demonstration if it has a situation, of which these values are known.
    pub fn decided(
        &mut self,
        moved: Displacement,
        turned: Bearing,
        perceived: Option<(Situation<16>, Mask)>,
    ) {
        if let Some(step) = self.open.take() {
            self.shown.push(ShownStep { moved, ..step });
        }
        if moved != Displacement::ZERO {
            self.course = moved;
        }
        self.course = self.course.rotated(turned.direction().mirrored());
        self.open = perceived.map(|(situation, known)| ShownStep {
            situation,
            known,
            course: self.course,
            moved: Displacement::ZERO,
        });
    }

    /// The step under way shows nothing: the robot is carried, or the recording ends.
    pub const fn abandon(&mut self) {
        self.open = None;
    }

    /// The last displacement that was not zero, in the ring's frame at the last decision.
    #[must_use]
    pub const fn course(&self) -> Displacement {
        self.course
    }

    /// The steps that have ended.
    #[must_use]
    pub fn shown(&self) -> &[ShownStep] {
        &self.shown
    }

    /// The steps that have ended.
    #[must_use]
    pub fn into_shown(self) -> Vec<ShownStep> {
        self.shown
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::fixed::Weight;

    const QUARTER_TURN: Bearing = Bearing::from_turns(16_384);

    fn along(dx_mm: i16, dy_mm: i16) -> Displacement {
        Displacement { dx_mm, dy_mm }
    }

    #[test]
    fn a_step_has_the_move_after_it_and_the_course_before_it() {
        let mut recorder = DemonstrationRecorder::default();
        let perceived = |value: f64| Some(([Weight::from_num(value); 16], Mask::ALL));
        recorder.decided(along(9, 9), Bearing::ZERO, perceived(0.25));
        // The ring has turned to the left: what was ahead is on its right now.
        recorder.decided(along(200, 0), QUARTER_TURN, perceived(0.5));
        assert_eq!(recorder.course(), along(0, -200));
        // A decision that is not demonstrated, and one where the robot stood.
        recorder.decided(along(0, 0), Bearing::ZERO, None);
        recorder.decided(along(70, 0), Bearing::ZERO, perceived(0.75));
        assert_eq!(recorder.course(), along(70, 0));
        recorder.abandon();
        recorder.decided(along(30, 0), Bearing::ZERO, None);
        let shown = recorder.into_shown();
        let steps: Vec<_> = shown
            .iter()
            .map(|step| (step.situation[3].to_num::<f64>(), step.course, step.moved))
            .collect();
        assert_eq!(
            steps,
            [
                (0.25, along(9, 9), along(200, 0)),
                (0.5, along(0, -200), along(0, 0)),
            ]
        );
    }
}
