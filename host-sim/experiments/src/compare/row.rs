//! One row of the comparison: its figures, and its differences from another row.

use super::drive::MethodOutcome;
use super::method::ComparedMethod;
use sim::statistics::{Mean, bootstrap, bootstrap_of};

/// One method with one number of learning moves, with or without the shield, over all worlds and
/// seeds.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonRow {
    /// The method.
    pub method: ComparedMethod,
    /// Learning moves.
    pub moves: u32,
    /// With the shield.
    pub shield: bool,
    /// By world and seed.
    pub outcomes: Vec<Vec<MethodOutcome>>,
}

/// Means over worlds and seeds with their 95 % intervals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodFigures {
    /// Contacts while learning.
    pub learning_contacts: Mean,
    /// Steps with contact per 100 m: sum of contacts over sum of distances.
    pub contacts_per_100_m: Mean,
    /// Steps with contact, %.
    pub contact_percent: Mean,
    /// Episodes without any contact, %.
    pub clean_percent: Mean,
    /// Distance traveled, m.
    pub distance_m: Mean,
    /// Area swept, m².
    pub coverage_m2: Mean,
    /// Smallest gap of an episode, m.
    pub clearance_m: Mean,
    /// Time from an obstacle nearer than 0.6 m until none is, s; an episode's end counts as one.
    /// `None` without such an obstacle.
    pub to_goal_s: Option<Mean>,
    /// Bytes of the learned state.
    pub bytes: f64,
    /// Wall time per decision, µs; 0 unless it was measured.
    pub decision_us: f64,
}

/// One row minus another, paired by world and seed: means with their 95 % intervals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Differences {
    /// Of contacts per 100 m.
    pub contacts_per_100_m: Mean,
    /// Of clean episodes, %.
    pub clean_percent: Mean,
    /// Of the distance traveled, m.
    pub distance_m: Mean,
    /// Of the area swept, m².
    pub coverage_m2: Mean,
}

/// 100 for an episode without contact, else 0.
fn clean(outcome: &MethodOutcome) -> f64 {
    if outcome.contacts == 0 { 100.0 } else { 0.0 }
}

fn contacts(outcome: &MethodOutcome) -> f64 {
    100.0 * f64::from(outcome.contacts)
}

/// A robot that never moves has a ratio of 0.
fn ratio(sum: f64, distance: f64) -> f64 {
    if distance > 0.0 { sum / distance } else { 0.0 }
}

impl ComparisonRow {
    fn columns<const N: usize>(
        &self,
        row: impl Fn(&MethodOutcome) -> [f64; N],
    ) -> Vec<Vec<[f64; N]>> {
        let of_world = |world: &Vec<MethodOutcome>| world.iter().map(&row).collect();
        self.outcomes.iter().map(of_world).collect()
    }

    fn mean(&self, value: impl Fn(&MethodOutcome) -> f64) -> Mean {
        let of_world = |world: &Vec<MethodOutcome>| world.iter().map(&value).collect();
        bootstrap(&self.outcomes.iter().map(of_world).collect::<Vec<_>>())
    }

    fn sum(&self, value: impl Fn(&MethodOutcome) -> f64) -> f64 {
        self.outcomes.iter().flatten().map(value).sum()
    }

    /// The figures of this row.
    #[must_use]
    pub fn figures(&self) -> MethodFigures {
        let distance = self.columns(|outcome| [contacts(outcome), outcome.distance_m]);
        let lost = self.columns(|outcome| {
            let observation = &outcome.observation;
            [
                observation.lost_ms as f64 / 1e3,
                f64::from(observation.losses),
            ]
        });
        let count = self.sum(|_| 1.0).max(1.0);
        let thought = self.sum(|outcome| outcome.observation.thought.as_secs_f64() * 1e6);
        let decisions = self.sum(|outcome| f64::from(outcome.observation.decisions));
        MethodFigures {
            learning_contacts: self.mean(|outcome| f64::from(outcome.learning_contacts)),
            contacts_per_100_m: bootstrap_of(&distance, |[sum, distance], _| ratio(sum, distance)),
            contact_percent: self.mean(|outcome| {
                contacts(outcome) / f64::from(outcome.observation.decisions.max(1))
            }),
            clean_percent: self.mean(clean),
            distance_m: self.mean(|outcome| outcome.distance_m),
            coverage_m2: self.mean(|outcome| outcome.coverage_m2),
            clearance_m: self.mean(|outcome| outcome.clearance_m),
            to_goal_s: (self.sum(|outcome| f64::from(outcome.observation.losses)) > 0.0)
                .then(|| bootstrap_of(&lost, |[time, losses], _| ratio(time, losses))),
            bytes: self.sum(|outcome| outcome.bytes as f64) / count,
            decision_us: thought / decisions.max(1.0),
        }
    }

    /// This row minus `other`.
    #[must_use]
    pub fn less(&self, other: &Self) -> Differences {
        let pairs: Vec<Vec<(MethodOutcome, MethodOutcome)>> = self
            .outcomes
            .iter()
            .zip(&other.outcomes)
            .map(|(a, b)| a.iter().copied().zip(b.iter().copied()).collect())
            .collect();
        let by_pair = |value: fn(&MethodOutcome) -> f64| {
            let of_world = |world: &Vec<(MethodOutcome, MethodOutcome)>| {
                world.iter().map(|(a, b)| value(a) - value(b)).collect()
            };
            bootstrap(&pairs.iter().map(of_world).collect::<Vec<_>>())
        };
        let distances = |world: &Vec<(MethodOutcome, MethodOutcome)>| {
            let row = |(a, b): &(MethodOutcome, MethodOutcome)| {
                [contacts(a), a.distance_m, contacts(b), b.distance_m]
            };
            world.iter().map(row).collect()
        };
        let distances: Vec<_> = pairs.iter().map(distances).collect();
        Differences {
            contacts_per_100_m: bootstrap_of(&distances, |[a, distance, b, other], _| {
                ratio(a, distance) - ratio(b, other)
            }),
            clean_percent: by_pair(clean),
            distance_m: by_pair(|outcome| outcome.distance_m),
            coverage_m2: by_pair(|outcome| outcome.coverage_m2),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::observer::DriverObservation;
    use super::*;

    fn row(contacts: u32, distance_m: f64) -> ComparisonRow {
        let outcome = MethodOutcome {
            learning_contacts: 2,
            contacts,
            distance_m,
            coverage_m2: 10.0,
            clearance_m: 0.1,
            bytes: 64,
            observation: DriverObservation {
                losses: 2,
                lost_ms: 3_000,
                ..DriverObservation::default()
            },
        };
        let clean = MethodOutcome {
            contacts: 0,
            observation: DriverObservation::default(),
            ..outcome
        };
        ComparisonRow {
            method: ComparedMethod::Random,
            moves: 0,
            shield: false,
            outcomes: vec![vec![outcome, clean]; 3],
        }
    }

    #[test]
    fn figures_by_hand() {
        let figures = row(3, 50.0).figures();
        // Three contacts on 100 m, half the episodes clean, two losses of 1.5 s.
        assert!((figures.contacts_per_100_m.mean - 3.0).abs() < 1e-9);
        assert_eq!(figures.clean_percent.mean, 50.0);
        assert_eq!(figures.to_goal_s.map(|mean| mean.mean), Some(1.5));
        assert_eq!((figures.learning_contacts.mean, figures.bytes), (2.0, 64.0));
    }

    #[test]
    fn differences_are_paired() {
        let less = row(3, 50.0).less(&row(1, 25.0));
        // 3 minus 2 contacts per 100 m; the distance of every pair differs by the same amount.
        assert!((less.contacts_per_100_m.mean - 1.0).abs() < 1e-9);
        assert_eq!(less.distance_m.interval, [25.0, 25.0]);
        assert_eq!(less.clean_percent.mean, 0.0);
    }
}
