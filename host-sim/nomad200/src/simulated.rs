//! A simulated Nomad 200, as its own software makes it appear: three motors, a ring of sonars that fire one after the
//! other, infrared sensors, bumpers, odometry, and a host that may fall silent.
//!
//! It knows no clock and no line: [`Simulated::take`] takes a command, [`Simulated::advance`] lets time pass in steps of a
//! millisecond, [`Simulated::answer`] returns what has to be said meanwhile. Body, sonars and world are the simulator's.

use super::firing::Firing;
use super::reckoning::Reckoning;
use super::units::{PER_UNIT, whole};
use super::{Kind, Mask, Packet, PosData, State};
use arena::noise::Noise;
use arena::robot::{Axes, Axis, BaseLimits};
use arena::sonar::{
    M_PER_INCH, MAX_READING_IN, Ring, RingGeometry, SonarConfig, SonarModel, reading_in,
};
use arena::world::{Pose, World};

mod operate;

pub(super) use operate::nak;

/// Time of silence after which motions end, until a host sets another with `conf_tm`: what the known drivers set, s.
const TIMEOUT_S: u8 = 5;

/// Time between two readings of the infrared sensors, ms. The robot's own is not known.
const INFRARED_MS: u32 = 100;

/// An infrared sensor that reads this sees nothing, in.
const NOTHING_NEAR: u8 = 15;

/// Raw voltages of a charged battery: 11.9 V and 12.7 V.
const VOLTAGE: u8 = 250;

/// What is to be said when motors stand, or it has been waited long enough.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Awaited {
    kind: Kind,
    axes: [bool; 3],
    /// `None`: as long as it takes.
    until_ms: Option<u32>,
}

/// How the robot fared, seen from outside.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ledger {
    /// Way rolled, m.
    pub traveled_m: f64,
    /// How often the body touched something.
    pub contacts: u32,
}

/// A robot in a world.
#[derive(Debug, Clone)]
pub struct Simulated {
    world: World,
    axes: Axes,
    reckoning: Reckoning,
    ring: Ring,
    firing: Firing,
    infrared: Ring,
    /// Tenths of an infrared reading that come from the one before.
    history: u8,
    /// Bit i: infrared sensor i is read.
    infrared_on: u16,
    compass_on: bool,
    noise: Noise,
    mask: Mask,
    timeout_s: u8,
    /// When the host was heard last.
    heard_ms: u32,
    awaited: Option<Awaited>,
    /// Steering and turret are on their way to zero.
    zeroing: bool,
    ledger: Ledger,
    /// Way rolled after which the wheels are blocked, m.
    rolls_m: f64,
    state: State,
}

impl Simulated {
    /// A robot that has just been switched on at the world's start, all angles 0, its sonars firing as the known drivers
    /// have them. With the sonar model *ideal* its wheels do not slip.
    #[must_use]
    pub fn new(world: World, sonar: SonarModel, seed: u64) -> Self {
        let mut noise = Noise::new(seed);
        let slip = match sonar {
            SonarModel::Ideal => 0.0,
            _ => BaseLimits::default().slip,
        };
        let limits = BaseLimits {
            slip,
            ..BaseLimits::default()
        };
        let near = SonarConfig {
            max_range_m: f64::from(NOTHING_NEAR) * M_PER_INCH,
            ..SonarConfig::ideal()
        };
        let geometry = RingGeometry::default();
        let ring = Ring::new(sonar, &mut noise);
        Self {
            axes: Axes::new(world.start(), &limits),
            world,
            reckoning: Reckoning::default(),
            ring,
            firing: Firing::default(),
            infrared: Ring::with_config(SonarModel::Ideal, geometry, near, &mut noise),
            history: 0,
            infrared_on: u16::MAX,
            compass_on: false,
            noise,
            mask: Mask::ALL,
            timeout_s: TIMEOUT_S,
            heard_ms: 0,
            awaited: None,
            zeroing: false,
            ledger: Ledger::default(),
            rolls_m: f64::INFINITY,
            state: State {
                infrared: [NOTHING_NEAR; 16],
                sonar: [MAX_READING_IN; 16],
                cpu_voltage: VOLTAGE,
                motor_voltage: VOLTAGE,
                ..State::default()
            },
        }
    }

    /// The same robot, whose wheels are blocked when it has rolled so far, m: its motor then runs and it stays where it is.
    #[must_use]
    pub fn with_wheels_blocked_after(mut self, way_m: f64) -> Self {
        self.rolls_m = way_m;
        self
    }

    /// Time since it was switched on, ms; wraps after 49.7 days.
    #[must_use]
    pub fn time_ms(&self) -> u32 {
        self.state.time_ms
    }

    /// True position, and bearing of the turret.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.axes.pose()
    }

    /// What state packets hold at present.
    #[must_use]
    pub fn mask(&self) -> &Mask {
        &self.mask
    }

    /// How it has fared.
    #[must_use]
    pub fn ledger(&self) -> Ledger {
        self.ledger
    }

    /// Its readings at this moment.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Lets `ms` milliseconds pass.
    pub fn advance(&mut self, ms: u32) {
        for _ in 0..ms {
            self.tick();
        }
    }

    /// An answer that had to wait, once it is due.
    pub fn answer(&mut self) -> Option<Packet> {
        let awaited = self.awaited?;
        let expired = |until_ms: u32| self.time_ms().wrapping_sub(until_ms) < 1 << 31;
        let waits = Axis::ALL.into_iter().zip(awaited.axes);
        let stands = waits
            .filter(|(_, waits)| *waits)
            .all(|(axis, _)| !self.axes.is_active(axis));
        if (stands && !self.zeroing) || awaited.until_ms.is_some_and(expired) {
            self.awaited = None;
            return Some(self.state_packet(awaited.kind));
        }
        None
    }

    /// Whoever asked is gone: nothing is answered any more.
    pub fn forget_question(&mut self) {
        self.awaited = None;
    }

    fn tick(&mut self) {
        self.fire();
        if self.time_ms().is_multiple_of(INFRARED_MS) {
            self.look();
        }
        let silent_ms = self.time_ms().wrapping_sub(self.heard_ms);
        let patience_ms = u32::from(self.timeout_s) * 1_000;
        // The robot zeroes itself without its host.
        if self.timeout_s > 0 && silent_ms > patience_ms && !self.zeroing {
            self.hold();
        }
        if Axis::ALL.into_iter().any(|axis| self.axes.is_active(axis)) {
            let touching = self.axes.bumpers() != 0;
            let (done, counted) = self.axes.advance(1e-3, &self.world);
            self.reckoning.roll(counted);
            self.ledger.traveled_m += done.traveled_m;
            self.ledger.contacts += u32::from(done.touched && !touching);
            if self.ledger.traveled_m >= self.rolls_m {
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

    /// The transducer whose turn it is fires and is heard; an echo that would come after the next firing is not.
    fn fire(&mut self) {
        let Some(shot) = self.firing.due(self.time_ms()) else {
            return;
        };
        let time_s = f64::from(self.time_ms()) * 1e-3;
        let pose = self.axes.pose();
        let heard = self
            .ring
            .ping(&self.world, &pose, shot.sensor, time_s, &mut self.noise);
        let heard = heard.filter(|range_m| *range_m <= shot.reach_m);
        let here = self.place();
        if let Some(reading) = self.state.sonar.get_mut(shot.sensor) {
            *reading = reading_in(heard);
        }
        if let Some(place) = self.state.sonar_at.get_mut(shot.sensor) {
            *place = here;
        }
    }

    /// Reads the infrared sensors, which share the sonars' places on the turret.
    fn look(&mut self) {
        let mut ranges = [None; 16];
        let pose = self.axes.pose();
        self.infrared.scan(&self.world, &pose, &mut ranges);
        let here = self.place();
        let (old, new) = (u32::from(self.history), u32::from(10 - self.history));
        for (sensor, range) in ranges.into_iter().enumerate() {
            if self.infrared_on >> sensor & 1 == 0 {
                continue;
            }
            let seen = u32::from(reading_in(range).min(NOTHING_NEAR));
            let reading = &mut self.state.infrared[sensor];
            // A weighted mean of two numbers up to 15.
            *reading = ((old * u32::from(*reading) + new * seen + 5) / 10) as u8;
            self.state.infrared_at[sensor] = here;
        }
    }

    /// Copies what the motors' board knows into the readings.
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
        // Below 3600. Which way the robot's own compass counts is not known: as the turret does, from the world's x axis.
        self.state.compass = if self.compass_on { bearing as u16 } else { 0 };
    }

    /// Where the robot is and when, to be attached to a reading.
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

    /// What has no time of its own is read when it is asked for.
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

#[cfg(test)]
mod tests;
