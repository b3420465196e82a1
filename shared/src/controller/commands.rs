//! Commands, alarms and ticks: what changes the mode.

use super::search::SearchProgress;
use super::{Command, CommandRefusal, Mode, Outputs, State, StopReason};
use crate::config::Config;
use crate::units::Millis;
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    /// Carries out a command, or refuses it.
    #[inline(never)]
    pub(super) fn command(
        &mut self,
        config: &Config<SENSORS>,
        at: Millis,
        command: Command<SENSORS>,
    ) -> Outputs<SENSORS> {
        self.last_plan.forget_cost();
        let max = u16::try_from(SAMPLES).unwrap_or(u16::MAX);
        let mode = match command {
            Command::Explore { moves, .. } if moves == 0 || moves > max => {
                return refused(CommandRefusal::InvalidMoveCount { max });
            }
            Command::Learn if self.memory.samples().is_empty() => {
                return refused(CommandRefusal::NoSamples);
            }
            Command::Seek(_) if !self.learned => return refused(CommandRefusal::NotLearned),
            Command::Explore { moves, seed } => {
                self.generator = Some(Xoshiro128PlusPlus::seed_from_u64(seed));
                self.memory.clear();
                Mode::Explore { left: moves }
            }
            Command::Learn => {
                self.start_maps(config);
                Mode::Learn { step: 0 }
            }
            Command::Seek(goal) => {
                self.search = SearchProgress::NEW;
                self.interrupt_traversal();
                self.forgive_pause(config, at);
                Mode::Seek { goal }
            }
            Command::Stop => {
                let stopped = self.stop(at, StopReason::Commanded);
                // Sent each time: the order before may have been lost.
                let motion = stopped.motion.or(Some(self.standing()));
                return Outputs { motion, ..stopped };
            }
            Command::Resume if self.can_resume() => self.interrupted,
            Command::Resume => return refused(CommandRefusal::NothingToResume),
            Command::Calibrate { .. } => return refused(CommandRefusal::FixedRing),
        };
        self.enter(at, mode)
    }

    /// Whether a stop interrupted something.
    const fn can_resume(&self) -> bool {
        matches!(
            (&self.mode, &self.interrupted),
            (Mode::Stopped(_), Mode::Explore { .. } | Mode::Seek { .. })
        )
    }

    /// Stands still and stores the interrupted mode for [`Command::Resume`].
    #[inline(never)]
    fn stop(&mut self, at: Millis, reason: StopReason) -> Outputs<SENSORS> {
        self.interrupted = match self.mode {
            Mode::Explore { .. } | Mode::Seek { .. } => self.mode,
            Mode::Stopped(_) => self.interrupted,
            Mode::Idle | Mode::Learn { .. } | Mode::Babble { .. } | Mode::Calibrate => Mode::Idle,
        };
        self.enter(at, Mode::Stopped(reason))
    }

    /// Stops a robot that may move; does nothing in other modes.
    pub(super) fn alarm(&mut self, at: Millis, reason: StopReason) -> Outputs<SENSORS> {
        match self.mode {
            Mode::Explore { .. } | Mode::Seek { .. } | Mode::Babble { .. } => self.stop(at, reason),
            Mode::Idle | Mode::Learn { .. } | Mode::Calibrate | Mode::Stopped(_) => Outputs::none(),
        }
    }

    /// Changes the mode. A motion under way is stopped, except from one goal to the next. One copy
    /// in the program.
    #[inline(never)]
    pub(super) fn enter(&mut self, at: Millis, mode: Mode<SENSORS>) -> Outputs<SENSORS> {
        let goes_on = matches!((&self.mode, &mode), (Mode::Seek { .. }, Mode::Seek { .. }));
        let stopped = match mode {
            Mode::Stopped(reason) => Some(reason),
            _ => None,
        };
        self.mode = mode;
        let motion = (self.moving && !goes_on).then(|| {
            self.motion_id = self.motion_id.wrapping_add(1);
            self.standing()
        });
        if !goes_on {
            self.pending = None;
            self.moving = false;
            self.silent_rings = 0;
            self.heard_any = false;
            self.await_ring(at);
        }
        Outputs {
            motion,
            mode_changed: true,
            stopped,
            ..Outputs::none()
        }
    }

    /// Learns a slice, or supervises the robot.
    #[inline(never)]
    pub(super) fn tick(&mut self, config: &Config<SENSORS>, at: Millis) -> Outputs<SENSORS> {
        let Mode::Learn { step } = self.mode else {
            return self.supervise(config, at);
        };
        let steps = self.learning_steps(config);
        let step = self.learn_slice(config, step, steps);
        if step < steps {
            self.mode = Mode::Learn { step };
            return Outputs::none();
        }
        self.learned = true;
        self.traverse_memory(config);
        self.enter(at, Mode::Idle)
    }
}

pub(crate) fn refused<const SENSORS: usize>(refusal: CommandRefusal) -> Outputs<SENSORS> {
    Outputs {
        refusal: Some(refusal),
        ..Outputs::none()
    }
}
