//! The protocol of the original simulator's server, which programs linked with `Nclient` speak (TCP
//! 7019).
//!
//! A message is `type(u16) size(u16) size × i32`, all big-endian, without any mark in between.
//! Every request has one answer; the state is always complete. Source: `Nclient.c` 2.7 (Nomadic
//! Technologies; copy in Player).

use super::state::has_time;
use super::{
    AxisMode, Kind, NomadCommand, NomadReadings, PosData, ReadingGroup, StateMask, WITH_BUMPER,
    WITH_COMPASS, WITH_INFRARED, WITH_LASER, WITH_SONAR,
};

const STATE: u16 = 80;
const REPLY: u16 = 82;
const INFRARED: u16 = 83;
const SONAR: u16 = 84;
const LASER: u16 = 85;
const COMPASS: u16 = 86;
const BUMPER: u16 = 87;
const CONFIGURATION: u16 = 88;
const VELOCITY: u16 = 89;
const ACCELERATION: u16 = 90;
const ERROR: u16 = 91;

/// Error number for unknown requests. The original's numbers are not known.
const UNKNOWN_ERROR: i32 = 1;

/// Size of type and size, bytes.
const HEAD: usize = 4;

/// A message in either direction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ServerMessage {
    /// Its type.
    pub kind: u16,
    /// Its numbers.
    pub numbers: Vec<i32>,
}

impl ServerMessage {
    /// Encodes the message, with at most 65 535 numbers.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let max = usize::from(u16::MAX);
        let numbers = self.numbers.get(..max).unwrap_or(&self.numbers);
        let mut bytes = self.kind.to_be_bytes().to_vec();
        // Limited two lines above.
        bytes.extend((numbers.len() as u16).to_be_bytes());
        bytes.extend(numbers.iter().flat_map(|number| number.to_be_bytes()));
        bytes
    }

    /// Takes a complete message from the front of `bytes`, if there is one.
    pub fn take_from(bytes: &mut Vec<u8>) -> Option<Self> {
        let &[kind_high, kind_low, size_high, size_low, ..] = &bytes[..] else {
            return None;
        };
        let size = usize::from(u16::from_be_bytes([size_high, size_low]));
        let numbers = bytes.get(HEAD..HEAD + 4 * size)?;
        let number = |quad: &[u8]| quad.try_into().map_or(0, i32::from_be_bytes);
        let message = Self {
            kind: u16::from_be_bytes([kind_high, kind_low]),
            numbers: numbers.chunks_exact(4).map(number).collect(),
        };
        bytes.drain(..HEAD + 4 * size);
        Some(message)
    }
}

/// A decoded request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Request {
    /// A command of the robot.
    Robot(NomadCommand),
    /// `connect_robot` or `create_robot`: answered with the robot's port.
    Connect,
    /// Disconnects; not answered.
    Disconnect,
    /// `place_robot`: x, y, steering, turret. It sets the robot's odometry, like `dp` and `da`.
    Place([i16; 4]),
    /// Requests the pose.
    Where,
    /// Drawing, speech, real mode: acknowledged without effect.
    NoEffect,
    /// Unknown or not simulated.
    Unknown,
}

impl Request {
    /// Decodes a message.
    #[must_use]
    pub fn of(message: &ServerMessage) -> Self {
        let numbers = Numbers(&message.numbers);
        numbers.request(message.kind).unwrap_or(Self::Unknown)
    }
}

/// Converts the numbers of a request to narrower types.
struct Numbers<'m>(&'m [i32]);

impl Numbers<'_> {
    /// Exactly N numbers, each saturated.
    fn all<const N: usize, T: Narrow>(&self) -> Option<[T; N]> {
        let all: [i32; N] = self.0.try_into().ok()?;
        Some(all.map(T::narrow))
    }

    fn sensors(&self) -> Option<(u8, [u8; 16])> {
        let [first, order @ ..] = self.all::<17, u8>()?;
        Some((first, order))
    }

    fn request(&self, kind: u16) -> Option<Request> {
        Some(match kind {
            41 => Request::Place(self.all()?),
            60..=62 | 71 | 72 | 74 | 150..=159 | 19 => Request::NoEffect,
            101 | 102 => Request::Connect,
            103 => Request::Disconnect,
            200 => Request::Where,
            _ => Request::Robot(self.command(kind)?),
        })
    }

    fn command(&self, kind: u16) -> Option<NomadCommand> {
        Some(match kind {
            10 => NomadCommand::Accelerations(self.all()?),
            11 => NomadCommand::Speeds(self.all()?),
            12 => NomadCommand::Velocity(self.all()?),
            13 => NomadCommand::Relative(self.all()?),
            14 => NomadCommand::Absolute(self.all()?),
            15 => NomadCommand::GetState,
            16 => NomadCommand::Communicate(mask(self.all()?)),
            17 => NomadCommand::Stop,
            18 => NomadCommand::Limp,
            20 => NomadCommand::Zero,
            21 => NomadCommand::DefinePosition(self.all()?),
            22 => {
                let (history, order) = self.sensors()?;
                NomadCommand::ConfigureInfrared { history, order }
            }
            23 => {
                let (rate, order) = self.sensors()?;
                NomadCommand::ConfigureSonar { rate, order }
            }
            24 => {
                let [mode] = self.all()?;
                NomadCommand::ConfigureCompass(mode)
            }
            26 => {
                let [seconds] = self.all()?;
                NomadCommand::ConfigureTimeout(seconds)
            }
            38 => NomadCommand::DefineAngles(self.all()?),
            39 => self.wait_for_stop()?,
            43 => self.move_axes()?,
            _ => NomadCommand::Get(reading_group(kind)?),
        })
    }

    fn wait_for_stop(&self) -> Option<NomadCommand> {
        let [translation, steering, turret, timeout_s] = self.all::<4, u8>()?;
        Some(NomadCommand::WaitForStop {
            axes: [translation, steering, turret].map(|flag| flag != 0),
            timeout_s,
        })
    }

    /// Modes and values in turn, for translation, steering and turret.
    fn move_axes(&self) -> Option<NomadCommand> {
        let [t, t_value, s, s_value, r, r_value] = self.all::<6, i16>()?;
        let mode = |number: i16| AxisMode::of(u16::try_from(number).ok()?);
        Some(NomadCommand::Move([
            (mode(t)?, t_value),
            (mode(s)?, s_value),
            (mode(r)?, r_value),
        ]))
    }
}

/// The readings that a `get_` request asks for.
fn reading_group(kind: u16) -> Option<ReadingGroup> {
    Some(match kind {
        27 => ReadingGroup::Infrared,
        28 => ReadingGroup::Sonar,
        29 => ReadingGroup::Pose,
        30 => ReadingGroup::Velocity,
        31 => ReadingGroup::Acceleration,
        32 => ReadingGroup::Compass,
        33 => ReadingGroup::Laser,
        35 => ReadingGroup::Bumper,
        37 => ReadingGroup::Segments,
        _ => return None,
    })
}

/// Saturating conversion.
trait Narrow {
    fn narrow(number: i32) -> Self;
}

impl Narrow for i16 {
    fn narrow(number: i32) -> Self {
        // The clamp keeps it in range.
        number.clamp(-i32::from(Self::MAX), Self::MAX.into()) as Self
    }
}

impl Narrow for u16 {
    fn narrow(number: i32) -> Self {
        // The clamp keeps it in range.
        number.clamp(0, Self::MAX.into()) as Self
    }
}

impl Narrow for u8 {
    fn narrow(number: i32) -> Self {
        // The clamp keeps it in range.
        number.clamp(0, Self::MAX.into()) as Self
    }
}

/// Decodes the seven bytes of this `ct`: laser and compass in the sixth, position bits in the
/// seventh.
fn mask(bytes: [u8; 7]) -> StateMask {
    let [a, b, c, d, motion, rest, attached] = bytes;
    let (laser, compass) = (rest >> 2 & 1, rest >> 3 & 1);
    StateMask::from_bytes([a, b, c, d, motion, laser, compass | attached << 1])
}

/// Answer to a command that the robot answered with a packet of `kind` (or NAK). `speed` is the
/// factor of simulated to real time.
#[must_use]
pub fn answer(kind: u8, state: &NomadReadings, mask: &StateMask, speed: u32) -> ServerMessage {
    match Kind::from_byte(kind) {
        Some(Kind::Nak) | None => ServerMessage {
            kind: ERROR,
            numbers: vec![UNKNOWN_ERROR],
        },
        Some(kind) => match ReadingGroup::of(kind) {
            Some(group) => group_message(group, state, mask),
            None => state_message(state, mask, speed),
        },
    }
}

/// Answer to a request that is no command, if it has one.
#[must_use]
pub fn answer_request(
    request: &Request,
    state: &NomadReadings,
    port: u16,
) -> Option<ServerMessage> {
    let (kind, numbers) = match request {
        Request::Connect => (REPLY, vec![i32::from(port)]),
        Request::Where => (CONFIGURATION, state.pose.to_vec()),
        Request::Place(_) | Request::NoEffect => (REPLY, Vec::new()),
        Request::Unknown => (ERROR, vec![UNKNOWN_ERROR]),
        Request::Disconnect | Request::Robot(_) => return None,
    };
    Some(ServerMessage { kind, numbers })
}

fn state_message(state: &NomadReadings, mask: &StateMask, speed: u32) -> ServerMessage {
    // 10 = real time; at most 10 000.
    let mut numbers = vec![(speed * 10) as i32];
    numbers.extend(state.infrared.map(i32::from));
    numbers.extend(state.sonar.map(i32::from));
    // 24 bits.
    numbers.push(state.bumpers as i32);
    numbers.extend(state.pose);
    numbers.extend(state.velocity);
    // Motors, laser mode, compass, error, number of laser points.
    numbers.extend([i32::from(state.motors), 0, state.compass.into(), 0, 0]);
    attach(&mut numbers, mask.has(WITH_INFRARED), &state.infrared_at);
    attach(&mut numbers, mask.has(WITH_SONAR), &state.sonar_at);
    attach(&mut numbers, mask.has(WITH_BUMPER), &[state.bumpers_at]);
    attach(&mut numbers, mask.has(WITH_LASER), &[state.laser_at]);
    attach(&mut numbers, mask.has(WITH_COMPASS), &[state.compass_at]);
    numbers.push(state.time_ms as i32);
    numbers.extend([state.cpu_voltage, state.motor_voltage].map(i32::from));
    ServerMessage {
        kind: STATE,
        numbers,
    }
}

fn group_message(group: ReadingGroup, state: &NomadReadings, mask: &StateMask) -> ServerMessage {
    let mut numbers = group_readings(group, state);
    attach_group(&mut numbers, group, state, mask);
    if has_time(group) {
        numbers.push(state.time_ms as i32);
    }
    ServerMessage {
        kind: group_kind(group),
        numbers,
    }
}

fn group_kind(group: ReadingGroup) -> u16 {
    match group {
        ReadingGroup::Infrared => INFRARED,
        ReadingGroup::Sonar => SONAR,
        ReadingGroup::Bumper => BUMPER,
        ReadingGroup::Compass => COMPASS,
        ReadingGroup::Laser | ReadingGroup::Segments => LASER,
        ReadingGroup::Pose => CONFIGURATION,
        ReadingGroup::Velocity => VELOCITY,
        ReadingGroup::Acceleration => ACCELERATION,
    }
}

fn group_readings(group: ReadingGroup, state: &NomadReadings) -> Vec<i32> {
    match group {
        ReadingGroup::Infrared => state.infrared.map(i32::from).to_vec(),
        ReadingGroup::Sonar => state.sonar.map(i32::from).to_vec(),
        ReadingGroup::Bumper => vec![state.bumpers as i32],
        ReadingGroup::Compass => vec![state.compass.into()],
        // No points and no lines.
        ReadingGroup::Laser | ReadingGroup::Segments => vec![0],
        ReadingGroup::Pose => state.pose.to_vec(),
        ReadingGroup::Velocity => state.velocity.to_vec(),
        ReadingGroup::Acceleration => state.acceleration.map(i32::from).to_vec(),
    }
}

/// Appends the position data of a group, if the mask selects them.
fn attach_group(out: &mut Vec<i32>, group: ReadingGroup, state: &NomadReadings, mask: &StateMask) {
    let (attached, places): (u8, &[PosData]) = match group {
        ReadingGroup::Infrared => (WITH_INFRARED, &state.infrared_at),
        ReadingGroup::Sonar => (WITH_SONAR, &state.sonar_at),
        ReadingGroup::Bumper => (WITH_BUMPER, &[state.bumpers_at]),
        ReadingGroup::Compass => (WITH_COMPASS, &[state.compass_at]),
        ReadingGroup::Laser | ReadingGroup::Segments => (WITH_LASER, &[state.laser_at]),
        ReadingGroup::Pose | ReadingGroup::Velocity | ReadingGroup::Acceleration => return,
    };
    attach(out, mask.has(attached), places);
}

fn attach(out: &mut Vec<i32>, on: bool, places: &[PosData]) {
    for place in places.iter().filter(|_| on) {
        out.extend(place.pose.iter().chain(&place.velocity));
        out.extend([place.pose_ms as i32, place.sensed_ms as i32]);
    }
}

#[cfg(test)]
mod tests;
