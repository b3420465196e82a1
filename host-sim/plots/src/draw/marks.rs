//! Marks of a behavior on a path: the leading robot, the sought place, the parts of a chain.

use arena::world::Point;
use sim::episode::NEST_RADIUS_M;
use sim::recording::Recording;

use super::color::{BLUE, INK, ORANGE};
use super::layout::Legend;
use super::scene::{self, SceneView};
use super::svg::{Anchor, Font, Svg, filled, num, stroke};

/// The path of the leading robot, and its last position.
pub fn leader(svg: &mut Svg, view: &SceneView, recording: &Recording) {
    let places: Vec<Point> = recording
        .seeking
        .iter()
        .filter_map(|step| step.leader)
        .collect();
    let on_page: Vec<_> = places.iter().map(|&place| view.at(place)).collect();
    if let Some(&end) = on_page.last() {
        svg.polyline(&on_page, &leader_style());
        let style = filled("#ffffff", BLUE, 2.4);
        let radius = (recording.robot_radius_m * view.scale).max(4.0);
        svg.circle(end, radius, &format!(r#"{style} fill-opacity="0.6""#));
        scene::label(svg, end, 15.0, "L");
    }
}

fn leader_style() -> String {
    format!(r#"{} stroke-dasharray="6 3""#, stroke(BLUE, 2.0))
}

/// The sought place, with the distance that counts as reached.
pub fn goal_place(svg: &mut Svg, view: &SceneView, recording: &Recording) {
    if let Some(place) = recording.goal_place {
        let [x, y] = view.at(place);
        let radius = (NEST_RADIUS_M * view.scale).max(5.0);
        svg.circle([x, y], radius, &goal_style());
        let aside = radius + 8.0;
        scene::label(svg, [x - aside * 0.8, y - aside * 0.8], 15.0, "N");
    }
}

fn goal_style() -> String {
    format!(r#"{} stroke-dasharray="4 2""#, stroke(ORANGE, 3.0))
}

/// The start of each part of a chain.
pub fn parts(svg: &mut Svg, view: &SceneView, recording: &Recording) {
    let mut last = 0;
    for step in &recording.seeking {
        if step.part != last {
            last = step.part;
            number(svg, view.at(step.pose.position), last + 1);
        }
    }
}

fn number(svg: &mut Svg, [x, y]: [f64; 2], number: usize) {
    svg.circle([x, y], 8.5, &filled("#ffffff", INK, 1.6));
    let font = Font::new(12.0).at(Anchor::Middle).bold();
    svg.text([x, y + 4.2], font, &number.to_string());
}

/// Legend entries for the marks that are present.
pub fn legend(legend: &mut Legend, svg: &mut Svg, recording: &Recording) {
    if recording.seeking.iter().any(|step| step.leader.is_some()) {
        legend.entry(svg, "the leading robot; L: its end", |svg, [x, y]| {
            svg.line([x - 11.0, y], [x + 11.0, y], &leader_style());
        });
    }
    if recording.goal_place.is_some() {
        let what = if recording.behavior.starts_with("seek") {
            "the sought place"
        } else {
            "the nest"
        };
        let text = format!("N: {what}, {}\u{a0}m around it", num(NEST_RADIUS_M));
        legend.entry(svg, &text, |svg, at| svg.circle(at, 8.0, &goal_style()));
    }
    let parts = &recording.parts;
    for (index, part) in parts.iter().enumerate().filter(|_| parts.len() > 1) {
        let from = if index == 0 { " (from S)" } else { " begins" };
        let text = format!("{part}{from}");
        legend.entry(svg, &text, |svg, at| number(svg, at, index + 1));
    }
}

/// A contact.
pub fn contact_mark(svg: &mut Svg, [x, y]: [f64; 2], color: &str) {
    for (color, width) in [("#ffffff", 5.0), (color, 2.6)] {
        let style = format!(r#"{} stroke-linecap="round""#, stroke(color, width));
        svg.line([x - 5.0, y - 5.0], [x + 5.0, y + 5.0], &style);
        svg.line([x - 5.0, y + 5.0], [x + 5.0, y - 5.0], &style);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{assert_well_formed, recording};
    use crate::path;

    #[test]
    fn leader_nest_and_parts_are_drawn_and_explained() {
        let mut recording = recording();
        // Of a file with a comma in its name: no chain.
        recording.behavior = "avoid by a,b.toml".into();
        let plain = path(&recording);
        assert!(!plain.contains("begins"));
        recording.parts = vec!["avoid".into(), "nest".into()];
        recording.goal_place = Some(Point::new(1.0, 1.0));
        for (i, step) in recording.seeking.iter_mut().enumerate() {
            step.leader = Some(step.pose.position + Point::new(1.0, 0.0));
            step.part = usize::from(i > 100);
        }
        let marked = path(&recording);
        assert_well_formed(&marked);
        for text in [">L<", ">N<", ">2<", "the nest", "avoid (from S)"] {
            assert!(marked.contains(text) && !plain.contains(text), "{text}");
        }
    }
}
