use super::*;
use crate::controller::Progress;
use std::vec::Vec;

/// A robot that goes round a square of half a metre, among 16 posts.
struct Walk {
    detector: Detector<16>,
    config: Config<16>,
    x_mm: i32,
    y_mm: i32,
    step: u32,
}

impl Walk {
    fn new() -> Self {
        let mut config = Config::recommended();
        config.fault_detection = true;
        Self {
            detector: Detector::new(),
            config,
            x_mm: 0,
            y_mm: 0,
            step: 0,
        }
    }

    /// What a transducer hears: its own post, 2 m from the middle.
    fn hears(&self, sensor: usize) -> Option<Range> {
        let (x, y) = self.config.robot.directions[sensor].times(2_000);
        let (dx, dy) = (i64::from(x - self.x_mm), i64::from(y - self.y_mm));
        let way = crate::fixed::isqrt((dx * dx + dy * dy).unsigned_abs());
        Some(Range::from_mm(way as u16 - 231))
    }

    /// Steps of 250 mm around a square, with a ring after each; what one transducer says is up to `wrong`.
    fn walk(
        &mut self,
        steps: u32,
        sensor: usize,
        wrong: impl Fn(u32, Option<Range>) -> Option<Range>,
    ) -> Vec<(u32, Verdict)> {
        let mut verdicts = Vec::new();
        for _ in 0..steps {
            let (dx, dy) = [(250, 0), (0, 250), (-250, 0), (0, -250)][(self.step / 2 % 4) as usize];
            self.step += 1;
            (self.x_mm, self.y_mm) = (self.x_mm + dx, self.y_mm + dy);
            let moved = Event::Odometry {
                motion: 1,
                moved: Displacement::saturating(dx, dy),
                turned: Bearing::ZERO,
                progress: Progress::Ended,
            };
            assert_eq!(self.detector.heed(&mut self.config, &moved), None);
            for index in 0..16 {
                let mut range = self.hears(index);
                if index == sensor {
                    range = wrong(self.step, range);
                }
                let echo = Event::Echo {
                    sensor: index as u8,
                    range,
                };
                let verdict = self.detector.heed(&mut self.config, &echo);
                verdicts.extend(verdict.map(|verdict| (self.step, verdict)));
            }
        }
        verdicts
    }
}

fn mm(mm: u16) -> Option<Range> {
    Some(Range::from_mm(mm))
}

/// The first verdict on transducer 3, which must be the first of all.
fn found(wrong: impl Fn(u32, Option<Range>) -> Option<Range>) -> Option<Fault> {
    let mut walk = Walk::new();
    let verdicts = walk.walk(400, 3, wrong);
    let (_, verdict) = *verdicts.first().expect("a verdict");
    assert_eq!(verdict.sensor, 3);
    assert!(!walk.config.believed.contains(3) && walk.config.believed.contains(4));
    verdict.fault
}

#[test]
fn every_kind_of_fault_is_found_and_named() {
    assert_eq!(found(|_, _| None), Some(Fault::Dead));
    assert_eq!(found(|_, _| mm(1_750)), Some(Fault::Stuck));
    let jump = |step: u32, _| mm((step.wrapping_mul(2_654_435_761) >> 20) as u16 + 200);
    assert_eq!(found(jump), Some(Fault::Jumping));
    // Right changes, half the range too near.
    let near = |_, range: Option<Range>| mm(range.map_or(0, Range::as_mm).saturating_sub(1_100));
    assert_eq!(found(near), Some(Fault::Short));
}

#[test]
fn a_ring_in_order_is_believed() {
    let mut walk = Walk::new();
    assert_eq!(walk.walk(2_000, 3, |_, range| range), []);
    assert_eq!(walk.config.believed, Mask::ALL);
}

#[test]
fn without_detection_and_without_moves_nothing_is_found() {
    let mut walk = Walk::new();
    walk.config.fault_detection = false;
    assert_eq!(walk.walk(400, 3, |_, _| mm(700)), []);
    let mut walk = Walk::new();
    for _ in 0..5_000 {
        let echo = Event::Echo {
            sensor: 3,
            range: None,
        };
        assert_eq!(walk.detector.heed(&mut walk.config, &echo), None);
    }
    assert_eq!(walk.detector.scores(3), Scores::default());
    let beyond = Event::Echo {
        sensor: 99,
        range: None,
    };
    assert_eq!(walk.detector.heed(&mut walk.config, &beyond), None);
}

#[test]
fn one_that_behaves_again_is_believed_again() {
    let mut walk = Walk::new();
    assert!(!walk.walk(300, 3, |_, _| mm(700)).is_empty());
    let back = walk.walk(1_500, 3, |_, range| range);
    let believed = Verdict {
        sensor: 3,
        fault: None,
    };
    assert!(
        matches!(back[..], [(_, verdict)] if verdict == believed),
        "{back:?}"
    );
    assert_eq!(walk.config.believed, Mask::ALL);
}

#[test]
fn somebody_elses_word_counts_more() {
    let mut walk = Walk::new();
    walk.config.believed = Mask::ALL.without(3);
    assert_eq!(walk.walk(400, 3, |_, _| mm(700)), [], "disbelieved already");
    assert!(!walk.config.believed.contains(3), "and not believed again");
    let mut walk = Walk::new();
    assert!(!walk.walk(300, 3, |_, _| mm(700)).is_empty());
    walk.config.believed = Mask::ALL;
    assert_eq!(walk.walk(2, 3, |_, _| mm(700)), [], "it starts anew");
    assert!(walk.config.believed.contains(3));
}

#[test]
fn no_more_than_a_quarter_of_the_ring_is_disbelieved() {
    let mut walk = Walk::new();
    // A multiplexer stuck at an address: all say the same, but for what moves them.
    for _ in 0..400 {
        let moved = Event::Odometry {
            motion: 1,
            moved: Displacement::saturating(
                if walk.step.is_multiple_of(2) {
                    250
                } else {
                    -250
                },
                250,
            ),
            turned: Bearing::ZERO,
            progress: Progress::Ended,
        };
        walk.step += 1;
        let _ = walk.detector.heed(&mut walk.config, &moved);
        for sensor in 0..16 {
            let echo = Event::Echo {
                sensor,
                range: mm(900),
            };
            let _ = walk.detector.heed(&mut walk.config, &echo);
        }
    }
    let off = (0..16).filter(|&sensor| !walk.config.believed.contains(sensor));
    assert_eq!(off.count(), 4);
}
