//! Counts the events of a robot with 16 sensors on its body, which finds them, learns and drives.

use crate::room::SquareRoom;
use crate::stopwatch::{InstructionStats, Stopwatch};
use amp::actuation::Actuation;
use amp::body::{Body as _, MountedSensors};
use amp::config::Config;
use amp::controller::{Command, Event, Mode, Motion, NomadState, Outputs, Progress};
use amp::fixed::Mask;
use amp::goal::Goal;
use amp::points::PointLimits;
use amp::som::Grid;
use amp::turret::{BodySpec, Mount};
use amp::units::{Bearing, Displacement, Millis, Range};
use core::hint::black_box;
use cortex_m4::KERNELS;

/// Decisions.
const DECISIONS: usize = 32;
/// Random moves that find the sensors, and for the maps.
const MOVES: u16 = 20;

/// A body in static memory: it is too large for the stack.
pub type Sensors = MountedSensors<16, 16, 256>;

/// Instructions by kind of event.
#[derive(Default)]
pub struct BodyCounts {
    /// Echo of a standing robot that does not complete the ring.
    pub echo: InstructionStats,
    /// Echo of a moving robot.
    pub on_the_way: InstructionStats,
    /// Echo that completes the ring of a robot that seeks.
    pub decision: InstructionStats,
    /// Report of the base.
    pub odometry: InstructionStats,
    /// Echo of a robot that finds its sensors.
    pub babble: InstructionStats,
    /// Tick of a robot that works out where they are.
    pub step: InstructionStats,
}

struct Rig<'a> {
    watch: &'a Stopwatch,
    config: Config<16>,
    body: &'a mut Sensors,
    state: NomadState,
    room: SquareRoom,
    time: u32,
    counts: BodyCounts,
}

/// Runs the whole episode.
pub fn episode(watch: &Stopwatch, body: &mut Sensors) -> BodyCounts {
    body.tell(&spec());
    let mut state = NomadState::new(Grid::rectangle(4, 4));
    state.use_kernels(&KERNELS);
    let mut rig = Rig {
        watch,
        config: Config {
            shield: None,
            fault_detection: false,
            ..Config::recommended()
        },
        body,
        state,
        room: SquareRoom::new(),
        time: 0,
        counts: BodyCounts::default(),
    };
    rig.find_sensors();
    rig.explore();
    rig.learn();
    rig.seek();
    rig.counts
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
        most_unseen: u8::MAX,
        guard_mm: Some(90),
        babble_margin_mm: 30,
    }
}

impl Rig<'_> {
    fn find_sensors(&mut self) {
        self.send(|| {
            Event::Command(Command::Calibrate {
                moves: MOVES,
                seed: 7,
                actuators: true,
            })
        });
        while *self.state.mode() != Mode::Calibrate {
            let mut motion = None;
            for sensor in 0..16 {
                let (instructions, out) = self.hear(sensor);
                self.counts.babble.add(instructions);
                motion = out.motion.or(motion);
            }
            self.carry_out(motion, |counts| &mut counts.babble);
        }
        self.think(|counts| Some(&mut counts.step));
    }

    fn explore(&mut self) {
        self.send(|| {
            Event::Command(Command::Explore {
                moves: MOVES,
                seed: 7,
            })
        });
        // What was found in a room that does not turn with the body is not where the sensors are.
        self.body.tell(&spec());
        loop {
            let (_, out) = self.ring();
            if out.mode_changed {
                return;
            }
            self.carry_out(out.motion, |counts| &mut counts.on_the_way);
        }
    }

    fn learn(&mut self) {
        self.send(|| Event::Command(Command::Learn));
        self.think(|_| None);
    }

    fn think(&mut self, counted: impl Fn(&mut BodyCounts) -> Option<&mut InstructionStats>) {
        loop {
            let (instructions, out) = self.send(|| Event::Tick);
            if let Some(stats) = counted(&mut self.counts) {
                stats.add(instructions);
            }
            if out.mode_changed {
                return;
            }
        }
    }

    fn seek(&mut self) {
        let goal = Goal::avoiding(&self.config);
        self.send(|| Event::Command(Command::Seek(goal)));
        for _ in 0..DECISIONS {
            let (instructions, out) = self.ring();
            self.counts.decision.add(instructions);
            self.carry_out(out.motion, |counts| &mut counts.on_the_way);
        }
    }

    /// Sends a ring of a standing robot. Returns instructions and outputs of its last echo.
    fn ring(&mut self) -> (u32, Outputs<16>) {
        for sensor in 0..15 {
            let (instructions, _) = self.hear(sensor);
            self.counts.echo.add(instructions);
        }
        self.hear(15)
    }

    /// Drives half of a motion, sends a ring, which may shorten the motion, and drives the rest.
    fn carry_out(
        &mut self,
        motion: Option<Motion>,
        counted: fn(&mut BodyCounts) -> &mut InstructionStats,
    ) {
        let Some(mut motion) = motion else {
            return;
        };
        let whole = motion.displacement;
        let half = Displacement {
            dx_mm: whole.dx_mm / 2,
            dy_mm: whole.dy_mm / 2,
        };
        let moved = self.report(motion, half, Progress::Moving);
        motion.displacement = whole.minus(moved);
        for sensor in 0..16 {
            let (instructions, out) = self.hear(sensor);
            counted(&mut self.counts).add(instructions);
            motion = out.motion.unwrap_or(motion);
        }
        self.report(motion, motion.displacement, Progress::Ended);
    }

    fn report(&mut self, motion: Motion, wanted: Displacement, progress: Progress) -> Displacement {
        let moved = self.room.drive(wanted);
        let (instructions, _) = self.send(|| Event::Odometry {
            motion: black_box(motion.id),
            moved: black_box(moved),
            turned: black_box(Bearing::ZERO),
            progress: black_box(progress),
        });
        self.counts.odometry.add(instructions);
        moved
    }

    fn hear(&mut self, sensor: u8) -> (u32, Outputs<16>) {
        self.time += 40;
        let range = Some(Range::from_mm(self.room.range_mm(usize::from(sensor))));
        self.send(|| Event::Echo {
            sensor: black_box(sensor),
            range: black_box(range),
        })
    }

    #[inline(always)]
    fn send(&mut self, event: impl FnOnce() -> Event<16>) -> (u32, Outputs<16>) {
        let (config, state, body) = (&self.config, &mut self.state, &mut *self.body);
        let at = Millis::from_ms(self.time);
        self.watch.count(|| {
            let (config, state) = (black_box(config), black_box(state));
            black_box(body).handle(config, state, black_box(at), event())
        })
    }
}
