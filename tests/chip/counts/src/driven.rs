//! A robot in its room, whose events are counted.

use crate::room::SquareRoom;
use crate::stopwatch::{InstructionStats, Stopwatch};
use amp::body::Body;
use amp::config::Config;
use amp::controller::{Event, Motion, NomadState, Outputs, Progress};
use amp::som::Grid;
use amp::units::{Bearing, Displacement, Millis, Range};
use core::hint::black_box;
use cortex_m4::KERNELS;

/// Instructions of the events of every ring and motion.
#[derive(Default)]
pub struct EventCounts {
    /// Echo of a standing robot that does not complete the ring.
    pub echo: InstructionStats,
    /// Echo of a moving robot.
    pub on_the_way: InstructionStats,
    /// Report of the base.
    pub odometry: InstructionStats,
    /// Slice of the thinking before a decision.
    pub slice: InstructionStats,
}

/// A robot with 16 transducers that do not turn.
pub struct DrivenRobot<'a, B> {
    watch: &'a Stopwatch,
    /// Configuration.
    pub config: Config<16>,
    /// State of the controller.
    pub state: NomadState,
    /// Its body.
    pub body: &'a mut B,
    /// Instructions so far.
    pub counts: EventCounts,
    room: SquareRoom,
    time: u32,
}

impl<'a, B: Body<16>> DrivenRobot<'a, B> {
    /// A robot that has learned nothing.
    pub fn new(watch: &'a Stopwatch, config: Config<16>, body: &'a mut B) -> Self {
        let mut state = NomadState::new(Grid::rectangle(4, 4));
        state.use_kernels(&KERNELS);
        Self {
            watch,
            config,
            state,
            body,
            counts: EventCounts::default(),
            room: SquareRoom::new(),
            time: 0,
        }
    }

    /// Sends a ring of a standing robot. Returns instructions and outputs of its last echo.
    pub fn ring(&mut self) -> (u32, Outputs<16>) {
        for sensor in 0..15 {
            let (instructions, _) = self.hear(sensor);
            self.counts.echo.add(instructions);
        }
        self.hear(15)
    }

    /// Drives half of a motion, sends a ring, which may shorten the motion, and drives the rest.
    pub fn carry_out(&mut self, motion: Option<Motion>) {
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
            self.counts.on_the_way.add(instructions);
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

    /// Passes an event to the body, and lets it think to the end. The event is built inside the
    /// counted call, from values that are unknown to the compiler.
    #[inline(always)]
    pub fn send(&mut self, event: impl FnOnce() -> Event<16>) -> (u32, Outputs<16>) {
        let (config, state, body) = (&self.config, &mut self.state, &mut *self.body);
        let at = Millis::from_ms(self.time);
        let (instructions, mut outputs) = self.watch.count(|| {
            let (config, state) = (black_box(config), black_box(&mut *state));
            black_box(&mut *body).handle(config, state, black_box(at), event())
        });
        while body.is_thinking() {
            let (slice, decided) = self.watch.count(|| {
                let (config, state) = (black_box(config), black_box(&mut *state));
                black_box(&mut *body).think(config, state, black_box(at))
            });
            self.counts.slice.add(slice);
            outputs = decided;
        }
        (instructions, outputs)
    }
}
