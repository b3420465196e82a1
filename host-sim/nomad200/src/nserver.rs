//! The protocol of the original simulator's server: what programs linked with `Nclient` speak (TCP 7019).
//!
//! A message is `type(u16) size(u16) size × i32`, all big-endian; a request is answered with one. Without any mark between
//! messages nothing can be found again once it is lost. The state is always whole: the 45 numbers of the library's `State`, the number
//! of laser points (none), position data for all sensors of the kinds the mask asks for, time, two voltages.
//!
//! Facts from `Nclient.c` 2.7 (Nomadic Technologies, as kept in Player).

use super::{
    AxisMode, Command, Group, Kind, Mask, PosData, State, WITH_BUMPER, WITH_COMPASS, WITH_INFRARED,
    WITH_LASER, WITH_SONAR,
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

/// The error number of what is not known or not simulated. What numbers the original had is not known.
const NOT_KNOWN: i32 = 1;

/// Bytes before the numbers.
const HEAD: usize = 4;

/// A message, either way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Its type.
    pub kind: u16,
    /// Its numbers.
    pub numbers: Vec<i32>,
}

impl Message {
    /// The bytes on the line. Numbers beyond the 65 535th have no place.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let most = usize::from(u16::MAX);
        let numbers = self.numbers.get(..most).unwrap_or(&self.numbers);
        let mut bytes = self.kind.to_be_bytes().to_vec();
        // At most 65 535 by the line above.
        bytes.extend((numbers.len() as u16).to_be_bytes());
        bytes.extend(numbers.iter().flat_map(|number| number.to_be_bytes()));
        bytes
    }

    /// Takes a whole message off the front of `bytes`, if there is one.
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

/// What a message asks for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Request {
    /// Something the robot itself does.
    Robot(Command),
    /// To be given the robot, `connect_robot` and `create_robot`: answered with the port it is at.
    Connect,
    /// Nothing more; not answered.
    Disconnect,
    /// `place_robot`: x, y, steering, turret. There is no other robot to place than the one that counts its wheels: as on
    /// the machine, `dp` and `da`.
    Place([i16; 4]),
    /// Where the robot is.
    Where,
    /// To draw, to talk, to be real: done without doing anything.
    Nothing,
    /// What is not known or not simulated.
    Unknown,
}

impl Request {
    /// What `message` asks for.
    #[must_use]
    pub fn of(message: &Message) -> Self {
        let numbers = Numbers(&message.numbers);
        numbers.request(message.kind).unwrap_or(Self::Unknown)
    }
}

/// The numbers of a request, as narrower ones.
struct Numbers<'m>(&'m [i32]);

impl Numbers<'_> {
    /// All of them, if there are N; each the nearest that fits.
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
            60..=62 | 71 | 72 | 74 | 150..=159 | 19 => Request::Nothing,
            101 | 102 => Request::Connect,
            103 => Request::Disconnect,
            200 => Request::Where,
            _ => Request::Robot(self.command(kind)?),
        })
    }

    fn command(&self, kind: u16) -> Option<Command> {
        Some(match kind {
            10 => Command::Accelerations(self.all()?),
            11 => Command::Speeds(self.all()?),
            12 => Command::Velocity(self.all()?),
            13 => Command::Relative(self.all()?),
            14 => Command::Absolute(self.all()?),
            15 => Command::GetState,
            16 => Command::Communicate(mask(self.all()?)),
            17 => Command::Stop,
            18 => Command::Limp,
            20 => Command::Zero,
            21 => Command::DefinePosition(self.all()?),
            22 => {
                let (history, order) = self.sensors()?;
                Command::ConfigureInfrared { history, order }
            }
            23 => {
                let (rate, order) = self.sensors()?;
                Command::ConfigureSonar { rate, order }
            }
            24 => {
                let [mode] = self.all()?;
                Command::ConfigureCompass(mode)
            }
            26 => {
                let [seconds] = self.all()?;
                Command::ConfigureTimeout(seconds)
            }
            27 => Command::Get(Group::Infrared),
            28 => Command::Get(Group::Sonar),
            29 => Command::Get(Group::Pose),
            30 => Command::Get(Group::Velocity),
            31 => Command::Get(Group::Acceleration),
            32 => Command::Get(Group::Compass),
            33 => Command::Get(Group::Laser),
            35 => Command::Get(Group::Bumper),
            37 => Command::Get(Group::Segments),
            38 => Command::DefineAngles(self.all()?),
            39 => {
                let [translation, steering, turret, timeout_s] = self.all::<4, u8>()?;
                Command::WaitForStop {
                    axes: [translation, steering, turret].map(|flag| flag != 0),
                    timeout_s,
                }
            }
            43 => {
                let [t, t_value, s, s_value, r, r_value] = self.all::<6, i16>()?;
                let mode = |number: i16| AxisMode::of(u16::try_from(number).ok()?);
                Command::Move([
                    (mode(t)?, t_value),
                    (mode(s)?, s_value),
                    (mode(r)?, r_value),
                ])
            }
            _ => return None,
        })
    }
}

/// A narrower number, the nearest to a wider one.
trait Narrow {
    fn narrow(number: i32) -> Self;
}

impl Narrow for i16 {
    fn narrow(number: i32) -> Self {
        // In range by the clamp.
        number.clamp(-i32::from(Self::MAX), Self::MAX.into()) as Self
    }
}

impl Narrow for u16 {
    fn narrow(number: i32) -> Self {
        // In range by the clamp.
        number.clamp(0, Self::MAX.into()) as Self
    }
}

impl Narrow for u8 {
    fn narrow(number: i32) -> Self {
        // In range by the clamp.
        number.clamp(0, Self::MAX.into()) as Self
    }
}

/// The seven bytes of this `ct`: laser and compass in the sixth, the position bits in the seventh.
fn mask(bytes: [u8; 7]) -> Mask {
    let [a, b, c, d, motion, rest, attached] = bytes;
    let (laser, compass) = (rest >> 2 & 1, rest >> 3 & 1);
    Mask::from_bytes([a, b, c, d, motion, laser, compass | attached << 1])
}

/// The answer to a command that the robot has answered with a packet of `kind` (or NAK); `speed` is how many times real time it
/// lives.
#[must_use]
pub fn answer(kind: u8, state: &State, mask: &Mask, speed: u32) -> Message {
    match Kind::from_byte(kind) {
        Some(Kind::Nak) | None => Message {
            kind: ERROR,
            numbers: vec![NOT_KNOWN],
        },
        Some(kind) => match Group::of(kind) {
            Some(group) => group_message(group, state, mask),
            None => state_message(state, mask, speed),
        },
    }
}

/// The answer to a request that concerns no robot, if it takes one.
#[must_use]
pub fn answer_else(request: &Request, state: &State, port: u16) -> Option<Message> {
    let (kind, numbers) = match request {
        Request::Connect => (REPLY, vec![i32::from(port)]),
        Request::Where => (CONFIGURATION, state.pose.to_vec()),
        Request::Place(_) | Request::Nothing => (REPLY, Vec::new()),
        Request::Unknown => (ERROR, vec![NOT_KNOWN]),
        Request::Disconnect | Request::Robot(_) => return None,
    };
    Some(Message { kind, numbers })
}

fn state_message(state: &State, mask: &Mask, speed: u32) -> Message {
    // 10 = real time; at most 10 000.
    let mut numbers = vec![(speed * 10) as i32];
    numbers.extend(state.infrared.map(i32::from));
    numbers.extend(state.sonar.map(i32::from));
    // 24 bits.
    numbers.push(state.bumpers as i32);
    numbers.extend(state.pose);
    numbers.extend(state.velocity);
    // Motors; the laser's mode, the compass, no error, no laser points.
    numbers.extend([i32::from(state.motors), 0, state.compass.into(), 0, 0]);
    attach(&mut numbers, mask.has(WITH_INFRARED), &state.infrared_at);
    attach(&mut numbers, mask.has(WITH_SONAR), &state.sonar_at);
    attach(&mut numbers, mask.has(WITH_BUMPER), &[state.bumpers_at]);
    attach(&mut numbers, mask.has(WITH_LASER), &[state.laser_at]);
    attach(&mut numbers, mask.has(WITH_COMPASS), &[state.compass_at]);
    numbers.push(state.time_ms as i32);
    numbers.extend([state.cpu_voltage, state.motor_voltage].map(i32::from));
    Message {
        kind: STATE,
        numbers,
    }
}

fn group_message(group: Group, state: &State, mask: &Mask) -> Message {
    let mut numbers: Vec<i32> = Vec::new();
    let out = &mut numbers;
    let kind = match group {
        Group::Infrared => {
            out.extend(state.infrared.map(i32::from));
            attach(out, mask.has(WITH_INFRARED), &state.infrared_at);
            INFRARED
        }
        Group::Sonar => {
            out.extend(state.sonar.map(i32::from));
            attach(out, mask.has(WITH_SONAR), &state.sonar_at);
            SONAR
        }
        Group::Bumper => {
            out.push(state.bumpers as i32);
            attach(out, mask.has(WITH_BUMPER), &[state.bumpers_at]);
            BUMPER
        }
        Group::Compass => {
            out.push(state.compass.into());
            attach(out, mask.has(WITH_COMPASS), &[state.compass_at]);
            COMPASS
        }
        // No points and no lines.
        Group::Laser | Group::Segments => {
            out.push(0);
            attach(out, mask.has(WITH_LASER), &[state.laser_at]);
            LASER
        }
        Group::Pose => {
            out.extend(state.pose);
            CONFIGURATION
        }
        Group::Velocity => {
            out.extend(state.velocity);
            VELOCITY
        }
        Group::Acceleration => {
            out.extend(state.acceleration.map(i32::from));
            ACCELERATION
        }
    };
    if !matches!(group, Group::Pose | Group::Velocity | Group::Acceleration) {
        out.push(state.time_ms as i32);
    }
    Message { kind, numbers }
}

fn attach(out: &mut Vec<i32>, on: bool, places: &[PosData]) {
    for place in places.iter().filter(|_| on) {
        out.extend(place.pose.iter().chain(&place.velocity));
        out.extend([place.pose_ms as i32, place.sensed_ms as i32]);
    }
}

#[cfg(test)]
mod tests;
