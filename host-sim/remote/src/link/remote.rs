//! A mind at the other end of a link drives the simulated robot.
//!
//! Time is the simulation's: the mind's clock is that of the latest message ([`Clock::Host`]), so neither a slow link nor
//! a slow chip changes what comes of an episode.

use super::{Answer, Knowledge, LinkError, Local, Session, next_number};
use amp::config::Config;
use amp::controller::{Command, Event, Motion, Outputs, Progress, StopReason};
use amp::fixed::Mask;
use amp::som::Grid;
use amp::units::{Millis, Range};
use amp::wire::message::{
    Clock, FromMind, GoalBy, Heard, MindHello, ModeReport, MotionOrder, Notice, Order, Part,
    Refusal, Report,
};
use amp::wire::{ToMind, message};
use sim::error::EpisodeError;
use sim::pilot::{HeardEcho, InspectableController, Pilot, SimState};
use std::borrow::BorrowMut;
use std::time::{Duration, Instant};

/// A sign of life at least this often in simulated time, milliseconds: half the silence a mind bears, so that one may be
/// lost.
const ALIVE_MS: u32 = amp::link::SILENCE_MS / 2;

/// How long a learning mind is left alone before it is asked whether it still learns.
const LEARNING: Duration = Duration::from_millis(500);

/// How long a mind may learn: the F405 takes an eighth of a second.
const MAX_LEARNING: Duration = Duration::from_secs(60);

/// What a mind is, in checksums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fingerprint {
    /// Of the configuration.
    pub config_crc: u32,
    /// Of the three maps.
    pub maps_crc: u32,
    /// Of the memory.
    pub memory_crc: u32,
}

impl From<&MindHello> for Fingerprint {
    fn from(hello: &MindHello) -> Self {
        Self {
            config_crc: hello.config_crc,
            maps_crc: hello.maps_crc,
            memory_crc: hello.memory_crc,
        }
    }
}

impl Fingerprint {
    /// That of a mind with this configuration that knows nothing.
    ///
    /// # Errors
    /// When the configuration is none a mind can send.
    pub fn fresh(config: &Config<16>) -> Result<Self, LinkError> {
        let mut session = Session::new(Local::new(config.clone()));
        session.expect_open_space(config.open_space);
        Ok(Self::from(&session.open(1, Clock::Host)?))
    }

    /// What differs from another one, in words; empty if nothing does.
    #[must_use]
    pub fn differences(&self, other: &Self) -> Vec<&'static str> {
        let pairs = [
            (self.config_crc != other.config_crc, "configuration"),
            (self.maps_crc != other.maps_crc, "maps"),
            (self.memory_crc != other.memory_crc, "memory"),
        ];
        let differing = pairs.into_iter().filter(|(differs, _)| *differs);
        differing.map(|(_, what)| what).collect()
    }
}

/// A mind at the other end of a link, for one episode; the session is its own (`Session`) or lent (`&mut Session`).
pub struct RemoteMind<S> {
    session: S,
    config: Config<16>,
    /// Transducers that its fault detector has disabled.
    disabled: Mask,
    found: Fingerprint,
    fresh: Fingerprint,
    /// Time of the latest message.
    told: Millis,
    /// The latest motion asked for: number and revision.
    motion: Option<(u16, u8)>,
    /// It has been told to stop and not yet said that it has.
    stopping: bool,
    /// It makes its maps.
    learning: bool,
    knowledge: Box<SimState>,
    error: Option<LinkError>,
}

impl<S: BorrowMut<Session>> RemoteMind<S> {
    /// Opens the sessions `number` and the one after it: gives the mind its configuration, makes it forget everything, and
    /// makes sure that it did.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn start(mut session: S, number: u16, config: &Config<16>) -> Result<Self, LinkError> {
        let (found, fresh) = begin(session.borrow_mut(), number, config)?;
        Ok(Self {
            session,
            config: config.clone(),
            disabled: Mask::NONE,
            found,
            fresh,
            told: Millis::from_ms(0),
            motion: None,
            stopping: false,
            learning: false,
            knowledge: Box::new(SimState::new(Grid::rectangle(4, 4))),
            error: None,
        })
    }

    /// As after [`start`](Self::start) with another configuration, whatever went wrong before; the simulation's time begins anew.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn restart(&mut self, config: &Config<16>) -> Result<(), LinkError> {
        let session = self.session.borrow_mut();
        let number = next_number(session.number());
        (self.found, self.fresh) = begin(session, number, config)?;
        (self.config, self.disabled) = (config.clone(), Mask::NONE);
        (self.told, self.motion, self.error) = (Millis::from_ms(0), None, None);
        self.learning = false;
        Ok(())
    }

    /// Gives the mind another configuration; what it knows stays.
    ///
    /// # Errors
    /// [`LinkError`]; a refusal while the robot explores, learns or seeks.
    pub fn configure(&mut self, config: &Config<16>) -> Result<(), LinkError> {
        let bytes = Knowledge::of_config(config)?;
        let session = self.session.borrow_mut();
        session.write_part(Part::Config, &bytes)?;
        (self.config, self.disabled) = (config.clone(), Mask::NONE);
        Ok(())
    }

    /// What the mind was told.
    #[must_use]
    pub fn config(&self) -> &Config<16> {
        &self.config
    }

    /// Transducers it uses.
    #[must_use]
    pub fn enabled(&self) -> Mask {
        Mask::from_bits(self.config.believed.to_bits() & !self.disabled.to_bits())
    }

    /// What the mind had instead of this configuration, empty maps and an empty memory before it was told; in words.
    #[must_use]
    pub fn replaced(&self) -> Vec<&'static str> {
        self.found.differences(&self.fresh)
    }

    fn happen(&mut self, at: Millis, event: Event<16>) -> Result<Outputs<16>, LinkError> {
        let at_ms = at.as_ms();
        match event {
            Event::Echo { sensor, range } => self.hear(at, &[HeardEcho::now(sensor, range)]),
            Event::Odometry {
                motion,
                moved,
                turned,
                progress,
            } => self.tell(
                at,
                &ToMind::Odometry {
                    at_ms,
                    motion,
                    dx_mm: moved.dx_mm,
                    dy_mm: moved.dy_mm,
                    turned: turned.as_turns(),
                    progress,
                },
            ),
            Event::Command(command) => self.command(at, command),
            Event::Tick if self.learning => self.let_learn(MAX_LEARNING),
            Event::Tick => self.tick(at),
            // Whoever is in charge of the link raises alarms, not whoever is at its end.
            Event::Alarm(_) | Event::Touched => Ok(Outputs::NONE),
        }
    }

    fn hear(&mut self, at: Millis, echoes: &[HeardEcho]) -> Result<Outputs<16>, LinkError> {
        let heard = |echo: &HeardEcho| Heard {
            sensor: echo.sensor,
            range_mm: echo.range.map(Range::as_mm),
            // A minute and older: more than any mind still uses.
            age_ms: echo.age_ms.try_into().unwrap_or(u16::MAX),
        };
        let echoes = echoes.iter().take(message::MAX_ECHOES).map(heard);
        let message = ToMind::Scan {
            at_ms: at.as_ms(),
            echoes: echoes.collect(),
        };
        self.tell(at, &message)
    }

    fn command(&mut self, at: Millis, command: Command<16>) -> Result<Outputs<16>, LinkError> {
        self.stopping = command == Command::Stop;
        let order = match command {
            Command::Explore { moves, seed } => Order::Explore { moves, seed },
            Command::Learn => Order::Learn,
            Command::Seek(goal) => {
                self.order(at, Order::Goal(GoalBy::Components(goal)))?;
                Order::Seek
            }
            Command::Stop => Order::Stop,
            Command::Resume => Order::Resume,
        };
        let done = self.order(at, order);
        self.stopping = false;
        let is_done = matches!(&done, Ok(outputs) if outputs.refusal.is_none());
        self.learning = is_done && command == Command::Learn;
        done
    }

    /// Lets the mind's time pass. Every message does so; one that says nothing else is needed only after a silence.
    fn tick(&mut self, at: Millis) -> Result<Outputs<16>, LinkError> {
        if !(ALIVE_MS..1 << 31).contains(&at.since(self.told)) {
            return Ok(Outputs::NONE);
        }
        // A sign of life is not answered, and whatever comes of the time is to be known: the base has not moved.
        let message = ToMind::Odometry {
            at_ms: at.as_ms(),
            motion: self.motion.map_or(0, |(id, _)| id),
            dx_mm: 0,
            dy_mm: 0,
            turned: 0,
            progress: Progress::Moving,
        };
        self.tell(at, &message)
    }

    fn order(&mut self, at: Millis, order: Order<16>) -> Result<Outputs<16>, LinkError> {
        let message = ToMind::Command {
            at_ms: at.as_ms(),
            ttl_ms: super::session::ORDER_TTL_MS,
            order,
        };
        self.tell(at, &message)
    }

    /// Sends something that happened at `at` and returns what came of it.
    fn tell(&mut self, at: Millis, message: &ToMind<16>) -> Result<Outputs<16>, LinkError> {
        self.pass_time(at)?;
        let answer = self.session.borrow_mut().request(message)?;
        self.outputs(&answer)
    }

    /// Has signs of life sent for the time until `at`, before whatever is sent next.
    fn pass_time(&mut self, at: Millis) -> Result<(), LinkError> {
        let mut gap_ms = at.since(self.told);
        // A time before the latest one looks like one far ahead.
        while (ALIVE_MS + 1..1 << 31).contains(&gap_ms) {
            self.told = Millis::from_ms(self.told.as_ms().wrapping_add(ALIVE_MS));
            let at_ms = self.told.as_ms();
            self.session.borrow_mut().put(&ToMind::Alive { at_ms })?;
            gap_ms = at.since(self.told);
        }
        self.told = at;
        Ok(())
    }

    fn outputs(&mut self, answer: &Answer) -> Result<Outputs<16>, LinkError> {
        if answer.missing > 0 {
            let reports = answer.missing;
            return Err(LinkError::Lost { reports });
        }
        let mut outputs = Outputs::NONE;
        for report in &answer.reports {
            self.take(report, &mut outputs)?;
        }
        match answer.refusal {
            Some(Refusal::Command(why)) => outputs.refusal = Some(why),
            Some(why) => return Err(LinkError::Refused(why)),
            None => {}
        }
        Ok(outputs)
    }

    fn take(&mut self, report: &Report<16>, outputs: &mut Outputs<16>) -> Result<(), LinkError> {
        match &report.said {
            FromMind::Decision(decision) => outputs.decision = Some(*decision),
            FromMind::Motion(order) => outputs.motion = self.news(*order).or(outputs.motion),
            FromMind::Mode(ModeReport::Stopped(StopReason::Commanded)) if self.stopping => {
                outputs.mode_changed = true;
            }
            FromMind::Mode(ModeReport::Stopped(reason)) => {
                return Err(LinkError::Stopped(*reason));
            }
            FromMind::Mode(_) => outputs.mode_changed = true,
            FromMind::Log(Notice::Disbelieved { sensor, .. }) => {
                self.disabled = self.disabled.with((*sensor).into());
            }
            FromMind::Log(Notice::Believed { sensor }) => {
                self.disabled = self.disabled.without((*sensor).into());
            }
            _ => {}
        }
        Ok(())
    }

    /// The motion, unless this only renews the time to live of the one under way.
    fn news(&mut self, order: MotionOrder) -> Option<Motion> {
        let mark = Some((order.id, order.revision));
        (std::mem::replace(&mut self.motion, mark) != mark).then(|| order.motion())
    }

    /// Waits until the mind has learned; it does so by itself, as fast as it can. After `limit` it is given up.
    fn let_learn(&mut self, limit: Duration) -> Result<Outputs<16>, LinkError> {
        self.learning = false;
        let end = Instant::now() + limit;
        let mut outputs = Outputs::NONE;
        while !outputs.mode_changed {
            let now = Instant::now();
            if now >= end {
                return Err(LinkError::Learning { waited: limit });
            }
            let until = end.min(now + LEARNING);
            match self.session.borrow_mut().next_report(until)? {
                Some(report) => self.take(&report, &mut outputs)?,
                // Had its report been lost, there would be nothing to wait for.
                None => outputs.mode_changed = !self.is_learning()?,
            }
        }
        Ok(outputs)
    }

    fn is_learning(&mut self) -> Result<bool, LinkError> {
        let mode = self.session.borrow_mut().mode()?;
        Ok(mode == ModeReport::Learn)
    }

    fn keep(&mut self, result: Result<Outputs<16>, LinkError>) -> Outputs<16> {
        result.unwrap_or_else(|error| {
            self.error = Some(error);
            Outputs::NONE
        })
    }
}

impl<S: BorrowMut<Session>> Pilot for RemoteMind<S> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        if self.error.is_some() {
            return Outputs::NONE;
        }
        let result = self.happen(at, event);
        self.keep(result)
    }

    /// Sends in one frame what cannot bring about a motion before its end: everything up to the last transducer that is
    /// enabled, for a ring is complete no sooner.
    fn echoes(&mut self, at: Millis, echoes: &[HeardEcho]) -> (usize, Outputs<16>) {
        if self.error.is_some() {
            return (echoes.len(), Outputs::NONE);
        }
        let count = batch(echoes, self.enabled());
        let result = self.hear(at, echoes.get(..count).unwrap_or(echoes));
        (count, self.keep(result))
    }

    fn failure(&self) -> Option<EpisodeError> {
        self.error.clone().map(EpisodeError::from)
    }
}

impl<S: BorrowMut<Session>> InspectableController for RemoteMind<S> {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        // Nothing happens in the mind while nothing is said to it, whatever its mode.
        let pulled = Knowledge::read(self.session.borrow_mut()).map(Knowledge::into_state);
        self.knowledge = pulled.map_err(EpisodeError::from)?;
        Ok(&self.knowledge)
    }
}

/// Opens two sessions with a mind: what it was before, and what it is with this configuration and nothing else.
fn begin(
    session: &mut Session,
    number: u16,
    config: &Config<16>,
) -> Result<(Fingerprint, Fingerprint), LinkError> {
    let fresh = Fingerprint::fresh(config)?;
    session.expect_open_space(config.open_space);
    let found = Fingerprint::from(&session.open(number, Clock::Host)?);
    // A mind that learns takes no configuration.
    session.order(0, Order::Stop)?;
    session.write_part(Part::Config, &Knowledge::of_config(config)?)?;
    session.order(0, Order::Forget)?;
    let hello = session.open(next_number(session.number()), Clock::Host)?;
    match Fingerprint::from(&hello).differences(&fresh).first() {
        Some(what) => Err(LinkError::Unlike { what }),
        None => Ok((found, fresh)),
    }
}

/// How many of the echoes go into one frame.
fn batch(echoes: &[HeardEcho], believed: Mask) -> usize {
    let counts = |echo: &HeardEcho| believed.contains(usize::from(echo.sensor));
    let last = echoes.iter().rposition(counts);
    // Behind the last believed one, or where none is, each may complete what was heard before.
    last.map_or(1, |last| last + 1).min(message::MAX_ECHOES)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::tests::floods::frames;
    use crate::link::{Flood, Transport};
    use amp::wire::{Frame, frame};
    use std::io;

    /// A mind that says it still learns whenever it is asked for its mode. Breaks after 5 s, so that every wait ends.
    struct Learner {
        mind: Local,
        began: Instant,
    }

    impl Transport for Learner {
        fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
            self.mind.send(bytes)
        }

        fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
            if self.began.elapsed() > Duration::from_secs(5) {
                return Err(io::Error::other("it has learned for long enough"));
            }
            let mut one = [0];
            let mut bytes = Vec::new();
            while self.mind.receive(&mut one, patience)? > 0 && one != [0] {
                bytes.push(one[0]);
            }
            let Ok((header, mut report)) = frame::unpack::<Report<16>>(&bytes) else {
                return Ok(0);
            };
            if let FromMind::Mode(mode) = &mut report.said {
                *mode = ModeReport::Learn;
            }
            let frame = Frame::pack(header, &report).unwrap();
            io::Read::read(&mut frame.as_bytes(), buffer)
        }
    }

    #[test]
    fn a_mind_that_learns_without_end_is_given_up() {
        let config = Config::recommended();
        let learner = Learner {
            mind: Local::new(config.clone()),
            began: Instant::now(),
        };
        let mut mind = RemoteMind::start(Session::new(learner), 1, &config).unwrap();
        let limit = Duration::from_millis(200);
        let given_up = Err(LinkError::Learning { waited: limit });
        let ends = |mind: &mut RemoteMind<Session>, what| {
            let began = Instant::now();
            assert_eq!(mind.let_learn(limit), given_up, "{what}");
            assert!(began.elapsed() < Duration::from_millis(700), "{what}");
        };
        ends(&mut mind, "it says so when asked");
        mind.session.transport = Box::new(Flood::of(frames(mind.session.number(), 1)));
        ends(&mut mind, "it says other things");
        let error = LinkError::Learning {
            waited: MAX_LEARNING,
        };
        assert_eq!(error.to_string(), "the mind has not learned within 60 s");
    }

    #[test]
    fn a_frame_ends_with_the_last_transducer_that_may_complete_the_ring() {
        let echoes: [_; 16] = std::array::from_fn(|sensor| HeardEcho::now(sensor as u8, None));
        assert_eq!(batch(&echoes, Mask::ALL), 16);
        assert_eq!(batch(&echoes, Mask::ALL.without(15)), 15);
        assert_eq!(batch(&echoes[15..], Mask::ALL.without(15)), 1);
        assert_eq!(batch(&echoes, Mask::NONE), 1);
    }
}
