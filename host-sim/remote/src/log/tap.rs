//! Between the robot and its mind: everything that passes is written down, nothing is changed.

use super::record::{Answer, EchoRecord, EventRecord, Happening, Setup};
use super::shared::SharedLog;
use amp::controller::{Command, Event, Outputs};
use amp::units::Millis;
use arena::world::World;
use sim::episode::{Body, Observer, StepResult};
use sim::error::EpisodeError;
use sim::pilot::{HeardEcho, InspectableController, Pilot, SimState};
use std::io::{Seek, Write};

/// A pilot whose dealings go into a log, if there is one.
pub struct Tap<P, W: Write + Seek> {
    pilot: P,
    log: Option<SharedLog<W>>,
    /// Ticks that changed nothing, not yet written, and when they were.
    ticks: Option<(Millis, u32)>,
    /// The pilot makes its maps: every tick is a step of that.
    learning: bool,
    /// Time of the latest event written.
    told: Option<Millis>,
}

impl<P, W: Write + Seek> Tap<P, W> {
    /// Taps a pilot.
    pub fn new(pilot: P, log: Option<SharedLog<W>>) -> Self {
        Self {
            pilot,
            log,
            ticks: None,
            learning: false,
            told: None,
        }
    }

    /// The pilot itself: what is done with it now is not written down.
    pub fn pilot(&mut self) -> &mut P {
        &mut self.pilot
    }

    /// The pilot itself, to be looked at.
    #[must_use]
    pub fn inner(&self) -> &P {
        &self.pilot
    }

    /// The log.
    #[must_use]
    pub fn log(&self) -> Option<&SharedLog<W>> {
        self.log.as_ref()
    }

    /// The pilot was told something other than an event.
    pub fn note(&mut self, at: Millis, what: Happening) {
        self.tell(at, what, &Outputs::NONE);
        // It has not let time pass.
        self.told = None;
    }

    /// A mind that knows nothing starts, in this world if it is known.
    pub fn begin(&mut self, setup: &Setup, world: Option<&World>) {
        self.tell_ticks();
        (self.learning, self.told) = (false, None);
        if let Some(log) = &self.log {
            log.write(|log| log.setup(setup, world));
        }
    }

    fn tell(&mut self, at: Millis, event: Happening, outputs: &Outputs<16>) {
        self.tell_ticks();
        self.told = Some(at);
        let Some(log) = &self.log else { return };
        let at_ms = at.as_ms();
        log.write(|log| {
            log.event(&EventRecord { at_ms, event });
            if let Some(answer) = Answer::of(at_ms, outputs) {
                log.answer(&answer);
            }
        });
    }

    /// A learning mind is ticked thousands of times: they are counted. Otherwise a tick that changes nothing lets time
    /// pass: of several the last one is enough, and none is needed where an event has brought the time along.
    fn tick(&mut self, at: Millis, outputs: &Outputs<16>) {
        if *outputs == Outputs::NONE && !self.learning {
            let is_news = self.told.is_none_or(|told| told.is_before(at));
            self.ticks = is_news.then_some((at, 1)).or(self.ticks);
            return;
        }
        let earlier = self.ticks.filter(|(then, _)| *then == at);
        if earlier.is_none() {
            self.tell_ticks();
        }
        let count = earlier.map_or(0, |(_, count)| count).saturating_add(1);
        if *outputs == Outputs::NONE {
            self.ticks = Some((at, count));
        } else {
            self.ticks = None;
            let done = outputs.mode_changed;
            self.tell(at, Happening::Ticks { count, done }, outputs);
        }
    }

    fn tell_ticks(&mut self) {
        if let Some((at, count)) = self.ticks.take() {
            let event = Happening::Ticks { count, done: false };
            let at_ms = at.as_ms();
            if let Some(log) = &self.log {
                log.write(|log| log.event(&EventRecord { at_ms, event }));
            }
        }
    }
}

impl<P: Pilot, W: Write + Seek> Pilot for Tap<P, W> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        let outputs = self.pilot.handle(at, event);
        if outputs.mode_changed {
            self.learning = event == Event::Command(Command::Learn);
        }
        match event {
            _ if self.is_lost() => {}
            Event::Tick => self.tick(at, &outputs),
            _ => self.tell(at, Happening::of(&event), &outputs),
        }
        outputs
    }

    fn echoes(&mut self, at: Millis, echoes: &[HeardEcho]) -> (usize, Outputs<16>) {
        let (taken, outputs) = self.pilot.echoes(at, echoes);
        if !self.is_lost() {
            let heard = echoes.iter().take(taken);
            let heard = heard.map(EchoRecord::of).collect();
            self.tell(at, Happening::Echoes(heard), &outputs);
        }
        (taken, outputs)
    }

    fn failure(&self) -> Option<EpisodeError> {
        let failed = |log: &SharedLog<W>| log.write(|log| log.failure().map(str::to_owned));
        let failed = self.log.as_ref().and_then(failed).map(EpisodeError::Log);
        self.pilot.failure().or(failed)
    }
}

impl<P: Pilot, W: Write + Seek> Tap<P, W> {
    /// Nothing is to be written down: there is no log, or what came of it is not known because the way to the mind failed.
    fn is_lost(&self) -> bool {
        self.log.is_none() || self.pilot.failure().is_some()
    }
}

impl<P: InspectableController, W: Write + Seek> InspectableController for Tap<P, W> {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        self.pilot.knowledge()
    }
}

/// Writes down what really happens.
pub struct Watcher<W: Write + Seek> {
    log: SharedLog<W>,
}

impl<W: Write + Seek> Watcher<W> {
    /// Into this log.
    pub fn new(log: SharedLog<W>) -> Self {
        Self { log }
    }
}

impl<W: Write + Seek> Observer for Watcher<W> {
    fn on_step(&mut self, at: Millis, happened: &StepResult, body: &Body<'_>) {
        self.log.write(|log| {
            log.pose(at, happened.pose, body.leader());
            if happened.decision.is_some() {
                log.sonar(at, body.ranges_m());
            }
            if let Some(moved) = happened.moved.filter(|moved| moved.touched) {
                log.contact(at, moved.to);
            }
        });
    }
}
