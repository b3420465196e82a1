//! Divides a duration into equal steps of at most 10 ms.

/// Longest step, s.
const MAX_STEP_S: f64 = 0.010;

/// A duration divided into equal steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeSteps {
    pub(super) whole_s: f64,
    pub(super) steps: u32,
    pub(super) step_s: f64,
}

impl TimeSteps {
    /// Divides a duration into at least one step.
    pub(super) fn new(whole_s: f64) -> Self {
        let steps = libm::ceil(whole_s / MAX_STEP_S).clamp(1.0, 1e7) as u32;
        Self {
            whole_s,
            steps,
            step_s: whole_s.max(0.0) / f64::from(steps),
        }
    }
}
