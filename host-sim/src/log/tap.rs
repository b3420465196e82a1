//! Between the robot and its mind: everything that passes is written down, nothing is changed.

use super::record::{Answer, EchoRecord, EventRecord, Happening};
use super::write::Log;
use crate::episode::{Failure, Happened, Observer};
use crate::pilot::{Pilot, SimState, Thinker};
use crate::world::Point;
use amp::controller::{Event, Outputs};
use amp::units::{Millis, Range};
use std::cell::RefCell;
use std::io::{Seek, Write};
use std::rc::Rc;

/// A pilot whose dealings go into a log.
pub struct Tap<P, W: Write + Seek> {
    pilot: P,
    log: Rc<RefCell<Log<W>>>,
    /// Ticks that changed nothing, not yet written, and when they were.
    ticks: Option<(Millis, u32)>,
}

impl<P, W: Write + Seek> Tap<P, W> {
    /// Taps a pilot.
    pub fn new(pilot: P, log: Rc<RefCell<Log<W>>>) -> Self {
        Self {
            pilot,
            log,
            ticks: None,
        }
    }

    fn tell(&mut self, at: Millis, event: Happening, outputs: &Outputs<16>) {
        self.tell_ticks();
        let at_ms = at.as_ms();
        let mut log = self.log.borrow_mut();
        log.event(&EventRecord { at_ms, event });
        if let Some(answer) = Answer::of(at_ms, outputs) {
            log.answer(&answer);
        }
    }

    /// A learning mind is ticked thousands of times: they are counted.
    fn tick(&mut self, at: Millis, outputs: &Outputs<16>) {
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
            self.log.borrow_mut().event(&EventRecord { at_ms, event });
        }
    }
}

impl<P: Pilot, W: Write + Seek> Pilot for Tap<P, W> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        let outputs = self.pilot.handle(at, event);
        match event {
            Event::Tick => self.tick(at, &outputs),
            _ => self.tell(at, Happening::of(&event), &outputs),
        }
        outputs
    }

    fn echoes(&mut self, at: Millis, echoes: &[(u8, Option<Range>)]) -> (usize, Outputs<16>) {
        let (taken, outputs) = self.pilot.echoes(at, echoes);
        let heard = echoes.iter().take(taken);
        let heard = heard.map(|(sensor, range)| EchoRecord::of(*sensor, *range));
        self.tell(at, Happening::Echoes(heard.collect()), &outputs);
        (taken, outputs)
    }

    fn failure(&self) -> Option<Failure> {
        let log = self.log.borrow();
        let failed = log.failure().map(|why| Failure::Log(why.to_owned()));
        self.pilot.failure().or(failed)
    }
}

impl<P: Thinker, W: Write + Seek> Thinker for Tap<P, W> {
    fn knowledge(&mut self) -> Result<&SimState, Failure> {
        self.pilot.knowledge()
    }
}

/// Writes down what really happens.
pub struct Watcher<W: Write + Seek> {
    log: Rc<RefCell<Log<W>>>,
}

impl<W: Write + Seek> Watcher<W> {
    /// Into this log.
    pub fn new(log: Rc<RefCell<Log<W>>>) -> Self {
        Self { log }
    }
}

impl<W: Write + Seek> Observer for Watcher<W> {
    fn happened(&mut self, at: Millis, happened: &Happened, leader: Option<Point>) {
        let mut log = self.log.borrow_mut();
        log.pose(at, happened.pose, leader);
        if happened.decision.is_some() {
            log.sonar(at, &happened.ranges_m);
        }
        if let Some(moved) = happened.moved.filter(|moved| moved.touched) {
            log.contact(at, moved.to);
        }
    }
}
