//! A bridge drives a Nomad and its controller or the bridge itself fails: time until the base
//! stops.
//!
//! Uses the code for a real robot: [`drive`], a controller behind a link, the robot's own protocol,
//! the simulated robot. Timeouts run in real time, so results vary.

use super::{CampaignVerdict, below, generator};
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

/// One in so many trials of a campaign uses a bridge; the least number of trials; trials in
/// parallel.
const SHARE: u64 = 1_000;
const MIN_TRIALS: u64 = 4;
const AT_ONCE: usize = 8;
/// So slow that even the first motion, of 80 mm, takes more than 8 s: a stop before its end is
/// visible.
const SPEED_MM_S: u16 = 10;
/// Latest failure after the start of the motors, ms.
const MAX_MS: usize = 4_000;
/// Time to stop the wheels from 45 °/s, ms.
const BRAKING_MS: u32 = 1_510;
/// Timeout of a trial, ms.
const GIVE_UP_MS: u32 = 20_000;
/// Poll interval.
const STEP: Duration = Duration::from_millis(2);

/// The component that fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BridgeFailure {
    /// The controller sends nothing more; its link stays open.
    Mind,
    /// The bridge and its line to the robot.
    Bridge,
}

impl BridgeFailure {
    const ALL: [Self; 2] = [Self::Mind, Self::Bridge];

    const fn name(self) -> &'static str {
        match self {
            Self::Mind => "bridge whose controller goes silent",
            Self::Bridge => "bridge gone",
        }
    }

    /// Longest time until the stop command, ms.
    ///
    /// A silent controller: timeout of 500 ms plus the delays of a busy machine. The robot itself
    /// stops after one second, the shortest value of its `conf_tm`.
    const fn max_ms(self) -> u32 {
        match self {
            Self::Mind => 900,
            Self::Bridge => 1_010,
        }
    }
}

/// The robot and its observation.
struct BridgeScene {
    line: RobotLine,
    began: Instant,
    lived_ms: u32,
    /// Time from the start of the motors to the failure, ms.
    after_ms: u32,
    ran_ms: u32,
    gone: BridgeFailure,
    /// Time of the failure, and the distance rolled until then.
    moment: Option<(u32, f64)>,
    decoder: Decoder,
    /// Time from the failure to the first stop command and to the standstill, and the distance
    /// rolled.
    told_ms: Option<u32>,
    stood: Option<(u32, f64)>,
    is_over: Arc<AtomicBool>,
}

impl BridgeScene {
    fn new(gone: BridgeFailure, after_ms: u32, seed: u64) -> Self {
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

    fn is_gone(&self, who: BridgeFailure) -> bool {
        self.gone == who && self.moment.is_some()
    }

    /// Advances the robot's time to real time.
    fn catch_up(&mut self) {
        while u128::from(self.lived_ms) < self.began.elapsed().as_millis() {
            self.advance_1_ms();
        }
    }

    /// Advances by one millisecond.
    fn advance_1_ms(&mut self) {
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

    /// Processes bytes of the bridge.
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

fn look(scene: &Mutex<BridgeScene>) -> MutexGuard<'_, BridgeScene> {
    scene.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The line to the robot.
struct RobotLink(Arc<Mutex<BridgeScene>>);

impl Transport for RobotLink {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut scene = look(&self.0);
        scene.catch_up();
        if !scene.is_gone(BridgeFailure::Bridge) {
            scene.hear(bytes);
        }
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        let until = Instant::now() + patience;
        loop {
            let mut scene = look(&self.0);
            scene.catch_up();
            // A bridge that has failed waits for nothing.
            if scene.is_gone(BridgeFailure::Bridge) {
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

/// The link to the controller.
struct ControllerLink {
    mind: InProcessNode,
    scene: Arc<Mutex<BridgeScene>>,
    is_over: Arc<AtomicBool>,
}

impl ControllerLink {
    fn is_mute(&self) -> bool {
        look(&self.scene).is_gone(BridgeFailure::Mind)
    }
}

impl Transport for ControllerLink {
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

/// Result of a trial: times after the failure, ms, and distance, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
struct BridgeStop {
    told_ms: u32,
    stood_ms: u32,
    way_mm: f64,
}

fn try_it(gone: BridgeFailure, seed: u64, trial: u64) -> BridgeStop {
    let mut config = Config::recommended();
    config.robot.speed_mm_s = SPEED_MM_S;
    let after_ms = below(&mut generator(seed, trial), MAX_MS) as u32;
    let scene = BridgeScene::new(gone, after_ms, seed.wrapping_add(trial));
    let is_over = Arc::clone(&scene.is_over);
    let scene = Arc::new(Mutex::new(scene));
    let controller = controller(&config, &scene, &is_over);
    let plan = BridgePlan {
        config,
        explore_moves: 100,
        steps: 1,
        behavior: Behavior::Avoid,
        seed: seed.wrapping_add(trial),
        sonars_at_once: 16,
    };
    let host = Host::new(RobotLink(Arc::clone(&scene)));
    let _ = drive(
        host,
        LoggedController::new(controller, None),
        &plan,
        &is_over,
        |_| {},
    );
    // Without a bridge the robot's time must not advance.
    let mut scene = look(&scene);
    while scene.stood.is_none() && scene.lived_ms < GIVE_UP_MS {
        scene.advance_1_ms();
    }
    let (stood_ms, way_m) = scene.stood.unwrap_or((GIVE_UP_MS, f64::INFINITY));
    BridgeStop {
        told_ms: scene.told_ms.unwrap_or(stood_ms),
        stood_ms,
        way_mm: way_m * 1e3,
    }
}

/// A controller at the end of a link that is part of the scene.
fn controller(
    config: &Config<16>,
    scene: &Arc<Mutex<BridgeScene>>,
    is_over: &Arc<AtomicBool>,
) -> AnyController {
    let mut session = Session::new(ControllerLink {
        mind: InProcessNode::new(config.clone()),
        scene: Arc::clone(scene),
        is_over: Arc::clone(is_over),
    });
    // The bridge must wait longer for an answer than the base may move.
    session.set_retry_policy(RetryPolicy {
        timeout: Duration::from_millis(GIVE_UP_MS.into()),
        attempts: 1,
    });
    let place = ControllerPlace::Link(Box::new(session), "a controller".to_owned());
    AnyController::new(config, None, place).expect("a controller")
}

/// Runs the trials for a campaign of `count`, and adds their figures to the verdict.
pub(super) fn run(verdict: &mut CampaignVerdict, seed: u64, count: u64) {
    let count = (count / SHARE).max(MIN_TRIALS);
    let mut rows = Vec::new();
    for (kind, gone) in (0..).zip(BridgeFailure::ALL) {
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
        "\n{count} failures each while a bridge drives a Nomad at {SPEED_MM_S} mm/s, in real time\n"
    ));
    let heads = [
        "failure",
        "stop command, ms, most",
        "allowed",
        "wheels stand, most",
        "distance mm, most",
    ];
    verdict.table(heads, &rows);
}

fn judge(verdict: &mut CampaignVerdict, gone: BridgeFailure, all: &[BridgeStop]) -> [String; 5] {
    let name = gone.name();
    let most = |of: fn(&BridgeStop) -> u32| all.iter().map(of).max().unwrap_or(0);
    let stood_ms = most(|stopped| stopped.stood_ms);
    let told_ms = most(|stopped| stopped.told_ms);
    let way_mm = all.iter().map(|stopped| stopped.way_mm).fold(0.0, f64::max);
    // The robot reports no stop of its own.
    let is_told = gone == BridgeFailure::Bridge || told_ms <= gone.max_ms();
    verdict.require(is_told, format!("{name}: {told_ms} ms"));
    let is_soon = stood_ms <= gone.max_ms() + BRAKING_MS;
    verdict.require(is_soon, format!("{name}: stood after {stood_ms} ms"));
    let told = match gone {
        BridgeFailure::Mind => told_ms.to_string(),
        BridgeFailure::Bridge => "–".to_owned(),
    };
    [
        name.to_owned(),
        told,
        gone.max_ms().to_string(),
        stood_ms.to_string(),
        format!("{way_mm:.0}"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_base_that_goes_on_for_too_long_is_found() {
        let stopped = |told_ms, stood_ms| BridgeStop {
            told_ms,
            stood_ms,
            way_mm: 20.0,
        };
        let broken = |gone, all: &[BridgeStop]| {
            let mut verdict = CampaignVerdict::default();
            let _ = judge(&mut verdict, gone, all);
            verdict.broken.len()
        };
        assert_eq!(broken(BridgeFailure::Mind, &[stopped(900, 2_410)]), 0);
        assert_eq!(
            broken(BridgeFailure::Mind, &[stopped(1, 2), stopped(901, 2_000)]),
            1
        );
        assert_eq!(broken(BridgeFailure::Mind, &[stopped(900, 2_411)]), 1);
        assert_eq!(broken(BridgeFailure::Bridge, &[stopped(2_520, 2_520)]), 0);
        assert_eq!(broken(BridgeFailure::Bridge, &[stopped(0, 2_521)]), 1);
    }
}
