//! Draws the world: meters to pixels, obstacles, scale bar, positions of an episode.

use arena::sources::{LAMP_M, Sources, hex};
use arena::world::{Point, Shape, World};
use sim::recording::Step;

use super::color::{GREEN, INK, OBSTACLE, ORANGE, YELLOW};
use super::layout::Legend;
use super::svg::{Anchor, Font, Svg, fill, filled, num, stroke};

/// The corners (lowest, highest) of the rectangle that holds the world, m.
pub fn extent(world: &World) -> [Point; 2] {
    world.bounds().into()
}

/// Maps a rectangle of the world to the page.
#[derive(Debug, Clone, Copy)]
pub struct SceneView {
    /// World point at the lower left corner of the drawing, m.
    low: Point,
    /// Page point of that corner, px.
    corner: [f64; 2],
    /// Pixels per meter.
    pub scale: f64,
    /// Width and height of the drawing, px.
    pub size: [f64; 2],
}

impl SceneView {
    /// The rectangle between two world corners, in a drawing at `[left, top]` of at most `room` px.
    pub fn new([low, high]: [Point; 2], [left, top]: [f64; 2], room: [f64; 2]) -> Self {
        let (width, height) = ((high.x - low.x).max(1e-3), (high.y - low.y).max(1e-3));
        let scale = (room[0] / width).min(room[1] / height);
        let size = [width * scale, height * scale];
        Self {
            low,
            corner: [left, top + size[1]],
            scale,
            size,
        }
    }

    /// The page point of a world point.
    pub fn at(&self, point: Point) -> [f64; 2] {
        let away = (point - self.low) * self.scale;
        [self.corner[0] + away.x, self.corner[1] - away.y]
    }

    /// The drawing on the page: `[left, top, width, height]`.
    pub fn area(&self) -> [f64; 4] {
        let [width, height] = self.size;
        [self.corner[0], self.corner[1] - height, width, height]
    }
}

/// Rings around a source, as shares of the distance over which it falls by half or to 1/e.
const RINGS: [f64; 3] = [0.25, 0.5, 1.0];

/// Colored floor, scents and lamps.
fn sources(svg: &mut Svg, view: &SceneView, sources: &Sources) {
    for patch in &sources.floor {
        let corners = Shape::box_corners(patch.center, patch.size, patch.angle);
        let style = format!(r#"{} fill-opacity="0.45""#, fill(&hex(patch.color)));
        svg.polygon(&corners.map(|corner| view.at(corner)), &style);
    }
    let scents = sources.scents.iter();
    let scents = scents.map(|scent| (scent.position, scent.reach_m, GREEN, GREEN));
    let lamps = sources.lights.iter();
    let lamps = lamps.map(|lamp| (lamp.position, LAMP_M, YELLOW, ORANGE));
    let area = view.area();
    for (position, reach_m, inside, rim) in scents.chain(lamps) {
        let at = view.at(position);
        svg.clipped(&format!("near-{:.0}-{:.0}", at[0], at[1]), area, |svg| {
            for share in RINGS {
                let style = format!(
                    r#"{} fill-opacity="0.12" stroke-opacity="0.5" stroke-dasharray="3 3""#,
                    filled(inside, rim, 1.0)
                );
                svg.circle(at, share * reach_m * view.scale, &style);
            }
        });
        source_mark(svg, at, inside);
    }
}

/// The mark of a scent or a lamp.
fn source_mark(svg: &mut Svg, at: [f64; 2], color: &str) {
    svg.circle(at, 5.0, &filled(color, INK, 1.3));
}

/// Legend entries of what else can be perceived.
pub fn sources_legend(legend: &mut Legend, svg: &mut Svg, sources: &Sources) {
    if !sources.scents.is_empty() {
        legend.entry(svg, "a source of a scent", |svg, at| {
            source_mark(svg, at, GREEN)
        });
    }
    if !sources.lights.is_empty() {
        legend.entry(svg, "a lamp", |svg, at| source_mark(svg, at, YELLOW));
    }
}

/// Draws walls as lines and bodies as filled outlines, above what else can be perceived.
pub fn obstacles(svg: &mut Svg, view: &SceneView, world: &World) {
    sources(svg, view, world.sources());
    let body = filled(OBSTACLE, INK, 1.3);
    let wall = format!(r#"{} stroke-linecap="round""#, stroke(INK, 2.4));
    let on_page = |points: &[Point]| {
        points
            .iter()
            .map(|&point| view.at(point))
            .collect::<Vec<_>>()
    };
    for shape in world.shapes() {
        match shape {
            Shape::Wall { points } => svg.polyline(&on_page(points), &wall),
            Shape::Box {
                center,
                size,
                angle,
            } => {
                svg.polygon(&on_page(&Shape::box_corners(*center, *size, *angle)), &body);
            }
            Shape::Circle { center, radius } => {
                svg.circle(view.at(*center), radius * view.scale, &body)
            }
            Shape::Outline { from, to } => svg.polyline(&on_page(&[*from, *to]), &stroke(INK, 1.5)),
        }
    }
}

/// A bar of a round number of meters, at most `room` px long, with its left end at (x, y).
pub fn scale_bar(svg: &mut Svg, [x, y]: [f64; 2], scale: f64, room: f64) {
    let fits = |&length: &f64| length * scale <= room;
    let meters = [50.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2]
        .into_iter()
        .find(fits)
        .unwrap_or(0.1);
    let end = x + meters * scale;
    svg.line([x, y], [end, y], &stroke(INK, 2.0));
    for tick in [x, end] {
        svg.line([tick, y - 4.0], [tick, y + 4.0], &stroke(INK, 1.5));
    }
    svg.text(
        [end + 8.0, y + 4.0],
        Font::new(12.0),
        &format!("{} m", num(meters)),
    );
}

/// A letter or number centered on a point, with a white rim.
pub fn label(svg: &mut Svg, [x, y]: [f64; 2], size: f64, text: &str) {
    let font = Font::new(size).at(Anchor::Middle);
    svg.text([x, y + size * 0.35], font.halo(), text);
    svg.text([x, y + size * 0.35], font.bold(), text);
}

/// The positions of an episode: one per decision, and the end of the last motion.
pub fn places(steps: &[Step]) -> Vec<Point> {
    let mut places: Vec<Point> = steps.iter().map(|step| step.pose.position).collect();
    places.extend(steps.last().map(end_of));
    places
}

/// End of a step's motion, as far as the step itself records it.
fn end_of(step: &Step) -> Point {
    let [x, y] = step.executed_m;
    step.pose.position + Point::new(x, y).turned(Point::unit(step.pose.heading))
}

/// The distance traveled, m.
pub fn distance(steps: &[Step]) -> f64 {
    steps
        .iter()
        .map(|step| libm::hypot(step.executed_m[0], step.executed_m[1]))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_keeps_proportions_and_turns_y_up() {
        let view = SceneView::new(
            [Point::new(-1.0, 2.0), Point::new(3.0, 4.0)],
            [10.0, 20.0],
            [400.0, 400.0],
        );
        assert_eq!(view.area(), [10.0, 20.0, 400.0, 200.0]);
        assert_eq!(view.at(Point::new(-1.0, 2.0)), [10.0, 220.0]);
        assert_eq!(view.at(Point::new(3.0, 4.0)), [410.0, 20.0]);
    }

    #[test]
    fn the_last_place_is_where_the_last_step_led() {
        let mut steps = crate::fixture::recording().seeking;
        steps.truncate(1);
        steps[0].pose = arena::world::Pose::new(Point::new(1.0, 1.0), core::f64::consts::FRAC_PI_2);
        steps[0].executed_m = [0.5, 0.0];
        let places = places(&steps);
        assert!(places[1].distance(Point::new(1.0, 1.5)) < 1e-12);
        assert!((distance(&steps) - 0.5).abs() < 1e-12);
    }
}
