//! What the robot says of itself: the readings, and the packets that carry them.
//!
//! Almost every command is answered with a *state packet* of its own type: the readings of the mask, in a fixed order, then
//! always motor status, time and voltages. The `get_` commands are answered with one group of readings, whatever the mask
//! says of them.

use super::bytes::{Reader, WrongLength, put_i16, put_i32, put_u16, put_u32};
use super::command::Group;
use super::mask::{Mask, WITH_BUMPER, WITH_COMPASS, WITH_INFRARED, WITH_LASER, WITH_SONAR};

/// Most points of the laser.
pub const MAX_LASER_POINTS: usize = 482;

/// Where the robot was when something was sensed, and when that was.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PosData {
    /// x, y in 0.1 in; steering, turret in 0.1°.
    pub pose: [i32; 4],
    /// Of translation in 0.1 in/s, of steering and turret in 0.1°/s.
    pub velocity: [i32; 3],
    /// When the pose was computed, ms of the sensor board.
    pub pose_ms: u32,
    /// When the sensor was read, ms of the sensor board.
    pub sensed_ms: u32,
}

/// The readings of the robot: the client library's `State` vector, and the position data beside it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct State {
    /// 0 … 15 in; 15 = nothing near.
    pub infrared: [u8; 16],
    /// Whole inches; 255 = nothing heard.
    pub sonar: [u8; 16],
    /// Bit i: the switch 18°·i to the left of the base's front; 24 bits travel.
    pub bumpers: u32,
    /// x, y in 0.1 in; steering, turret in 0.1°.
    pub pose: [i32; 4],
    /// Of translation in 0.1 in/s, of steering and turret in 0.1°/s.
    pub velocity: [i32; 3],
    /// Set accelerations, 0.1 in/s² and 0.1°/s².
    pub acceleration: [u16; 3],
    /// 0.1°.
    pub compass: u16,
    /// Points or pixels of the laser, at most [`MAX_LASER_POINTS`].
    pub laser: Vec<u16>,
    /// Bit 0: translation is active; 1: steering; 2: turret.
    pub motors: u8,
    /// Time of the sensor board, ms.
    pub time_ms: u32,
    /// Of the processors: (2 + 3·n/255) · 12.0/5 V.
    pub cpu_voltage: u8,
    /// Of the motors: (2 + 3·n/255) · 12.85/5 V.
    pub motor_voltage: u8,
    /// Where each infrared sensor read.
    pub infrared_at: [PosData; 16],
    /// Where each sonar was heard.
    pub sonar_at: [PosData; 16],
    /// Where the bumpers were read.
    pub bumpers_at: PosData,
    /// Where the laser was read.
    pub laser_at: PosData,
    /// Where the compass was read.
    pub compass_at: PosData,
}

impl State {
    /// The payload of a state packet.
    #[must_use]
    pub fn to_payload(&self, mask: &Mask) -> Vec<u8> {
        let mut out = Vec::new();
        self.put_infrared(&mut out, mask.infrared, mask);
        self.put_sonar(&mut out, mask.sonar, mask);
        if mask.bumper {
            self.put_bumper(&mut out, mask);
        }
        for (number, _) in self.pose.iter().zip(mask.pose).filter(|(_, on)| *on) {
            put_i16(&mut out, *number);
        }
        for (number, _) in self
            .velocity
            .iter()
            .zip(mask.velocity)
            .filter(|(_, on)| *on)
        {
            put_i16(&mut out, *number);
        }
        if mask.compass {
            self.put_compass(&mut out, mask);
        }
        if mask.laser {
            self.put_laser(&mut out, mask);
        }
        out.push(self.motors);
        put_u32(&mut out, self.time_ms);
        out.extend([self.cpu_voltage, self.motor_voltage]);
        out
    }

    /// Takes over the readings of a state packet; those not in the mask stay as they were.
    ///
    /// # Errors
    /// When the payload is not as long as the mask makes it.
    pub fn take_payload(&mut self, mask: &Mask, payload: &[u8]) -> Result<(), WrongLength> {
        let mut reader = Reader::new(payload);
        self.take_infrared(&mut reader, mask.infrared, mask)?;
        self.take_sonar(&mut reader, mask.sonar, mask)?;
        if mask.bumper {
            self.take_bumper(&mut reader, mask)?;
        }
        for (number, _) in self.pose.iter_mut().zip(mask.pose).filter(|(_, on)| *on) {
            *number = i32::from(reader.i16()?);
        }
        let velocity = self.velocity.iter_mut().zip(mask.velocity);
        for (number, _) in velocity.filter(|(_, on)| *on) {
            *number = i32::from(reader.i16()?);
        }
        if mask.compass {
            self.take_compass(&mut reader, mask)?;
        }
        if mask.laser {
            self.take_laser(&mut reader, mask)?;
        }
        self.motors = reader.u8()?;
        self.time_ms = reader.u32()?;
        [self.cpu_voltage, self.motor_voltage] = reader.bytes()?;
        reader.end()
    }

    /// The payload of the answer to a `get_` command. That of `get_ra` is not known, for the library does not read it:
    /// the three accelerations. `get_ls` is answered as the library reads it: two counts, of which only the second has
    /// points behind it.
    #[must_use]
    pub fn to_group(&self, group: Group, mask: &Mask) -> Vec<u8> {
        let mut out = Vec::new();
        match group {
            Group::Infrared => self.put_infrared(&mut out, u16::MAX, mask),
            Group::Sonar => self.put_sonar(&mut out, u16::MAX, mask),
            Group::Bumper => self.put_bumper(&mut out, mask),
            Group::Compass => self.put_compass(&mut out, mask),
            Group::Laser => {
                put_u16(&mut out, 0);
                self.put_laser(&mut out, mask);
            }
            // No lines: they are not simulated.
            Group::Segments => {
                put_u16(&mut out, 0);
                put_attached(&mut out, mask.has(WITH_LASER), &[self.laser_at]);
            }
            Group::Pose => self
                .pose
                .iter()
                .for_each(|&number| put_i16(&mut out, number)),
            Group::Velocity => self
                .velocity
                .iter()
                .for_each(|&number| put_i16(&mut out, number)),
            Group::Acceleration => {
                self.acceleration
                    .iter()
                    .for_each(|&number| put_u16(&mut out, number));
            }
        }
        if has_time(group) {
            put_u32(&mut out, self.time_ms);
        }
        out
    }

    /// Takes over a group of readings.
    ///
    /// # Errors
    /// When the payload is not as long as the group is; for laser lines when there are any.
    pub fn take_group(
        &mut self,
        group: Group,
        mask: &Mask,
        payload: &[u8],
    ) -> Result<(), WrongLength> {
        let mut reader = Reader::new(payload);
        match group {
            Group::Infrared => self.take_infrared(&mut reader, u16::MAX, mask)?,
            Group::Sonar => self.take_sonar(&mut reader, u16::MAX, mask)?,
            Group::Bumper => self.take_bumper(&mut reader, mask)?,
            Group::Compass => self.take_compass(&mut reader, mask)?,
            Group::Laser => {
                reader.u16()?;
                self.take_laser(&mut reader, mask)?;
            }
            Group::Segments => {
                reader.u16()?;
                take_attached(&mut reader, mask.has(WITH_LASER), [&mut self.laser_at])?;
            }
            Group::Pose => self.pose = reader.i16s()?.map(i32::from),
            Group::Velocity => self.velocity = reader.i16s()?.map(i32::from),
            Group::Acceleration => self.acceleration = reader.u16s()?,
        }
        if has_time(group) {
            self.time_ms = reader.u32()?;
        }
        reader.end()
    }

    /// Two sensors to a byte, the first in the low half.
    fn put_infrared(&self, out: &mut Vec<u8>, sensors: u16, mask: &Mask) {
        let chosen: Vec<_> = chosen(&self.infrared, sensors).collect();
        for pair in chosen.chunks(2) {
            let half = |place: usize| pair.get(place).map_or(0, |reading| **reading & 0xf);
            out.push(half(0) | half(1) << 4);
        }
        put_attached(
            out,
            mask.has(WITH_INFRARED),
            chosen_at(&self.infrared_at, sensors),
        );
    }

    fn take_infrared(
        &mut self,
        reader: &mut Reader<'_>,
        sensors: u16,
        mask: &Mask,
    ) -> Result<(), WrongLength> {
        let mut pair = 0;
        for (place, reading) in chosen_mut(&mut self.infrared, sensors).enumerate() {
            pair = if place % 2 == 0 {
                reader.u8()?
            } else {
                pair >> 4
            };
            *reading = pair & 0xf;
        }
        let places = chosen_mut(&mut self.infrared_at, sensors);
        take_attached(reader, mask.has(WITH_INFRARED), places)
    }

    fn put_sonar(&self, out: &mut Vec<u8>, sensors: u16, mask: &Mask) {
        out.extend(chosen(&self.sonar, sensors));
        put_attached(
            out,
            mask.has(WITH_SONAR),
            chosen_at(&self.sonar_at, sensors),
        );
    }

    fn take_sonar(
        &mut self,
        reader: &mut Reader<'_>,
        sensors: u16,
        mask: &Mask,
    ) -> Result<(), WrongLength> {
        for reading in chosen_mut(&mut self.sonar, sensors) {
            *reading = reader.u8()?;
        }
        let places = chosen_mut(&mut self.sonar_at, sensors);
        take_attached(reader, mask.has(WITH_SONAR), places)
    }

    /// The topmost byte first.
    fn put_bumper(&self, out: &mut Vec<u8>, mask: &Mask) {
        let [_, high, middle, low] = self.bumpers.to_be_bytes();
        out.extend([high, middle, low]);
        put_attached(out, mask.has(WITH_BUMPER), &[self.bumpers_at]);
    }

    fn take_bumper(&mut self, reader: &mut Reader<'_>, mask: &Mask) -> Result<(), WrongLength> {
        let [high, middle, low] = reader.bytes()?;
        self.bumpers = u32::from_be_bytes([0, high, middle, low]);
        take_attached(reader, mask.has(WITH_BUMPER), [&mut self.bumpers_at])
    }

    fn put_compass(&self, out: &mut Vec<u8>, mask: &Mask) {
        put_u16(out, self.compass);
        put_attached(out, mask.has(WITH_COMPASS), &[self.compass_at]);
    }

    fn take_compass(&mut self, reader: &mut Reader<'_>, mask: &Mask) -> Result<(), WrongLength> {
        self.compass = reader.u16()?;
        take_attached(reader, mask.has(WITH_COMPASS), [&mut self.compass_at])
    }

    fn put_laser(&self, out: &mut Vec<u8>, mask: &Mask) {
        let points = self.laser.get(..MAX_LASER_POINTS).unwrap_or(&self.laser);
        // At most 482.
        put_u16(out, points.len() as u16);
        points.iter().for_each(|&point| put_u16(out, point));
        put_attached(out, mask.has(WITH_LASER), &[self.laser_at]);
    }

    fn take_laser(&mut self, reader: &mut Reader<'_>, mask: &Mask) -> Result<(), WrongLength> {
        let count = usize::from(reader.u16()?);
        self.laser.clear();
        for _ in 0..count {
            self.laser.push(reader.u16()?);
        }
        take_attached(reader, mask.has(WITH_LASER), [&mut self.laser_at])
    }
}

/// Whether the answer ends with the sensor board's time.
fn has_time(group: Group) -> bool {
    !matches!(group, Group::Pose | Group::Velocity | Group::Acceleration)
}

fn chosen<T>(of: &[T; 16], sensors: u16) -> impl Iterator<Item = &T> {
    of.iter()
        .enumerate()
        .filter(move |(sensor, _)| sensors >> sensor & 1 != 0)
        .map(|(_, item)| item)
}

fn chosen_at(of: &[PosData; 16], sensors: u16) -> impl Iterator<Item = &PosData> {
    chosen(of, sensors)
}

fn chosen_mut<T>(of: &mut [T; 16], sensors: u16) -> impl Iterator<Item = &mut T> {
    of.iter_mut()
        .enumerate()
        .filter(move |(sensor, _)| sensors >> sensor & 1 != 0)
        .map(|(_, item)| item)
}

fn put_attached<'a>(out: &mut Vec<u8>, on: bool, places: impl IntoIterator<Item = &'a PosData>) {
    for place in places.into_iter().filter(|_| on) {
        let numbers = place.pose.iter().chain(&place.velocity);
        numbers.for_each(|&number| put_i32(out, number));
        put_u32(out, place.pose_ms);
        put_u32(out, place.sensed_ms);
    }
}

fn take_attached<'a>(
    reader: &mut Reader<'_>,
    on: bool,
    places: impl IntoIterator<Item = &'a mut PosData>,
) -> Result<(), WrongLength> {
    for place in places.into_iter().filter(|_| on) {
        for number in place.pose.iter_mut().chain(&mut place.velocity) {
            *number = reader.i32()?;
        }
        place.pose_ms = reader.u32()?;
        place.sensed_ms = reader.u32()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
