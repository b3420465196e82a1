//! The flags that define an episode: behavior, options, sonars, turret.

use super::robot::RobotArgs;
use super::run::{Preset, SonarChoice, Switch, TourChoice, TurretChoice};
use amp::config::Config;
use arena::sonar::TransducerFault;
use clap::Args;
use files::error::BadInput;
use sim::behavior::Behavior;
use sim::episode::Setup;
use sim::pilot::MAX_MOVES;
use sim::robot::AnyRobot;
use sim::settings;

/// Flags for a robot's behavior and its controller's options.
#[derive(Debug, Clone, Args)]
pub struct TaskArgs {
    /// What to do after exploring: avoid, avoid-right, wall-left, wall-right, nest, home, follow,
    /// seek:FILE (a captured situation), scent:strongest, light:strongest, floor:COLOR, or
    /// scent:before, light:before, floor:before (where it was before that changed), or several of
    /// them one after the other: a,b,c (see `host-sim behaviors`)
    #[arg(long, value_name = "NAME", default_value = "avoid", value_parser = parsed::<Behavior>)]
    pub(super) behavior: Behavior,
    /// Random moves before the behavior
    #[arg(long, value_name = "MOVES", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_MOVES)))]
    pub(super) explore: u16,
    /// Seed of all randomness: the same seed gives the same bytes
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub(super) seed: u64,
    /// Let the sonars limit motion: measures the robot (on) or the maps alone (off)
    #[arg(long, value_name = "ON|OFF", default_value = "on", value_enum)]
    shield: Switch,
    /// Let both maps learn from every move while behaving
    #[arg(long, value_name = "ON|OFF", default_value = "on", value_enum)]
    online: Switch,
    /// Preset of the controller's options: the best found, or the most literal reading of the paper
    #[arg(long, value_name = "NAME", default_value = "default", value_enum)]
    pub(super) preset: Preset,
    /// Change one option, e.g. --set far=1.2 (see `host-sim settings`); may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
}

/// Flags of an episode, apart from its world.
#[derive(Debug, Clone, Args)]
pub struct SetupArgs {
    #[command(flatten)]
    task: TaskArgs,
    /// Sonar model
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// A faulty sonar: dead:N, stuck:N:METERS, scaled:N:SHARE, offset:N:METERS,
    /// jumping:N:PROBABILITY, noisy:N:METERS, delayed:N:FIRINGS, intermittent:N:PROBABILITY,
    /// crosstalk:N:PROBABILITY, swapped:N:M or turned:N:DEGREES, with @SECONDS at the end if it
    /// begins later; may be given several times (see also --set fault-detection=off)
    #[arg(long = "fault", value_name = "KIND:N", value_parser = parsed::<TransducerFault>)]
    faults: Vec<TransducerFault>,
    /// After exploring, a second robot drives around in the world
    #[arg(long)]
    second_robot: bool,
    /// Steps of driving around before the behaviors home, scent:…, light:… and floor:… [default:
    /// 500], or before the robot is set down elsewhere with the behavior nest [default: 0]
    #[arg(long, value_name = "STEPS")]
    tour: Option<u32>,
    /// What leads the robot on that tour: its places, to where it has not been, or nothing, and it
    /// avoids obstacles [default: frontier]
    #[arg(long, value_name = "frontier|avoid", value_enum)]
    tour_by: Option<TourChoice>,
    /// The robot that is set down elsewhere with the behavior nest is turned as well, by a random
    /// angle; not a robot whose bearing is held
    #[arg(long)]
    turned: bool,
    /// Whether a memory of places leads the robot where it comes no nearer to a place by the goal
    /// alone [default: on, for nomad200 off]; on reads the ring of nomad200 through points, as the
    /// sensors of other robots
    #[arg(long, value_name = "on|off", value_enum)]
    places: Option<Switch>,
    #[command(flatten)]
    robot: RobotArgs,
    /// Whether the ring keeps its bearing in the world or turns with the heading [default: held;
    /// follow for the preset touzet]; of a robot behind points only where its drive is synchro
    #[arg(long, value_name = "MODE", value_enum)]
    turret: Option<TurretChoice>,
}

/// Parses a value by its type.
pub(super) fn parsed<T: std::str::FromStr<Err = BadInput>>(text: &str) -> Result<T, BadInput> {
    text.parse()
}

/// Applies the settings of `--set`.
///
/// # Errors
/// An unknown setting or an invalid value.
pub(super) fn configured(
    preset: Preset,
    sets: &[String],
    shield: Switch,
    online: Switch,
) -> Result<Config<16>, BadInput> {
    let mut config = preset.config();
    settings::apply(&mut config, sets)?;
    if shield == Switch::Off {
        config.shield = None;
    }
    if online == Switch::Off {
        config.online = None;
    }
    Ok(config)
}

impl TaskArgs {
    /// The preset with the settings of `--set`, whatever `--shield` and `--online` say.
    ///
    /// # Errors
    /// An unknown setting or an invalid value.
    pub(super) fn whole(&self) -> Result<Config<16>, BadInput> {
        configured(self.preset, &self.sets, Switch::On, Switch::On)
    }

    /// The configuration.
    ///
    /// # Errors
    /// As [`TaskArgs::whole`].
    pub(super) fn config(&self) -> Result<Config<16>, BadInput> {
        configured(self.preset, &self.sets, self.shield, self.online)
    }
}

impl SetupArgs {
    /// The flags for behavior and options.
    pub(super) fn task(&self) -> &TaskArgs {
        &self.task
    }

    /// As [`TaskArgs::whole`].
    ///
    /// # Errors
    /// An unknown setting or an invalid value.
    pub(super) fn whole(&self) -> Result<Config<16>, BadInput> {
        self.task.whole()
    }

    /// The robot, if it is not the Nomad.
    ///
    /// # Errors
    /// An unknown robot or a bad file; a turret for a robot that has none.
    fn robot(&self) -> Result<Option<AnyRobot>, BadInput> {
        let has_guard = self.task.shield == Switch::On;
        let needs_points = self.places == Some(Switch::On) || self.behavior()?.needs_places();
        let moves = self.task.explore;
        let turret = self.turret.map(Into::into);
        let robot = if needs_points {
            Some(self.robot.behind_points(has_guard, moves, turret)?)
        } else {
            self.robot.find(has_guard, moves, turret)?
        };
        let knows_bearing = !robot.as_ref().is_some_and(AnyRobot::heading_drifts);
        if self.turned && knows_bearing {
            return Err(BadInput::new(
                "--turned: the bearing of this robot is held; try --robot p3dx",
            ));
        }
        Ok(robot.map(|robot| robot.led(self.places != Some(Switch::Off))))
    }

    fn behavior(&self) -> Result<Behavior, BadInput> {
        let mut behavior = self.task.behavior.clone();
        match behavior.tour_mut() {
            Some(tour) => {
                tour.steps = self.tour.unwrap_or(tour.steps);
                tour.by = self.tour_by.map_or(tour.by, Into::into);
            }
            None if self.tour.is_some() || self.tour_by.is_some() => {
                return Err(BadInput::new(
                    "--tour and --tour-by: only with --behavior home, nest, scent:…, light:… or \
                     floor:…",
                ));
            }
            None => {}
        }
        if self.turned {
            match &mut behavior {
                Behavior::Nest { is_turned, .. } => *is_turned = true,
                _ => return Err(BadInput::new("--turned: only with --behavior nest")),
            }
        }
        Ok(behavior)
    }

    /// The setup of an episode of one step, without a recording.
    ///
    /// # Errors
    /// As [`TaskArgs::whole`].
    pub(super) fn setup(&self) -> Result<Setup, BadInput> {
        let task = &self.task;
        let robot = self.robot()?;
        let config = task.config()?;
        Ok(Setup {
            config: match &robot {
                None => config,
                Some(robot) => robot.config(config),
            },
            preset: task.preset.name().to_owned(),
            behavior: self.behavior()?,
            explore_moves: task.explore,
            steps: 1,
            seed: task.seed,
            sonar: self.sonar.into(),
            turret: match self.turret {
                None => task.preset.turret(),
                Some(turret) => turret.into(),
            },
            robot,
            set_down: None,
            faults: self.faults.clone(),
            goal: None,
            second_robot: self.second_robot,
            record: false,
        })
    }
}
