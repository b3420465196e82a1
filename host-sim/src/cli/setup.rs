//! The flags that say what an episode is made of.

use super::run::{Preset, SonarChoice, Switch, TurretChoice};
use amp::config::Config;
use arena::robot::TurretMode;
use arena::sonar::TransducerFault;
use clap::Args;
use files::error::BadInput;
use sim::behavior::Behavior;
use sim::episode::Setup;
use sim::pilot::MAX_MOVES;
use sim::settings;

/// What a robot is to do, and the open choices of its mind.
#[derive(Debug, Clone, Args)]
pub struct TaskArgs {
    /// What to do after exploring: avoid, avoid-right, wall-left, wall-right, nest, follow, seek:FILE (a
    /// captured situation), or several of them one after the other: a,b,c (see `host-sim behaviors`)
    #[arg(long, value_name = "NAME", default_value = "avoid", value_parser = parsed::<Behavior>)]
    pub(super) behavior: Behavior,
    /// Random moves before it
    #[arg(long, value_name = "MOVES", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_MOVES)))]
    pub(super) explore: u16,
    /// Seed of all randomness: the same seed gives the same bytes
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub(super) seed: u64,
    /// Let the sonars limit motion: what the robot does (on) or what the maps alone do (off)
    #[arg(long, value_name = "ON|OFF", default_value = "on", value_enum)]
    shield: Switch,
    /// Let both maps go on learning from every move
    #[arg(long, value_name = "ON|OFF", default_value = "on", value_enum)]
    online: Switch,
    /// The open choices of the method: the best found, or the most literal reading of the paper
    #[arg(long, value_name = "NAME", default_value = "default", value_enum)]
    pub(super) preset: Preset,
    /// Change one open choice, e.g. --set far=1.2 (see `host-sim settings`); may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
}

/// What an episode is made of, but for its world.
#[derive(Debug, Clone, Args)]
pub struct SetupArgs {
    #[command(flatten)]
    task: TaskArgs,
    /// What the sonars return
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// A sonar that is out of order: dead:N, stuck:N:METERS, scaled:N:SHARE, offset:N:METERS, jumping:N:PROBABILITY,
    /// noisy:N:METERS, delayed:N:FIRINGS, intermittent:N:PROBABILITY, crosstalk:N:PROBABILITY or swapped:N:M; may be
    /// given several times (see also --set fault-detection=off)
    #[arg(long = "fault", value_name = "KIND:N", value_parser = parsed::<TransducerFault>)]
    faults: Vec<TransducerFault>,
    /// Whether the ring keeps its bearing in the world or turns with the heading
    /// [default: held; follow for the preset touzet]
    #[arg(long, value_name = "MODE", value_enum)]
    turret: Option<TurretChoice>,
}

/// Reads a value as its type does.
pub(super) fn parsed<T: std::str::FromStr<Err = BadInput>>(text: &str) -> Result<T, BadInput> {
    text.parse()
}

/// The choices as the flags change them.
///
/// # Errors
/// A setting that is unknown or takes another value.
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
    /// The preset with what was set, as if shield and learning while behaving were on.
    ///
    /// # Errors
    /// A setting that is unknown or takes another value.
    pub(super) fn whole(&self) -> Result<Config<16>, BadInput> {
        configured(self.preset, &self.sets, Switch::On, Switch::On)
    }

    /// The open choices.
    ///
    /// # Errors
    /// Like [`TaskArgs::whole`].
    pub(super) fn config(&self) -> Result<Config<16>, BadInput> {
        configured(self.preset, &self.sets, self.shield, self.online)
    }
}

impl SetupArgs {
    /// What a robot is to do.
    pub(super) fn task(&self) -> &TaskArgs {
        &self.task
    }

    /// Like [`TaskArgs::whole`].
    ///
    /// # Errors
    /// As there.
    pub(super) fn whole(&self) -> Result<Config<16>, BadInput> {
        self.task.whole()
    }

    /// The setup of one step, not recorded.
    ///
    /// # Errors
    /// Like [`TaskArgs::whole`].
    pub(super) fn setup(&self) -> Result<Setup, BadInput> {
        let task = &self.task;
        Ok(Setup {
            config: task.config()?,
            preset: task.preset.name().to_owned(),
            behavior: task.behavior.clone(),
            explore_moves: task.explore,
            steps: 1,
            seed: task.seed,
            sonar: self.sonar.into(),
            turret: match self.turret {
                None => task.preset.turret(),
                Some(TurretChoice::Held) => TurretMode::Held,
                Some(TurretChoice::Follow) => TurretMode::Follow,
            },
            set_down: None,
            faults: self.faults.clone(),
            record: false,
        })
    }
}
