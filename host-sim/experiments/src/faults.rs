//! What a transducer that is out of order does to the robot, and how soon the robot notices.

use amp::config::Config;
use amp::controller::{Event, Outputs, Progress};
use amp::faults::Fault;
use amp::units::Millis;
use arena::robot::TurretMode;
use arena::sonar::{FaultKind, SonarModel, TransducerFault};
use arena::world::World;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{Setup, run_with};
use sim::error::EpisodeError;
use sim::pilot::{HeardEcho, InspectableController, LocalController, Pilot, SimState};

/// What is the same for every episode.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Random rooms, at least 1.
    pub rooms: u32,
    /// Seed of the first room; each episode has its room's.
    pub first: u64,
    /// Random moves before the behavior.
    pub explore_moves: u16,
    /// Steps of obstacle avoidance.
    pub steps: u32,
    /// What the sonars return, but for the fault.
    pub sonar: SonarModel,
    /// What the ring does while the base steers.
    pub turret: TurretMode,
    /// The mind's open choices.
    pub config: Config<16>,
    /// Name of the preset they came from.
    pub preset: &'static str,
}

/// The faults that have a name, as [`Course::false_alarms`] counts them.
pub const FAULTS: [Fault; 4] = [Fault::Dead, Fault::Stuck, Fault::Short, Fault::Jumping];

/// What came of one episode.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Course {
    /// Moves that touched something while the faulty transducer was believed (all of them, where there is none).
    pub contacts_before: u32,
    /// Moves that touched something while it was not.
    pub contacts_after: u32,
    /// Moves, random ones included, until it was no longer believed.
    pub noticed: Option<u32>,
    /// Moves until its fault had a name: as before, but for [`Fault::Unheard`].
    pub named: Option<u32>,
    /// Times it was believed again.
    pub returns: u32,
    /// Times a transducer in good order was disbelieved, by fault: [`FAULTS`]; but not because it had never been heard.
    pub false_alarms: [u32; 4],
    /// Times a transducer in good order was not believed because it had never been heard.
    pub unheard: u32,
    /// Area swept, m².
    pub coverage_m2: f64,
    /// Way traveled, m.
    pub distance_m: f64,
}

/// Lets the same fault befall each of the 16 transducers in turn in every room; without a fault, each room once. The
/// courses come by transducer, then by room; `done` is called after each.
///
/// # Errors
/// When an episode fails.
pub fn courses(
    kind: Option<FaultKind>,
    trial: &Trial,
    done: &(impl Fn() + Sync),
) -> Result<Vec<Course>, EpisodeError> {
    let faults: Vec<_> = match kind {
        Some(kind) => (0..16)
            .map(|sensor| {
                let kind = kind.turned(sensor);
                Some(TransducerFault { sensor, kind })
            })
            .collect(),
        None => vec![None],
    };
    let rooms = trial.first..trial.first + u64::from(trial.rooms);
    let each: Vec<_> = faults
        .iter()
        .flat_map(|fault| rooms.clone().map(move |room| (*fault, room)))
        .collect();
    let courses = each.par_iter().map(|(fault, room)| {
        let course = course(*fault, *room, trial);
        done();
        course
    });
    courses.collect()
}

fn course(
    fault: Option<TransducerFault>,
    room: u64,
    trial: &Trial,
) -> Result<Course, EpisodeError> {
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
        set_down: None,
        faults: fault.into_iter().collect(),
        record: false,
    };
    let mut witness = Witness {
        mind: LocalController::new(setup.config.clone()),
        faulty: fault.map(|fault| fault.sensor as u8),
        course: Course::default(),
        moves: 0,
        seen: 0,
        touched: false,
    };
    let report = run_with(&world, &setup, &mut witness, |_, _, _| {})?.report;
    Ok(Course {
        coverage_m2: report.coverage_m2,
        distance_m: report.distance_m,
        ..witness.course
    })
}

/// A mind, and what happens to it.
struct Witness {
    mind: LocalController,
    faulty: Option<u8>,
    course: Course,
    moves: u32,
    /// Verdicts dealt with.
    seen: usize,
    /// This move has touched something already.
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

    fn echoes(&mut self, at: Millis, echoes: &[HeardEcho]) -> (usize, Outputs<16>) {
        let Some(&HeardEcho {
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
        let news = self.mind.verdicts().get(self.seen..).unwrap_or_default();
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
        self.seen += news.len();
    }
}
