//! Draws values of the sonar ring as bars around a circle, front up, left to the left.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use super::color::{BLUE, GRAY, INK, PALE, VALUE, VERMILLION};
use super::svg::{Anchor, Font, Svg, fill, filled, stroke};

/// Radius of the inner circle of a rosette of values, as part of its radius.
const HUB: f64 = 0.27;
/// Radius of the zero circle of a rosette of changes, as part of its radius.
const ZERO: f64 = 0.62;

/// Position and size of one rosette.
#[derive(Debug, Clone, Copy)]
pub struct Rosette<'a> {
    /// Page coordinates, px.
    pub center: [f64; 2],
    /// Radius of the full value, px.
    pub radius: f64,
    /// Bearings of the transducers, rad counter-clockwise from the front.
    pub bearings: &'a [f64],
}

impl Rosette<'_> {
    /// One outward bar per transducer; `full` is the value at the outer circle.
    pub fn values(&self, svg: &mut Svg, values: &[f64], full: f64) {
        svg.circle(self.center, self.radius, &filled("#ffffff", PALE, 1.0));
        for (i, &value) in values.iter().enumerate() {
            let length = part(value / full, 0.0) * (1.0 - HUB);
            if length > 0.004 {
                self.bar(
                    svg,
                    self.bearing(i, values.len()),
                    [HUB, HUB + length],
                    VALUE,
                );
            }
        }
        svg.circle(self.center, self.radius * HUB, &stroke(GRAY, 1.0));
        self.front(svg);
    }

    /// One bar per transducer from the zero circle: outward for an increase, inward for a decrease;
    /// `full` is the change that reaches the outer circle.
    pub fn changes(&self, svg: &mut Svg, changes: &[f64], full: f64) {
        svg.circle(self.center, self.radius, &filled("#ffffff", PALE, 1.0));
        for (i, &change) in changes.iter().enumerate() {
            let length = if full > 0.0 {
                part(change / full, -1.0) * (1.0 - ZERO)
            } else {
                0.0
            };
            let color = if length > 0.0 { VERMILLION } else { BLUE };
            if length.abs() > 0.004 {
                self.bar(
                    svg,
                    self.bearing(i, changes.len()),
                    [ZERO, ZERO + length],
                    color,
                );
            }
        }
        svg.circle(self.center, self.radius * ZERO, &stroke(GRAY, 1.0));
        self.front(svg);
    }

    /// An arrow from the center along `displacement` (ring frame, m); `full` m nearly reach the
    /// zero circle.
    pub fn arrow(&self, svg: &mut Svg, displacement: [f64; 2], full: f64) {
        let [x, y] = displacement;
        let length = libm::hypot(x, y);
        if !(full > 0.0 && length.is_finite() && length > full * 1e-6) {
            svg.circle(self.center, 2.5, &fill(INK));
            return;
        }
        let reach = self.radius * (ZERO - 0.05) * (length / full).min(1.0);
        arrow(svg, self.center, libm::atan2(y, x), reach, 2.2);
    }

    /// Fills the inner circle of a rosette of values.
    pub fn fill_hub(&self, svg: &mut Svg, color: &str) {
        svg.circle(self.center, self.radius * HUB, &filled(color, color, 1.0));
    }

    /// Labels front, left, back and right around the rosette, with transducer numbers.
    pub fn annotate(&self, svg: &mut Svg) {
        let [x, y] = self.center;
        let r = self.radius;
        let font = Font::new(11.0).color(GRAY);
        let middle = font.at(Anchor::Middle);
        let at = |bearing| {
            nearest(self.bearings, bearing)
                .map(|i| format!(" {i}"))
                .unwrap_or_default()
        };
        svg.text([x, y - r - 9.0], middle, &format!("front{}", at(0.0)));
        svg.text([x, y + r + 14.0], middle, &format!("back{}", at(PI)));
        svg.text(
            [x - r - 5.0, y + 4.0],
            font.at(Anchor::End),
            &format!("left{}", at(FRAC_PI_2)),
        );
        svg.text(
            [x + r + 5.0, y + 4.0],
            font,
            &format!("right{}", at(-FRAC_PI_2)),
        );
    }

    /// A small mark at the front, outside the circle.
    fn front(&self, svg: &mut Svg) {
        let [x, y] = self.center;
        let top = y - self.radius;
        svg.polygon(
            &[[x - 3.0, top], [x + 3.0, top], [x, top - 5.0]],
            &fill(GRAY),
        );
    }

    fn bar(&self, svg: &mut Svg, bearing: f64, [from, to]: [f64; 2], color: &str) {
        let half = 0.36 * TAU / self.bearings.len().max(1) as f64;
        let half = half.min(0.3);
        let corner = |radius: f64, offset: f64| self.at(radius, bearing + offset);
        let corners = [
            corner(from, half),
            corner(to, half),
            corner(to, -half),
            corner(from, -half),
        ];
        svg.polygon(&corners, &fill(color));
    }

    /// The page point at `radius` (relative to the rosette's) and `bearing`.
    fn at(&self, radius: f64, bearing: f64) -> [f64; 2] {
        toward(self.center, bearing, radius * self.radius)
    }

    /// Bearing of transducer `i` of `count`; evenly spread without given bearings.
    fn bearing(&self, i: usize, count: usize) -> f64 {
        let even = TAU * i as f64 / count.max(1) as f64;
        self.bearings.get(i).copied().unwrap_or(even)
    }
}

/// An arrow of `length` px from `tail` toward `bearing`, with a white rim.
pub fn arrow(svg: &mut Svg, tail: [f64; 2], bearing: f64, length: f64, width: f64) {
    // Short arrows are thinner, which keeps their shape.
    let width = width.min(0.2 * length);
    let head = (3.2 * width).min(0.7 * length);
    let neck = toward(tail, bearing, length - head * 0.8);
    let tip = toward(tail, bearing, length);
    let back = toward(tail, bearing, length - head);
    let wing = |side: f64| toward(back, bearing + side * FRAC_PI_2, head * 0.5);
    let point = [tip, wing(1.0), wing(-1.0)];
    svg.line(tail, neck, &stroke("#ffffff", width + 2.0));
    svg.polygon(&point, &filled("#ffffff", "#ffffff", 2.0));
    svg.line(tail, neck, &stroke(INK, width));
    svg.polygon(&point, &fill(INK));
}

/// `distance` px from `origin` toward `bearing`, 0 up the page and counter-clockwise positive.
fn toward([x, y]: [f64; 2], bearing: f64, distance: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(bearing);
    [x - distance * sin, y - distance * cos]
}

/// The transducer whose bearing is nearest to `wanted` (rad), the first among equals.
pub fn nearest(bearings: &[f64], wanted: f64) -> Option<usize> {
    let away = |bearing: f64| -libm::cos(bearing - wanted);
    let mut best: Option<(usize, f64)> = None;
    for (i, &bearing) in bearings.iter().enumerate() {
        if best.is_none_or(|(_, distance)| away(bearing) < distance - 1e-9) {
            best = Some((i, away(bearing)));
        }
    }
    best.map(|(i, _)| i)
}

/// `value` clamped to [`low`, 1]; NaN counts as 0.
fn part(value: f64, low: f64) -> f64 {
    if value.is_nan() {
        0.0
    } else {
        value.clamp(low, 1.0)
    }
}

/// Draws background and number of neuron `index`; returns its rosette.
pub fn tile<'a>(
    svg: &mut Svg,
    area: [f64; 4],
    index: usize,
    shade: &str,
    bearings: &'a [f64],
) -> Rosette<'a> {
    let [x, y, side, _] = area;
    svg.rect(area, &filled(shade, "#ffffff", 2.0));
    svg.text(
        [x + 6.0, y + 15.0],
        Font::new(12.5).bold(),
        &format!("N{}", index + 1),
    );
    let radius = (side - 34.0) / 2.0;
    Rosette {
        center: [x + side / 2.0, y + side / 2.0 + 9.0],
        radius,
        bearings,
    }
}

/// A word in the top right corner of a tile.
pub fn corner(svg: &mut Svg, [x, y, side, _]: [f64; 4], text: &str) {
    let font = Font::new(11.0).color(INK).at(Anchor::End);
    svg.text([x + side - 6.0, y + 15.0], font, text);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn front_is_up_and_left_is_left() {
        let [x, y] = toward([0.0, 0.0], 0.0, 1.0);
        assert!(x.abs() < 1e-12 && y == -1.0);
        let [x, y] = toward([0.0, 0.0], FRAC_PI_2, 1.0);
        assert!(x == -1.0 && y.abs() < 1e-12);
    }

    #[test]
    fn named_directions_are_found_on_any_ring() {
        for count in [8_usize, 16, 24] {
            let ring: Vec<f64> = (0..count).map(|i| TAU * i as f64 / count as f64).collect();
            let found = [0.0, FRAC_PI_2, PI, -FRAC_PI_2].map(|b| nearest(&ring, b).unwrap());
            assert_eq!(found, [0, count / 4, count / 2, 3 * count / 4]);
        }
        assert_eq!(nearest(&[], 0.0), None);
    }
}
