//! What the virtual turret needs of the controller behind it.

use crate::config::Config;
use crate::controller::{self, Event, Mode, Outputs, State};
use crate::fixed::Mask;
use crate::goal::Goal;
use crate::places::Leg;
use crate::shield::Shield;
use crate::units::Millis;

/// A controller that decides by whole rings of a turret that keeps its bearing: [`State`], or a
/// rule to compare it with.
pub trait RingController<const SECTORS: usize> {
    /// Handles an event of the ring.
    fn handle_ring(
        &mut self,
        config: &Config<SECTORS>,
        at: Millis,
        event: Event<SECTORS>,
    ) -> Outputs<SECTORS>;

    /// What it knows of near things. Its own ring is read off points, and is nothing to steer clear
    /// of; a guard keeps there what the body's sensors hear.
    fn shield(&mut self) -> &mut Shield<SECTORS>;

    /// Whether the base has been sent on its way and has not reported its end.
    fn is_moving(&self) -> bool;

    /// Whether it pursues a goal, so that a decision may be taken anew.
    fn pursues_goal(&self) -> bool;

    /// The goal that it pursues; `None` for a rule of its own.
    fn goal(&self) -> Option<&Goal<SECTORS>> {
        None
    }

    /// Whether it pursues a place and comes no nearer.
    fn is_stuck(&self) -> bool {
        false
    }

    /// Whether it goes to a position by a rule of its own: silence counts then, as for a robot that
    /// its places lead to one.
    fn looks_for_position(&self) -> bool {
        false
    }

    /// The age of an echo heard at `at` that is not to be used, milliseconds; `None` = use it.
    fn stale_ms(&self, _config: &Config<SECTORS>, _at: Millis) -> Option<u32> {
        None
    }

    /// Whether it orders a motion when the next ring is complete.
    fn awaits_ring(&self) -> bool;

    /// From now on every sector has to be heard again.
    fn await_ring(&mut self, at: Millis);

    /// The sectors that it uses.
    fn enabled(&self, config: &Config<SECTORS>) -> Mask;

    /// Limits what is used of the ring to these sectors, until the next call.
    fn set_visible(&mut self, visible: Mask);

    /// Ends the motion under way before it began: nothing is learned from it.
    fn abandon_motion(&mut self, at: Millis);

    /// At the next decision it goes about along this way, if there is one; a rule of its own may go
    /// where it will.
    fn lead(&mut self, _leg: Option<Leg>) {}
}

impl<const SECTORS: usize, const NEURONS: usize, const SAMPLES: usize> RingController<SECTORS>
    for State<SECTORS, NEURONS, SAMPLES>
{
    fn handle_ring(
        &mut self,
        config: &Config<SECTORS>,
        at: Millis,
        event: Event<SECTORS>,
    ) -> Outputs<SECTORS> {
        controller::handle(config, self, at, event)
    }

    fn shield(&mut self) -> &mut Shield<SECTORS> {
        self.shield_mut()
    }

    fn is_moving(&self) -> bool {
        Self::is_moving(self)
    }

    fn pursues_goal(&self) -> bool {
        matches!(self.mode(), Mode::Seek { .. })
    }

    fn goal(&self) -> Option<&Goal<SECTORS>> {
        match self.mode() {
            Mode::Seek { goal } => Some(goal),
            _ => None,
        }
    }

    fn is_stuck(&self) -> bool {
        Self::is_stuck(self)
    }

    fn stale_ms(&self, config: &Config<SECTORS>, at: Millis) -> Option<u32> {
        Self::stale_ms(self, config, at)
    }

    fn awaits_ring(&self) -> bool {
        matches!(self.mode(), Mode::Explore { .. } | Mode::Seek { .. }) && !self.is_moving()
    }

    fn await_ring(&mut self, at: Millis) {
        Self::await_ring(self, at);
    }

    fn enabled(&self, config: &Config<SECTORS>) -> Mask {
        Self::enabled(self, config)
    }

    fn set_visible(&mut self, visible: Mask) {
        Self::set_visible(self, visible);
    }

    fn abandon_motion(&mut self, at: Millis) {
        Self::abandon_motion(self, at);
    }

    fn lead(&mut self, leg: Option<Leg>) {
        Self::lead(self, leg);
    }
}
