//! A robot as the controller is told of it: its body, and a configuration in its size.

use super::{AnyRobot, MAX_BEAMS, ToldRobot};
use amp::actuation::Actuation;
use amp::config::{Config, Exploration, Learning};
use amp::fixed::Mask;
use amp::points::{Beam, PointLimits, PointMemory};
use amp::robot::{RobotSpec, evenly_spaced};
use amp::scan::Encoding;
use amp::turret::{BodySpec, Guard, Mount};
use amp::units::{Bearing, Displacement, Range};
use arena::robot_model::SensorMount;
use arena::sonar::SonarModel;
use std::f64::consts::TAU;
use std::num::NonZeroU16;

/// A robot that turns does so once around where it knows nothing of its surroundings.
const FIRST_LOOKS: u8 = 12;
/// Distance from the body that a random move leaves while it finds its sensors, mm of the Nomad's.
const BABBLE_MARGIN_MM: u16 = 30;

impl AnyRobot {
    /// What the controller is told, beside its configuration.
    #[must_use]
    pub fn told(&self) -> ToldRobot {
        ToldRobot {
            body: self.body(),
            is_led: self.is_led,
        }
    }

    /// The body as the controller is told.
    #[must_use]
    pub fn body(&self) -> BodySpec<MAX_BEAMS> {
        let mut mounts = [Mount::default(); MAX_BEAMS];
        let mut enabled = Mask::NONE;
        for (index, (mount, sensor)) in mounts.iter_mut().zip(&self.model.sensors).enumerate() {
            *mount = mount_of(sensor);
            enabled = enabled.with(index);
        }
        let nomad = PointLimits::NOMAD;
        BodySpec {
            mounts,
            enabled,
            actuation: Actuation::EXACT,
            points: PointLimits {
                face_radius_mm: self.scaled_mm(nomad.face_radius_mm),
                keep_mm: self.scaled_way_mm(nomad.keep_mm),
                half_cone: bearing(self.half_cone_rad()),
                short_of_echo_mm: self.scaled_way_mm(nomad.short_of_echo_mm),
                nearer_mm: self.scaled_way_mm(nomad.nearer_mm),
                here_mm: self.scaled_way_mm(nomad.here_mm),
                near_mm: self.scaled_way_mm(nomad.near_mm),
                replan_within_mm: self.scaled_way_mm(nomad.replan_within_mm),
                replan_nearer_mm: self.scaled_way_mm(nomad.replan_nearer_mm),
            },
            silence_mm: self.silence_mm(),
            first_looks: if self.turns() { FIRST_LOOKS } else { 0 },
            most_unseen: if self.has_few_sensors() { 4 } else { u8::MAX },
            guard: self.guard.and_then(|share| self.guard(share)),
            babble_margin_mm: self.scaled_mm(BABBLE_MARGIN_MM),
            has_compass: !self.heading_drifts(),
        }
    }

    /// The ring of sectors that its controller reads off what its sensors heard in one place,
    /// turned by these angles, rad; and which of the sectors are known.
    pub(crate) fn ring_of(
        &self,
        rings: impl IntoIterator<Item = (f64, [Option<Range>; 16])>,
    ) -> ([Option<Range>; 16], Mask) {
        let limits = self.body().points;
        let silence = self.silence_mm().map(|mm| Range::from_mm(mm.get()));
        let mut points = PointMemory::<256>::new();
        for (turn_rad, ranges) in rings {
            let turned = bearing(turn_rad).minus(points.heading());
            points.moved(&limits, Displacement::ZERO, turned);
            for (mount, echo) in self.mounts().iter().zip(ranges) {
                let Mount { position, axis } = mount_of(mount);
                let Some(range) = echo.or(silence) else {
                    continue;
                };
                let beam = Beam {
                    mount: position,
                    axis,
                    range,
                    is_echo: echo.is_some(),
                };
                points.hear(&limits, &beam);
            }
        }
        points.ring(&limits)
    }

    /// A guard that keeps a distance of so many radii.
    fn guard(&self, share: f64) -> Option<Guard> {
        let margin_mm = (share * self.model.radius_m * 1e3).round() as u16;
        Some(Guard {
            margin_mm: NonZeroU16::new(margin_mm)?,
            least_range_mm: (self.sensing(SonarModel::Nomad).min_range_m * 1e3).ceil() as u16,
        })
    }

    /// What the controller is told of the body's radius.
    fn told_mm(&self, radius_mm: u16) -> u16 {
        (f64::from(radius_mm) * self.told_radius).round() as u16
    }

    /// The configuration for the ring of sectors that the controller sees: lengths scaled to the
    /// body, no shield, no fault detection.
    #[must_use]
    pub fn config(&self, config: Config<16>) -> Config<16> {
        let (limits, reach_mm) = (self.limits(), self.reach_mm());
        let (scaled, scaled_way) = (|mm| self.scaled_mm(mm), |mm| self.scaled_way_mm(mm));
        let half_turn_s = std::f64::consts::PI / self.model.max_turn_rad_s;
        Config {
            robot: RobotSpec {
                directions: evenly_spaced(),
                symmetric: true,
                face_radius_mm: scaled(config.robot.face_radius_mm),
                body_radius_mm: self.told_mm(scaled(config.robot.body_radius_mm)),
                step_mm: scaled_way(config.robot.step_mm).min(reach_mm / 4),
                speed_mm_s: (limits.speed_m_s * 1e3).round() as u16,
                ring_period_ms: (self.model.period_s * 1e3).round() as u16,
                steer_ms: ((half_turn_s + 2.0) * 1e3) as u16,
                // A point stands anywhere in its beam's cone, and a sector tells the nearest one.
                half_cone: config.robot.half_cone.plus(bearing(self.half_cone_rad())),
                ..config.robot
            },
            encoding: Encoding {
                near_mm: scaled_way(config.encoding.near_mm).min(reach_mm / 8),
                far_mm: scaled_way(config.encoding.far_mm).min(reach_mm),
            },
            exploration: Exploration {
                shortest_mm: scaled_way(config.exploration.shortest_mm).min(reach_mm / 8),
                ..config.exploration
            },
            learning: Learning {
                largest_change_mm: scaled_way(config.learning.largest_change_mm),
                // None, unless it was set: a wrong point is in the ring for more than one move.
                most_changed: match config.learning.most_changed {
                    u8::MAX => 0,
                    most => most,
                },
                ..config.learning
            },
            clearance_mm: scaled_way(config.clearance_mm).min(reach_mm / 2),
            shield: None,
            fault_detection: false,
            // Where silence means free space it is no failure.
            open_space: config.open_space || self.silence_mm().is_some(),
            ..config
        }
    }
}

/// A sensor's place and direction in the controller's units.
fn mount_of(sensor: &SensorMount) -> Mount {
    let mm = |m: f64| (m * 1e3).round() as i32;
    Mount {
        position: Displacement::saturating(mm(sensor.position.x), mm(sensor.position.y)),
        axis: bearing(sensor.bearing_rad),
    }
}

/// The nearest bearing to an angle in rad.
pub(super) fn bearing(angle: f64) -> Bearing {
    Bearing::from_turns((angle / TAU * 65_536.0).round() as i32 as u16)
}
