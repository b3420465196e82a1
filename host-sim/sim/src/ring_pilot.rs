//! A rule that drives by whole rings, made a [`Pilot`]: the echoes gathered, the way reckoned, the shield of the `amp`
//! crate applied just as the mind's controller applies it: before a motion, with its detours, and at every echo on the way.

use crate::pilot::Pilot;
use amp::config::Config;
use amp::controller::{Decision, Event, Motion, Outputs, Progress, Tracked};
use amp::fixed::Mask;
use amp::scan::{Echo, Scan};
use amp::shield::{Allowed, Shield, Shielding};
use amp::units::{Bearing, Displacement, Millis, Range};
use arena::world::{Point, Pose, wrap_angle};
use std::f64::consts::{PI, TAU};

/// Longest displacement of one decision, m.
pub const STEP_M: f64 = 0.25;

/// What a [`Policy`] decides by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Perception {
    /// Latest range of each transducer from its face; `None` = nothing answered.
    pub ranges: [Option<Range>; 16],
    /// Dead-reckoned pose of the ring, counted from where the driver began: place in m, heading in rad.
    pub pose: Pose,
    /// How far the ring has turned since the last decision.
    pub turned: Bearing,
    /// What came of the last decision; `None` before the first.
    pub last: Option<MotionOutcome>,
}

/// A motion that has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionOutcome {
    /// Displacement that was tried, m in the ring's frame at that decision: what the policy asked for, or the detour that the
    /// shield made of it.
    pub wanted: Point,
    /// Displacement carried out, m in the same frame.
    pub moved: Point,
    /// The body touched something on the way.
    pub touched: bool,
}

impl Perception {
    /// Range of a transducer, m from its face; infinite where nothing answered.
    #[must_use]
    pub fn range_m(&self, sensor: usize) -> f64 {
        let range = self.ranges.get(sensor).copied().flatten();
        range.map_or(f64::INFINITY, |range| f64::from(range.as_mm()) / 1e3)
    }
}

/// Where transducer `sensor` looks, in the ring's frame.
#[must_use]
pub fn axis(sensor: usize) -> Point {
    Point::unit(sensor as f64 * TAU / 16.0)
}

/// A rule that answers each complete ring with a displacement.
pub trait Policy {
    /// The displacement to try next, m in the ring's present frame, at most [`STEP_M`] long.
    fn decide(&mut self, perceived: &Perception) -> Point;

    /// Bytes of what it remembers, as the simulator holds it.
    fn bytes(&self) -> usize {
        size_of_val(self)
    }
}

/// A policy that can be told where to go.
pub trait Steerable: Policy {
    /// From now on the robot is to go along `target`, rad counter-clockwise in the frame of [`Perception::pose`] (with a
    /// held turret: from where the ring looks); `None` = wherever the way is free.
    fn steer(&mut self, target: Option<f64>);
}

/// A motion under way.
#[derive(Debug, Clone, Copy, PartialEq)]
struct UnderWay {
    wanted: Point,
    /// The same, rounded.
    commanded: Displacement,
    /// Executed so far, m in the frame of the decision.
    moved: Point,
    /// Still to go.
    remaining: Tracked,
    turned: Bearing,
    speed_mm_s: u16,
}

/// A policy with a ring of 16 sonars.
#[derive(Debug, Clone)]
pub struct RingPilot<P> {
    policy: P,
    config: Config<16>,
    scan: Scan<16>,
    shield: Shield<16>,
    pose: Pose,
    under_way: Option<UnderWay>,
    moving: bool,
    touched: bool,
    motion: u16,
    /// Decisions in a row for which all ways were closed.
    closed: u8,
}

impl<P: Policy> RingPilot<P> {
    /// Lets `policy` drive a Nomad 200, with this shield or none.
    #[must_use]
    pub fn new(policy: P, shield: Option<Shielding>) -> Self {
        Self {
            policy,
            config: Config {
                shield,
                ..Config::recommended()
            },
            scan: Scan::default(),
            shield: Shield::new(),
            pose: Pose::default(),
            under_way: None,
            moving: false,
            touched: false,
            motion: 0,
            closed: 0,
        }
    }

    /// The rule.
    #[must_use]
    pub fn policy(&self) -> &P {
        &self.policy
    }

    /// The rule, to be told something.
    pub fn policy_mut(&mut self) -> &mut P {
        &mut self.policy
    }

    /// Dead-reckoned pose since the start.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.pose
    }

    fn echo(&mut self, sensor: usize, echo: Echo) -> Outputs<16> {
        self.scan.hear(sensor, echo);
        if self.config.shield.is_some() {
            self.shield.hear(&self.config, sensor, echo);
        }
        if self.moving {
            self.guard(sensor, echo.at)
        } else if self.scan.is_complete(Mask::ALL) {
            self.decide(echo.at)
        } else {
            Outputs::NONE
        }
    }

    /// Shortens the motion under way where the newest echo asks for it.
    fn guard(&mut self, sensor: usize, now: Millis) -> Outputs<16> {
        let Some(under_way) = &mut self.under_way else {
            return Outputs::NONE;
        };
        let remaining = under_way.remaining.now();
        let shorter = self
            .shield
            .shorten(&self.config, Mask::ALL, remaining, now, sensor);
        let Some(allowed) = shorter else {
            return Outputs::NONE;
        };
        // A base that has gone too far stands, as under the mind.
        let left = remaining.rotated(under_way.turned.direction());
        let left_mm = if left.opposes(under_way.commanded) {
            0
        } else {
            allowed.distance_mm
        };
        let shorter = remaining.with_length(left_mm);
        under_way.remaining = Tracked::new(shorter);
        under_way.speed_mm_s = allowed.speed_mm_s.min(under_way.speed_mm_s);
        Outputs {
            motion: Some(Motion {
                id: self.motion,
                displacement: shorter,
                speed_mm_s: under_way.speed_mm_s,
            }),
            ..Outputs::NONE
        }
    }

    /// A ring is complete and the base stands.
    fn decide(&mut self, now: Millis) -> Outputs<16> {
        let ended = self.under_way.take();
        let perceived = Perception {
            ranges: self.scan.echoes().map(|echo| echo.range),
            pose: self.pose,
            turned: ended.map_or(Bearing::ZERO, |ended| ended.turned),
            last: ended.map(|ended| MotionOutcome {
                wanted: ended.wanted,
                moved: ended.moved,
                touched: self.touched,
            }),
        };
        let asked = self.policy.decide(&perceived);
        let millimeters = |meters: f64| libm::round(meters * 1e3) as i32;
        let wanted = Displacement::saturating(millimeters(asked.x), millimeters(asked.y));
        let (way, limit) = self.way(wanted, now);
        let allowed = if limit.distance_mm >= way.length_mm() {
            way
        } else {
            way.with_length(limit.distance_mm)
        };
        if allowed != Displacement::ZERO {
            self.closed = 0;
        } else if way != Displacement::ZERO {
            self.closed = self.closed.wrapping_add(1);
        }
        self.motion = self.motion.wrapping_add(1);
        (self.moving, self.touched) = (true, false);
        self.scan.renew();
        self.under_way = Some(UnderWay {
            wanted: if way == wanted { asked } else { meters(way) },
            commanded: way,
            moved: Point::default(),
            remaining: Tracked::new(allowed),
            turned: Bearing::ZERO,
            speed_mm_s: limit.speed_mm_s,
        });
        Outputs {
            motion: Some(Motion {
                id: self.motion,
                displacement: allowed,
                speed_mm_s: limit.speed_mm_s,
            }),
            decision: Some(Decision {
                situation: self.config.encoding.situation(&self.scan),
                plan: None,
                wanted: way,
                allowed,
                at_goal: false,
            }),
            ..Outputs::NONE
        }
    }

    /// What is tried of a way, and how far.
    fn way(&self, wanted: Displacement, now: Millis) -> (Displacement, Allowed) {
        let (config, shield) = (&self.config, &self.shield);
        let aside = shield.step_aside(config, Mask::ALL, wanted, now);
        aside.unwrap_or_else(|| shield.detour(config, Mask::ALL, wanted, now, self.closed))
    }

    fn odometry(&mut self, motion: u16, moved: Displacement, turned: Bearing, progress: Progress) {
        if self.config.shield.is_some() {
            self.shield.moved(moved, turned);
        }
        let way = meters(moved);
        let place = self.pose.position + way.turned(Point::unit(self.pose.heading));
        self.pose = Pose::new(place, wrap_angle(self.pose.heading + radians(turned)));
        let Some(under_way) = &mut self.under_way else {
            return;
        };
        let since = Point::unit(radians(under_way.turned));
        under_way.moved = under_way.moved + way.turned(since);
        under_way.remaining.go(moved, turned);
        under_way.turned = under_way.turned.plus(turned);
        self.touched |= progress == Progress::Touched;
        let is_over = matches!(progress, Progress::Ended | Progress::Touched);
        if motion == self.motion && is_over && self.moving {
            self.moving = false;
            self.scan.renew();
        }
    }
}

impl<P: Policy> Pilot for RingPilot<P> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        match event {
            Event::Echo { sensor, range } => self.echo(usize::from(sensor), Echo { range, at }),
            Event::Odometry {
                motion,
                moved,
                turned,
                progress,
            } => {
                self.odometry(motion, moved, turned, progress);
                Outputs::NONE
            }
            Event::Command(_) | Event::Tick | Event::Alarm(_) | Event::Touched => Outputs::NONE,
        }
    }
}

fn meters(moved: Displacement) -> Point {
    Point::new(f64::from(moved.dx_mm) / 1e3, f64::from(moved.dy_mm) / 1e3)
}

/// A turn in rad, −π … π.
fn radians(turned: Bearing) -> f64 {
    f64::from(turned.as_signed_turns()) * PI / 32_768.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::episode::{Body, Setup, drive_pilot, explore_and_learn};
    use crate::pilot::{LocalController, SimState};
    use crate::behavior::Behavior;
    use amp::controller::{Command, Part};
    use amp::goal::{Goal, Side};
    use amp::som::Grid;
    use arena::robot::TurretMode;
    use arena::rooms::small;
    use arena::sonar::SonarModel;

    /// Whatever was asked of the mind is asked of the policy.
    struct Script(Displacement);

    impl Policy for Script {
        fn decide(&mut self, _: &Perception) -> Point {
            meters(self.0)
        }
    }

    /// Two drivers side by side: every motion of the one has to be one of the other.
    struct Both {
        mind: LocalController,
        other: RingPilot<Script>,
        shortened: u32,
        /// Motions in another direction than was asked for.
        detours: u32,
    }

    impl Pilot for Both {
        fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
            let outputs = self.mind.handle(at, event);
            if let Some(decision) = &outputs.decision {
                self.other.policy_mut().0 = decision.plan.expect("it seeks").action;
            }
            let twin = self.other.handle(at, event);
            let told = |motion: Option<Motion>| motion.map(|m| (m.displacement, m.speed_mm_s));
            assert_eq!(
                told(outputs.motion),
                told(twin.motion),
                "{at:?} {event:?} {:?}",
                outputs.stale_ms
            );
            self.detours += u32::from(outputs.decision.is_some_and(|decision| {
                decision
                    .plan
                    .is_some_and(|plan| plan.action != decision.wanted)
            }));
            self.shortened += u32::from(outputs.motion.is_some() && outputs.decision.is_none());
            outputs
        }
    }

    /// What a mind has learned that has heard nothing yet.
    fn learned(config: &Config<16>) -> SimState {
        let mut mind = LocalController::new(config.clone());
        let setup = Setup {
            config: config.clone(),
            preset: "default".to_owned(),
            behavior: Behavior::Avoid,
            explore_moves: 100,
            steps: 1,
            seed: 7,
            sonar: SonarModel::Ideal,
            faults: Vec::new(),
            turret: TurretMode::Held,
            set_down: None,
            record: false,
        };
        explore_and_learn(&small(2), &setup, &mut mind).expect("it learns");
        // Only what it has learned, not what it has heard.
        let mut fresh = SimState::new(Grid::rectangle(4, 4));
        for part in [Part::Situations, Part::Changes, Part::Actions, Part::Memory] {
            let mut bytes = vec![0; mind.state().part_len(part)];
            mind.state().read_part(part, 0, &mut bytes);
            fresh.write_part(part, 0, &bytes).expect("its own part");
        }
        fresh
    }

    #[test]
    fn the_shield_is_the_minds_own_motion_by_motion() {
        let mut config = Config::recommended();
        // The other driver uses every transducer.
        config.fault_detection = false;
        let learned = learned(&config);
        for (sonar, turret) in [
            (SonarModel::Ideal, TurretMode::Held),
            (SonarModel::Harsh, TurretMode::Held),
            (SonarModel::Nomad, TurretMode::Follow),
        ] {
            let mut mind = LocalController::with_state(config.clone(), learned.clone());
            // So near that the shield has much to do.
            let goal = Goal::wall(Side::Right, Range::from_mm(150), &config);
            let _ = mind.handle(Millis::from_ms(0), Event::Command(Command::Seek(goal)));
            let mut both = Both {
                mind,
                other: RingPilot::new(Script(Displacement::ZERO), config.shield),
                shortened: 0,
                detours: 0,
            };
            let world = small(3);
            let body = Body::new(&world, sonar, turret, 5);
            let tally = drive_pilot(&world, &mut both, body, 200).expect("it drives");
            assert_eq!(tally.steps, 200);
            assert!(tally.shield_stops > 0, "{sonar:?}");
            // One is the step aside at the start.
            assert!(both.detours > 1, "{sonar:?}");
            if sonar != SonarModel::Ideal {
                assert!(both.shortened > 0, "{sonar:?}");
            }
        }
    }

    /// A pilot with nothing around it and its first motion; it asks for 100 mm straight on.
    fn under_way(shield: Option<Shielding>) -> (RingPilot<Script>, Motion) {
        let mut pilot = RingPilot::new(Script(Displacement::along(Bearing::ZERO, 100)), shield);
        let motion = (0..16).find_map(|sensor| {
            let range = None;
            let echo = Event::Echo { sensor, range };
            pilot.handle(Millis::from_ms(0), echo).motion
        });
        (pilot, motion.expect("a motion after a whole ring"))
    }

    #[test]
    fn a_way_that_was_overrun_is_not_gone_back() {
        let config = Config::<16>::recommended();
        let (mut pilot, motion) = under_way(config.shield);
        let way = motion.displacement;
        let _ = pilot.handle(
            Millis::from_ms(300),
            Event::Odometry {
                motion: motion.id,
                moved: way.with_length(way.length_mm() + 60),
                turned: Bearing::ZERO,
                progress: Progress::Moving,
            },
        );
        let behind = (0..16).min_by_key(|&sensor: &usize| {
            let axis = config.robot.directions[sensor];
            axis.along(way.dx_mm.into(), way.dy_mm.into())
        });
        let echo = Event::Echo {
            sensor: behind.expect("16 of them") as u8,
            range: Some(Range::from_mm(160)),
        };
        let stand = pilot.handle(Millis::from_ms(320), echo).motion;
        let stand = stand.expect("an order to stand");
        assert_eq!(
            (stand.id, stand.displacement),
            (motion.id, Displacement::ZERO)
        );
    }

    #[test]
    fn the_way_is_reckoned_across_a_turn_of_the_ring() {
        let (mut pilot, _) = under_way(None);
        let quarter = Bearing::from_turns(16_384);
        let ahead = Displacement::along(Bearing::ZERO, 50);
        for progress in [Progress::Moving, Progress::Ended] {
            let odometry = Event::Odometry {
                motion: 1,
                moved: ahead,
                turned: quarter,
                progress,
            };
            let _ = pilot.handle(Millis::from_ms(0), odometry);
        }
        // 50 mm along x, then, a quarter turn later, 50 mm along what was y.
        let expected = Point::new(0.05, 0.05);
        assert!(pilot.pose().position.distance(expected) < 1e-12);
        assert!((pilot.pose().heading.abs() - PI).abs() < 1e-12);
        let moved = pilot.under_way.expect("a motion").moved;
        assert!(moved.distance(expected) < 1e-12);
    }
}
