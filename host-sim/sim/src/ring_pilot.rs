//! Turns a rule that decides once per ring into a [`Pilot`].
//!
//! It collects the echoes, integrates the odometry and applies the shield of `amp` as the
//! controller does: before a motion, with detours, and at every echo during it.

use crate::pilot::Pilot;
use amp::config::Config;
use amp::controller::{Decision, Event, Motion, Outputs, Progress, Tracked};
use amp::fixed::Mask;
use amp::scan::{Echo, Scan};
use amp::shield::{Allowed, Shield, ShieldConfig};
use amp::turret::RingController;
use amp::units::{Bearing, Displacement, Millis, Range};
use arena::world::{Point, Pose, wrap_angle};
use std::f64::consts::{PI, TAU};

/// Longest displacement of one decision, m.
pub const STEP_M: f64 = 0.25;

/// Input of a [`Policy`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Perception {
    /// Latest range of each transducer from its face; `None` = no echo.
    pub ranges: [Option<Range>; 16],
    /// Dead-reckoned pose of the ring since the start: position in m, heading in rad.
    pub pose: Pose,
    /// Turn of the ring since the last decision.
    pub turned: Bearing,
    /// Result of the last decision; `None` before the first.
    pub last: Option<MotionOutcome>,
}

/// A motion that has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionOutcome {
    /// Displacement that was commanded, m in the ring's frame at that decision: the policy's, or
    /// the shield's detour.
    pub wanted: Point,
    /// Displacement carried out, m in the same frame.
    pub moved: Point,
    /// The body touched something.
    pub touched: bool,
}

impl Perception {
    /// Range of a transducer, m from its face; infinite without an echo.
    #[must_use]
    pub fn range_m(&self, sensor: usize) -> f64 {
        let range = self.ranges.get(sensor).copied().flatten();
        range.map_or(f64::INFINITY, |range| f64::from(range.as_mm()) / 1e3)
    }
}

/// Unit vector along transducer `sensor`, in the ring's frame.
#[must_use]
pub fn axis(sensor: usize) -> Point {
    Point::unit(sensor as f64 * TAU / 16.0)
}

/// A rule that answers each complete ring with a displacement.
pub trait Policy {
    /// The next displacement, m in the ring's current frame, at most [`STEP_M`] long.
    fn decide(&mut self, perceived: &Perception) -> Point;

    /// As [`RingController::looks_for_position`].
    fn looks_for_position(&self) -> bool {
        false
    }

    /// Size of its memory in the simulator, bytes.
    fn bytes(&self) -> usize {
        size_of_val(self)
    }
}

/// A policy with a target direction.
pub trait Steerable: Policy {
    /// Sets the target direction, rad counter-clockwise in the frame of [`Perception::pose`];
    /// `None` = any free direction. With a held turret the frame is that of the ring.
    fn steer(&mut self, target: Option<f64>);
}

/// The current motion.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ActiveMotion {
    wanted: Point,
    /// `wanted`, rounded.
    commanded: Displacement,
    /// Executed so far, m in the frame of the decision.
    moved: Point,
    /// Remaining displacement.
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
    active: Option<ActiveMotion>,
    moving: bool,
    touched: bool,
    motion: u16,
    /// Consecutive decisions in which all directions were blocked.
    blocked: u8,
}

impl<P: Policy> RingPilot<P> {
    /// A pilot of a Nomad 200 that follows `policy`; without a shield if it is `None`.
    #[must_use]
    pub fn new(policy: P, shield: Option<ShieldConfig>) -> Self {
        Self {
            policy,
            config: Config {
                shield,
                ..Config::recommended()
            },
            scan: Scan::default(),
            shield: Shield::new(),
            pose: Pose::default(),
            active: None,
            moving: false,
            touched: false,
            motion: 0,
            blocked: 0,
        }
    }

    /// A pilot of another robot that follows `policy`: behind a virtual turret, without a shield.
    #[must_use]
    pub fn of_robot(policy: P, config: Config<16>) -> Self {
        Self {
            config: Config {
                shield: None,
                ..config
            },
            ..Self::new(policy, None)
        }
    }

    /// The policy.
    #[must_use]
    pub fn policy(&self) -> &P {
        &self.policy
    }

    /// The policy, mutable.
    pub fn policy_mut(&mut self) -> &mut P {
        &mut self.policy
    }

    /// The policy, without its pilot.
    pub fn into_policy(self) -> P {
        self.policy
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
            self.guard()
        } else if self.scan.is_complete(self.config.enabled) {
            self.decide(echo.at)
        } else {
            Outputs::NONE
        }
    }

    /// Shortens the current motion if the newest echo requires it.
    fn guard(&mut self) -> Outputs<16> {
        let Some(active) = &mut self.active else {
            return Outputs::NONE;
        };
        let remaining = active.remaining.now();
        let Some(allowed) = self.shield.shorten(&self.config, remaining) else {
            return Outputs::NONE;
        };
        // A base that has overrun its motion stops, as under the controller.
        let left = remaining.rotated(active.turned.direction());
        let left_mm = if left.opposes(active.commanded) {
            0
        } else {
            allowed.distance_mm
        };
        let shorter = remaining.with_length(left_mm);
        active.remaining = Tracked::new(shorter);
        active.speed_mm_s = allowed.speed_mm_s.min(active.speed_mm_s);
        Outputs {
            motion: Some(Motion {
                id: self.motion,
                displacement: shorter,
                speed_mm_s: active.speed_mm_s,
            }),
            ..Outputs::NONE
        }
    }

    /// The policy's input; ends the last motion.
    fn perception(&mut self) -> Perception {
        let ended = self.active.take();
        Perception {
            ranges: std::array::from_fn(|sensor| {
                let echo = self.scan.echoes()[sensor];
                echo.range.filter(|_| self.config.enabled.contains(sensor))
            }),
            pose: self.pose,
            turned: ended.map_or(Bearing::ZERO, |ended| ended.turned),
            last: ended.map(|ended| MotionOutcome {
                wanted: ended.wanted,
                moved: ended.moved,
                touched: self.touched,
            }),
        }
    }

    /// Decides: the ring is complete and the base stands.
    fn decide(&mut self, now: Millis) -> Outputs<16> {
        let perception = self.perception();
        let requested = self.policy.decide(&perception);
        let millimeters = |meters: f64| libm::round(meters * 1e3) as i32;
        let wanted = Displacement::saturating(millimeters(requested.x), millimeters(requested.y));
        let (path, limit) = self.allowed_path(wanted, now);
        let allowed = if limit.distance_mm >= path.length_mm() {
            path
        } else {
            path.with_length(limit.distance_mm)
        };
        self.count_blocked(path, allowed);
        let motion = self.begin(ActiveMotion {
            wanted: if path == wanted {
                requested
            } else {
                meters(path)
            },
            commanded: path,
            moved: Point::default(),
            remaining: Tracked::new(allowed),
            turned: Bearing::ZERO,
            speed_mm_s: limit.speed_mm_s,
        });
        Outputs {
            motion: Some(Motion {
                id: motion,
                displacement: allowed,
                speed_mm_s: limit.speed_mm_s,
            }),
            decision: Some(Decision {
                situation: self.config.encoding.situation(&self.scan),
                plan: None,
                wanted: path,
                allowed,
                at_goal: false,
            }),
            ..Outputs::NONE
        }
    }

    /// Counts a decision whose path is blocked; any motion restarts the count.
    fn count_blocked(&mut self, path: Displacement, allowed: Displacement) {
        if allowed != Displacement::ZERO {
            self.blocked = 0;
        } else if path != Displacement::ZERO {
            self.blocked = self.blocked.wrapping_add(1);
        }
    }

    /// Begins a motion; returns its number.
    fn begin(&mut self, active: ActiveMotion) -> u16 {
        self.motion = self.motion.wrapping_add(1);
        (self.moving, self.touched) = (true, false);
        self.scan.renew();
        self.active = Some(active);
        self.motion
    }

    /// The displacement that the shield tries instead of `wanted`, and how far it may go.
    fn allowed_path(&self, wanted: Displacement, now: Millis) -> (Displacement, Allowed) {
        let (config, shield) = (&self.config, &self.shield);
        let aside = shield.step_aside(config, Mask::ALL, wanted, now);
        aside.unwrap_or_else(|| shield.detour(config, Mask::ALL, wanted, now, self.blocked))
    }

    fn odometry(&mut self, motion: u16, moved: Displacement, turned: Bearing, progress: Progress) {
        self.shield.moved(moved, turned);
        let way = meters(moved);
        let place = self.pose.position + way.turned(Point::unit(self.pose.heading));
        self.pose = Pose::new(place, wrap_angle(self.pose.heading + radians(turned)));
        let Some(active) = &mut self.active else {
            return;
        };
        let since = Point::unit(radians(active.turned));
        active.moved = active.moved + way.turned(since);
        active.remaining.go(moved, turned);
        active.turned = active.turned.plus(turned);
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

impl<P: Policy> RingController<16> for RingPilot<P> {
    fn handle_ring(&mut self, _: &Config<16>, at: Millis, event: Event<16>) -> Outputs<16> {
        self.handle(at, event)
    }

    fn shield(&mut self) -> &mut Shield<16> {
        &mut self.shield
    }

    fn is_moving(&self) -> bool {
        self.moving
    }

    fn pursues_goal(&self) -> bool {
        true
    }

    fn awaits_ring(&self) -> bool {
        !self.moving
    }

    fn looks_for_position(&self) -> bool {
        self.policy.looks_for_position()
    }

    fn await_ring(&mut self, _: Millis) {
        self.scan.renew();
    }

    fn enabled(&self, _: &Config<16>) -> Mask {
        self.config.enabled
    }

    fn set_visible(&mut self, visible: Mask) {
        self.config.enabled = visible;
    }

    fn abandon_motion(&mut self, _: Millis) {
        (self.active, self.moving) = (None, false);
        self.scan.renew();
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
    use crate::behavior::Behavior;
    use crate::episode::{Body, Setup, drive_pilot, explore_and_learn};
    use crate::pilot::{LocalController, SimState};
    use amp::controller::{Command, StatePart};
    use amp::goal::{Goal, Side};
    use amp::som::Grid;
    use arena::loaders::rooms::small;
    use arena::robot::TurretMode;
    use arena::sonar::SonarModel;

    /// Asks for the displacement that it holds.
    struct FixedPolicy(Displacement);

    impl Policy for FixedPolicy {
        fn decide(&mut self, _: &Perception) -> Point {
            meters(self.0)
        }
    }

    /// Runs the controller and a ring pilot on the same events and compares their motions.
    struct SideBySide {
        controller: LocalController,
        other: RingPilot<FixedPolicy>,
        shortened: u32,
        /// Motions in another direction than the planned one.
        detours: u32,
    }

    impl Pilot for SideBySide {
        fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
            let outputs = self.controller.handle(at, event);
            if let Some(decision) = &outputs.decision {
                self.other.policy_mut().0 = decision.plan.expect("it seeks").action;
            }
            let twin = self.other.handle(at, event);
            let what = |motion: Option<Motion>| motion.map(|m| (m.displacement, m.speed_mm_s));
            assert_eq!(
                what(outputs.motion),
                what(twin.motion),
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

    /// Knowledge of a controller that has received no echo yet.
    fn learned(config: &Config<16>) -> SimState {
        let mut controller = LocalController::new(config.clone());
        let setup = Setup {
            config: config.clone(),
            preset: "default".to_owned(),
            behavior: Behavior::Avoid,
            explore_moves: 100,
            steps: 1,
            seed: 7,
            sonar: SonarModel::Ideal,
            faults: Vec::new(),
            goal: None,
            second_robot: false,
            turret: TurretMode::Held,
            robot: None,
            set_down: None,
            record: false,
        };
        explore_and_learn(&small(2), &setup, &mut controller).expect("it learns");
        // Copies the knowledge without the scan and the shield.
        let mut fresh = SimState::new(Grid::rectangle(4, 4));
        for part in [
            StatePart::Situations,
            StatePart::Changes,
            StatePart::Actions,
            StatePart::Memory,
        ] {
            let mut bytes = vec![0; controller.state().part_len(part)];
            controller.state().read_part(part, 0, &mut bytes);
            fresh.write_part(part, 0, &bytes).expect("its own part");
        }
        fresh
    }

    #[test]
    fn the_shield_is_the_minds_own_motion_by_motion() {
        let mut config = Config::recommended();
        // The ring pilot uses every transducer.
        config.fault_detection = false;
        let learned = learned(&config);
        for (sonar, turret) in [
            (SonarModel::Ideal, TurretMode::Held),
            (SonarModel::Harsh, TurretMode::Held),
            (SonarModel::Nomad, TurretMode::Follow),
        ] {
            let mut controller = LocalController::with_state(config.clone(), learned.clone());
            // So near to the wall that the shield acts often.
            let goal = Goal::wall(Side::Right, Range::from_mm(150), &config);
            let _ = controller.handle(Millis::from_ms(0), Event::Command(Command::Seek(goal)));
            let mut both = SideBySide {
                controller,
                other: RingPilot::new(FixedPolicy(Displacement::ZERO), config.shield),
                shortened: 0,
                detours: 0,
            };
            let world = small(3);
            let body = Body::new(&world, sonar, turret, 5);
            let metrics = drive_pilot(&world, &mut both, body, 200).expect("it drives");
            assert_eq!(metrics.steps, 200);
            assert!(metrics.shield_stops > 0, "{sonar:?}");
            // One detour is the step aside at the start.
            assert!(both.detours > 1, "{sonar:?}");
            if sonar != SonarModel::Ideal {
                assert!(both.shortened > 0, "{sonar:?}");
            }
        }
    }

    /// A pilot with nothing around it, and its first motion of 100 mm straight ahead.
    fn active(shield: Option<ShieldConfig>) -> (RingPilot<FixedPolicy>, Motion) {
        let mut pilot =
            RingPilot::new(FixedPolicy(Displacement::along(Bearing::ZERO, 100)), shield);
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
        let (mut pilot, motion) = active(config.shield);
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
        let (mut pilot, _) = active(None);
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
        // 50 mm along x; after a quarter turn 50 mm along what was y.
        let expected = Point::new(0.05, 0.05);
        assert!(pilot.pose().position.distance(expected) < 1e-12);
        assert!((pilot.pose().heading.abs() - PI).abs() < 1e-12);
        let moved = pilot.active.expect("a motion").moved;
        assert!(moved.distance(expected) < 1e-12);
    }
}
