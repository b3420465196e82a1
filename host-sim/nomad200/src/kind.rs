//! Packet types of the Nomad's protocol, with the names and numbers of its client library (Ndirect
//! 2.6).

/// Defines the enumeration and the conversion from a byte together, so neither can miss a type.
macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident = $number:literal,)*) => {
        /// Type of a packet.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum Kind {
            $($(#[$doc])* $name = $number,)*
        }

        impl Kind {
            /// Every type.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];

            /// The type with this number.
            #[must_use]
            pub const fn from_byte(byte: u8) -> Option<Self> {
                match byte {
                    $($number => Some(Self::$name),)*
                    _ => None,
                }
            }
        }
    };
}

kinds! {
    /// `ac`: accelerations.
    Ac = 1,
    /// `sp`: speeds of position moves.
    Sp = 2,
    /// `pr`: relative move.
    Pr = 3,
    /// `pa`: absolute move.
    Pa = 4,
    /// `vm`: velocities.
    Vm = 5,
    /// `ct`: which data the robot sends.
    Ct = 6,
    /// `gs`: the state.
    Gs = 7,
    /// Not acknowledged.
    Nak = 8,
    /// `st`: stop and hold.
    St = 9,
    /// `lp`: motors off.
    Lp = 10,
    /// `tk`: talk.
    Tk = 11,
    /// `dp`: define the position.
    Dp = 12,
    /// `zr`: zero.
    Zr = 13,
    /// `conf_ir`: infrared sensors.
    ConfIr = 14,
    /// `conf_sn`: sonars.
    ConfSn = 15,
    /// `conf_cp`: compass.
    ConfCp = 16,
    /// `conf_ls`: laser.
    ConfLs = 17,
    /// `conf_tm`: time-out of motions.
    ConfTm = 18,
    /// `get_ir`.
    GetIr = 19,
    /// `get_sn`.
    GetSn = 20,
    /// `get_rc`: pose.
    GetRc = 21,
    /// `get_rv`: velocities.
    GetRv = 22,
    /// `get_ra`: accelerations.
    GetRa = 23,
    /// `get_cp`: compass.
    GetCp = 24,
    /// `get_ls`: laser.
    GetLs = 25,
    /// Laser setup.
    SetupLs = 26,
    /// `get_bp`: bumpers.
    GetBp = 27,
    /// `conf_sg`: laser line segments.
    ConfSg = 28,
    /// `get_sg`: laser line segments.
    GetSg = 29,
    /// `da`: define the angles.
    Da = 30,
    /// `ws`: wait for the motors to stop.
    Ws = 31,
    /// Adds an obstacle in the simulator.
    AddObs = 32,
    /// Deletes an obstacle.
    DeleteObs = 33,
    /// Moves an obstacle.
    MoveObs = 34,
    /// Serial port of a Scout.
    ConfSer = 35,
    /// Places the simulated robot.
    PlaceRobot = 36,
    /// `mv`: each axis in its own mode.
    Mv = 43,
    /// User packet.
    Special = 128,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_leads_back_to_its_type() {
        for &kind in Kind::ALL {
            assert_eq!(Kind::from_byte(kind as u8), Some(kind));
        }
        assert_eq!(Kind::ALL.len(), 38);
        assert_eq!(Kind::from_byte(0), None);
        assert_eq!(Kind::from_byte(42), None);
    }
}
