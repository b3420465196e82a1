//! Unit of the ring's readings: whole inches in a byte.

/// Length of an inch, m.
pub const M_PER_INCH: f64 = 0.0254;

/// The largest reading, in: no echo.
pub const MAX_READING_IN: u8 = 255;

pub(super) const INCHES_PER_M: f64 = 1.0 / M_PER_INCH;

/// The nearest whole number of inches.
pub(super) fn whole_inches(range_m: f64) -> f64 {
    libm::rint(range_m / M_PER_INCH)
}

/// The byte the Nomad's ring reports for a range in meters: whole inches, 255 for `None`.
#[must_use]
pub fn reading_in(range: Option<f64>) -> u8 {
    let inches = range.map_or(f64::INFINITY, whole_inches);
    // The clamp keeps the cast in range; NaN becomes 0.
    inches.clamp(0.0, f64::from(MAX_READING_IN)) as u8
}
