//! What a device counts from its start on.

use serde::{Deserialize, Serialize};

/// What has been counted since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counters {
    /// Frames accepted.
    pub accepted: u32,
    /// Frames with wrong COBS or of a wrong length.
    pub malformed: u32,
    /// Frames with a wrong CRC.
    pub crc_errors: u32,
    /// Sound frames without a message of this protocol.
    pub unknown: u32,
    /// Frames too long for the buffer.
    pub oversized: u32,
    /// Frames of another session or none.
    pub wrong_session: u32,
    /// Frames that came again or too late.
    pub replayed: u32,
    /// Commands past their time to live.
    pub expired: u32,
    /// Requests refused.
    pub refused: u32,
    /// Frames sent.
    pub sent: u32,
    /// Frames that found no room on the way out.
    pub dropped: u32,
    /// Times the host was lost.
    pub link_losses: u32,
    /// Echoes that were too old to be used.
    pub stale_echoes: u32,
    /// How far the host's clock has fallen behind the device's in this session, milliseconds;
    /// negative: it is ahead.
    pub clock_drift_ms: i32,
    /// What the device counted.
    pub device: DeviceCounters,
}

impl Counters {
    /// Nothing counted.
    pub const NONE: Self = Self {
        accepted: 0,
        malformed: 0,
        crc_errors: 0,
        unknown: 0,
        oversized: 0,
        wrong_session: 0,
        replayed: 0,
        expired: 0,
        refused: 0,
        sent: 0,
        dropped: 0,
        link_losses: 0,
        stale_echoes: 0,
        clock_drift_ms: 0,
        device: DeviceCounters {
            overruns: 0,
            queue_losses: 0,
            stack_peak_bytes: 0,
            ticks: 0,
            longest_tick_ms: 0,
            ring_faults: 0,
        },
    };
}

/// What the device itself counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct DeviceCounters {
    /// Bytes the receiver's hardware lost.
    pub overruns: u32,
    /// Bytes that found no room in the receive queue.
    pub queue_losses: u32,
    /// Most bytes of stack used.
    pub stack_peak_bytes: u32,
    /// Control ticks.
    pub ticks: u32,
    /// Longest time between two control ticks.
    pub longest_tick_ms: u32,
    /// Firings of the chip's own ring that its ECHO line spoilt, and readings for which there was
    /// no room.
    pub ring_faults: u32,
}
