//! Draws successive decisions of an avoidance (Fig. 4 of the paper).

use core::ops::Range;

use arena::world::Point;
use sim::recording::{Recording, Step};

use super::path::shield_mark;
use super::sequence_panels::{self as panels, AXES, Ends, HEIGHT, PITCH, Panel};
use crate::draw::color::{self, BLUE, GRAY, INK, PALE, VALUE, VERMILLION};
use crate::draw::layout::{Legend, MARGIN, PAGE, TOP, heading, shortened};
use crate::draw::marks::contact_mark;
use crate::draw::scene::{self, SceneView};
use crate::draw::stretch::{best_avoidance, difference};
use crate::draw::svg::{Font, Svg, decimal, fill, filled, stroke};

/// Number of drawn decisions.
const SHOWN: usize = 8;
/// Panels in a row.
const COLUMNS: usize = 4;
/// Side of the box with the world, px.
const BOX: f64 = 310.0;

/// Draws up to eight successive decisions in which the robot meets an obstacle and turns away.
///
/// Per decision: the situation, the measured change since the previous one and the change wanted
/// there. Below: the robot's numbered positions beside the obstacle (meters) and the plan at each.
///
/// Returns an SVG document.
#[must_use]
pub fn sequence(recording: &Recording) -> String {
    let steps = &recording.seeking;
    let shown = best_avoidance(steps, SHOWN);
    let rows = shown.len().div_ceil(COLUMNS).max(1) as f64;
    let below = TOP + rows * HEIGHT + 12.0;
    let mut svg = Svg::new(PAGE, below + BOX + 36.0);
    let title = format!(
        "Decision by decision: behavior “{}”, world “{}”",
        recording.behavior,
        recording.world.name()
    );
    let subtitle = subtitle(recording, &shown);
    heading(&mut svg, &title, &subtitle);
    charts(&mut svg, recording, &shown);
    if shown.is_empty() {
        svg.text(
            [MARGIN, TOP + 30.0],
            Font::new(14.0),
            "No decisions were recorded.",
        );
    } else {
        surroundings(&mut svg, [MARGIN, below], recording, &shown);
        explanation(&mut svg, [MARGIN + BOX + 24.0, below], recording, &shown);
    }
    svg.finish(&title, &subtitle)
}

/// The panels, four in a row.
fn charts(svg: &mut Svg, recording: &Recording, shown: &Range<usize>) {
    let decisions = shown.clone().enumerate();
    let all: Vec<Panel> = decisions
        .map(|(i, t)| panel(&recording.seeking, i, t))
        .collect();
    let ends = Ends::holding(&all);
    for (i, panel) in all.iter().enumerate() {
        let (column, row) = (i % COLUMNS, i / COLUMNS);
        let x = MARGIN / 2.0 + AXES + column as f64 * PITCH;
        let corner = [x, TOP - 8.0 + row as f64 * HEIGHT];
        panels::draw(svg, corner, panel, ends, &recording.bearings_rad);
        if column == 0 {
            panels::axes(svg, corner, ends);
        }
    }
}

fn subtitle(recording: &Recording, shown: &Range<usize>) -> String {
    format!(
        "preset {} · seed {} · decisions {} to {} of {}",
        recording.preset,
        recording.seed,
        shown.start + usize::from(!shown.is_empty()),
        shown.end,
        recording.seeking.len()
    )
}

/// The panel of decision `t` (from 0), the `i`-th shown.
fn panel(steps: &[Step], i: usize, t: usize) -> Panel {
    let before = t.checked_sub(1).map(|t| &steps[t]);
    let plan = before.and_then(|step| step.plan.as_ref());
    let wanted = match (before, plan) {
        (None, _) => Err("first decision"),
        (Some(_), None) => Err("no plan"),
        (Some(_), Some(plan)) if plan.at_goal => Err("goal held"),
        (Some(_), Some(plan)) => Ok(plan.wanted_change.clone()),
    };
    let situation = steps[t].situation.clone();
    let measured = before.map_or(Vec::new(), |step| difference(&step.situation, &situation));
    Panel {
        title: format!("{} · decision {}", i + 1, t + 1),
        situation,
        measured,
        wanted,
    }
}

/// The box with the obstacle and the numbered positions of the robot.
fn surroundings(svg: &mut Svg, [x, y]: [f64; 2], recording: &Recording, shown: &Range<usize>) {
    let places: Vec<Point> = recording.seeking[shown.clone()]
        .iter()
        .map(|s| s.pose.position)
        .collect();
    // Room for the body and the perceived surroundings, within limits.
    let margin = recording.robot_radius_m + recording.far_m.clamp(0.3, 1.5);
    let view = SceneView::new(around(&places, margin), [x, y], [BOX, BOX]);
    let shade = |i: usize| color::time(i as f64 / (places.len() - 1).max(1) as f64);
    svg.clipped("surroundings", view.area(), |svg| {
        scene::obstacles(svg, &view, &recording.world);
        for (i, &place) in places.iter().enumerate() {
            let style = format!(
                r#"{} fill-opacity="0.25""#,
                filled("#ffffff", &shade(i), 1.6)
            );
            svg.circle(
                view.at(place),
                recording.robot_radius_m * view.scale,
                &style,
            );
        }
        let line: Vec<_> = places.iter().map(|&place| view.at(place)).collect();
        svg.polyline(&line, &stroke(INK, 1.0));
    });
    let on_page: Vec<_> = places.iter().map(|&place| view.at(place)).collect();
    for ([x, y], text) in numbered(&on_page) {
        if text.len() > 1 {
            // A joined label covers the path, which would hide its commas.
            let width = 7.0 * text.len() as f64 + 4.0;
            svg.rect([x - width / 2.0, y - 8.0, width, 16.0], &fill("#ffffff"));
        }
        scene::label(svg, [x, y], 13.0, &text);
    }
    svg.rect(view.area(), &stroke(GRAY, 1.2));
    scene::scale_bar(svg, [x + 2.0, y + BOX + 16.0], view.scale, 120.0);
}

/// The corners of a square that leaves `margin` m around `places`.
fn around(places: &[Point], margin: f64) -> [Point; 2] {
    let fold = |f: fn(f64, f64) -> f64| {
        places
            .iter()
            .copied()
            .reduce(|a, b| Point::new(f(a.x, b.x), f(a.y, b.y)))
            .unwrap_or_default()
    };
    let (low, high) = (fold(f64::min), fold(f64::max));
    let half = 0.5 * (high.x - low.x).max(high.y - low.y) + margin;
    let middle = (low + high) * 0.5;
    let corner = Point::new(half, half);
    [middle - corner, middle + corner]
}

/// Position numbers; numbers too close to each other are joined into one label.
fn numbered(places: &[[f64; 2]]) -> Vec<([f64; 2], String)> {
    let mut labels: Vec<([f64; 2], String)> = Vec::new();
    for (i, &[x, y]) in places.iter().enumerate() {
        let near = |&&mut ([a, b], _): &&mut ([f64; 2], String)| {
            (a - x).abs() < 17.0 && (b - y).abs() < 14.0
        };
        match labels.iter_mut().find(near) {
            Some((_, text)) => text.push_str(&format!(",{}", i + 1)),
            None => labels.push(([x, y], (i + 1).to_string())),
        }
    }
    labels
}

/// The plan of each decision, and how to read the charts.
fn explanation(svg: &mut Svg, [x, y]: [f64; 2], recording: &Recording, shown: &Range<usize>) {
    let columns = [
        ("", 0.0),
        ("neuron", 22.0),
        ("goal", 118.0),
        ("action", 166.0),
        ("moved", 220.0),
        ("why", 294.0),
    ];
    for (name, offset) in columns {
        svg.text([x + offset, y + 11.0], Font::new(11.5).color(GRAY), name);
    }
    svg.rect([x, y + 17.0, PAGE - MARGIN - x, 1.0], &fill(PALE));
    for (i, step) in recording.seeking[shown.clone()].iter().enumerate() {
        let line = y + 33.0 + 17.0 * i as f64;
        svg.text([x, line], Font::new(12.0).bold(), &(i + 1).to_string());
        for (text, (_, offset)) in row(step).iter().zip(&columns[1..]) {
            svg.text([x + offset, line], Font::new(12.0), text);
        }
        let beside = [x + 274.0, line - 4.0];
        if step.touched {
            contact_mark(svg, beside, VERMILLION);
        } else if step.shielded {
            shield_mark(svg, beside);
        }
    }
    reading(svg, [x, y + 178.0]);
}

/// How to read the charts and the table.
fn reading(svg: &mut Svg, [x, y]: [f64; 2]) {
    let mut legend = Legend::new(x, y, PAGE - MARGIN - x);
    legend.entry(
        svg,
        "situation S(t): 1 = obstacle at the near limit, 0 = none",
        |svg, at| swatch(svg, at, VALUE),
    );
    legend.entry(
        svg,
        "difference: an obstacle comes nearer (up), goes away (down)",
        |svg, [x, y]| {
            swatch(svg, [x - 6.0, y], VERMILLION);
            swatch(svg, [x + 6.0, y], BLUE);
        },
    );
    legend.entry(
        svg,
        "the shield shortened the move; the robot touched something",
        |svg, [x, y]| {
            shield_mark(svg, [x - 10.0, y]);
            contact_mark(svg, [x + 6.0, y], VERMILLION);
        },
    );
    legend.note(
        svg,
        "measured: S(t) − S(t−1), the change of the last move. wanted: the change expected of that \
     move; with look-ahead the prediction of the action map, else the input of the map. Across: the \
     transducers, counted to the left from the front.",
    );
}

/// The cells of the table: neurons, goal, action, distance, reason.
fn row(step: &Step) -> [String; 5] {
    let distance_cm = 100.0 * libm::hypot(step.executed_m[0], step.executed_m[1]);
    let moved = format!("{} cm", decimal(distance_cm, 0));
    let Some(plan) = &step.plan else {
        return [
            "–".into(),
            "–".into(),
            "–".into(),
            moved,
            "exploring".into(),
        ];
    };
    let name = |neuron: usize| format!("N{}", neuron + 1);
    let from = name(plan.current_neuron);
    let neurons = if plan.at_goal || plan.subgoal_neuron == plan.current_neuron {
        from
    } else {
        format!("{from} to {}", name(plan.subgoal_neuron))
    };
    [
        neurons,
        name(plan.goal_neuron),
        name(plan.action_neuron),
        moved,
        shortened(&plan.reason, 22),
    ]
}

fn swatch(svg: &mut Svg, [x, y]: [f64; 2], color: &str) {
    svg.rect([x - 5.0, y - 7.0, 10.0, 14.0], &fill(color));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{assert_well_formed, empty, recording};

    #[test]
    fn the_same_episode_gives_the_same_bytes() {
        assert_well_formed(&sequence(&recording()));
        assert_eq!(sequence(&recording()), sequence(&recording()));
        assert_well_formed(&sequence(&empty()));
    }

    #[test]
    fn short_and_strange_episodes_do_not_stop_the_picture() {
        let mut recording = recording();
        recording.seeking.truncate(1);
        recording.seeking[0].plan = None;
        recording.seeking[0].situation = vec![f64::NAN; 3];
        assert_well_formed(&sequence(&recording));
    }

    #[test]
    fn wanted_and_measured_belong_to_the_same_move() {
        let steps = recording().seeking;
        let t = (1..steps.len())
            .find(|&t| steps[t - 1].plan.as_ref().is_some_and(|plan| !plan.at_goal))
            .unwrap();
        let panel = panel(&steps, 0, t);
        assert_eq!(
            panel.wanted.unwrap(),
            steps[t - 1].plan.as_ref().unwrap().wanted_change
        );
        assert_eq!(
            panel.measured[0],
            steps[t].situation[0] - steps[t - 1].situation[0]
        );
    }

    #[test]
    fn crowded_numbers_share_a_label() {
        let labels = numbered(&[[0.0, 0.0], [40.0, 0.0], [42.0, 3.0]]);
        assert_eq!(
            labels,
            [([0.0, 0.0], "1".into()), ([40.0, 0.0], "2,3".into())]
        );
    }
}
