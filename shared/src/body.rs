//! What stands between a robot's transducers and the controller.
//!
//! | body | transducers |
//! |---|---|
//! | [`HeldRing`] | an even ring that keeps its bearing in the world: the controller hears it as it is |
//! | [`MountedSensors`] | anywhere on the body, known or to be found: behind a [virtual turret](crate::turret) |

use crate::config::Config;
#[cfg(feature = "store")]
use crate::config::MAX_CONFIG;
#[cfg(feature = "store")]
use crate::controller::TransferError;
use crate::controller::{self, Event, Outputs, State};
use crate::places::Aim;
use crate::units::Millis;

mod mounted_sensors;

pub use mounted_sensors::MountedSensors;

/// Hands events of the robot to the controller, and its motions back.
pub trait Body<const SENSORS: usize> {
    /// A body of which nothing is known yet. All zeros: a static one takes no flash.
    const NEW: Self;

    /// Most bytes of [`to_bytes`](Self::to_bytes).
    #[cfg(feature = "store")]
    const MAX_BYTES: usize = 0;

    /// Most bytes of its places; 0 if it has no memory of places.
    #[cfg(feature = "store")]
    const MAX_PLACES_BYTES: usize = 0;

    /// Bytes of a place; 1 if it has no memory of places.
    #[cfg(feature = "store")]
    const PLACE_BYTES: usize = 1;

    /// Handles an event as [`controller::handle`] does.
    fn handle<const NEURONS: usize, const SAMPLES: usize>(
        &mut self,
        config: &Config<SENSORS>,
        state: &mut State<SENSORS, NEURONS, SAMPLES>,
        at: Millis,
        event: Event<SENSORS>,
    ) -> Outputs<SENSORS>;

    /// From now on its memory of places leads a robot that pursues a goal there; `None`: it finds
    /// its way by the goal alone. False if it has no memory of places.
    fn lead_to(&mut self, _aim: Option<Aim>) -> bool {
        false
    }

    /// The robot was carried elsewhere. False if it has no memory of places.
    fn set_down(&mut self) -> bool {
        false
    }

    /// Whether it thinks before it decides: [`think`](Self::think) is to be called between events.
    fn is_thinking(&self) -> bool {
        false
    }

    /// Thinks on for a short while.
    fn think<const NEURONS: usize, const SAMPLES: usize>(
        &mut self,
        _config: &Config<SENSORS>,
        _state: &mut State<SENSORS, NEURONS, SAMPLES>,
        _at: Millis,
    ) -> Outputs<SENSORS> {
        Outputs::NONE
    }

    /// The body as it is known, in postcard's form; nothing if there is nothing to be told.
    #[cfg(feature = "store")]
    fn to_bytes<'a>(&self, buffer: &'a mut [u8; MAX_CONFIG]) -> &'a [u8];

    /// Replaces what is known of the body, for a robot that stands; false for bytes that are no
    /// body of this kind.
    #[cfg(feature = "store")]
    fn replace(&mut self, bytes: &[u8]) -> bool;

    /// Length of its places in bytes; see [`Places::read_saved`](crate::places::Places::read_saved)
    /// for this and the next two.
    #[cfg(feature = "store")]
    fn places_len(&self) -> usize {
        0
    }

    /// Copies its places from `offset` on into `out`, as far as both reach; returns the number of
    /// bytes.
    #[cfg(feature = "store")]
    fn read_places(&self, _offset: usize, _out: &mut [u8]) -> usize {
        0
    }

    /// Replaces a piece of the places of a robot that stands, whole places each, in order; one at
    /// offset 0 forgets all places first. The robot may then be anywhere among them.
    ///
    /// # Errors
    /// [`TransferError::OutOfBounds`], also without a memory of places; nothing has changed then.
    #[cfg(feature = "store")]
    fn write_places(&mut self, _offset: usize, _bytes: &[u8]) -> Result<(), TransferError> {
        Err(TransferError::OutOfBounds)
    }
}

/// A ring that keeps its bearing in the world: a [`RobotSpec`](crate::robot::RobotSpec) says all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HeldRing;

impl<const SENSORS: usize> Body<SENSORS> for HeldRing {
    const NEW: Self = Self;

    // The only caller is on the path of every echo.
    #[inline(always)]
    fn handle<const NEURONS: usize, const SAMPLES: usize>(
        &mut self,
        config: &Config<SENSORS>,
        state: &mut State<SENSORS, NEURONS, SAMPLES>,
        at: Millis,
        event: Event<SENSORS>,
    ) -> Outputs<SENSORS> {
        controller::handle(config, state, at, event)
    }

    #[cfg(feature = "store")]
    fn to_bytes<'a>(&self, _: &'a mut [u8; MAX_CONFIG]) -> &'a [u8] {
        &[]
    }

    #[cfg(feature = "store")]
    fn replace(&mut self, bytes: &[u8]) -> bool {
        bytes.is_empty()
    }
}
