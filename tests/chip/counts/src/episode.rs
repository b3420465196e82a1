//! Counts each event of an episode of the controller: 100 random moves, learning, decisions.

use crate::room::SquareRoom;
use crate::stopwatch::{InstructionStats, Stopwatch};
use amp::config::Config;
use amp::controller::{Command, Decision, Event, Motion, NomadState, Outputs, Progress, handle};
use amp::goal::{Goal, Side};
use amp::som::Grid;
use amp::units::{Bearing, Displacement, Millis, Range};
use core::hint::black_box;
use cortex_m4::KERNELS;
use heapless::Vec;

/// Decisions per goal.
pub const DECISIONS: usize = 32;

/// Instructions by kind of event.
#[derive(Default)]
pub struct EpisodeCounts {
    /// Echo that completes a ring while exploring.
    pub random_move: InstructionStats,
    /// Other echo of a standing robot.
    pub echo: InstructionStats,
    /// Tick while learning.
    pub tick: InstructionStats,
    /// Echo that completes a ring, goal: avoid obstacles.
    pub decision: InstructionStats,
    /// Goal: along a wall.
    pub along_wall: InstructionStats,
    /// Goal: to a place.
    pub to_place: InstructionStats,
    /// Goal: pass obstacles on the right.
    pub passing: InstructionStats,
    /// Goal: follow a leader that is not there.
    pub following: InstructionStats,
    /// Goal: avoid obstacles, by the paper's four steps.
    pub four_steps: InstructionStats,
    /// Echo of a moving robot.
    pub guard: InstructionStats,
    /// Report of the base.
    pub odometry: InstructionStats,
}

/// A robot in its room.
pub struct CountedEpisode<'a> {
    watch: &'a Stopwatch,
    /// Configuration.
    pub config: Config<16>,
    /// State of the controller.
    pub state: NomadState,
    /// Instructions so far.
    pub counts: EpisodeCounts,
    /// Decisions of the first goal.
    pub decisions: Vec<Decision<16>, DECISIONS>,
    room: SquareRoom,
    time: u32,
}

impl<'a> CountedEpisode<'a> {
    /// Runs the whole episode.
    pub fn new(watch: &'a Stopwatch, config: Config<16>) -> Self {
        let mut state = NomadState::new(Grid::rectangle(4, 4));
        state.use_kernels(&KERNELS);
        let mut episode = Self {
            watch,
            config,
            state,
            counts: EpisodeCounts::default(),
            decisions: Vec::new(),
            room: SquareRoom::new(),
            time: 0,
        };
        episode.explore();
        episode.learn();
        episode.seek();
        episode.seek_other_goals();
        episode
    }

    fn explore(&mut self) {
        let moves = 100;
        self.send(|| Event::Command(Command::Explore { moves, seed: 7 }));
        loop {
            let (instructions, out) = self.ring();
            if out.mode_changed {
                return;
            }
            self.counts.random_move.add(instructions);
            self.carry_out(out.motion);
        }
    }

    fn learn(&mut self) {
        self.send(|| Event::Command(Command::Learn));
        loop {
            let (instructions, out) = self.send(|| Event::Tick);
            self.counts.tick.add(instructions);
            if out.mode_changed {
                return;
            }
        }
    }

    fn seek(&mut self) {
        let goal = Goal::avoiding(&self.config);
        self.send(|| Event::Command(Command::Seek(goal)));
        while !self.decisions.is_full() {
            let (instructions, out) = self.ring();
            self.counts.decision.add(instructions);
            self.decisions.extend(out.decision);
            self.carry_out(out.motion);
        }
    }

    fn seek_other_goals(&mut self) {
        let wall = Goal::wall(Side::Right, Range::from_mm(600), &self.config);
        self.counts.along_wall = self.decisions_towards(wall);
        let place = self.decisions.first().map(|first| first.situation);
        let place = Goal::perceived(&place.unwrap_or_default());
        self.counts.to_place = self.decisions_towards(place);
        self.config.planning = Config::probing().planning;
        let clear = Goal::avoiding(&self.config);
        self.counts.four_steps = self.decisions_towards(clear);
        self.config.planning = Config::recommended().planning;
        let passing = Goal::passing(Side::Right, Range::from_mm(1_500), &self.config);
        self.counts.passing = self.decisions_towards(passing);
        let following = Goal::following(Range::from_mm(340), &self.config);
        self.counts.following = self.decisions_towards(following);
    }

    /// Instructions of the next decisions towards a goal.
    fn decisions_towards(&mut self, goal: Goal<16>) -> InstructionStats {
        let mut counted = InstructionStats::default();
        self.send(|| Event::Command(Command::Seek(goal)));
        for _ in 0..DECISIONS {
            let (instructions, out) = self.ring();
            counted.add(instructions);
            self.carry_out(out.motion);
        }
        counted
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
    fn carry_out(&mut self, motion: Option<Motion>) {
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
            self.counts.guard.add(instructions);
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

    /// Passes an event to the controller. It is built inside the counted call, from values that are
    /// unknown to the compiler.
    #[inline(always)]
    fn send(&mut self, event: impl FnOnce() -> Event<16>) -> (u32, Outputs<16>) {
        let (config, state) = (&self.config, &mut self.state);
        let at = Millis::from_ms(self.time);
        self.watch.count(|| {
            let (config, state) = (black_box(config), black_box(state));
            handle(config, state, black_box(at), event())
        })
    }
}
