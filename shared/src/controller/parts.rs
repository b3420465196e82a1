//! Maps and memory as bytes, read and written in pieces.
//!
//! | part | bytes, little-endian |
//! |---|---|
//! | [`StatePart::Situations`] | code vectors of the situation map, neuron by neuron, each component as `i32` in units of 2⁻²⁹ |
//! | [`StatePart::Changes`] | code vectors of the action map's changes, as above |
//! | [`StatePart::Actions`] | code vectors of its actions (two components), as above |
//! | [`StatePart::Memory`] | samples in the order they came: before and after, a byte per transducer (see [`memory`](crate::memory)); commanded dx, dy, executed dx, dy as `i16` millimeters |

use super::tracked::Tracked;
use super::{Mode, State};
use crate::faults::Detector;
use crate::fixed::{Mask, Weight32};
use crate::memory::Sample;
use crate::planner::SearchCache;
use crate::som::Som;
use crate::units::Displacement;
use serde::{Deserialize, Serialize};

/// A part of what the robot knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum StatePart {
    /// The situation map.
    Situations,
    /// The changes of the action map.
    Changes,
    /// The actions of the action map.
    Actions,
    /// The lazy memory.
    Memory,
}

/// Why a piece was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum TransferError {
    /// The robot explores, learns or seeks.
    Busy,
    /// The piece does not begin or end where a component or a sample does, or lies beyond the end;
    /// samples come in order.
    OutOfBounds,
}

impl core::fmt::Display for TransferError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Busy => "the robot explores, learns or seeks",
            Self::OutOfBounds => "the piece does not fit where it says",
        })
    }
}

impl core::error::Error for TransferError {}

/// Bytes of a component.
const COMPONENT: usize = 4;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    /// Bytes of a sample.
    pub const SAMPLE_BYTES: usize = 2 * SENSORS + 8;

    /// Length of a part in bytes.
    #[must_use]
    pub fn part_len(&self, part: StatePart) -> usize {
        match part {
            StatePart::Situations | StatePart::Changes => COMPONENT * SENSORS * NEURONS,
            StatePart::Actions => COMPONENT * 2 * NEURONS,
            StatePart::Memory => self.memory.samples().len() * Self::SAMPLE_BYTES,
        }
    }

    /// Copies a part from `offset` on into `out`, as far as both reach; returns the number of
    /// bytes.
    // One copy in the program.
    #[inline(never)]
    pub fn read_part(&self, part: StatePart, offset: usize, out: &mut [u8]) -> usize {
        let rest = self.part_len(part).saturating_sub(offset);
        let count = rest.min(out.len());
        for (place, index) in out.iter_mut().zip(offset..offset.saturating_add(count)) {
            *place = self.part_byte(part, index);
        }
        count
    }

    fn part_byte(&self, part: StatePart, index: usize) -> u8 {
        match part {
            StatePart::Situations => map_byte(&self.situations, index),
            StatePart::Changes => map_byte(self.actions.changes(), index),
            StatePart::Actions => map_byte(self.actions.actions(), index),
            StatePart::Memory => {
                let sample = self.memory.samples().get(index / Self::SAMPLE_BYTES);
                sample.map_or(0, |sample| sample_byte(sample, index % Self::SAMPLE_BYTES))
            }
        }
    }

    /// Replaces a piece of a part. A memory is written from its beginning on, whole samples in
    /// order; a piece at offset 0 empties it first. When all three maps have been written to their
    /// ends they count as learned.
    ///
    /// # Errors
    /// [`TransferError`]; nothing has changed then.
    pub fn write_part(
        &mut self,
        part: StatePart,
        offset: usize,
        bytes: &[u8],
    ) -> Result<(), TransferError> {
        if !matches!(self.mode, Mode::Idle | Mode::Stopped(_)) {
            return Err(TransferError::Busy);
        }
        match part {
            StatePart::Situations => {
                write_map(&mut self.situations, offset, bytes)?;
                self.forget_traversals();
            }
            StatePart::Changes => write_map(self.actions.changes_mut(), offset, bytes)?,
            StatePart::Actions => write_map(self.actions.actions_mut(), offset, bytes)?,
            StatePart::Memory => return self.write_memory(offset, bytes),
        }
        if offset.saturating_add(bytes.len()) == self.part_len(part) {
            self.written |= 1 << (part as u8);
            self.updates = 0;
            self.learned |= self.written == 0b111;
        }
        Ok(())
    }

    fn write_memory(&mut self, offset: usize, bytes: &[u8]) -> Result<(), TransferError> {
        let kept = if offset == 0 {
            0
        } else {
            self.memory.samples().len()
        };
        let (samples, rest) = (
            bytes.chunks_exact(Self::SAMPLE_BYTES),
            bytes.len() % Self::SAMPLE_BYTES,
        );
        if rest != 0
            || offset != kept * Self::SAMPLE_BYTES
            || kept.saturating_add(samples.len()) > SAMPLES
        {
            return Err(TransferError::OutOfBounds);
        }
        if offset == 0 {
            self.memory.clear();
        }
        for bytes in samples {
            // There is room: it was counted above.
            let _ = self.memory.keep(sample_of(bytes));
        }
        Ok(())
    }

    /// Forgets samples, maps and goal: as after the start.
    // One copy in the program.
    #[inline(never)]
    pub fn forget(&mut self) {
        self.mode = Mode::Idle;
        self.interrupted = Mode::Idle;
        self.scan.renew();
        self.heard_any = false;
        self.silent_rings = 0;
        self.detector = Detector::new();
        self.hidden = Mask::NONE;
        self.shield.forget();
        self.memory.clear();
        self.situations.clear();
        self.actions.changes_mut().clear();
        self.actions.actions_mut().clear();
        self.learned = false;
        self.updates = 0;
        self.written = 0;
        self.generator = None;
        self.pending = None;
        self.moving = false;
        self.acting_neuron = None;
        self.motion_id = 0;
        self.course = Tracked::ZERO;
        self.inhibited = [0; NEURONS];
        self.last_plan = SearchCache::NONE;
        self.search = super::SearchProgress::NEW;
    }
}

fn map_byte<const NEURONS: usize, const DIMS: usize>(map: &Som<NEURONS, DIMS>, index: usize) -> u8 {
    let component = map.component(index / COMPONENT).unwrap_or(Weight32::ZERO);
    let bytes = component.to_bits().to_le_bytes();
    bytes.get(index % COMPONENT).copied().unwrap_or(0)
}

fn write_map<const NEURONS: usize, const DIMS: usize>(
    map: &mut Som<NEURONS, DIMS>,
    offset: usize,
    bytes: &[u8],
) -> Result<(), TransferError> {
    let (components, rest) = bytes.as_chunks::<COMPONENT>();
    let end = offset.saturating_add(bytes.len());
    if !rest.is_empty() || !offset.is_multiple_of(COMPONENT) || end > COMPONENT * NEURONS * DIMS {
        return Err(TransferError::OutOfBounds);
    }
    for (index, component) in (offset / COMPONENT..).zip(components) {
        map.set_component(index, Weight32::from_bits(i32::from_le_bytes(*component)));
    }
    Ok(())
}

fn sample_byte<const SENSORS: usize>(sample: &Sample<SENSORS>, index: usize) -> u8 {
    let situations = sample.before.iter().chain(&sample.after).copied();
    let moves = [sample.commanded, sample.executed].into_iter();
    let moves = moves.flat_map(|moved| [moved.dx_mm, moved.dy_mm]);
    let mut bytes = situations.chain(moves.flat_map(i16::to_le_bytes));
    bytes.nth(index).unwrap_or(0)
}

fn sample_of<const SENSORS: usize>(bytes: &[u8]) -> Sample<SENSORS> {
    let byte = |index: usize| bytes.get(index).copied().unwrap_or(0);
    let value = |index: usize| i16::from_le_bytes([byte(index), byte(index.saturating_add(1))]);
    let moved = |index: usize| Displacement {
        dx_mm: value(index),
        dy_mm: value(index.saturating_add(2)),
    };
    Sample {
        before: core::array::from_fn(byte),
        after: core::array::from_fn(|sensor| byte(SENSORS.saturating_add(sensor))),
        commanded: moved(2 * SENSORS),
        executed: moved(2 * SENSORS + 4),
    }
}
