//! Effect of a faulty transducer on the robot, and the time until its detection.

use amp::config::Config;
use amp::controller::{Event, Outputs, Progress};
use amp::faults::SensorFault;
use amp::units::Millis;
use arena::robot::TurretMode;
use arena::sonar::{FaultKind, SonarModel, TransducerFault};
use arena::world::World;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{Setup, run_with};
use sim::error::EpisodeError;
use sim::pilot::{AgedEcho, InspectableController, LocalController, Pilot, SimState};

/// What all episodes share.
#[derive(Debug, Clone)]
pub struct FaultTrial {
    /// Number of random rooms, at least 1.
    pub rooms: u32,
    /// Seed of the first room; each episode uses the seed of its room.
    pub first: u64,
    /// Random moves before the behavior.
    pub explore_moves: u16,
    /// Steps of obstacle avoidance.
    pub steps: u32,
    /// Sonar model, apart from the fault.
    pub sonar: SonarModel,
    /// Motion of the turret while the base steers.
    pub turret: TurretMode,
    /// The controller's configuration.
    pub config: Config<16>,
    /// Name of the preset behind `config`.
    pub preset: &'static str,
}

/// The faults that have a name, as [`FaultEpisode::false_alarms`] counts them.
pub const FAULTS: [SensorFault; 4] = [
    SensorFault::Dead,
    SensorFault::Stuck,
    SensorFault::Short,
    SensorFault::Jumping,
];

/// Result of one episode.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FaultEpisode {
    /// Moves with contact while the faulty transducer was enabled (all of them without a fault).
    pub contacts_before: u32,
    /// Moves with contact while it was disabled.
    pub contacts_after: u32,
    /// Moves, including random ones, until it was disabled.
    pub noticed: Option<u32>,
    /// Moves until a fault other than [`SensorFault::Unheard`] was reported.
    pub named: Option<u32>,
    /// Number of times it was enabled again.
    pub returns: u32,
    /// Number of times an intact transducer was disabled, by fault: [`FAULTS`] (all except
    /// [`SensorFault::Unheard`]).
    pub false_alarms: [u32; 4],
    /// Number of times an intact transducer was disabled because it had never reported an echo.
    pub unheard: u32,
    /// Area swept, m².
    pub coverage_m2: f64,
    /// Distance traveled, m.
    pub distance_m: f64,
}

/// Applies the same fault to each of the 16 transducers in turn in every room; without a fault,
/// drives each room once. Results are ordered by transducer, then room. `done` is called after
/// each.
///
/// # Errors
/// When an episode fails.
pub fn fault_episodes(
    kind: Option<FaultKind>,
    trial: &FaultTrial,
    done: &(impl Fn() + Sync),
) -> Result<Vec<FaultEpisode>, EpisodeError> {
    let faults: Vec<_> = match kind {
        Some(kind) => (0..16)
            .map(|sensor| {
                let kind = kind.turned(sensor);
                Some(TransducerFault {
                    sensor,
                    kind,
                    since_s: 0.0,
                })
            })
            .collect(),
        None => vec![None],
    };
    let rooms = trial.first..trial.first + u64::from(trial.rooms);
    let each: Vec<_> = faults
        .iter()
        .flat_map(|fault| rooms.clone().map(move |room| (*fault, room)))
        .collect();
    let fault_episodes = each.par_iter().map(|(fault, room)| {
        let course = course(*fault, *room, trial);
        done();
        course
    });
    fault_episodes.collect()
}

fn course(
    fault: Option<TransducerFault>,
    room: u64,
    trial: &FaultTrial,
) -> Result<FaultEpisode, EpisodeError> {
    let world = World::random(room);
    let setup = Setup {
        config: trial.config.clone(),
        preset: trial.preset.to_owned(),
        behavior: Behavior::Avoid,
        explore_moves: trial.explore_moves,
        steps: trial.steps,
        seed: room,
        sonar: trial.sonar,
        turret: trial.turret,
        robot: None,
        set_down: None,
        faults: fault.into_iter().collect(),
        goal: None,
        second_robot: false,
        record: false,
    };
    let mut witness = Witness {
        mind: LocalController::new(setup.config.clone()),
        faulty: fault.map(|fault| fault.sensor as u8),
        course: FaultEpisode::default(),
        moves: 0,
        processed: 0,
        touched: false,
    };
    let report = run_with(&world, &setup, &mut witness, |_, _, _| {})?.report;
    Ok(FaultEpisode {
        coverage_m2: report.coverage_m2,
        distance_m: report.distance_m,
        ..witness.course
    })
}

/// A controller and the events that reach it.
struct Witness {
    mind: LocalController,
    faulty: Option<u8>,
    course: FaultEpisode,
    moves: u32,
    /// Number of verdicts already processed.
    processed: usize,
    /// The current move already has a contact.
    touched: bool,
}

impl Pilot for Witness {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        if let Event::Odometry {
            progress: Progress::Touched,
            ..
        } = event
        {
            self.note_contact();
        }
        let outputs = self.mind.handle(at, event);
        self.note_verdicts();
        if outputs.decision.is_some() {
            self.moves += 1;
            self.touched = false;
        }
        outputs
    }

    fn echoes(&mut self, at: Millis, echoes: &[AgedEcho]) -> (usize, Outputs<16>) {
        let Some(&AgedEcho {
            sensor,
            range,
            age_ms,
        }) = echoes.first()
        else {
            return (0, Outputs::NONE);
        };
        let heard_at = at.minus_ms(age_ms);
        (1, self.handle(heard_at, Event::Echo { sensor, range }))
    }
}

impl InspectableController for Witness {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        self.mind.knowledge()
    }
}

impl Witness {
    fn note_contact(&mut self) {
        if std::mem::replace(&mut self.touched, true) {
            return;
        }
        let believed = |sensor: u8| self.mind.enabled().contains(sensor.into());
        if self.faulty.is_none_or(believed) {
            self.course.contacts_before += 1;
        } else {
            self.course.contacts_after += 1;
        }
    }

    fn note_verdicts(&mut self) {
        let news = self
            .mind
            .verdicts()
            .get(self.processed..)
            .unwrap_or_default();
        for verdict in news {
            let mine = Some(verdict.sensor) == self.faulty;
            let course = &mut self.course;
            let Some(fault) = verdict.fault else {
                course.returns += u32::from(mine);
                continue;
            };
            let place = FAULTS.iter().position(|named| *named == fault);
            if mine {
                course.noticed = course.noticed.or(Some(self.moves));
                course.named = course.named.or(place.map(|_| self.moves));
            } else if let Some(count) = place.and_then(|place| course.false_alarms.get_mut(place)) {
                *count += 1;
            } else {
                course.unheard += 1;
            }
        }
        self.processed += news.len();
    }
}
