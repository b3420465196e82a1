//! A simulated Nomad 200: three motors, sonars, infrared sensors, bumpers, odometry, and a time-out
//! of the host.
//!
//! [`SimulatedNomad::execute`] executes a command, [`SimulatedNomad::advance`] advances the time,
//! [`SimulatedNomad::answer`] returns delayed answers. It has no clock and no line of its own.

use super::dead_reckoning::DeadReckoning;
use super::firing::FiringSchedule;
use super::units::{PER_UNIT, whole};
use super::{Kind, NomadReadings, Packet, PosData, StateMask};
use arena::noise::Noise;
use arena::robot::{Axes, Axis, BaseLimits};
use arena::sonar::{
    M_PER_INCH, MAX_READING_IN, Ring, RingGeometry, SonarConfig, SonarModel, reading_in,
};
use arena::world::{Pose, World};

mod operate;

pub(super) use operate::nak;

/// Time-out of motions until a host sets another one, s: that of the known drivers.
const TIMEOUT_S: u8 = 5;

/// Period of the infrared sensors, ms. The robot's own is not known.
const INFRARED_MS: u32 = 100;

/// Infrared reading without an object, in.
const MAX_INFRARED_IN: u8 = 15;

/// Raw voltages of a charged battery: 11.9 V and 12.7 V.
const VOLTAGE: u8 = 250;

/// An answer that waits for the motors or for a time-out.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PendingAnswer {
    kind: Kind,
    axes: [bool; 3],
    /// `None` = no time-out.
    until_ms: Option<u32>,
}

/// True motion of the robot.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroundTruth {
    /// Distance rolled, m.
    pub traveled_m: f64,
    /// Number of contacts.
    pub contacts: u32,
}

/// A robot in a world.
#[derive(Debug, Clone)]
pub struct SimulatedNomad {
    world: World,
    axes: Axes,
    reckoning: DeadReckoning,
    ring: Ring,
    firing: FiringSchedule,
    infrared: Ring,
    /// Tenths of an infrared reading that come from the previous one.
    history: u8,
    /// Bit i: infrared sensor i is on.
    infrared_on: u16,
    compass_on: bool,
    noise: Noise,
    mask: StateMask,
    timeout_s: u8,
    /// Time of the latest command.
    last_command_ms: u32,
    pending: Option<PendingAnswer>,
    /// Steering and turret move to zero.
    zeroing: bool,
    ground_truth: GroundTruth,
    /// Distance after which the wheels are blocked, m.
    blocked_after_m: f64,
    state: NomadReadings,
}

impl SimulatedNomad {
    /// A robot that has just been switched on at the world's start. All angles are 0, and the
    /// sonars fire in the known drivers' order. With ideal sonars the wheels do not slip.
    #[must_use]
    pub fn new(world: World, sonar: SonarModel, seed: u64) -> Self {
        let mut noise = Noise::new(seed);
        let ring = Ring::new(sonar, &mut noise);
        let infrared = infrared_ring(&mut noise);
        Self {
            axes: Axes::new(world.start(), &base_limits(sonar)),
            world,
            reckoning: DeadReckoning::default(),
            ring,
            firing: FiringSchedule::default(),
            infrared,
            history: 0,
            infrared_on: u16::MAX,
            compass_on: false,
            noise,
            mask: StateMask::ALL,
            timeout_s: TIMEOUT_S,
            last_command_ms: 0,
            pending: None,
            zeroing: false,
            ground_truth: GroundTruth::default(),
            blocked_after_m: f64::INFINITY,
            state: initial_state(),
        }
    }

    /// The same robot, whose wheels are blocked after this distance, m: the motor runs, but the
    /// robot does not move.
    #[must_use]
    pub fn with_wheels_blocked_after(mut self, distance_m: f64) -> Self {
        self.blocked_after_m = distance_m;
        self
    }

    /// Time since it was switched on, ms; wraps after 49.7 days.
    #[must_use]
    pub fn time_ms(&self) -> u32 {
        self.state.time_ms
    }

    /// True position and heading of the turret.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.axes.pose()
    }

    /// Content of state packets.
    #[must_use]
    pub fn mask(&self) -> &StateMask {
        &self.mask
    }

    /// True motion since the start.
    #[must_use]
    pub fn ground_truth(&self) -> GroundTruth {
        self.ground_truth
    }

    /// The current readings.
    #[must_use]
    pub fn state(&self) -> &NomadReadings {
        &self.state
    }

    /// Advances the time by `ms` milliseconds.
    pub fn advance(&mut self, ms: u32) {
        for _ in 0..ms {
            self.tick();
        }
    }

    /// A delayed answer, once it is due.
    pub fn answer(&mut self) -> Option<Packet> {
        let pending = self.pending?;
        let expired = |until_ms: u32| self.time_ms().wrapping_sub(until_ms) < 1 << 31;
        let waits = Axis::ALL.into_iter().zip(pending.axes);
        let stands = waits
            .filter(|(_, waits)| *waits)
            .all(|(axis, _)| !self.axes.is_active(axis));
        if (stands && !self.zeroing) || pending.until_ms.is_some_and(expired) {
            self.pending = None;
            return Some(self.state_packet(pending.kind));
        }
        None
    }

    /// Cancels a delayed answer.
    pub fn cancel_answer(&mut self) {
        self.pending = None;
    }

    fn tick(&mut self) {
        self.fire();
        if self.time_ms().is_multiple_of(INFRARED_MS) {
            self.read_infrared();
        }
        let silent_ms = self.time_ms().wrapping_sub(self.last_command_ms);
        let timeout_ms = u32::from(self.timeout_s) * 1_000;
        // Zeroing continues without the host.
        if self.timeout_s > 0 && silent_ms > timeout_ms && !self.zeroing {
            self.hold();
        }
        if Axis::ALL.into_iter().any(|axis| self.axes.is_active(axis)) {
            let touching = self.axes.bumpers() != 0;
            let (done, counted) = self.axes.advance(1e-3, &self.world);
            self.reckoning.roll(counted);
            self.ground_truth.traveled_m += done.traveled_m;
            self.ground_truth.contacts += u32::from(done.touched && !touching);
            if self.ground_truth.traveled_m >= self.blocked_after_m {
                self.axes.block_wheels();
            }
        }
        if self.zeroing {
            self.finish_zeroing();
        }
        self.state.time_ms = self.state.time_ms.wrapping_add(1);
        self.read_motors();
    }

    fn hold(&mut self) {
        Axis::ALL.into_iter().for_each(|axis| self.axes.hold(axis));
    }

    /// Fires the sonar that is due. An echo after the next firing is lost.
    fn fire(&mut self) {
        let Some(shot) = self.firing.due(self.time_ms()) else {
            return;
        };
        let time_s = f64::from(self.time_ms()) * 1e-3;
        let pose = self.axes.pose();
        let range_m = self
            .ring
            .ping(&self.world, &pose, shot.sensor, time_s, &mut self.noise);
        let range_m = range_m.filter(|reading_m| *reading_m <= shot.reach_m);
        let here = self.place();
        if let Some(reading) = self.state.sonar.get_mut(shot.sensor) {
            *reading = reading_in(range_m);
        }
        if let Some(place) = self.state.sonar_at.get_mut(shot.sensor) {
            *place = here;
        }
    }

    /// Reads the infrared sensors, which sit at the sonars' places.
    fn read_infrared(&mut self) {
        let mut ranges = [None; 16];
        let pose = self.axes.pose();
        self.infrared.scan(&self.world, &pose, &mut ranges);
        let here = self.place();
        let (old, new) = (u32::from(self.history), u32::from(10 - self.history));
        for (sensor, range) in ranges.into_iter().enumerate() {
            if self.infrared_on >> sensor & 1 == 0 {
                continue;
            }
            let measured = u32::from(reading_in(range).min(MAX_INFRARED_IN));
            let reading = &mut self.state.infrared[sensor];
            // A weighted mean of two numbers up to 15.
            *reading = ((old * u32::from(*reading) + new * measured + 5) / 10) as u8;
            self.state.infrared_at[sensor] = here;
        }
    }

    /// Copies the motors' state into the readings.
    fn read_motors(&mut self) {
        let axes = &self.axes;
        let [steering, turret] = [axes.at(Axis::Steering), axes.at(Axis::Turret)];
        self.state.pose = self.reckoning.reported(steering, turret);
        for (axis, unit) in Axis::ALL.into_iter().zip(PER_UNIT) {
            self.state.velocity[axis as usize] = whole(axes.rate(axis), unit);
            // At most 450.
            self.state.acceleration[axis as usize] =
                whole(axes.set(axis).acceleration, unit) as u16;
        }
        let active = Axis::ALL
            .into_iter()
            .map(|axis| u8::from(axes.is_active(axis)) << axis as u8);
        self.state.motors = active.fold(0, |bits, bit| bits | bit);
        self.state.bumpers = axes.bumpers();
        let bearing = super::units::whole_angle(axes.pose().heading);
        // Below 3600. The real compass's orientation is not known; this one follows the turret from
        // the world's x axis.
        self.state.compass = if self.compass_on { bearing as u16 } else { 0 };
    }

    /// Pose and time to attach to a reading.
    fn place(&self) -> PosData {
        PosData {
            pose: self.state.pose,
            velocity: self.state.velocity,
            pose_ms: self.time_ms(),
            sensed_ms: self.time_ms(),
        }
    }

    fn state_packet(&mut self, kind: Kind) -> Packet {
        self.read_now();
        Packet::new(kind, self.state.to_payload(&self.mask))
    }

    /// Updates the readings without a period of their own.
    fn read_now(&mut self) {
        self.read_motors();
        let here = self.place();
        (
            self.state.bumpers_at,
            self.state.compass_at,
            self.state.laser_at,
        ) = (here, here, here);
    }
}

/// The base's limits; with ideal sonars its wheels do not slip.
fn base_limits(sonar: SonarModel) -> BaseLimits {
    let default = BaseLimits::default();
    let slip = match sonar {
        SonarModel::Ideal => 0.0,
        _ => default.slip,
    };
    BaseLimits { slip, ..default }
}

fn infrared_ring(noise: &mut Noise) -> Ring {
    let config = SonarConfig {
        max_range_m: f64::from(MAX_INFRARED_IN) * M_PER_INCH,
        ..SonarConfig::ideal()
    };
    Ring::with_config(SonarModel::Ideal, RingGeometry::default(), config, noise)
}

/// The readings before the first echo.
fn initial_state() -> NomadReadings {
    NomadReadings {
        infrared: [MAX_INFRARED_IN; 16],
        sonar: [MAX_READING_IN; 16],
        cpu_voltage: VOLTAGE,
        motor_voltage: VOLTAGE,
        ..NomadReadings::default()
    }
}

#[cfg(test)]
mod tests;
