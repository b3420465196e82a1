//! The robot's readings and the packets that carry them.
//!
//! Almost every command is answered with a *state packet* of its own type: the readings of the mask
//! in a fixed order, then motor status, time and voltages. A `get_` command is answered with one
//! group of readings, whatever the mask.

use super::bytes::{LengthError, PayloadReader, put_i16, put_i32, put_u16, put_u32};
use super::command::ReadingGroup;
use super::mask::{StateMask, WITH_BUMPER, WITH_COMPASS, WITH_INFRARED, WITH_LASER, WITH_SONAR};

/// Maximum number of laser points.
pub const MAX_LASER_POINTS: usize = 482;

/// Pose and times of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PosData {
    /// x, y in 0.1 in; steering, turret in 0.1°.
    pub pose: [i32; 4],
    /// Translation in 0.1 in/s; steering and turret in 0.1°/s.
    pub velocity: [i32; 3],
    /// Time of the pose, ms of the sensor board.
    pub pose_ms: u32,
    /// Time of the reading, ms of the sensor board.
    pub sensed_ms: u32,
}

/// The robot's readings: the client library's `State` vector, with position data.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct NomadReadings {
    /// 0 … 15 in; 15 = no object.
    pub infrared: [u8; 16],
    /// Whole inches; 255 = no echo.
    pub sonar: [u8; 16],
    /// Bit i: the switch 18°·i to the left of the base's front; 24 bits are sent.
    pub bumpers: u32,
    /// x, y in 0.1 in; steering, turret in 0.1°.
    pub pose: [i32; 4],
    /// Translation in 0.1 in/s; steering and turret in 0.1°/s.
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
    /// Processor supply: (2 + 3·n/255) · 12.0/5 V.
    pub cpu_voltage: u8,
    /// Motor supply: (2 + 3·n/255) · 12.85/5 V.
    pub motor_voltage: u8,
    /// Position data of the infrared sensors.
    pub infrared_at: [PosData; 16],
    /// Position data of the sonars.
    pub sonar_at: [PosData; 16],
    /// Position data of the bumpers.
    pub bumpers_at: PosData,
    /// Position data of the laser.
    pub laser_at: PosData,
    /// Position data of the compass.
    pub compass_at: PosData,
}

impl NomadReadings {
    /// Encodes a state packet.
    #[must_use]
    pub fn to_payload(&self, mask: &StateMask) -> Vec<u8> {
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

    /// Decodes a state packet; readings outside the mask keep their values.
    ///
    /// # Errors
    /// When the length does not match the mask.
    pub fn take_payload(&mut self, mask: &StateMask, payload: &[u8]) -> Result<(), LengthError> {
        let mut reader = PayloadReader::new(payload);
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

    /// Encodes the answer to a `get_` command. That of `get_ra` is not known, because the library
    /// does not read it; it holds three accelerations. `get_ls` has two counts, as the library
    /// reads it; points follow the second.
    #[must_use]
    pub fn to_group(&self, group: ReadingGroup, mask: &StateMask) -> Vec<u8> {
        let mut out = Vec::new();
        match group {
            ReadingGroup::Infrared => self.put_infrared(&mut out, u16::MAX, mask),
            ReadingGroup::Sonar => self.put_sonar(&mut out, u16::MAX, mask),
            ReadingGroup::Bumper => self.put_bumper(&mut out, mask),
            ReadingGroup::Compass => self.put_compass(&mut out, mask),
            ReadingGroup::Laser => {
                put_u16(&mut out, 0);
                self.put_laser(&mut out, mask);
            }
            // Laser lines are not simulated.
            ReadingGroup::Segments => {
                put_u16(&mut out, 0);
                put_attached(&mut out, mask.has(WITH_LASER), &[self.laser_at]);
            }
            ReadingGroup::Pose => self
                .pose
                .iter()
                .for_each(|&number| put_i16(&mut out, number)),
            ReadingGroup::Velocity => self
                .velocity
                .iter()
                .for_each(|&number| put_i16(&mut out, number)),
            ReadingGroup::Acceleration => {
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

    /// Decodes a group of readings.
    ///
    /// # Errors
    /// When the length does not match the group, or there are laser lines.
    pub fn take_group(
        &mut self,
        group: ReadingGroup,
        mask: &StateMask,
        payload: &[u8],
    ) -> Result<(), LengthError> {
        let mut reader = PayloadReader::new(payload);
        match group {
            ReadingGroup::Infrared => self.take_infrared(&mut reader, u16::MAX, mask)?,
            ReadingGroup::Sonar => self.take_sonar(&mut reader, u16::MAX, mask)?,
            ReadingGroup::Bumper => self.take_bumper(&mut reader, mask)?,
            ReadingGroup::Compass => self.take_compass(&mut reader, mask)?,
            ReadingGroup::Laser => {
                reader.u16()?;
                self.take_laser(&mut reader, mask)?;
            }
            ReadingGroup::Segments => {
                reader.u16()?;
                take_attached(&mut reader, mask.has(WITH_LASER), [&mut self.laser_at])?;
            }
            ReadingGroup::Pose => self.pose = reader.i16s()?.map(i32::from),
            ReadingGroup::Velocity => self.velocity = reader.i16s()?.map(i32::from),
            ReadingGroup::Acceleration => self.acceleration = reader.u16s()?,
        }
        if has_time(group) {
            self.time_ms = reader.u32()?;
        }
        reader.end()
    }

    /// Two sensors per byte, the first in the low half.
    fn put_infrared(&self, out: &mut Vec<u8>, sensors: u16, mask: &StateMask) {
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
        reader: &mut PayloadReader<'_>,
        sensors: u16,
        mask: &StateMask,
    ) -> Result<(), LengthError> {
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

    fn put_sonar(&self, out: &mut Vec<u8>, sensors: u16, mask: &StateMask) {
        out.extend(chosen(&self.sonar, sensors));
        put_attached(
            out,
            mask.has(WITH_SONAR),
            chosen_at(&self.sonar_at, sensors),
        );
    }

    fn take_sonar(
        &mut self,
        reader: &mut PayloadReader<'_>,
        sensors: u16,
        mask: &StateMask,
    ) -> Result<(), LengthError> {
        for reading in chosen_mut(&mut self.sonar, sensors) {
            *reading = reader.u8()?;
        }
        let places = chosen_mut(&mut self.sonar_at, sensors);
        take_attached(reader, mask.has(WITH_SONAR), places)
    }

    /// Most significant byte first.
    fn put_bumper(&self, out: &mut Vec<u8>, mask: &StateMask) {
        let [_, high, middle, low] = self.bumpers.to_be_bytes();
        out.extend([high, middle, low]);
        put_attached(out, mask.has(WITH_BUMPER), &[self.bumpers_at]);
    }

    fn take_bumper(
        &mut self,
        reader: &mut PayloadReader<'_>,
        mask: &StateMask,
    ) -> Result<(), LengthError> {
        let [high, middle, low] = reader.bytes()?;
        self.bumpers = u32::from_be_bytes([0, high, middle, low]);
        take_attached(reader, mask.has(WITH_BUMPER), [&mut self.bumpers_at])
    }

    fn put_compass(&self, out: &mut Vec<u8>, mask: &StateMask) {
        put_u16(out, self.compass);
        put_attached(out, mask.has(WITH_COMPASS), &[self.compass_at]);
    }

    fn take_compass(
        &mut self,
        reader: &mut PayloadReader<'_>,
        mask: &StateMask,
    ) -> Result<(), LengthError> {
        self.compass = reader.u16()?;
        take_attached(reader, mask.has(WITH_COMPASS), [&mut self.compass_at])
    }

    fn put_laser(&self, out: &mut Vec<u8>, mask: &StateMask) {
        let points = self.laser.get(..MAX_LASER_POINTS).unwrap_or(&self.laser);
        // At most 482.
        put_u16(out, points.len() as u16);
        points.iter().for_each(|&point| put_u16(out, point));
        put_attached(out, mask.has(WITH_LASER), &[self.laser_at]);
    }

    fn take_laser(
        &mut self,
        reader: &mut PayloadReader<'_>,
        mask: &StateMask,
    ) -> Result<(), LengthError> {
        let count = usize::from(reader.u16()?);
        self.laser.clear();
        for _ in 0..count {
            self.laser.push(reader.u16()?);
        }
        take_attached(reader, mask.has(WITH_LASER), [&mut self.laser_at])
    }
}

/// Whether the answer ends with the time of the sensor board.
pub(super) fn has_time(group: ReadingGroup) -> bool {
    !matches!(
        group,
        ReadingGroup::Pose | ReadingGroup::Velocity | ReadingGroup::Acceleration
    )
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
    reader: &mut PayloadReader<'_>,
    on: bool,
    places: impl IntoIterator<Item = &'a mut PosData>,
) -> Result<(), LengthError> {
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
