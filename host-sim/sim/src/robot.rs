//! Robots other than the Nomad: a model, and what its sensors can tell.

use amp::controller::Command;
use amp::turret::BodySpec;
use arena::noise::Noise;
use arena::robot::{BaseLimits, COLLISION_RADIUS_M, TurretMode};
use arena::robot_model::{DriveKind, RobotModel, SensorKind, SensorMount};
use arena::sonar::{FACE_RADIUS_M, RING_PERIOD_S, SonarConfig, SonarModel};
use arena::world::Point;
use files::error::BadInput;
use std::num::NonZeroU16;

mod for_controller;
mod told;

use for_controller::bearing;
pub use told::{Miswiring, Origin, Ranges, ToldRobot};

/// Most sensors of a simulated robot.
pub const MAX_BEAMS: usize = 16;

/// A robot whose sensors stand anywhere on its body.
#[derive(Debug, Clone, PartialEq)]
pub struct AnyRobot {
    model: RobotModel,
    ranges: Ranges,
    /// Distance that the guard keeps to everything seen, as a share of the body's radius; `None` =
    /// no guard.
    guard: Option<f64>,
    /// Which sensor is wired to each input of the controller.
    wires: Vec<usize>,
    miswiring: Option<Miswiring>,
    geometry: Origin,
    actuators: Origin,
    /// Share of its radius that the controller is told.
    told_radius: f64,
    /// Its memory of places leads it to goals.
    is_led: bool,
    /// The turret of a synchro drive turns with the wheels.
    turret_follows: bool,
}

/// Distance that the guard keeps, as a share of the body's radius: 70 mm for the Nomad.
const GUARD: f64 = 0.07 / COLLISION_RADIUS_M;
/// Fewest random moves of a robot that learns where its sensors look.
pub const LEAST_MOVES: u16 = 20;
/// Share of the random moves that teach nothing else than where the sensors look, %.
const CALIBRATION_PERCENT: u32 = 20;
/// Those are at least so many.
const LEAST_CALIBRATION_MOVES: u16 = 12;
/// A robot with at most so many sensors turns on the spot to look around.
const FEW_SENSORS: usize = 4;
/// A holonomic base moves any way at once: its wheels turn this fast, rad/s.
const AT_ONCE_RAD_S: f64 = 1e3;
/// Turns of a differential drive with the Nomad's body, rad/s.
const NOMAD_TURN_RAD_S: f64 = std::f64::consts::FRAC_PI_4;

impl AnyRobot {
    /// A robot of this model, with a guard or without.
    ///
    /// # Errors
    /// When it has more than [`MAX_BEAMS`] sensors.
    pub fn new(model: RobotModel, ranges: Ranges, has_guard: bool) -> Result<Self, BadInput> {
        let count = model.sensors.len();
        if count > MAX_BEAMS {
            return Err(BadInput::new(format!(
                "robot \"{}\": {count} sensors; at most {MAX_BEAMS} can be simulated",
                model.name
            )));
        }
        let model = match ranges {
            Ranges::Own => model,
            Ranges::Nomad => on_nomad(model),
        };
        let robot = Self {
            model,
            ranges,
            guard: None,
            wires: (0..count).collect(),
            miswiring: None,
            geometry: Origin::Known,
            actuators: Origin::Known,
            told_radius: 1.0,
            is_led: true,
            turret_follows: false,
        };
        Ok(robot.with_guard(has_guard))
    }

    /// The same robot, with a guard or without.
    #[must_use]
    pub fn with_guard(mut self, has_guard: bool) -> Self {
        self.guard = has_guard.then_some(GUARD);
        self
    }

    /// The same robot with a guard that keeps this distance to everything seen, m.
    #[must_use]
    pub fn with_margin(mut self, margin_m: f64) -> Self {
        self.guard = Some(margin_m / self.model.radius_m);
        self
    }

    /// The same robot, whose controller is told this share of its radius.
    #[must_use]
    pub fn with_told_radius(mut self, share: f64) -> Self {
        self.told_radius = share;
        self
    }

    /// The same robot, led to its goals by its memory of places or finding its way by the goal
    /// alone.
    #[must_use]
    pub fn led(mut self, is_led: bool) -> Self {
        self.is_led = is_led;
        self
    }

    /// Whether its memory of places leads it to goals.
    #[must_use]
    pub fn is_led(&self) -> bool {
        self.is_led
    }

    /// Whether its heading drifts and its odometry does not measure it.
    #[must_use]
    pub fn heading_drifts(&self) -> bool {
        self.model.heading_drift > 0.0
    }

    /// The same robot with a turret that keeps its bearing or turns with the wheels.
    ///
    /// # Errors
    /// A drive without a turret: the sensors turn with the body.
    pub fn with_turret(mut self, turret: TurretMode) -> Result<Self, BadInput> {
        if self.model.drive != DriveKind::Synchro {
            return Err(BadInput::new(format!(
                "--turret: the robot \"{}\" has no turret",
                self.model.name
            )));
        }
        self.turret_follows = turret == TurretMode::Follow;
        Ok(self)
    }

    /// The same robot with the wires of its sensors permuted; the controller is not told.
    #[must_use]
    pub fn scrambled(mut self, seed: u64) -> Self {
        let mut noise = Noise::new(seed);
        for last in (1..self.wires.len()).rev() {
            self.wires.swap(last, noise.index(last + 1));
        }
        self
    }

    /// The same robot, told where its sensors look or not.
    ///
    /// # Errors
    /// A geometry to be learned by a robot that does not turn: sensors are told apart by turning.
    pub fn with_geometry(mut self, geometry: Origin) -> Result<Self, BadInput> {
        if geometry == Origin::Learned && !self.turns() {
            return Err(BadInput::new(format!(
                "robot \"{}\": its sensors do not turn; learning where they look needs that",
                self.model.name
            )));
        }
        self.geometry = geometry;
        Ok(self)
    }

    /// The same robot with a base whose commands and odometry do not mean what they say; the
    /// controller is not told.
    #[must_use]
    pub fn miswired(mut self, miswiring: Miswiring) -> Self {
        self.miswiring = Some(miswiring);
        self
    }

    /// What is wrong with its base, if anything is.
    #[must_use]
    pub fn miswiring(&self) -> Option<Miswiring> {
        self.miswiring
    }

    /// The same robot, told what its commands do or not.
    ///
    /// # Errors
    /// Actuators to be learned with a geometry that is known: what is left and what is right, and
    /// which way is ahead, is learned of both together.
    pub fn with_actuators(mut self, actuators: Origin) -> Result<Self, BadInput> {
        if actuators == Origin::Learned && self.geometry == Origin::Known {
            return Err(BadInput::new(
                "--actuators learned: only with --geometry learned",
            ));
        }
        self.actuators = actuators;
        Ok(self)
    }

    /// Whether the controller is told where its sensors look.
    #[must_use]
    pub fn geometry(&self) -> Origin {
        self.geometry
    }

    /// Checks that so many random moves are enough to learn where the sensors look.
    ///
    /// # Errors
    /// Fewer than [`LEAST_MOVES`] for a geometry to be learned.
    pub fn check_moves(&self, moves: u16) -> Result<(), BadInput> {
        if self.geometry == Origin::Learned && moves < LEAST_MOVES {
            return Err(BadInput::new(format!(
                "--geometry learned: at least {LEAST_MOVES} random moves (--explore), not {moves}"
            )));
        }
        Ok(())
    }

    /// Of so many random moves those that teach where the sensors look; the others teach the maps.
    #[must_use]
    pub fn calibration_moves(&self, moves: u16) -> u16 {
        match self.geometry {
            Origin::Known => 0,
            Origin::Learned => {
                let share = (u32::from(moves) * CALIBRATION_PERCENT / 100) as u16;
                share.max(LEAST_CALIBRATION_MOVES)
            }
        }
    }

    /// The command that has the controller find what it is not told; `None` if it is told all.
    #[must_use]
    pub fn calibration(&self, moves: u16, seed: u64) -> Option<Command<16>> {
        (self.geometry == Origin::Learned).then(|| Command::Calibrate {
            moves: self.calibration_moves(moves),
            seed,
            actuators: self.actuators == Origin::Learned,
        })
    }

    /// Median and greatest error of learned bearings, degrees; `None` if none was learned.
    #[must_use]
    pub fn bearing_errors_deg(&self, body: &BodySpec<MAX_BEAMS>) -> Option<[f64; 2]> {
        let exact = self.mounts().into_iter().enumerate();
        let mut errors: Vec<f64> = exact
            .filter(|(sensor, _)| body.enabled.contains(*sensor))
            .map(|(sensor, exact)| {
                let side = self.miswiring.map_or(1.0, |wrong| wrong.side());
                let exact = bearing(exact.bearing_rad * side);
                let error = body.mounts[sensor].axis.minus(exact);
                f64::from(error.as_signed_turns()).abs() * 360.0 / 65_536.0
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        Some([*errors.get(errors.len() / 2)?, *errors.last()?])
    }

    /// Its name; of a layout on the Nomad's body, `p3dx on nomad200`.
    #[must_use]
    pub fn label(&self) -> String {
        let name = &self.model.name;
        match self.ranges {
            Ranges::Own => name.clone(),
            Ranges::Nomad => format!("{name} on nomad200"),
        }
    }

    /// The robot; with [`Ranges::Nomad`] on the Nomad's body.
    #[must_use]
    pub fn model(&self) -> &RobotModel {
        &self.model
    }

    /// The sensor at each input of the controller.
    #[must_use]
    pub fn mounts(&self) -> Vec<SensorMount> {
        let sensors = self.wires.iter().map(|wire| self.model.sensors[*wire]);
        sensors.collect()
    }

    /// Whether its sensors look to few sides, so that it has to look around.
    fn has_few_sensors(&self) -> bool {
        self.model.sensors.len() <= FEW_SENSORS
    }

    /// Whether the body turns to where it goes. A holonomic body need not, but can: with few
    /// sensors it looks around that way.
    #[must_use]
    pub fn turns(&self) -> bool {
        match self.model.drive {
            DriveKind::Synchro => self.turret_follows,
            DriveKind::Differential => true,
            DriveKind::Holonomic => self.has_few_sensors(),
        }
    }

    /// What the sensors do while the base turns its wheels.
    #[must_use]
    pub fn turret(&self) -> TurretMode {
        if self.turns() {
            TurretMode::Follow
        } else {
            TurretMode::Held
        }
    }

    /// Size relative to the Nomad.
    fn scale(&self) -> f64 {
        self.model.radius_m / COLLISION_RADIUS_M
    }

    /// A length of the Nomad's body, mm, scaled to this body.
    fn scaled_mm(&self, nomad_mm: u16) -> u16 {
        (f64::from(nomad_mm) * self.scale()).round() as u16
    }

    /// A length of the Nomad's ways, mm: scaled to this body, or to what its sensors see if that is
    /// more.
    fn scaled_way_mm(&self, nomad_mm: u16) -> u16 {
        let sight = f64::from(self.reach_mm()) / 1e3 / SonarConfig::nomad().max_range_m;
        (f64::from(nomad_mm) * self.scale().max(sight.min(1.0))).round() as u16
    }

    /// Size and limits of the base.
    #[must_use]
    pub fn limits(&self) -> BaseLimits {
        let nomad = BaseLimits::default();
        let turn_rate_rad_s = match self.model.drive {
            DriveKind::Holonomic if !self.turns() => AT_ONCE_RAD_S,
            _ => self.model.max_turn_rad_s,
        };
        BaseLimits {
            radius_m: self.model.radius_m,
            speed_m_s: self.model.max_speed_m_s.min(nomad.speed_m_s),
            turn_rate_rad_s,
            turn_acceleration_rad_s2: 2.0 * turn_rate_rad_s,
            slip: self.model.wheel_slip,
            ..nomad
        }
    }

    /// Parameters of its sensors.
    #[must_use]
    pub fn sensing(&self, sonar: SonarModel) -> SonarConfig {
        let config = sonar.config();
        match self.ranges {
            Ranges::Nomad => config,
            Ranges::Own => SonarConfig {
                half_angle_rad: self.model.half_cone_rad,
                max_range_m: self.model.range_m[1],
                min_range_m: self.model.range_m[0],
                ..config
            },
        }
    }

    /// Half the opening of a sensor's cone, rad.
    fn half_cone_rad(&self) -> f64 {
        self.sensing(SonarModel::Ideal).half_angle_rad
    }

    /// How far a sensor sees free space when nothing answers: not at all for sonars.
    fn silence_mm(&self) -> Option<NonZeroU16> {
        let sensors = &self.model.sensors;
        let is_certain = sensors.iter().all(|s| s.kind != SensorKind::Sonar);
        NonZeroU16::new(self.reach_mm()).filter(|_| is_certain)
    }

    /// Greatest range of its sensors, mm.
    fn reach_mm(&self) -> u16 {
        match self.ranges {
            Ranges::Own => (self.model.range_m[1] * 1e3).round() as u16,
            Ranges::Nomad => u16::MAX,
        }
    }
}

/// A model's layout and drive on the Nomad's body.
fn on_nomad(model: RobotModel) -> RobotModel {
    let nomad = BaseLimits::default();
    let sensors = model.sensors.into_iter().map(|sensor| SensorMount {
        bearing_rad: sensor.bearing_rad,
        position: Point::unit(sensor.bearing_rad) * FACE_RADIUS_M,
        kind: SensorKind::Sonar,
    });
    RobotModel {
        radius_m: COLLISION_RADIUS_M,
        max_speed_m_s: nomad.speed_m_s,
        max_turn_rad_s: NOMAD_TURN_RAD_S,
        period_s: RING_PERIOD_S,
        wheel_slip: nomad.slip,
        heading_drift: 0.0,
        sensors: sensors.collect(),
        ..model
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::config::Config;
    use amp::turret::Guard;
    use amp::units::Bearing;

    fn robot(name: &str, ranges: Ranges) -> AnyRobot {
        AnyRobot::new(RobotModel::builtin(name).unwrap(), ranges, true).unwrap()
    }

    #[test]
    fn a_turret_is_held_or_follows_the_wheels_of_a_synchro_drive() {
        let nomad = robot("nomad200", Ranges::Own);
        assert_eq!(nomad.turret(), TurretMode::Held);
        let following = nomad.with_turret(TurretMode::Follow).unwrap();
        assert_eq!(following.turret(), TurretMode::Follow);
        let held = following.with_turret(TurretMode::Held).unwrap();
        assert_eq!(held.turret(), TurretMode::Held);
        let p3dx = robot("p3dx", Ranges::Own).with_turret(TurretMode::Held);
        let why = p3dx.unwrap_err().to_string();
        assert_eq!(why, "--turret: the robot \"p3dx\" has no turret");
    }

    #[test]
    fn a_layout_on_the_nomads_body_has_its_size_and_range() {
        let robot = robot("epuck2", Ranges::Nomad);
        let body = robot.body();
        let guard = |margin_mm| {
            Some(Guard {
                margin_mm: NonZeroU16::new(margin_mm)?,
                least_range_mm: 153,
            })
        };
        assert_eq!((body.points.face_radius_mm, body.guard), (231, guard(70)));
        assert_eq!(robot.clone().with_margin(0.03).body().guard, guard(30));
        assert_eq!(robot.sensing(SonarModel::Nomad), SonarConfig::nomad());
        let config = robot.config(Config::recommended());
        assert_eq!(config.robot.step_mm, 250);
        assert_eq!(config.clearance_mm, Config::recommended().clearance_mm);
    }

    #[test]
    fn a_small_body_takes_small_steps() {
        let robot = robot("epuck2", Ranges::Own);
        let config = robot.config(Config::recommended());
        let radius_mm = (robot.model().radius_m * 1e3).round() as u16;
        assert_eq!(config.robot.body_radius_mm, radius_mm);
        assert!((10..20).contains(&config.robot.step_mm));
        assert!(config.encoding.near_mm < config.encoding.far_mm);
        assert!(robot.sensing(SonarModel::Ideal).max_range_m < 0.11);
    }

    /// A Crazyflie sees 4 m of the Nomad's 6.5 with a body of a quarter of its size.
    #[test]
    fn a_robot_that_sees_far_takes_longer_steps_than_its_body_asks_for() {
        let far = robot("crazyflie", Ranges::Own);
        let config = far.config(Config::recommended());
        assert_eq!(config.robot.step_mm, 154);
        assert_eq!(config.robot.body_radius_mm, 70);
        assert!((170..200).contains(&far.body().points.here_mm));
    }

    #[test]
    fn silence_is_no_failure_where_it_means_free_space() {
        for (name, is_free) in [("thymio2", true), ("crazyflie", true), ("p3dx", false)] {
            let robot = robot(name, Ranges::Own);
            assert_eq!(
                robot.config(Config::recommended()).open_space,
                is_free,
                "{name}"
            );
            assert_eq!(robot.body().silence_mm.is_some(), is_free, "{name}");
        }
    }

    #[test]
    fn a_holonomic_robot_turns_only_to_look_around() {
        let few = robot("crazyflie", Ranges::Own);
        assert!(few.turns() && few.body().most_unseen == 4);
        let many = robot("lidar16", Ranges::Own);
        assert!(!many.turns() && many.body().most_unseen == u8::MAX);
    }

    #[test]
    fn scrambled_wires_are_a_permutation_of_the_seed() {
        let plain = robot("p3dx", Ranges::Own);
        let (one, other) = (plain.clone().scrambled(1), plain.clone().scrambled(2));
        assert_eq!(one, plain.clone().scrambled(1));
        assert!(one != other && one != plain);
        let sorted = |robot: &AnyRobot| {
            let mounts = robot.mounts().into_iter();
            let mut axes: Vec<_> = mounts.map(|m| bearing(m.bearing_rad).as_turns()).collect();
            axes.sort_unstable();
            axes
        };
        assert_eq!(sorted(&one), sorted(&plain));
        assert_eq!(one.body(), plain.body());
    }

    #[test]
    fn sensors_look_where_the_model_says() {
        let body = robot("p3dx", Ranges::Own).body();
        let [first, ..] = body.mounts;
        assert_eq!(first.axis, Bearing::from_turns(1 << 14));
        assert_eq!((first.position.dx_mm, first.position.dy_mm), (69, 136));
        assert!(body.enabled.covers(16));
    }
}
