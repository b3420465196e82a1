//! Counts each event of an episode of the controller: 100 random moves, learning, decisions.

use crate::driven::DrivenRobot;
use crate::stopwatch::{InstructionStats, Stopwatch};
use amp::body::HeldRing;
use amp::config::Config;
use amp::controller::{Command, Decision, Event};
use amp::goal::{Goal, Side};
use amp::units::Range;
use heapless::Vec;

/// Decisions per goal.
pub const DECISIONS: usize = 32;

/// Instructions by kind of event.
#[derive(Default)]
pub struct EpisodeCounts {
    /// Echo that completes a ring while exploring.
    pub random_move: InstructionStats,
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
}

/// An episode of a robot with a ring on a held turret.
pub struct CountedEpisode<'a> {
    /// The robot.
    pub robot: DrivenRobot<'a, HeldRing>,
    /// Instructions so far.
    pub counts: EpisodeCounts,
    /// Decisions of the first goal.
    pub decisions: Vec<Decision<16>, DECISIONS>,
}

impl<'a> CountedEpisode<'a> {
    /// Runs the whole episode.
    pub fn new(watch: &'a Stopwatch, config: Config<16>, ring: &'a mut HeldRing) -> Self {
        let mut episode = Self {
            robot: DrivenRobot::new(watch, config, ring),
            counts: EpisodeCounts::default(),
            decisions: Vec::new(),
        };
        episode.explore();
        episode.learn();
        episode.seek();
        episode.seek_other_goals();
        episode
    }

    fn explore(&mut self) {
        let moves = 100;
        self.robot
            .send(|| Event::Command(Command::Explore { moves, seed: 7 }));
        loop {
            let (instructions, out) = self.robot.ring();
            if out.mode_changed {
                return;
            }
            self.counts.random_move.add(instructions);
            self.robot.carry_out(out.motion);
        }
    }

    fn learn(&mut self) {
        self.robot.send(|| Event::Command(Command::Learn));
        loop {
            let (instructions, out) = self.robot.send(|| Event::Tick);
            self.counts.tick.add(instructions);
            if out.mode_changed {
                return;
            }
        }
    }

    fn seek(&mut self) {
        let goal = Goal::avoiding(&self.robot.config);
        self.robot.send(|| Event::Command(Command::Seek(goal)));
        while !self.decisions.is_full() {
            let (instructions, out) = self.robot.ring();
            self.counts.decision.add(instructions);
            self.decisions.extend(out.decision);
            self.robot.carry_out(out.motion);
        }
    }

    fn seek_other_goals(&mut self) {
        let wall = Goal::wall(Side::Right, Range::from_mm(600), &self.robot.config);
        self.counts.along_wall = self.decisions_towards(wall);
        let place = self.decisions.first().map(|first| first.situation);
        let place = Goal::perceived(&place.unwrap_or_default());
        self.counts.to_place = self.decisions_towards(place);
        self.robot.config.planning = Config::probing().planning;
        let clear = Goal::avoiding(&self.robot.config);
        self.counts.four_steps = self.decisions_towards(clear);
        self.robot.config.planning = Config::recommended().planning;
        let passing = Goal::passing(Side::Right, Range::from_mm(1_500), &self.robot.config);
        self.counts.passing = self.decisions_towards(passing);
        let following = Goal::following(Range::from_mm(340), &self.robot.config);
        self.counts.following = self.decisions_towards(following);
    }

    /// Instructions of the next decisions towards a goal.
    fn decisions_towards(&mut self, goal: Goal<16>) -> InstructionStats {
        let mut counted = InstructionStats::default();
        self.robot.send(|| Event::Command(Command::Seek(goal)));
        for _ in 0..DECISIONS {
            let (instructions, out) = self.robot.ring();
            counted.add(instructions);
            self.robot.carry_out(out.motion);
        }
        counted
    }
}
