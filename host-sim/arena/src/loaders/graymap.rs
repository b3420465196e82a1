//! A gray image in memory.

/// Most pixels an image may have.
const MAX_PIXELS: usize = 1 << 26;

/// A gray image; row 0 is the top one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Graymap {
    pub width: usize,
    pub height: usize,
    /// Value of white.
    pub max_value: u16,
    /// `width · height` values, row by row.
    pub pixels: Vec<u16>,
}

/// Number of pixels of an image that is neither empty nor too large.
pub(super) fn pixel_count(width: usize, height: usize) -> Result<usize, String> {
    let count = width.checked_mul(height);
    count
        .filter(|count| (1..=MAX_PIXELS).contains(count))
        .ok_or_else(|| format!("an image of {width} × {height} pixels is empty or too large"))
}
