//! Draws the path of a robot through its world from above (Fig. 5 of the paper).

use arena::world::Point;
use sim::recording::{Recording, Step};

use crate::draw::color::{self, GRAY, INK, OBSTACLE, ORANGE, PURPLE, VERMILLION};
use crate::draw::layout::{Legend, MARGIN, PAGE, PLOT, TOP, counted, heading};
use crate::draw::marks::{self, contact_mark};
use crate::draw::scene::{self, SceneView};
use crate::draw::svg::{Anchor, Font, Svg, decimal, filled, num, stroke};

/// Distance between two drawn bodies, m.
const SPACING_M: f64 = 1.0;
/// Number of colors along the path.
const SHADES: usize = 48;

/// Draws a whole episode from above: obstacles, exploration, the path colored by time.
///
/// The body is drawn about every meter; also start S, end F, contacts, shield interventions, scale
/// bar and legend.
///
/// The world's x points right, its y up the page. Returns an SVG document.
#[must_use]
pub fn path(recording: &Recording) -> String {
    let view = SceneView::new(
        scene::extent(&recording.world),
        [MARGIN, TOP],
        [PLOT, 640.0],
    );
    let mut svg = Svg::new(PAGE, TOP + view.size[1] + 48.0);
    let title = format!(
        "Path of the robot: behavior “{}”, world “{}”",
        recording.behavior,
        recording.world.name()
    );
    let subtitle = subtitle(recording);
    heading(&mut svg, &title, &subtitle);
    draw_path(&mut svg, &view, recording);
    scene::scale_bar(
        &mut svg,
        [MARGIN + 2.0, TOP + view.size[1] + 24.0],
        view.scale,
        160.0,
    );
    legend(&mut svg, &view, recording);
    svg.finish(&title, &subtitle)
}

/// The world with the path and all marks.
pub(super) fn draw_path(svg: &mut Svg, view: &SceneView, recording: &Recording) {
    scene::obstacles(svg, view, &recording.world);
    exploration(svg, view, &recording.exploration);
    marks::leader(svg, view, recording);
    seeking(svg, view, recording);
    marks::goal_place(svg, view, recording);
    marks::parts(svg, view, recording);
}

fn subtitle(recording: &Recording) -> String {
    let steps = &recording.seeking;
    format!(
        "preset {} · seed {} · {} · {} m traveled · {}",
        recording.preset,
        recording.seed,
        counted(steps.len(), "decision"),
        decimal(scene::distance(steps), 1),
        counted(count(steps, |step| step.touched), "contact"),
    )
}

fn count(steps: &[Step], condition: impl Fn(&Step) -> bool) -> usize {
    steps.iter().filter(|&step| condition(step)).count()
}

fn exploration(svg: &mut Svg, view: &SceneView, steps: &[Step]) {
    let places: Vec<_> = scene::places(steps)
        .iter()
        .map(|&place| view.at(place))
        .collect();
    let style = stroke(PURPLE, 1.2);
    svg.polyline(&places, &format!(r#"{style} stroke-opacity="0.75""#));
    contacts(svg, view, steps, PURPLE);
}

fn seeking(svg: &mut Svg, view: &SceneView, recording: &Recording) {
    let places = scene::places(&recording.seeking);
    let last = places.len().saturating_sub(1);
    let shade = |i: usize| color::time(i as f64 / last.max(1) as f64);
    let radius = recording.robot_radius_m;
    for i in footprints(&places, radius) {
        let style = format!(r#"{} stroke-opacity="0.8""#, stroke(&shade(i), 1.2));
        svg.circle(view.at(places[i]), radius * view.scale, &style);
    }
    let part = last.div_ceil(SHADES).max(1);
    for start in (0..last).step_by(part) {
        let end = (start + part).min(last);
        let stretch: Vec<_> = places[start..=end]
            .iter()
            .map(|&place| view.at(place))
            .collect();
        let style = stroke(&shade((start + end) / 2), 1.8);
        svg.polyline(&stretch, &format!(r#"{style} stroke-linecap="round""#));
    }
    if let (Some(&start), Some(&end)) = (places.first(), places.last()) {
        ends(svg, view, [start, end], radius);
    }
    shielded(svg, view, &recording.seeking);
    contacts(svg, view, &recording.seeking, VERMILLION);
}

/// The positions of the drawn bodies: about every meter of path, if there is room.
fn footprints(places: &[Point], radius: f64) -> Vec<usize> {
    let ends = [places.first(), places.last()];
    let mut chosen: Vec<usize> = Vec::new();
    let mut since = 0.0;
    for (i, pair) in places.windows(2).enumerate() {
        since += pair[0].distance(pair[1]);
        let far = |other: &Point| other.distance(pair[1]) > 1.8 * radius;
        let clear =
            ends.iter().flatten().all(|&end| far(end)) && chosen.iter().all(|&k| far(&places[k]));
        if since >= SPACING_M && clear {
            chosen.push(i + 1);
            since = 0.0;
        }
    }
    chosen
}

/// Marks the ends of the motions that the shield shortened.
fn shielded(svg: &mut Svg, view: &SceneView, steps: &[Step]) {
    let ends = scene::places(steps).into_iter().skip(1);
    for (_, end) in steps
        .iter()
        .zip(ends)
        .filter(|(step, _)| step.shielded && !step.touched)
    {
        shield_mark(svg, view.at(end));
    }
}

/// Marks the ends of the motions with contact.
fn contacts(svg: &mut Svg, view: &SceneView, steps: &[Step], color: &str) {
    let ends = scene::places(steps).into_iter().skip(1);
    for (_, end) in steps.iter().zip(ends).filter(|(step, _)| step.touched) {
        contact_mark(svg, view.at(end), color);
    }
}

/// The mark of a shortened motion.
pub fn shield_mark(svg: &mut Svg, [x, y]: [f64; 2]) {
    let corners = [[x, y - 4.0], [x + 4.0, y], [x, y + 4.0], [x - 4.0, y]];
    svg.polygon(&corners, &filled(ORANGE, "#ffffff", 0.8));
}

/// Start and end: the body with a letter inside, or beside it if both are at one position.
fn ends(svg: &mut Svg, view: &SceneView, [start, end]: [Point; 2], radius: f64) {
    let apart = start.distance(end) > 1.5 * radius;
    let size = (radius * view.scale).max(4.0);
    for (place, letter, side, shade) in [(start, "S", -1.0, 0.0), (end, "F", 1.0, 1.0)] {
        let [x, y] = view.at(place);
        let style = filled("#ffffff", &color::time(shade), 2.4);
        svg.circle([x, y], size, &format!(r#"{style} fill-opacity="0.6""#));
        let aside = if apart && size > 8.0 {
            0.0
        } else {
            side * (size + 9.0)
        };
        scene::label(svg, [x + aside, y], 15.0, letter);
    }
}

fn legend(svg: &mut Svg, view: &SceneView, recording: &Recording) {
    let mut legend = Legend::right_of(PLOT.min(view.size[0]));
    let steps = &recording.seeking;
    let decisions = format!("{} (F)", steps.len());
    legend.ramp(
        svg,
        "Path, colored by decision",
        ["0 (S)", &decisions],
        color::time,
    );
    legend.skip(8.0);
    let body = format!(
        "the body (radius {}\u{a0}m), about every meter",
        num(recording.robot_radius_m)
    );
    legend.entry(svg, &body, |svg, at| {
        svg.circle(at, 8.0, &stroke(&color::time(0.5), 1.2))
    });
    legend.entry(svg, "start and end", |svg, [x, y]| {
        svg.circle([x, y], 8.0, &stroke(GRAY, 2.2));
        svg.text([x, y + 4.0], Font::new(11.0).at(Anchor::Middle).bold(), "S");
    });
    let stopped = format!(
        "shortened by the shield: {}",
        count(steps, |step| step.shielded)
    );
    legend.entry(svg, &stopped, shield_mark);
    let touched = format!("contacts: {}", count(steps, |step| step.touched));
    legend.entry(svg, &touched, |svg, at| contact_mark(svg, at, VERMILLION));
    marks::legend(&mut legend, svg, recording);
    scene::sources_legend(&mut legend, svg, recording.world.sources());
    surroundings(&mut legend, svg, recording);
}

/// Legend entries of exploration, obstacles and the situation.
fn surroundings(legend: &mut Legend, svg: &mut Svg, recording: &Recording) {
    let exploration = &recording.exploration;
    let (phase, step, when) = if recording.has_toured {
        ("tour", "step", "on the tour")
    } else {
        ("exploration", "random move", "while exploring")
    };
    let moves = format!("{phase}: {}", counted(exploration.len(), step));
    legend.entry(svg, &moves, |svg, [x, y]| {
        svg.line([x - 11.0, y], [x + 11.0, y], &stroke(PURPLE, 1.6));
    });
    let touched = count(exploration, |step| step.touched);
    let touched = format!("contacts {when}: {touched}");
    legend.entry(svg, &touched, |svg, at| contact_mark(svg, at, PURPLE));
    legend.entry(svg, "wall, obstacle", |svg, [x, y]| {
        svg.rect([x - 9.0, y - 6.0, 18.0, 12.0], &filled(OBSTACLE, INK, 1.3));
    });
    let near = if recording.near_m > 0.0 {
        format!("something at {}\u{a0}m or nearer", num(recording.near_m))
    } else {
        "something at the ring".to_owned()
    };
    let range = format!(
        "Situations run from 0 (nothing within {}\u{a0}m) to 1 ({near}).",
        num(recording.far_m)
    );
    legend.skip(4.0);
    legend.note(svg, &range);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{assert_well_formed, empty, recording};

    #[test]
    fn the_same_episode_gives_the_same_bytes() {
        assert_well_formed(&path(&recording()));
        assert_eq!(path(&recording()), path(&recording()));
        assert_well_formed(&path(&empty()));
    }

    #[test]
    fn every_contact_is_marked() {
        let mut recording = recording();
        let before = path(&recording).matches(VERMILLION).count();
        recording.seeking[3].touched = !recording.seeking[3].touched;
        assert_ne!(path(&recording).matches(VERMILLION).count(), before);
    }

    #[test]
    fn a_tour_is_no_random_moves() {
        let moves = recording();
        let tour = Recording {
            has_toured: true,
            ..moves.clone()
        };
        assert!(path(&moves).contains("random moves") && !path(&moves).contains("tour:"));
        assert!(path(&tour).contains("tour:") && !path(&tour).contains("random moves"));
    }

    #[test]
    fn bodies_are_about_a_meter_apart_and_do_not_pile_up() {
        let line: Vec<Point> = (0..100)
            .map(|i| Point::new(f64::from(i) * 0.1, 0.0))
            .collect();
        let there_and_back: Vec<Point> = line.iter().chain(line.iter().rev()).copied().collect();
        assert_eq!(footprints(&line, 0.23).len(), 9);
        assert!(footprints(&there_and_back, 0.23).len() < 20);
        assert!(footprints(&[], 0.23).is_empty());
    }
}
