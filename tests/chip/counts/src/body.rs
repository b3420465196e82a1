//! Counts the events of a robot with 16 sensors on its body, which finds them, learns and drives.

use crate::driven::{DrivenRobot, EventCounts};
use crate::stopwatch::{InstructionStats, Stopwatch};
use amp::actuation::Actuation;
use amp::body::{Body as _, MountedSensors};
use amp::config::Config;
use amp::controller::{Command, Event, Mode};
use amp::fixed::Mask;
use amp::goal::Goal;
use amp::places::Aim;
use amp::points::PointLimits;
use amp::turret::{BodySpec, Guard, Mount};
use amp::units::{Bearing, Displacement};
use core::num::NonZeroU16;

/// Decisions.
const DECISIONS: usize = 32;
/// Random moves that find the sensors, and for the maps.
const MOVES: u16 = 20;

/// A body in static memory: it is too large for the stack.
pub type Sensors<const RECORDS: usize> = MountedSensors<16, 16, 256, RECORDS>;

/// Instructions by kind of event.
#[derive(Default)]
pub struct BodyCounts {
    /// While it finds its sensors.
    pub babble: EventCounts,
    /// Tick of a robot that works out where they are.
    pub step: InstructionStats,
    /// From then on.
    pub events: EventCounts,
    /// Echo that completes the ring of a robot that seeks.
    pub decision: InstructionStats,
}

/// Runs the whole episode.
pub fn episode<const RECORDS: usize>(watch: &Stopwatch, body: &mut Sensors<RECORDS>) -> BodyCounts {
    body.tell(&spec());
    let config = Config {
        shield: None,
        fault_detection: false,
        ..Config::recommended()
    };
    let mut episode = BodyEpisode {
        robot: DrivenRobot::new(watch, config, body),
        counts: BodyCounts::default(),
    };
    episode.find_sensors();
    episode.explore();
    episode.learn();
    episode.seek();
    BodyCounts {
        events: episode.robot.counts,
        ..episode.counts
    }
}

struct BodyEpisode<'a, const RECORDS: usize> {
    robot: DrivenRobot<'a, Sensors<RECORDS>>,
    counts: BodyCounts,
}

fn spec() -> BodySpec<16> {
    let mounts = core::array::from_fn(|sensor| {
        let axis = Bearing::of_place(sensor, 16);
        Mount {
            position: Displacement::along(axis, 231),
            axis,
        }
    });
    BodySpec {
        mounts,
        enabled: Mask::from_bits(0xFFFF),
        actuation: Actuation::EXACT,
        points: PointLimits::NOMAD,
        silence_mm: None,
        first_looks: 0,
        most_unseen: u8::MAX,
        guard: NonZeroU16::new(70).map(|margin_mm| Guard {
            margin_mm,
            least_range_mm: 153,
        }),
        babble_margin_mm: 30,
        has_compass: false,
    }
}

impl<const RECORDS: usize> BodyEpisode<'_, RECORDS> {
    fn find_sensors(&mut self) {
        self.robot.send(|| {
            Event::Command(Command::Calibrate {
                moves: MOVES,
                seed: 7,
                actuators: true,
            })
        });
        while *self.robot.state.mode() != Mode::Calibrate {
            let (_, out) = self.robot.ring();
            self.robot.carry_out(out.motion);
        }
        self.counts.babble = core::mem::take(&mut self.robot.counts);
        while *self.robot.state.mode() == Mode::Calibrate {
            let (instructions, _) = self.robot.send(|| Event::Tick);
            self.counts.step.add(instructions);
        }
    }

    fn explore(&mut self) {
        self.robot.send(|| {
            Event::Command(Command::Explore {
                moves: MOVES,
                seed: 7,
            })
        });
        // What was found in a room that does not turn with the body is not where the sensors are.
        self.robot.body.tell(&spec());
        loop {
            let (_, out) = self.robot.ring();
            if out.mode_changed {
                return;
            }
            self.robot.carry_out(out.motion);
        }
    }

    fn learn(&mut self) {
        self.robot.send(|| Event::Command(Command::Learn));
        while !self.robot.send(|| Event::Tick).1.mode_changed {}
    }

    fn seek(&mut self) {
        let goal = Goal::avoiding(&self.robot.config);
        let _ = self.robot.body.lead_to(Some(Aim::Frontier));
        self.robot.send(|| Event::Command(Command::Seek(goal)));
        for _ in 0..DECISIONS {
            let (instructions, out) = self.robot.ring();
            self.counts.decision.add(instructions);
            self.robot.carry_out(out.motion);
        }
    }
}
