//! Finds the stretch of an episode that tells most: the robot meets an obstacle and turns away.

use core::ops::Range;

use sim::recording::Step;

/// What a meeting gains by a half turn.
const TURN: f64 = 1.0;
/// What a meeting gains by getting away instead of going to and fro.
const PROGRESS: f64 = 1.0;
/// What a decision that perceives nothing counts, against one that does.
const QUIET: f64 = 0.1;
/// From which value on a decision perceives something worth showing.
const SEEN: f64 = 0.005;
/// Weight of the mean change of situation, against a meeting.
const CHANGE: f64 = 0.1;
/// What a contact takes away: an avoidance should show avoiding.
const CONTACT: f64 = 20.0;

/// The `count` successive decisions that show most of an avoidance; all of them when there are fewer.
///
/// Each has a decision before it where possible, so that its change of situation is known.
pub fn telling(steps: &[Step], count: usize) -> Range<usize> {
    if steps.len() <= count {
        return 0..steps.len();
    }
    let mut best = (1..1 + count, f64::NEG_INFINITY);
    for start in 1..=steps.len() - count {
        let score = score(steps, start..start + count);
        if score > best.1 {
            best = (start..start + count, score);
        }
    }
    best.0
}

fn score(steps: &[Step], range: Range<usize>) -> f64 {
    let changes: f64 = range
        .clone()
        .map(|t| change(&steps[t - 1], &steps[t]))
        .sum();
    let steps = &steps[range];
    let nearness: Vec<f64> = steps.iter().map(nearness).collect();
    let peak = nearness.iter().copied().fold(0.0, f64::max);
    // The peak above both ends: going to and fro before a wall is no meeting.
    let met = peak - nearness[0].max(nearness[nearness.len() - 1]);
    let contacts = steps.iter().filter(|step| step.touched).count();
    let turned = turn(&steps[0], &steps[steps.len() - 1]);
    let seen = nearness.iter().filter(|&&value| value > SEEN).count() as f64 / steps.len() as f64;
    let meeting = met * (1.0 + TURN * turned + PROGRESS * progress(steps)) * (QUIET + seen);
    meeting + CHANGE * changes / steps.len() as f64 - CONTACT * contacts as f64
}

/// The sum of all differences between two situations.
fn change(before: &Step, after: &Step) -> f64 {
    difference(&before.situation, &after.situation)
        .iter()
        .map(|value| value.abs())
        .sum()
}

/// `after` − `before`, value by value.
pub fn difference(before: &[f64], after: &[f64]) -> Vec<f64> {
    after
        .iter()
        .zip(before)
        .map(|(after, before)| after - before)
        .collect()
}

/// How much the situation asks for a change: the largest one wanted, or, where nobody planned, the
/// largest value perceived.
fn nearness(step: &Step) -> f64 {
    let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    match &step.plan {
        Some(plan) if plan.at_goal => 0.0,
        Some(plan) => largest(&plan.wanted_change),
        None => largest(&step.situation),
    }
}

/// The straight way between both ends as part of the way traveled, 0 when the robot stood still.
fn progress(steps: &[Step]) -> f64 {
    let places: Vec<_> = steps.iter().map(|step| step.pose.position).collect();
    let traveled: f64 = places
        .windows(2)
        .map(|pair| pair[0].distance(pair[1]))
        .sum();
    let straight = places[0].distance(places[places.len() - 1]);
    if traveled > 0.0 {
        straight / traveled
    } else {
        0.0
    }
}

/// How much the direction of motion differs, 0 to 1 half turn; 0 when the robot stood still.
fn turn(first: &Step, last: &Step) -> f64 {
    let ([ax, ay], [bx, by]) = (first.executed_m, last.executed_m);
    let angle = libm::atan2(ax * by - ay * bx, ax * bx + ay * by);
    angle.abs() / core::f64::consts::PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::recording;

    #[test]
    fn the_meeting_with_an_obstacle_is_found() {
        let mut steps = recording().seeking;
        steps.truncate(60);
        for step in &mut steps {
            step.situation.fill(0.0);
            step.touched = false;
            step.plan = None;
        }
        for (t, value) in [(33, 0.4), (34, 0.9), (35, 0.5)] {
            steps[t].situation[0] = value;
        }
        let range = telling(&steps, 8);
        assert_eq!(range.len(), 8);
        assert!(range.start < 33 && range.end > 36, "{range:?}");
        // Long straight ways through the open do not count as a meeting.
        steps[50].pose.position.x += 3.0;
        assert_eq!(telling(&steps, 8), range);
        steps[34].touched = true;
        assert!(!telling(&steps, 8).contains(&34));
    }

    #[test]
    fn short_episodes_are_taken_whole() {
        let steps = recording().seeking;
        assert_eq!(telling(&steps[..3], 8), 0..3);
        assert_eq!(telling(&[], 8), 0..0);
        assert_eq!(telling(&steps[..9], 8), 1..9);
    }
}
