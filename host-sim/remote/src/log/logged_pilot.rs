//! Wraps a pilot and logs its inputs and answers; it changes neither.

use super::record::{AnswerRecord, EchoRecord, EventKind, EventRecord};
use super::setup_record::SetupRecord;
use super::shared::SharedLog;
use amp::controller::{Command, Event, Outputs};
use amp::places::Aim;
use amp::turret::BodySpec;
use amp::units::Millis;
use arena::world::World;
use sim::episode::{Body, Observer, StepResult};
use sim::error::EpisodeError;
use sim::pilot::{AgedEcho, InspectableController, Pilot, SimState};
use sim::robot::MAX_BEAMS;
use sim::senses::{Readings, SenseGoal};
use std::io::{Seek, Write};

/// A pilot with an optional log.
pub struct LoggedPilot<P, W: Write + Seek> {
    pilot: P,
    log: Option<SharedLog<W>>,
    /// Time and number of ticks without a result that are not logged yet.
    ticks: Option<(Millis, u32)>,
    /// The robot's sensors stand anywhere: every tick is a step of finding them, and places may
    /// lead it.
    has_body: bool,
    /// The pilot learns: every tick is a step of learning.
    learning: bool,
    /// Time of the latest event.
    now: Millis,
    /// Time of the latest logged event.
    last_logged: Option<Millis>,
}

impl<P, W: Write + Seek> LoggedPilot<P, W> {
    /// Wraps a pilot.
    pub fn new(pilot: P, log: Option<SharedLog<W>>) -> Self {
        Self {
            pilot,
            log,
            ticks: None,
            has_body: false,
            learning: false,
            now: Millis::from_ms(0),
            last_logged: None,
        }
    }

    /// The pilot, mutable. Calls on it are not logged.
    pub fn pilot(&mut self) -> &mut P {
        &mut self.pilot
    }

    /// The pilot.
    #[must_use]
    pub fn inner(&self) -> &P {
        &self.pilot
    }

    /// The log.
    #[must_use]
    pub fn log(&self) -> Option<&SharedLog<W>> {
        self.log.as_ref()
    }

    /// Logs a change that is not an event of the pilot.
    pub fn log_change(&mut self, at: Millis, what: EventKind) {
        self.write_event(at, what, &Outputs::NONE);
        // Such a change does not advance the time.
        self.last_logged = None;
    }

    /// Logs the start of a controller without knowledge, in this world if it is known.
    pub fn begin(&mut self, setup: &SetupRecord, world: Option<&World>) {
        self.flush_ticks();
        (self.learning, self.last_logged) = (false, None);
        (self.has_body, self.now) = (setup.robot.is_some(), Millis::from_ms(0));
        if let Some(log) = &self.log {
            log.write(|log| log.setup(setup, world));
        }
    }

    fn write_event(&mut self, at: Millis, event: EventKind, outputs: &Outputs<16>) {
        self.flush_ticks();
        self.last_logged = Some(at);
        let Some(log) = &self.log else { return };
        let at_ms = at.as_ms();
        log.write(|log| {
            log.event(&EventRecord { at_ms, event });
            if let Some(answer) = AnswerRecord::of(at_ms, outputs) {
                log.answer(&answer);
            }
        });
    }

    /// Ticks of a learning controller or of any body are counted. Any other tick without a result
    /// only advances the time: only the last of several is logged, and none after an event of the
    /// same time.
    fn tick(&mut self, at: Millis, outputs: &Outputs<16>) {
        if *outputs == Outputs::NONE && !self.learning && !self.has_body {
            let is_new = self
                .last_logged
                .is_none_or(|last_logged| last_logged.is_before(at));
            self.ticks = is_new.then_some((at, 1)).or(self.ticks);
            return;
        }
        let earlier = self.ticks.filter(|(then, _)| *then == at);
        if earlier.is_none() {
            self.flush_ticks();
        }
        let count = earlier.map_or(0, |(_, count)| count).saturating_add(1);
        if *outputs == Outputs::NONE {
            self.ticks = Some((at, count));
        } else {
            self.ticks = None;
            let done = outputs.mode_changed;
            self.write_event(at, EventKind::Ticks { count, done }, outputs);
        }
    }

    fn flush_ticks(&mut self) {
        if let Some((at, count)) = self.ticks.take() {
            let event = EventKind::Ticks { count, done: false };
            let at_ms = at.as_ms();
            if let Some(log) = &self.log {
                log.write(|log| log.event(&EventRecord { at_ms, event }));
            }
        }
    }
}

impl<P: Pilot, W: Write + Seek> Pilot for LoggedPilot<P, W> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        let outputs = self.pilot.handle(at, event);
        self.now = at;
        if outputs.mode_changed {
            self.learning = event == Event::Command(Command::Learn);
        }
        match event {
            _ if self.is_off() => {}
            Event::Tick => self.tick(at, &outputs),
            _ => self.write_event(at, EventKind::of(&event), &outputs),
        }
        outputs
    }

    fn echoes(&mut self, at: Millis, echoes: &[AgedEcho]) -> (usize, Outputs<16>) {
        let (taken, outputs) = self.pilot.echoes(at, echoes);
        self.now = at;
        if !self.is_off() {
            let records = echoes.iter().take(taken);
            let records = records.map(EchoRecord::of).collect();
            self.write_event(at, EventKind::Echoes(records), &outputs);
        }
        (taken, outputs)
    }

    fn lead_to(&mut self, aim: Option<Aim>) -> Result<(), EpisodeError> {
        self.pilot.lead_to(aim)?;
        self.log_for_body(self.now, || EventKind::LeadTo(aim));
        Ok(())
    }

    fn sense(&mut self, at: Millis, readings: &Readings) {
        self.pilot.sense(at, readings);
        self.log_for_body(at, || EventKind::Sense(*readings));
    }

    fn seek_sense(&mut self, goal: Option<SenseGoal>) -> Result<(), EpisodeError> {
        self.pilot.seek_sense(goal)?;
        let name = || goal.map(|goal| goal.name());
        self.log_for_body(self.now, || EventKind::SeekSense(name()));
        Ok(())
    }

    fn failure(&self) -> Option<EpisodeError> {
        let failed = |log: &SharedLog<W>| log.write(|log| log.failure().map(str::to_owned));
        let failed = self.log.as_ref().and_then(failed).map(EpisodeError::Log);
        self.pilot.failure().or(failed)
    }
}

impl<P: Pilot, W: Write + Seek> LoggedPilot<P, W> {
    /// Nothing is logged without a log, or after the link has failed: then the outcome is unknown.
    fn is_off(&self) -> bool {
        self.log.is_none() || self.pilot.failure().is_some()
    }

    /// Logs what only a robot is told whose sensors stand anywhere.
    fn log_for_body(&mut self, at: Millis, what: impl FnOnce() -> EventKind) {
        if self.has_body && !self.is_off() {
            self.write_event(at, what(), &Outputs::NONE);
        }
    }
}

impl<P: InspectableController, W: Write + Seek> InspectableController for LoggedPilot<P, W> {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        self.pilot.knowledge()
    }

    fn body(&mut self) -> Result<Option<BodySpec<MAX_BEAMS>>, EpisodeError> {
        self.pilot.body()
    }
}

/// Logs the true state of the simulated world.
pub struct WorldLogger<W: Write + Seek> {
    log: SharedLog<W>,
}

impl<W: Write + Seek> WorldLogger<W> {
    /// Logs into `log`.
    pub fn new(log: SharedLog<W>) -> Self {
        Self { log }
    }
}

impl<W: Write + Seek> Observer for WorldLogger<W> {
    fn on_step(&mut self, at: Millis, result: &StepResult, body: &Body<'_>) {
        self.log.write(|log| {
            log.pose(at, result.pose, body.leader());
            match (&result.decision, body.robot()) {
                (None, _) => {}
                (Some(_), None) => log.sonar(at, body.ranges_m()),
                (Some(_), Some(robot)) => log.beams(at, &robot.mounts(), body.ranges_m()),
            }
            if let Some(moved) = result.moved.filter(|moved| moved.touched) {
                log.contact(at, moved.to);
            }
        });
    }
}
