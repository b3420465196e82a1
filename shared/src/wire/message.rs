//! The messages of the link, and the values that both directions use.
//!
//! Quantities are integers with their unit in the name. Enumerations only grow at their ends.

use serde::{Deserialize, Serialize};

mod counters;
mod replies;
mod requests;

pub use counters::{Counters, DeviceCounters};
pub use replies::{
    DeviceHello, DeviceMessage, LogEvent, ModeReport, MotionCommand, Refusal, Report,
};
pub use requests::{
    FlashError, FlashOperation, GoalSpec, HostHello, HostMessage, RobotCommand, TimedEcho,
};

/// Most bytes of a part in one message.
pub const MAX_CHUNK: usize = 160;
/// Most echoes in one message.
pub const MAX_ECHOES: usize = 16;

/// A part of the state that is read and written in chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum TransferPart {
    /// The configuration, in postcard's form; written from its beginning on, it takes effect with
    /// the last chunk.
    Config,
    /// The situation map.
    Situations,
    /// The changes of the action map.
    Changes,
    /// The actions of the action map.
    Actions,
    /// The lazy memory.
    Memory,
    /// The body, as the configuration; empty if the program is for a held ring only.
    Body,
    /// The places.
    Places,
}

/// Where echoes come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// From the host, over the link.
    Link,
    /// From the ring at the chip's own pins.
    Ring,
}

/// Whose time counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Clock {
    /// The host's: time is that of its latest message. For simulators: a slow host changes nothing.
    Host,
    /// The device's own: a silent host stops the robot.
    Device,
}

/// What both ends have to agree on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Dimensions {
    /// Version of the protocol.
    pub protocol: u16,
    /// CRC-32 of the messages' grammar.
    pub schema: u32,
    /// Transducers.
    pub sensors: u8,
    /// Neurons of each map.
    pub neurons: u8,
}

/// What clocks the processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Oscillator {
    /// Not known: a simulator, or a board with one oscillator.
    #[default]
    Unknown,
    /// The crystal.
    Crystal,
    /// The internal oscillator, because the crystal failed or has an unexpected frequency. It is
    /// accurate to 1 % at 25 °C.
    Internal,
}

/// Why the program started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ResetCause {
    /// Not known.
    #[default]
    Unknown,
    /// Power came on.
    PowerOn,
    /// The reset pin.
    Pin,
    /// It was asked for.
    Requested,
    /// The watchdog was not fed.
    Watchdog,
    /// The program panicked.
    Panic,
    /// The processor faulted.
    HardFault,
    /// The stack left its region.
    StackOverflow,
}
