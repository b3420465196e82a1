//! Whoever drives: takes what happens to the robot, says what the base is to do.

use amp::config::Config;
use amp::controller::{self, Event, Outputs, State};
use amp::som::Grid;
use amp::units::Millis;

/// Most random moves the simulator's memory holds.
pub const MOST_MOVES: u16 = 1_000;

/// The mind's state with the simulator's larger memory; all else as on the chip.
pub type SimState = State<16, 16, { MOST_MOVES as usize }>;

/// Something that drives the robot by its echoes.
pub trait Pilot {
    /// Takes one event and says what to do.
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16>;
}

/// The robot's mind: the very crate that runs on the microcontroller.
pub struct Mind {
    config: Config<16>,
    state: Box<SimState>,
}

impl Mind {
    /// A mind that knows nothing yet.
    #[must_use]
    pub fn new(config: Config<16>) -> Self {
        Self {
            config,
            state: Box::new(State::new(Grid::rectangle(4, 4))),
        }
    }

    /// What it was told.
    #[must_use]
    pub fn config(&self) -> &Config<16> {
        &self.config
    }

    /// What it knows.
    #[must_use]
    pub fn state(&self) -> &SimState {
        &self.state
    }
}

impl Pilot for Mind {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        controller::handle(&self.config, &mut self.state, at, event)
    }
}
