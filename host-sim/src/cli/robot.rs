//! The robot and what its controller is told of it, as named on the command line.

use super::setup::parsed;
use arena::robot::TurretMode;
use arena::robot_model::RobotModel;
use clap::Args;
use files::error::BadInput;
use sim::robot::{AnyRobot, Miswiring, Origin, Ranges};

/// The robot with a ring on a turret.
const NOMAD: &str = "nomad200";

/// Flags for the robot, and for what its controller is told of it.
#[derive(Debug, Clone, Args)]
pub(super) struct RobotArgs {
    #[command(flatten)]
    named: NamedRobotArgs,
    #[command(flatten)]
    told: ToldArgs,
}

/// Flags for the robot.
#[derive(Debug, Clone, Args)]
pub(super) struct NamedRobotArgs {
    /// Robot: a built-in name (nomad200, p3dx, p3dx-front, p3at, epuck2, thymio2, khepera,
    /// crazyflie, turtlebot3, lidar16, one-beam) or a .toml FILE (see docs/robots.md); with
    /// --shield on, a guard keeps other robots than nomad200 from everything they have seen
    #[arg(long, value_name = "NAME|FILE", default_value = NOMAD)]
    robot: String,
    /// What another robot than nomad200 has: everything its own, or its layout and drive on the
    /// Nomad's body, with the Nomad's sonars
    #[arg(long, value_name = "own|nomad", default_value = "own", value_parser = parsed::<Ranges>)]
    ranges: Ranges,
}

/// What the controller of another robot than the Nomad is told.
#[derive(Debug, Clone, Args)]
pub(super) struct ToldArgs {
    /// Whether another robot than nomad200 is told where its sensors look, or learns that from its
    /// random moves
    #[arg(long, value_name = "known|learned", default_value = "known", value_parser = parsed::<Origin>)]
    geometry: Origin,
    /// Whether it is told what its commands do and its odometry means, or learns that as well
    #[arg(long, value_name = "known|learned", default_value = "known", value_parser = parsed::<Origin>)]
    actuators: Origin,
    /// Permute the wires of its sensors; the controller is not told
    #[arg(long, value_name = "SEED")]
    scramble: Option<u64>,
    /// Turn, mirror and scale its commands and its odometry; the controller is not told
    #[arg(long, value_name = "SEED")]
    miswire: Option<u64>,
    /// Share of its radius that it is told, 0.3 to 1.5; with --shield on it learns the rest from
    /// contacts
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, value_parser = radius_share)]
    told_radius: f64,
}

fn radius_share(text: &str) -> Result<f64, String> {
    let share = text
        .parse()
        .ok()
        .filter(|share| (0.3..=1.5).contains(share));
    share.ok_or_else(|| "not from 0.3 to 1.5".to_owned())
}

impl RobotArgs {
    /// The robot behind points, the Nomad as well, with a guard or without, for so many random
    /// moves.
    ///
    /// # Errors
    /// An unknown robot or a bad file; a turret for a robot that has none; what cannot be learned;
    /// too few random moves.
    pub(super) fn behind_points(
        &self,
        has_guard: bool,
        moves: u16,
        turret: Option<TurretMode>,
    ) -> Result<AnyRobot, BadInput> {
        let robot = self.named.behind_points(has_guard)?;
        self.told.apply(with_turret(robot, turret)?, moves)
    }

    /// The robot, with a guard or without, for so many random moves; `None` = the Nomad as it is.
    ///
    /// # Errors
    /// As [`behind_points`](Self::behind_points), and what only other robots have.
    pub(super) fn find(
        &self,
        has_guard: bool,
        moves: u16,
        turret: Option<TurretMode>,
    ) -> Result<Option<AnyRobot>, BadInput> {
        match (self.named.find(has_guard)?, self.told.first_used()) {
            (Some(robot), _) => {
                let robot = with_turret(robot, turret)?;
                self.told.apply(robot, moves).map(Some)
            }
            (None, None) => Ok(None),
            (None, Some(flag)) => Err(BadInput::new(format!(
                "--{flag}: only with another robot than {NOMAD}"
            ))),
        }
    }
}

/// The robot, its turret as asked for.
fn with_turret(robot: AnyRobot, turret: Option<TurretMode>) -> Result<AnyRobot, BadInput> {
    match turret {
        Some(turret) => robot.with_turret(turret),
        None => Ok(robot),
    }
}

impl NamedRobotArgs {
    /// These flags again, each after a space; none for the Nomad as it is.
    pub(super) fn flags(&self) -> String {
        let name = &self.robot;
        match self.ranges {
            Ranges::Own if name == NOMAD => String::new(),
            Ranges::Own => format!(" --robot {name}"),
            Ranges::Nomad => format!(" --robot {name} --ranges nomad"),
        }
    }

    /// The robot, with a guard or without; `None` = the Nomad as it is.
    ///
    /// # Errors
    /// An unknown robot or a bad file.
    pub(super) fn find(&self, has_guard: bool) -> Result<Option<AnyRobot>, BadInput> {
        if self.robot == NOMAD && self.ranges == Ranges::Own {
            return Ok(None);
        }
        self.behind_points(has_guard).map(Some)
    }

    /// The robot behind points, the Nomad as well.
    ///
    /// # Errors
    /// An unknown robot or a bad file.
    pub(super) fn behind_points(&self, has_guard: bool) -> Result<AnyRobot, BadInput> {
        AnyRobot::new(RobotModel::find(&self.robot)?, self.ranges, has_guard)
    }

    /// As [`find`](Self::find), for methods whose distances are the Nomad's.
    ///
    /// # Errors
    /// As [`find`](Self::find), and another robot with its own ranges.
    pub(super) fn find_on_nomad(&self, has_guard: bool) -> Result<Option<AnyRobot>, BadInput> {
        if self.robot != NOMAD && self.ranges == Ranges::Own {
            return Err(BadInput::new(format!(
                "--robot {}: needs --ranges nomad, the other methods keep the Nomad's distances",
                self.robot
            )));
        }
        self.find(has_guard)
    }
}

impl ToldArgs {
    /// The geometry.
    pub(super) fn geometry(&self) -> Origin {
        self.geometry
    }

    /// The robot, wired and told as the flags say, for so many random moves.
    ///
    /// # Errors
    /// What cannot be learned; too few random moves.
    pub(super) fn apply(&self, robot: AnyRobot, moves: u16) -> Result<AnyRobot, BadInput> {
        let mut robot = robot
            .with_geometry(self.geometry)?
            .with_actuators(self.actuators)?
            .with_told_radius(self.told_radius);
        robot.check_moves(moves)?;
        if let Some(seed) = self.scramble {
            robot = robot.scrambled(seed);
        }
        if let Some(seed) = self.miswire {
            robot = robot.miswired(Miswiring::of_seed(seed));
        }
        Ok(robot)
    }

    fn first_used(&self) -> Option<&'static str> {
        let flags = [
            ("scramble", self.scramble.is_some()),
            ("miswire", self.miswire.is_some()),
            ("told-radius", self.told_radius != 1.0),
            ("geometry", self.geometry == Origin::Learned),
            ("actuators", self.actuators == Origin::Learned),
        ];
        let used = flags.into_iter().find(|(_, is_used)| *is_used);
        used.map(|(flag, _)| flag)
    }
}
