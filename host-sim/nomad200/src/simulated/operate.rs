//! Executes the commands of a host.

use super::{PendingAnswer, SimulatedNomad};
use crate::firing::FiringSchedule;
use crate::units::{M_PER_TENTH_INCH, PER_UNIT, RAD_PER_TENTH_DEGREE};
use crate::{AxisMode, Kind, NomadCommand, Packet, ReadingGroup};
use arena::robot::Axis;
use arena::world::{Point, wrap_angle};

/// Limit of the infrared history, tenths.
const MAX_HISTORY: u8 = 10;

/// Conversion of seconds.
const MS_PER_S: u32 = 1_000;

impl SimulatedNomad {
    /// Executes a command. Returns the answer, unless it waits for the motors: then
    /// [`answer`](Self::answer) returns it later. A new command cancels a delayed answer.
    ///
    /// Torques and packets with an unknown payload are answered with NAK.
    pub fn execute(&mut self, command: &NomadCommand) -> Option<Packet> {
        self.last_command_ms = self.time_ms();
        self.pending = None;
        if is_motion(command) {
            self.zeroing = false;
        }
        match command {
            NomadCommand::Move(axes) if axes.iter().any(|(mode, _)| is_torque(*mode)) => {
                return Some(nak());
            }
            NomadCommand::Opaque(..) => return Some(nak()),
            NomadCommand::Zero => {
                self.begin_zeroing();
                return None;
            }
            NomadCommand::WaitForStop { axes, timeout_s } => {
                return self.wait_for_stop(*axes, *timeout_s);
            }
            NomadCommand::Get(group) => return Some(self.group_packet(*group)),
            NomadCommand::ConfigureCompass(mode) => return Some(self.configure_compass(*mode)),
            _ if is_motion(command) => self.begin_motion(command),
            _ => self.configure(command),
        }
        Some(self.state_packet(command.kind()))
    }

    fn begin_motion(&mut self, command: &NomadCommand) {
        match command {
            NomadCommand::Velocity(wanted) => self.for_each_axis(*wanted, Self::run),
            NomadCommand::Relative(wanted) => self.for_each_axis(*wanted, Self::move_by),
            NomadCommand::Absolute(wanted) => self.for_each_axis(*wanted, Self::move_to),
            NomadCommand::Move(axes) => {
                for (axis, (mode, value)) in Axis::ALL.into_iter().zip(*axes) {
                    self.move_axis(axis, mode, value);
                }
            }
            // `st` and `lp`: limp and holding motors stop the body alike.
            _ => self.hold(),
        }
    }

    fn wait_for_stop(&mut self, axes: [bool; 3], timeout_s: u8) -> Option<Packet> {
        let timeout_ms = u32::from(timeout_s) * MS_PER_S;
        self.pending = Some(PendingAnswer {
            kind: Kind::Ws,
            axes,
            until_ms: Some(self.time_ms().wrapping_add(timeout_ms)),
        });
        self.answer()
    }

    /// The answer has three values of a calibration, which is not simulated.
    fn configure_compass(&mut self, mode: u8) -> Packet {
        self.compass_on = mode == 1;
        Packet::new(Kind::ConfCp, vec![0; 3])
    }

    fn configure(&mut self, command: &NomadCommand) {
        match command {
            NomadCommand::Speeds(speeds) => {
                self.for_each_axis(*speeds, |robot, axis, speed| {
                    robot.set_speed(axis, f64::from(speed));
                });
            }
            NomadCommand::Accelerations(accelerations) => {
                self.for_each_axis(*accelerations, |robot, axis, acceleration| {
                    robot.set_acceleration(axis, f64::from(acceleration));
                });
            }
            NomadCommand::Communicate(mask) => self.mask = *mask,
            NomadCommand::DefinePosition([x, y]) => {
                let position = Point::new(f64::from(*x), f64::from(*y)) * M_PER_TENTH_INCH;
                self.reckoning.define_position(position);
            }
            NomadCommand::DefineAngles(angles) => {
                let angles = angles.map(|angle| f64::from(angle) * RAD_PER_TENTH_DEGREE);
                let axes = [self.axes.at(Axis::Steering), self.axes.at(Axis::Turret)];
                self.reckoning.define_angles(axes, angles);
            }
            NomadCommand::ConfigureSonar { rate, order } => {
                self.firing = FiringSchedule::new(*rate, *order, self.time_ms());
            }
            NomadCommand::ConfigureInfrared { history, order } => {
                self.history = (*history).min(MAX_HISTORY);
                let listed = order.iter().take_while(|&&sensor| sensor < 16);
                self.infrared_on = listed.fold(0, |on, sensor| on | 1 << sensor);
            }
            NomadCommand::ConfigureTimeout(seconds) => self.timeout_s = *seconds,
            // There is no laser, speech or second port.
            _ => {}
        }
    }

    fn for_each_axis<T>(&mut self, values: [T; 3], set: fn(&mut Self, Axis, T)) {
        for (axis, value) in Axis::ALL.into_iter().zip(values) {
            set(self, axis, value);
        }
    }

    fn move_axis(&mut self, axis: Axis, mode: AxisMode, value: i16) {
        match mode {
            AxisMode::Velocity => self.run(axis, value),
            AxisMode::Relative => self.move_by(axis, value),
            AxisMode::Absolute => self.move_to(axis, value),
            AxisMode::Limp => self.axes.hold(axis),
            AxisMode::Acceleration => self.set_acceleration(axis, f64::from(value.max(0))),
            AxisMode::Speed => self.set_speed(axis, f64::from(value.max(0))),
            AxisMode::Ignore | AxisMode::Torque | AxisMode::MaxTorque => {}
        }
    }

    fn run(&mut self, axis: Axis, velocity: i16) {
        let velocity = f64::from(velocity) * PER_UNIT[axis as usize];
        self.axes.run(axis, velocity, &mut self.noise);
    }

    fn move_by(&mut self, axis: Axis, amount: i16) {
        let goal = self.axes.at(axis) + f64::from(amount) * PER_UNIT[axis as usize];
        if amount == 0 {
            self.axes.hold(axis);
        } else {
            self.axes.go_to(axis, goal, &mut self.noise);
        }
    }

    /// Steering and turret take the smaller turn to the reported angle. Translation goes to the
    /// distance rolled since the start; the library says only "absolute position".
    fn move_to(&mut self, axis: Axis, position: i16) {
        let (at, wanted) = (
            self.axes.at(axis),
            f64::from(position) * PER_UNIT[axis as usize],
        );
        let goal = match axis {
            Axis::Translation => wanted,
            Axis::Steering => at + self.reckoning.off(0, at, wanted),
            Axis::Turret => at + self.reckoning.off(1, at, wanted),
        };
        self.axes.go_to(axis, goal, &mut self.noise);
    }

    fn set_speed(&mut self, axis: Axis, units: f64) {
        self.axes.set_speed(axis, units * PER_UNIT[axis as usize]);
    }

    fn set_acceleration(&mut self, axis: Axis, units: f64) {
        let acceleration = units * PER_UNIT[axis as usize];
        self.axes.set_acceleration(axis, acceleration);
    }

    /// Turns steering and turret to the base's front by the smaller turn.
    fn begin_zeroing(&mut self) {
        self.zeroing = true;
        self.axes.hold(Axis::Translation);
        for axis in [Axis::Steering, Axis::Turret] {
            let at = self.axes.at(axis);
            let goal = at - wrap_angle(at);
            self.axes.go_to(axis, goal, &mut self.noise);
        }
        self.pending = Some(PendingAnswer {
            kind: Kind::Zr,
            axes: [true; 3],
            until_ms: None,
        });
    }

    /// Sets all angles to zero once all axes stand.
    pub(super) fn finish_zeroing(&mut self) {
        if Axis::ALL.into_iter().any(|axis| self.axes.is_active(axis)) {
            return;
        }
        self.zeroing = false;
        let axes = [self.axes.at(Axis::Steering), self.axes.at(Axis::Turret)];
        self.reckoning.define_position(Point::default());
        self.reckoning.define_angles(axes, [0.0; 2]);
    }

    fn group_packet(&mut self, group: ReadingGroup) -> Packet {
        self.read_now();
        Packet::new(group.kind(), self.state.to_group(group, &self.mask))
    }
}

/// The answer to an unknown command.
pub(in super::super) fn nak() -> Packet {
    Packet::new(Kind::Nak, Vec::new())
}

fn is_torque(mode: AxisMode) -> bool {
    matches!(mode, AxisMode::Torque | AxisMode::MaxTorque)
}

fn is_motion(command: &NomadCommand) -> bool {
    matches!(
        command,
        NomadCommand::Velocity(_)
            | NomadCommand::Relative(_)
            | NomadCommand::Absolute(_)
            | NomadCommand::Move(_)
            | NomadCommand::Stop
            | NomadCommand::Limp
    )
}
