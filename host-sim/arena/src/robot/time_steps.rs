//! A time cut into equal steps, none longer than 10 ms.

/// Longest step, s.
const MAX_STEP_S: f64 = 0.010;

/// A time cut into equal steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeSteps {
    pub(super) whole_s: f64,
    pub(super) steps: u32,
    pub(super) step_s: f64,
}

impl TimeSteps {
    /// The steps of a time; at least one.
    pub(super) fn of(whole_s: f64) -> Self {
        let steps = libm::ceil(whole_s / MAX_STEP_S).clamp(1.0, 1e7) as u32;
        Self {
            whole_s,
            steps,
            step_s: whole_s.max(0.0) / f64::from(steps),
        }
    }
}
