//! Draws the paths of several methods through several worlds side by side.

use crate::barn::RunEnd;
use arena::robot::COLLISION_RADIUS_M;
use arena::world::{Point, World};

use plots::draw::color::{self, GRAY, INK, VERMILLION};
use plots::draw::layout::{MARGIN, PAGE, TOP, heading, shortened};
use plots::draw::marks::contact_mark;
use plots::draw::scene::{self, SceneView};
use plots::draw::svg::{Anchor, Font, Svg, fill, filled, num, stroke};

/// Panels in a row.
const COLUMNS: usize = 4;
/// Height of the legend, px.
const KEY: f64 = 26.0;
/// Height of a panel's title, px.
const NAME: f64 = 26.0;

/// One world with the paths driven in it.
#[derive(Debug, Clone)]
pub struct RoutePanel {
    /// The world; its start and goal are marked.
    pub world: World,
    /// The shortest path; empty = there is none.
    pub shortest: Vec<Point>,
    /// Positions of the robot, by method.
    pub paths: Vec<Vec<Point>>,
    /// How the run ended, by method.
    pub marks: Vec<RunEnd>,
}

/// Draws the worlds as small multiples with one line per method: a dot marks its end, a cross a
/// contact.
///
/// Returns an SVG document.
#[must_use]
pub fn routes(title: &str, drivers: &[&str], panels: &[RoutePanel]) -> String {
    let columns = panels.len().clamp(1, COLUMNS);
    let side = (PAGE - 2.0 * MARGIN) / columns as f64;
    let room = [side - 14.0, 460.0];
    let heights: Vec<f64> = panels
        .chunks(columns)
        .map(|row| tallest(row, room))
        .collect();
    let height: f64 = heights.iter().map(|height| height + NAME).sum();
    let mut svg = Svg::new(PAGE, TOP + KEY + height + MARGIN);
    let subtitle = "Dashed: the shortest path · dot: the end of a run · cross: contact · circle: 1 m around the goal";
    heading(&mut svg, title, subtitle);
    key(&mut svg, drivers);
    let mut top = TOP + KEY;
    for (row, height) in panels.chunks(columns).zip(heights) {
        for (column, panel) in row.iter().enumerate() {
            draw(&mut svg, panel, [MARGIN + column as f64 * side, top], room);
        }
        top += height + NAME;
    }
    svg.finish(title, subtitle)
}

fn key(svg: &mut Svg, drivers: &[&str]) {
    let mut x = MARGIN;
    for (index, name) in drivers.iter().enumerate() {
        svg.line(
            [x, TOP + 4.0],
            [x + 22.0, TOP + 4.0],
            &stroke(color::class(index), 3.0),
        );
        svg.text([x + 28.0, TOP + 8.0], Font::new(12.0).color(INK), name);
        x += 28.0 + 7.0 * name.chars().count() as f64 + 22.0;
    }
}

/// Extent of a panel: the world, its start and its goal with the circle around it.
fn extent(panel: &RoutePanel) -> [Point; 2] {
    let [mut low, mut high] = scene::extent(&panel.world);
    let goal = panel.world.goal().into_iter();
    for (place, rim) in goal
        .map(|goal| (goal, 1.05))
        .chain([(panel.world.start().position, 0.3)])
    {
        low = Point::new(low.x.min(place.x - rim), low.y.min(place.y - rim));
        high = Point::new(high.x.max(place.x + rim), high.y.max(place.y + rim));
    }
    [low, high]
}

fn tallest(row: &[RoutePanel], room: [f64; 2]) -> f64 {
    let height = |panel: &RoutePanel| SceneView::new(extent(panel), [0.0; 2], room).size[1];
    row.iter().map(height).fold(0.0, f64::max)
}

fn draw(svg: &mut Svg, panel: &RoutePanel, corner: [f64; 2], room: [f64; 2]) {
    let view = SceneView::new(extent(panel), corner, room);
    scene::obstacles(svg, &view, &panel.world);
    if let Some(goal) = panel.world.goal() {
        svg.circle(view.at(goal), view.scale, &stroke(GRAY, 1.0));
        svg.circle(view.at(goal), 2.5, &fill(GRAY));
    }
    let on_page = |path: &[Point]| path.iter().map(|&place| view.at(place)).collect::<Vec<_>>();
    let dashed = format!(r#"{} stroke-dasharray="5 4""#, stroke(GRAY, 1.3));
    svg.polyline(&on_page(&panel.shortest), &dashed);
    for (index, path) in panel.paths.iter().enumerate() {
        svg.polyline(&on_page(path), &stroke(color::class(index), 1.9));
    }
    let ends = panel.paths.iter().zip(&panel.marks).enumerate();
    for (index, (path, mark)) in ends {
        let Some(&last) = path.last() else { continue };
        match mark {
            RunEnd::Touched => contact_mark(svg, view.at(last), VERMILLION),
            RunEnd::Reached | RunEnd::TimedOut => {
                svg.circle(
                    view.at(last),
                    3.6,
                    &filled(color::class(index), "#ffffff", 1.0),
                );
            }
        }
    }
    let start = view.at(panel.world.start().position);
    let body = format!(r#"{} fill-opacity="0.7""#, filled("#ffffff", INK, 1.4));
    svg.circle(start, COLLISION_RADIUS_M * view.scale, &body);
    let [left, top, width, height] = view.area();
    let name = shortened(panel.world.name(), (num(width).len().max(4) * 6).min(24));
    let font = Font::new(12.0).bold().at(Anchor::Middle);
    svg.text([left + width / 2.0, top + height + 16.0], font, &name);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pictures::assert_well_formed;

    #[test]
    fn every_driver_has_its_line_in_every_world() {
        let path = vec![Point::new(1.0, 1.0), Point::new(2.0, 1.5)];
        let panel = RoutePanel {
            world: World::random(1).with_goal(Point::new(7.0, 5.0)),
            shortest: path.clone(),
            paths: vec![path.clone(), path],
            marks: vec![RunEnd::Reached, RunEnd::Touched],
        };
        let picture = routes("ways", &["a", "<b>"], &vec![panel; 5]);
        assert_well_formed(&picture);
        assert!(picture.contains("&lt;b&gt;"));
        assert_eq!(picture.matches(r#"stroke-dasharray="5 4""#).count(), 5);
        assert_well_formed(&routes("none", &[], &[]));
    }
}
