//! Color-blind-safe colors and continuous color ramps.

/// Text and outlines.
pub const INK: &str = "#1f2933";
/// Secondary text.
pub const GRAY: &str = "#5a6673";
/// Axes, zero lines, empty cells.
pub const PALE: &str = "#c5ccd3";
/// Fill of obstacles.
pub const OBSTACLE: &str = "#e3e6e9";
/// Bars of values in [0, 1].
pub const VALUE: &str = "#3f5871";
/// Okabe and Ito's vermillion: increase (an obstacle comes nearer), contact.
pub const VERMILLION: &str = "#d55e00";
/// Okabe and Ito's blue: decrease (an obstacle goes away).
pub const BLUE: &str = "#0072b2";
/// Okabe and Ito's orange: the shield, the goal.
pub const ORANGE: &str = "#e69f00";
/// Okabe and Ito's reddish purple: exploration.
pub const PURPLE: &str = "#cc79a7";

/// Okabe and Ito's bluish green.
pub const GREEN: &str = "#009e73";
/// Okabe and Ito's sky blue.
pub const SKY: &str = "#56b4e9";
/// Okabe and Ito's yellow.
pub const YELLOW: &str = "#f0e442";

/// The color of class `index`; colors repeat after eight.
pub fn class(index: usize) -> &'static str {
    const CLASSES: [&str; 8] = [BLUE, ORANGE, GREEN, PURPLE, SKY, VERMILLION, YELLOW, PALE];
    CLASSES[index % CLASSES.len()]
}

const VIRIDIS: [[u8; 3]; 9] = [
    [0x44, 0x01, 0x54],
    [0x47, 0x2d, 0x7b],
    [0x3b, 0x52, 0x8b],
    [0x2c, 0x72, 0x8e],
    [0x21, 0x91, 0x8c],
    [0x28, 0xae, 0x80],
    [0x5e, 0xc9, 0x62],
    [0xad, 0xdc, 0x30],
    [0xfd, 0xe7, 0x25],
];
const CIVIDIS: [[u8; 3]; 9] = [
    [0x00, 0x22, 0x4e],
    [0x12, 0x35, 0x70],
    [0x3b, 0x49, 0x6c],
    [0x57, 0x5d, 0x6d],
    [0x70, 0x71, 0x73],
    [0x8a, 0x86, 0x78],
    [0xa5, 0x9c, 0x74],
    [0xc3, 0xb3, 0x69],
    [0xfe, 0xe8, 0x38],
];
const TINT: [[u8; 3]; 2] = [[0xff, 0xff, 0xff], [0xb4, 0xbe, 0xca]];

/// Time along a path: viridis without its palest end, `at` in [0, 1].
pub fn time(at: f64) -> String {
    hex(mix(&VIRIDIS, at.clamp(0.0, 1.0) * 0.86))
}

/// A continuous value: cividis, `at` in [0, 1].
pub fn value(at: f64) -> String {
    hex(mix(&CIVIDIS, at))
}

/// A background that dark bars stay visible on: white to slate gray, `at` in [0, 1].
pub fn tint(at: f64) -> String {
    hex(mix(&TINT, at))
}

/// The text color to read on [`value`]`(at)`.
pub fn text_on_value(at: f64) -> &'static str {
    if at < 0.55 { "#ffffff" } else { INK }
}

fn mix(stops: &[[u8; 3]], at: f64) -> [u8; 3] {
    let at = if at.is_nan() { 0.0 } else { at.clamp(0.0, 1.0) };
    let place = at * (stops.len() - 1) as f64;
    let below = (place as usize).min(stops.len() - 2);
    let part = place - below as f64;
    core::array::from_fn(|channel| {
        let (a, b) = (
            f64::from(stops[below][channel]),
            f64::from(stops[below + 1][channel]),
        );
        (a + (b - a) * part + 0.5) as u8
    })
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_meet_their_stops_and_stay_inside() {
        assert_eq!(value(0.0), "#00224e");
        assert_eq!(value(1.0), "#fee838");
        assert_eq!(value(7.0), value(1.0));
        assert_eq!(value(f64::NAN), value(0.0));
        assert_eq!(tint(0.0), "#ffffff");
        assert_eq!(time(0.0), "#440154");
        assert_eq!(value(0.5), "#707173");
    }
}
