//! The content of state packets: the `Smask` of the client library.

use super::bytes::{LengthError, PayloadReader};

/// Bit of [`StateMask::attached`]: position data with infrared readings.
pub const WITH_INFRARED: u8 = 1;
/// With sonar readings.
pub const WITH_SONAR: u8 = 1 << 1;
/// With the bumpers.
pub const WITH_BUMPER: u8 = 1 << 2;
/// With the laser.
pub const WITH_LASER: u8 = 1 << 3;
/// With the compass.
pub const WITH_COMPASS: u8 = 1 << 4;

const WITH_ALL: u8 = 0x1f;

/// Content of a state packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StateMask {
    /// Bit i: infrared sensor i.
    pub infrared: u16,
    /// Bit i: sonar i.
    pub sonar: u16,
    /// The bumpers.
    pub bumper: bool,
    /// x, y, steering, turret.
    pub pose: [bool; 4],
    /// Translation, steering, turret.
    pub velocity: [bool; 3],
    /// The laser.
    pub laser: bool,
    /// The compass.
    pub compass: bool,
    /// Readings with position data: bits [`WITH_INFRARED`] … [`WITH_COMPASS`].
    pub attached: u8,
}

impl StateMask {
    /// Everything without position data, as `init_sensors` requests it.
    pub const ALL: Self = Self {
        infrared: u16::MAX,
        sonar: u16::MAX,
        bumper: true,
        pose: [true; 4],
        velocity: [true; 3],
        laser: true,
        compass: true,
        attached: 0,
    };

    /// Only what is always present: motor status, time, voltages.
    pub const NONE: Self = Self {
        infrared: 0,
        sonar: 0,
        bumper: false,
        pose: [false; 4],
        velocity: [false; 3],
        laser: false,
        compass: false,
        attached: 0,
    };

    /// Whether readings of this kind come with position data.
    #[must_use]
    pub const fn has(&self, attached: u8) -> bool {
        self.attached & attached != 0
    }

    /// Bumper, pose and velocities in one byte.
    fn motion_byte(&self) -> u8 {
        let bits = [self.bumper].into_iter().chain(self.pose);
        let bits = bits.chain(self.velocity).enumerate();
        bits.fold(0, |byte, (place, bit)| byte | u8::from(bit) << place)
    }

    fn set_motion(&mut self, byte: u8) {
        let bit = |place: usize| byte >> place & 1 != 0;
        self.bumper = bit(0);
        self.pose = std::array::from_fn(|i| bit(1 + i));
        self.velocity = std::array::from_fn(|i| bit(5 + i));
    }

    /// The seven bytes of a `ct`. The library has a bug here: it uses the bit of sonar 13 for the
    /// turret's velocity.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; 7] {
        let [ir_low, ir_high] = self.infrared.to_le_bytes();
        let [sonar_low, sonar_high] = self.sonar.to_le_bytes();
        [
            ir_low,
            ir_high,
            sonar_low,
            sonar_high,
            self.motion_byte(),
            u8::from(self.laser),
            u8::from(self.compass) | (self.attached & WITH_ALL) << 1,
        ]
    }

    /// Decodes the seven bytes of a `ct`; unknown bits are ignored.
    #[must_use]
    pub fn from_bytes(bytes: [u8; 7]) -> Self {
        let [ir_low, ir_high, sonar_low, sonar_high, motion, laser, rest] = bytes;
        let mut mask = Self {
            infrared: u16::from_le_bytes([ir_low, ir_high]),
            sonar: u16::from_le_bytes([sonar_low, sonar_high]),
            laser: laser & 1 != 0,
            compass: rest & 1 != 0,
            attached: rest >> 1 & WITH_ALL,
            ..Self::NONE
        };
        mask.set_motion(motion);
        mask
    }
}

/// Laser setup in a [`Greeting`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LaserSetup {
    /// On-board processing; 51 by default.
    pub mode: u8,
    /// Number of points.
    pub points: u16,
    /// Pixels averaged.
    pub processing: u8,
}

impl Default for LaserSetup {
    /// As in the library's example.
    fn default() -> Self {
        Self {
            mode: 51,
            points: 20,
            processing: 4,
        }
    }
}

/// The eleven bytes that a Nomad 200 sends on a TCP connection first: its mask and laser setup.
/// Laser and compass are swapped compared with `ct`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Greeting {
    /// Content of state packets.
    pub mask: StateMask,
    /// The laser.
    pub laser: LaserSetup,
}

impl Greeting {
    /// Length in bytes.
    pub const BYTES: usize = 11;

    /// Encodes the greeting.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let [a, b, c, d, motion, ..] = self.mask.to_bytes();
        let compass = u8::from(self.mask.compass);
        let laser = u8::from(self.mask.laser) | (self.mask.attached & WITH_ALL) << 1;
        let [points_low, points_high] = self.laser.points.to_le_bytes();
        let LaserSetup {
            mode, processing, ..
        } = self.laser;
        [
            a,
            b,
            c,
            d,
            motion,
            compass,
            laser,
            mode,
            points_low,
            points_high,
            processing,
        ]
    }

    /// Decodes a greeting.
    ///
    /// # Errors
    /// When there are not eleven bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, LengthError> {
        let mut reader = PayloadReader::new(bytes);
        let [a, b, c, d, motion, compass, laser] = reader.bytes()?;
        let (mode, points, processing) = (reader.u8()?, reader.u16()?, reader.u8()?);
        reader.end()?;
        let as_ct = [a, b, c, d, motion, laser & 1, compass & 1 | laser & !1];
        Ok(Self {
            mask: StateMask::from_bytes(as_ct),
            laser: LaserSetup {
                mode,
                points,
                processing,
            },
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Any mask.
    pub(in super::super) fn masks() -> impl Strategy<Value = StateMask> {
        any::<[u8; 7]>().prop_map(StateMask::from_bytes)
    }

    #[test]
    fn each_bit_of_a_ct_has_its_place() {
        assert_eq!(
            StateMask::ALL.to_bytes(),
            [0xff, 0xff, 0xff, 0xff, 0xff, 0x01, 0x01]
        );
        let one = StateMask {
            sonar: 1 << 9,
            pose: [false, true, false, false],
            velocity: [false, false, true],
            attached: WITH_SONAR | WITH_COMPASS,
            ..StateMask::NONE
        };
        assert_eq!(one.to_bytes(), [0, 0, 0, 0x02, 0x84, 0, 0x24]);
    }

    #[test]
    fn the_greeting_has_compass_before_laser() {
        let greeting = Greeting {
            mask: StateMask {
                laser: true,
                attached: WITH_INFRARED,
                ..StateMask::NONE
            },
            laser: LaserSetup::default(),
        };
        let bytes = greeting.to_bytes();
        assert_eq!(bytes, [0, 0, 0, 0, 0, 0, 3, 51, 20, 0, 4]);
        assert!(Greeting::from_bytes(&bytes[1..]).is_err());
    }

    proptest! {
        #[test]
        fn masks_come_back(mask in masks(), mode: u8, points: u16, processing: u8) {
            prop_assert_eq!(StateMask::from_bytes(mask.to_bytes()), mask);
            let greeting = Greeting { mask, laser: LaserSetup { mode, points, processing } };
            prop_assert_eq!(Greeting::from_bytes(&greeting.to_bytes()), Ok(greeting));
        }
    }
}
