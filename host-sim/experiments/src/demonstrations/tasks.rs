//! The tasks: worlds, teacher and measure.

use super::measure::{
    Measure, in_doorway, off_center, off_circle, off_corner, off_distance, off_dock,
};
use super::rules::{self, Rule};
use arena::loaders::rooms;
use arena::world::{Point, World};
use sim::behavior::Behavior;

/// The worlds of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TaskWorlds {
    /// Of the kind in which it is demonstrated.
    Usual,
    /// Of another kind.
    Other,
}

/// What demonstrates a task.
#[derive(Debug, Clone, Copy)]
pub enum TaskKind {
    /// The built-in goal of the behavior of its name, which has a measure of its own.
    BuiltIn,
    /// A rule that sees the world.
    ByRule {
        /// The rule.
        rule: Rule,
        /// How well a path does the task.
        measure: Measure,
    },
}

/// What is demonstrated, and how it is measured.
pub struct Task {
    /// Its name.
    pub name: &'static str,
    /// Descriptions of the usual and of the other worlds.
    pub places: [&'static str; 2],
    /// Description of the measure.
    pub unit: &'static str,
    /// A smaller value of the measure is better.
    pub less_is_better: bool,
    /// Decisions.
    pub steps: u32,
    /// What demonstrates it.
    pub kind: TaskKind,
    /// Another robot starts ahead.
    pub leader: bool,
    /// Where the robot begins; `None` = anywhere.
    pub start: Option<fn(TaskWorlds, &World, u64) -> Point>,
    worlds: [fn(u64) -> World; 2],
}

impl Task {
    const fn built_in(
        name: &'static str,
        unit: &'static str,
        places: [&'static str; 2],
        worlds: [fn(u64) -> World; 2],
    ) -> Self {
        Self {
            name,
            places,
            unit,
            less_is_better: false,
            steps: 500,
            kind: TaskKind::BuiltIn,
            leader: false,
            start: None,
            worlds,
        }
    }

    const fn by_rule(
        name: &'static str,
        rule: Rule,
        (measure, unit): (Measure, &'static str),
        places: [&'static str; 2],
        worlds: [fn(u64) -> World; 2],
    ) -> Self {
        Self {
            kind: TaskKind::ByRule { rule, measure },
            less_is_better: true,
            steps: 300,
            ..Self::built_in(name, unit, places, worlds)
        }
    }

    const fn less_is_better(mut self) -> Self {
        self.less_is_better = true;
        self
    }

    const fn more_is_better(mut self) -> Self {
        self.less_is_better = false;
        self
    }

    const fn with_leader(mut self) -> Self {
        (self.leader, self.steps) = (true, 400);
        self
    }

    const fn from(mut self, start: fn(TaskWorlds, &World, u64) -> Point) -> Self {
        self.start = Some(start);
        self
    }

    /// The behavior that is measured with it.
    #[must_use]
    pub fn behavior(&self) -> Behavior {
        match self.kind {
            TaskKind::BuiltIn => self.name.parse().unwrap_or(Behavior::Avoid),
            TaskKind::ByRule { .. } => Behavior::Avoid,
        }
    }

    /// World number `index` of a kind.
    #[must_use]
    pub fn world(&self, worlds: TaskWorlds, index: u64) -> World {
        (self.worlds[worlds as usize])(index)
    }

    /// Description of the worlds of a kind.
    #[must_use]
    pub const fn place(&self, worlds: TaskWorlds) -> &'static str {
        self.places[worlds as usize]
    }
}

/// All tasks.
pub static TASKS: &[Task] = &[
    Task::built_in(
        "avoid",
        "area m²",
        ["12 boxes", "12 other kinds"],
        [World::random, World::random2],
    ),
    Task::built_in(
        "avoid-right",
        "passed on its left",
        ["one obstacle", "five boxes"],
        [rooms::one_obstacle, rooms::boxes],
    ),
    Task::built_in(
        "wall-right",
        "error m",
        ["five boxes", "12 other kinds"],
        [rooms::boxes, World::random2],
    )
    .less_is_better(),
    Task::built_in(
        "wall-left",
        "error m",
        ["corridor", "12 other kinds"],
        [rooms::corridor, World::random2],
    )
    .less_is_better(),
    Task::built_in(
        "follow",
        "share of 300 s",
        ["plain room", "five boxes"],
        [rooms::plain, rooms::boxes],
    )
    .with_leader(),
    Task::by_rule(
        "corridor center",
        rules::center,
        (off_center, "error m"),
        ["corridor", "closed loop"],
        [rooms::corridor, rooms::around_a_block],
    ),
    Task::by_rule(
        "doorway",
        rules::doorway,
        (in_doorway, "reached"),
        ["from the room", "from the hall"],
        [rooms::with_exit, rooms::with_exit],
    )
    .more_is_better()
    .from(beside_the_exit),
    Task::by_rule(
        "corner",
        rules::into_corner,
        (off_corner, "error m"),
        ["plain room", "4 m × 4 m"],
        [rooms::plain, rooms::small],
    ),
    Task::by_rule(
        "dock",
        rules::dock,
        (off_dock, "error m"),
        ["plain room", "five boxes"],
        [rooms::plain, rooms::boxes],
    ),
    Task::by_rule(
        "distance ahead",
        rules::keep_distance,
        (off_distance, "error m"),
        ["plain room", "five boxes"],
        [rooms::plain, rooms::boxes],
    )
    .with_leader(),
    Task::by_rule(
        "circle",
        rules::circle,
        (off_circle, "error m"),
        ["one obstacle", "large block"],
        [rooms::one_obstacle, rooms::one_block],
    )
    .from(|_, world, _| world.start().position),
];

fn beside_the_exit(worlds: TaskWorlds, world: &World, seed: u64) -> Point {
    match worlds {
        TaskWorlds::Usual => rooms::inside(seed),
        TaskWorlds::Other => world.start().position,
    }
}
