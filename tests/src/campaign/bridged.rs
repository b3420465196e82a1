//! A bridge drives a Nomad, and its mind falls silent, or the bridge itself is gone: how long until the base stands?
//!
//! All of it is the code that drives a real robot: [`drive`], a mind at the end of a link, the robot's own line, and the
//! simulated robot, which misses its host as the Nomad does. The bridge counts its mind's silence by this machine's clock, so
//! robot and mind live by it too, and the figures are never quite the same again.

use super::{Verdict, below, generator};
use amp::config::Config;
use arena::sonar::SonarModel;
use arena::world::{Point, Pose, Shape, World};
use nomad200::bridge::{BridgePlan, drive};
use nomad200::{Decoder, Host, MAX_TO_ROBOT, NomadCommand, Protocol, RobotLine, SimulatedNomad};
use remote::link::{
    AnyController, ControllerPlace, InProcessNode, RetryPolicy, Session, Transport,
};
use remote::log::LoggedController;
use sim::behavior::Behavior;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// One of so many trials of a campaign is made with a bridge; at least so many, and so many at the same time.
const SHARE: u64 = 1_000;
const LEAST: u64 = 4;
const AT_ONCE: usize = 8;
/// So slow that even the first motion, of 80 mm, takes more than 8 s: whoever stops it is seen.
const SPEED_MM_S: u16 = 10;
/// The moment comes at most so long after the motors began to run, ms.
const MAX_MS: usize = 4_000;
/// From an order to stand to wheels that stand, if they were turning at 45 °/s, ms.
const BRAKING_MS: u32 = 1_510;
/// A base that does not begin to move, or goes on for so long, is not watched any longer, ms.
const GIVE_UP_MS: u32 = 20_000;
/// A wait is looked at so often.
const STEP: Duration = Duration::from_millis(2);

/// Who is gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Gone {
    /// The mind says nothing more, and its link stays.
    Mind,
    /// The bridge, with its line.
    Bridge,
}

impl Gone {
    const ALL: [Self; 2] = [Self::Mind, Self::Bridge];

    const fn name(self) -> &'static str {
        match self {
            Self::Mind => "bridge whose mind falls silent",
            Self::Bridge => "bridge gone",
        }
    }

    /// Longest time until the motors are told to stand, ms: after 500 ms of a silent mind, and what a busy machine adds; by the
    /// robot itself after a second, the shortest that its `conf_tm` knows.
    const fn most_ms(self) -> u32 {
        match self {
            Self::Mind => 900,
            Self::Bridge => 1_010,
        }
    }
}

/// The robot, and what is seen of it.
struct Scene {
    line: RobotLine,
    began: Instant,
    lived_ms: u32,
    /// So long the motors run before the moment, ms.
    after_ms: u32,
    ran_ms: u32,
    gone: Gone,
    /// When somebody is gone, and how far the base had rolled.
    moment: Option<(u32, f64)>,
    decoder: Decoder,
    /// From the moment to the first order to stand, to motors that stand, and the way until then.
    told_ms: Option<u32>,
    stood: Option<(u32, f64)>,
    is_over: Arc<AtomicBool>,
}

impl Scene {
    fn new(gone: Gone, after_ms: u32, seed: u64) -> Self {
        let walls = Shape::room(Point::new(4.0, 4.0));
        let world = World::new("hall", Pose::default(), vec![walls]).expect("a world");
        let robot = SimulatedNomad::new(world, SonarModel::Ideal, seed);
        Self {
            line: RobotLine::new(robot, Protocol::Direct),
            began: Instant::now(),
            lived_ms: 0,
            after_ms,
            ran_ms: 0,
            gone,
            moment: None,
            decoder: Decoder::new(MAX_TO_ROBOT),
            told_ms: None,
            stood: None,
            is_over: Arc::default(),
        }
    }

    fn is_gone(&self, who: Gone) -> bool {
        self.gone == who && self.moment.is_some()
    }

    /// Lives as long as this machine has.
    fn live(&mut self) {
        while u128::from(self.lived_ms) < self.began.elapsed().as_millis() {
            self.pass();
        }
    }

    /// A millisecond.
    fn pass(&mut self) {
        self.line.advance(1);
        self.lived_ms += 1;
        let robot = self.line.robot();
        let is_running = robot.state().motors != 0 || robot.state().velocity != [0; 3];
        let way_m = robot.ground_truth().traveled_m;
        self.ran_ms += u32::from(is_running);
        match self.moment {
            None if self.ran_ms > self.after_ms => self.moment = Some((self.lived_ms, way_m)),
            Some((moment_ms, before_m)) if !is_running => {
                let stood = (self.lived_ms - moment_ms, way_m - before_m);
                self.stood = self.stood.or(Some(stood));
            }
            _ => {}
        }
        if self.stood.is_some() || self.lived_ms > GIVE_UP_MS {
            self.is_over.store(true, Ordering::Relaxed);
        }
    }

    /// The bridge says something.
    fn hear(&mut self, bytes: &[u8]) {
        let mut packets = Vec::new();
        self.decoder.push(bytes, &mut packets);
        let is_stop = |packet| matches!(NomadCommand::from_packet(packet), Ok(NomadCommand::Stop));
        if let Some((moment_ms, _)) = self.moment
            && packets.iter().any(is_stop)
        {
            self.told_ms = self.told_ms.or(Some(self.lived_ms - moment_ms));
        }
        self.line.receive(bytes);
    }
}

fn look(scene: &Mutex<Scene>) -> MutexGuard<'_, Scene> {
    scene.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The line to the robot.
struct ToRobot(Arc<Mutex<Scene>>);

impl Transport for ToRobot {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut scene = look(&self.0);
        scene.live();
        if !scene.is_gone(Gone::Bridge) {
            scene.hear(bytes);
        }
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        let until = Instant::now() + patience;
        loop {
            let mut scene = look(&self.0);
            scene.live();
            // A bridge that is gone waits for nothing.
            if scene.is_gone(Gone::Bridge) {
                return Ok(0);
            }
            let answer = scene.line.take();
            drop(scene);
            if !answer.is_empty() || Instant::now() >= until {
                let room = buffer.get_mut(..answer.len()).expect("a short answer");
                room.copy_from_slice(&answer);
                return Ok(answer.len());
            }
            sleep(STEP);
        }
    }
}

/// The link to the mind.
struct ToMind {
    mind: InProcessNode,
    scene: Arc<Mutex<Scene>>,
    is_over: Arc<AtomicBool>,
}

impl ToMind {
    fn is_mute(&self) -> bool {
        look(&self.scene).is_gone(Gone::Mind)
    }
}

impl Transport for ToMind {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        if self.is_mute() {
            return Ok(());
        }
        self.mind.send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        let until = Instant::now() + patience;
        while self.is_mute() {
            if self.is_over.load(Ordering::Relaxed) {
                return Err(io::ErrorKind::BrokenPipe.into());
            }
            if Instant::now() >= until {
                return Ok(0);
            }
            sleep(STEP);
        }
        self.mind.receive(buffer, patience)
    }
}

/// What came of a trial: times from the moment on, ms, and the way, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stopped {
    told_ms: u32,
    stood_ms: u32,
    way_mm: f64,
}

fn try_it(gone: Gone, seed: u64, trial: u64) -> Stopped {
    let mut config = Config::recommended();
    config.robot.speed_mm_s = SPEED_MM_S;
    let after_ms = below(&mut generator(seed, trial), MAX_MS) as u32;
    let scene = Scene::new(gone, after_ms, seed.wrapping_add(trial));
    let is_over = Arc::clone(&scene.is_over);
    let scene = Arc::new(Mutex::new(scene));
    let mut session = Session::new(ToMind {
        mind: InProcessNode::new(config.clone()),
        scene: Arc::clone(&scene),
        is_over: Arc::clone(&is_over),
    });
    // Whoever asks the mind waits for longer than the base may move.
    session.set_retry_policy(RetryPolicy {
        timeout: Duration::from_millis(GIVE_UP_MS.into()),
        attempts: 1,
    });
    let place = ControllerPlace::Link(Box::new(session), "a mind".to_owned());
    let mind = AnyController::new(&config, place).expect("a mind");
    let plan = BridgePlan {
        config,
        explore_moves: 100,
        steps: 1,
        behavior: Behavior::Avoid,
        seed: seed.wrapping_add(trial),
        sonars_at_once: 16,
    };
    let host = Host::new(ToRobot(Arc::clone(&scene)));
    let _ = drive(
        host,
        LoggedController::new(mind, None),
        &plan,
        &is_over,
        |_| {},
    );
    // A robot whose bridge is gone needs no clock.
    let mut scene = look(&scene);
    while scene.stood.is_none() && scene.lived_ms < GIVE_UP_MS {
        scene.pass();
    }
    let (stood_ms, way_m) = scene.stood.unwrap_or((GIVE_UP_MS, f64::INFINITY));
    Stopped {
        told_ms: scene.told_ms.unwrap_or(stood_ms),
        stood_ms,
        way_mm: way_m * 1e3,
    }
}

/// Makes some trials for a campaign of `count`, and says what came of them.
pub(super) fn run(verdict: &mut Verdict, seed: u64, count: u64) {
    let count = (count / SHARE).max(LEAST);
    let mut rows = Vec::new();
    for (kind, gone) in (0..).zip(Gone::ALL) {
        let next = Mutex::new(0..count);
        let all = Mutex::new(Vec::new());
        std::thread::scope(|scope| {
            for _ in 0..AT_ONCE {
                scope.spawn(|| {
                    let draw = || next.lock().unwrap_or_else(PoisonError::into_inner).next();
                    while let Some(trial) = draw() {
                        let stopped = try_it(gone, seed, kind * count + trial);
                        let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
                        all.push(stopped);
                    }
                });
            }
        });
        let all = all.into_inner().unwrap_or_else(PoisonError::into_inner);
        rows.push(judge(verdict, gone, &all));
    }
    verdict.say(format_args!(
        "\n{count} moments each at which a bridge drives a Nomad at {SPEED_MM_S} mm/s, in real time\n"
    ));
    let heads = [
        "what is gone",
        "told to stand, ms, most",
        "allowed",
        "wheels stand, most",
        "way mm, most",
    ];
    verdict.table(heads, &rows);
}

fn judge(verdict: &mut Verdict, gone: Gone, all: &[Stopped]) -> [String; 5] {
    let name = gone.name();
    let most = |of: fn(&Stopped) -> u32| all.iter().map(of).max().unwrap_or(0);
    let stood_ms = most(|stopped| stopped.stood_ms);
    let told_ms = most(|stopped| stopped.told_ms);
    let way_mm = all.iter().map(|stopped| stopped.way_mm).fold(0.0, f64::max);
    // The robot itself tells nobody that it stops.
    let is_told = gone == Gone::Bridge || told_ms <= gone.most_ms();
    verdict.require(is_told, format!("{name}: {told_ms} ms"));
    let is_soon = stood_ms <= gone.most_ms() + BRAKING_MS;
    verdict.require(is_soon, format!("{name}: stood after {stood_ms} ms"));
    let told = match gone {
        Gone::Mind => told_ms.to_string(),
        Gone::Bridge => "–".to_owned(),
    };
    [
        name.to_owned(),
        told,
        gone.most_ms().to_string(),
        stood_ms.to_string(),
        format!("{way_mm:.0}"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_base_that_goes_on_for_too_long_is_found() {
        let stopped = |told_ms, stood_ms| Stopped {
            told_ms,
            stood_ms,
            way_mm: 20.0,
        };
        let broken = |gone, all: &[Stopped]| {
            let mut verdict = Verdict::default();
            let _ = judge(&mut verdict, gone, all);
            verdict.broken.len()
        };
        assert_eq!(broken(Gone::Mind, &[stopped(900, 2_410)]), 0);
        assert_eq!(broken(Gone::Mind, &[stopped(1, 2), stopped(901, 2_000)]), 1);
        assert_eq!(broken(Gone::Mind, &[stopped(900, 2_411)]), 1);
        assert_eq!(broken(Gone::Bridge, &[stopped(2_520, 2_520)]), 0);
        assert_eq!(broken(Gone::Bridge, &[stopped(0, 2_521)]), 1);
    }
}
