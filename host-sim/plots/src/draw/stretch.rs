//! Selects the part of an episode that shows an avoidance best: approach and turn away.

use core::ops::Range;

use sim::recording::Step;

/// Score of a half turn.
const TURN: f64 = 1.0;
/// Score of straight progress, as opposed to moving to and fro.
const PROGRESS: f64 = 1.0;
/// Weight of a decision that perceives nothing.
const QUIET: f64 = 0.1;
/// Smallest value that counts as perceived.
const SEEN: f64 = 0.005;
/// Weight of the mean change of situation.
const CHANGE: f64 = 0.1;
/// Penalty of a contact: an avoidance must avoid.
const CONTACT: f64 = 20.0;

/// The `count` consecutive decisions with the best avoidance; all if there are fewer.
///
/// The first decision of the episode is left out where possible: its change of situation is
/// unknown.
pub fn best_avoidance(steps: &[Step], count: usize) -> Range<usize> {
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
    // Peak above both ends: moving to and fro before a wall does not count.
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

/// Urgency of a change: the largest wanted one, or, without a plan, the largest value perceived.
fn nearness(step: &Step) -> f64 {
    let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    match &step.plan {
        Some(plan) if plan.at_goal => 0.0,
        Some(plan) => largest(&plan.wanted_change),
        None => largest(&step.situation),
    }
}

/// Straight distance between both ends divided by the distance traveled; 0 for a robot at rest.
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

/// Difference of the directions of motion, 0 to 1 half turn; 0 for a robot at rest.
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
        let range = best_avoidance(&steps, 8);
        assert_eq!(range.len(), 8);
        assert!(range.start < 33 && range.end > 36, "{range:?}");
        // A long straight path through free space does not count.
        steps[50].pose.position.x += 3.0;
        assert_eq!(best_avoidance(&steps, 8), range);
        steps[34].touched = true;
        assert!(!best_avoidance(&steps, 8).contains(&34));
    }

    #[test]
    fn short_episodes_are_taken_whole() {
        let steps = recording().seeking;
        assert_eq!(best_avoidance(&steps[..3], 8), 0..3);
        assert_eq!(best_avoidance(&[], 8), 0..0);
        assert_eq!(best_avoidance(&steps[..9], 8), 1..9);
    }
}
