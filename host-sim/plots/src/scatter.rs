//! Draws samples in the plane or in space with the map trained on them (Fig. 1 of the paper).

use sim::recording::MapRecord;

use crate::draw::color::{BLUE, GRAY, INK, ORANGE, PALE};
use crate::draw::layout::{Legend, MARGIN, PAGE, PLOT, TOP, counted, heading, shortened};
use crate::draw::svg::{Anchor, Font, Svg, fill, filled, num, stroke};

/// Largest number of drawn samples, evenly picked.
const MAX_DOTS: usize = 4000;
/// View of three dimensions: rotation about the third axis, then elevation, rad.
const TURN: f64 = 0.62;
const LIFT: f64 = 0.42;
/// Height of the drawing, px.
const HEIGHT: f64 = 540.0;

/// Draws samples as dots and code vectors as circles joined along the grid, in two or three
/// dimensions.
///
/// Three dimensions are shown in parallel projection, all axes on one scale. `names` label the axes
/// (may be empty).
///
/// Returns an SVG document, or nothing when the code vectors have another number of dimensions.
#[must_use]
pub fn scatter(
    map: &MapRecord,
    samples: &[Vec<f64>],
    names: &[String],
    title: &str,
) -> Option<String> {
    let dimensions = map.code.first()?.len();
    if !(2..=3).contains(&dimensions) || map.code.iter().any(|code| code.len() != dimensions) {
        return None;
    }
    let dots: Vec<[f64; 3]> = picked(samples)
        .filter_map(|sample| point(sample, dimensions))
        .collect();
    let code: Vec<[f64; 3]> = map
        .code
        .iter()
        .map(|code| point(code, dimensions).unwrap_or_default())
        .collect();
    let space = Space::holding(dots.iter().chain(&code), dimensions);
    let mut svg = Svg::new(PAGE, TOP + HEIGHT + 30.0);
    let subtitle = format!(
        "{} × {} neurons · {} · {dimensions} dimensions",
        map.grid[0],
        map.grid[1],
        counted(samples.len(), "sample")
    );
    heading(&mut svg, title, &subtitle);
    space.axes(&mut svg, names);
    for &dot in &dots {
        let style = format!(r#"{} fill-opacity="0.4""#, fill(BLUE));
        svg.circle(space.at(dot), 1.7, &style);
    }
    neurons(&mut svg, &space, map.grid, &code);
    legend(&mut svg, map.grid);
    Some(svg.finish(title, &subtitle))
}

fn picked(samples: &[Vec<f64>]) -> impl Iterator<Item = &Vec<f64>> {
    samples
        .iter()
        .step_by(samples.len().div_ceil(MAX_DOTS).max(1))
}

/// The first `dimensions` values; `None` if there are fewer or one is not finite.
fn point(values: &[f64], dimensions: usize) -> Option<[f64; 3]> {
    let values = values.get(..dimensions)?;
    let at = |i: usize| values.get(i).copied().unwrap_or(0.0);
    values
        .iter()
        .all(|value| value.is_finite())
        .then(|| [at(0), at(1), at(2)])
}

/// The box around the data, and its position on the page.
struct Space {
    low: [f64; 3],
    high: [f64; 3],
    flat: bool,
    scale: f64,
    /// Projected center of the box.
    middle: [f64; 2],
}

impl Space {
    fn holding<'a>(points: impl Iterator<Item = &'a [f64; 3]>, dimensions: usize) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in points {
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let mut space = Self {
            low,
            high,
            flat: dimensions == 2,
            scale: 1.0,
            middle: [0.0, 0.0],
        };
        let corners: Vec<[f64; 2]> = (0..8).map(|i| space.project(space.corner(i))).collect();
        let range = |axis: usize| {
            let of = |pick: fn(f64, f64) -> f64| {
                corners.iter().map(|c| c[axis]).reduce(pick).unwrap_or(0.0)
            };
            (of(f64::min), of(f64::max))
        };
        let ((left, right), (down, up)) = (range(0), range(1));
        let room = [
            (PLOT - 70.0) / (right - left).max(1e-12),
            (HEIGHT - 70.0) / (up - down).max(1e-12),
        ];
        space.scale = room[0].min(room[1]);
        space.middle = [(left + right) / 2.0, (down + up) / 2.0];
        space
    }

    /// Corner 0 to 7 of the box; bit k set = the far end of axis k.
    fn corner(&self, index: usize) -> [f64; 3] {
        core::array::from_fn(|axis| {
            if index >> axis & 1 == 1 {
                self.high[axis]
            } else {
                self.low[axis]
            }
        })
    }

    /// Right and up, in units of the data.
    fn project(&self, [x, y, z]: [f64; 3]) -> [f64; 2] {
        if self.flat {
            return [x, y];
        }
        let ((sin, cos), (lift_sin, lift_cos)) = (libm::sincos(TURN), libm::sincos(LIFT));
        let (right, away) = (cos * x + sin * y, -sin * x + cos * y);
        [right, lift_sin * away + lift_cos * z]
    }

    fn at(&self, point: [f64; 3]) -> [f64; 2] {
        let [x, y] = self.project(point);
        let middle = [MARGIN + PLOT / 2.0, TOP + HEIGHT / 2.0];
        [
            middle[0] + (x - self.middle[0]) * self.scale,
            middle[1] - (y - self.middle[1]) * self.scale,
        ]
    }

    /// The box and the names of its axes with their ranges.
    fn axes(&self, svg: &mut Svg, names: &[String]) {
        let count = if self.flat { 2 } else { 3 };
        for from in 0..(1 << count) {
            for axis in (0..count).filter(|axis| from >> axis & 1 == 0) {
                let ends = [from, from | 1 << axis].map(|corner| self.at(self.corner(corner)));
                svg.line(ends[0], ends[1], &stroke(PALE, 1.0));
            }
        }
        // The edges nearest to the viewer carry the axes.
        let edges: [[usize; 2]; 3] = if self.flat {
            [[0, 1], [0, 2], [0, 0]]
        } else {
            [[0, 1], [1, 3], [0, 4]]
        };
        for (axis, edge) in edges.into_iter().enumerate().take(count) {
            let [a, b] = edge.map(|corner| self.at(self.corner(corner)));
            svg.line(a, b, &stroke(GRAY, 1.4));
            let name = names
                .get(axis)
                .cloned()
                .unwrap_or_else(|| format!("x{}", axis + 1));
            let range = format!(
                "{}: {} to {}",
                shortened(&name, 16),
                num(self.low[axis]),
                num(self.high[axis])
            );
            self.axis_name(
                svg,
                axis,
                [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0],
                &range,
            );
        }
    }

    fn axis_name(&self, svg: &mut Svg, axis: usize, [x, y]: [f64; 2], text: &str) {
        let font = Font::new(12.0);
        match (self.flat, axis) {
            (true, 0) => svg.text([x, y + 20.0], font.at(Anchor::Middle), text),
            (false, 0) => svg.text([x - 4.0, y + 22.0], font.at(Anchor::Middle), text),
            (false, 1) => svg.text([x + 10.0, y + 16.0], font, text),
            _ => svg.text_upwards([x - 12.0, y], font, text),
        }
    }
}

/// Circles for code vectors, lines between neighbors.
fn neurons(svg: &mut Svg, space: &Space, [columns, _]: [usize; 2], code: &[[f64; 3]]) {
    let columns = columns.max(1);
    for i in 0..code.len() {
        let right = Some(i + 1).filter(|j| j % columns != 0);
        for j in [right, Some(i + columns)]
            .into_iter()
            .flatten()
            .filter(|&j| j < code.len())
        {
            svg.line(space.at(code[i]), space.at(code[j]), &stroke(INK, 1.3));
        }
    }
    for &place in code {
        svg.circle(space.at(place), 6.0, &filled(ORANGE, INK, 1.2));
    }
}

fn legend(svg: &mut Svg, grid: [usize; 2]) {
    let mut legend = Legend::right_of(PLOT);
    legend.entry(svg, "sample", |svg, at| svg.circle(at, 2.5, &fill(BLUE)));
    legend.entry(svg, "code vector of a neuron", |svg, at| {
        svg.circle(at, 6.0, &filled(ORANGE, INK, 1.2))
    });
    let joined = if grid[0].min(grid[1]) <= 1 {
        "neighbors in the chain"
    } else {
        "neighbors in the grid"
    };
    legend.entry(svg, joined, |svg, [x, y]| {
        svg.line([x - 12.0, y], [x + 12.0, y], &stroke(INK, 1.3));
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{assert_well_formed, map};

    #[test]
    fn every_neuron_is_drawn_once_and_joined_to_its_neighbors() {
        let samples = map([10, 10], 3, 0.0).code;
        let picture = scatter(&map([4, 4], 3, 0.0), &samples, &[], "cube").unwrap();
        assert_well_formed(&picture);
        assert_eq!(picture.matches("r=\"6\"").count(), 16 + 1);
        assert_eq!(picture.matches("stroke-width=\"1.3\"").count(), 24 + 1);
        assert_eq!(picture.matches("r=\"1.7\"").count(), 100);
    }

    #[test]
    fn only_the_plane_and_space_can_be_drawn() {
        assert!(scatter(&map([4, 4], 4, 0.0), &[], &[], "").is_none());
        assert!(scatter(&map([1, 32], 2, 0.0), &[], &[], "").is_some());
        assert!(scatter(&map([1, 1], 3, 0.0), &[vec![f64::NAN; 3], vec![]], &[], "").is_some());
    }
}
