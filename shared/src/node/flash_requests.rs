//! Requests for the flash, and goals saved under names.
//!
//! The node itself has no flash. It stores a host's request; the device polls [`Node::flash_task`],
//! does it and reports the result.

use super::{FrameSink, Node};
use crate::body::Body;
use crate::goal::{Name, NamedGoal};
use crate::store::Contents;
use crate::units::Millis;
use crate::wire::message::{DeviceMessage, FlashError, FlashOperation, Refusal};

/// A request that waits for the flash; all zeros if there is none.
#[derive(Debug, Clone, Copy)]
pub(super) struct FlashRequest {
    /// Number of the frame that asked.
    seq: Option<u16>,
    operation: FlashOperation,
}

impl FlashRequest {
    /// No request.
    pub(super) const NONE: Self = Self {
        seq: None,
        operation: FlashOperation::Save,
    };
}

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize, B: Body<SENSORS>>
    Node<SENSORS, NEURONS, SAMPLES, B>
{
    /// What a saved image holds.
    #[must_use]
    pub const fn contents(&self) -> Contents<'_, SENSORS, NEURONS, SAMPLES, B> {
        Contents {
            config: &self.config,
            body: &self.body,
            state: &self.state,
            goal: &self.goal,
            goals: &self.goals,
        }
    }

    /// The request for the flash, until [`flash_done`](Self::flash_done). Frames and ticks wait
    /// meanwhile.
    #[must_use]
    pub const fn flash_task(&self) -> Option<FlashOperation> {
        match self.flash.seq {
            Some(_) => Some(self.flash.operation),
            None => None,
        }
    }

    /// Tells the host that the node neither receives nor sends for at most `ms` milliseconds.
    pub fn announce_pause(&mut self, ms: u32, now: Millis, out: &mut impl FrameSink) {
        self.send(DeviceMessage::Busy { ms }, now, out);
    }

    /// Answers the request for the flash. From now on a silent host stops the robot again.
    pub fn flash_done(
        &mut self,
        result: Result<(), FlashError>,
        now: Millis,
        out: &mut impl FrameSink,
    ) {
        let Some(seq) = self.flash.seq.take() else {
            return;
        };
        self.link.resume(now);
        if let Err(why) = result {
            self.refuse(seq, Refusal::Flash(why), now, out);
        }
        self.done(seq, now, out);
        self.reply_cache.finish();
    }

    /// Stores a request for the flash.
    pub(super) fn request_flash(
        &mut self,
        seq: u16,
        operation: FlashOperation,
    ) -> Result<(), Refusal> {
        self.require_standing()?;
        let seq = Some(seq);
        self.flash = FlashRequest { seq, operation };
        Ok(())
    }

    pub(super) fn save_goal(&mut self, name: Name) -> Result<(), Refusal> {
        let goal = self.goal;
        let saved = self.goals.save(NamedGoal { name, goal });
        saved.map_err(|_| Refusal::InvalidGoalName)
    }

    pub(super) fn delete_goal(&mut self, name: Name) -> Result<(), Refusal> {
        let deleted = self.goals.delete(name);
        deleted.then_some(()).ok_or(Refusal::NoSuchGoal)
    }

    /// Sends every goal, the present one first.
    // Apart, so that it adds nothing to the stack of every request.
    #[inline(never)]
    pub(super) fn send_goals(&mut self, now: Millis, out: &mut impl FrameSink) {
        let (name, goal) = (Name::NONE, self.goal);
        self.send(DeviceMessage::Goal { name, goal }, now, out);
        for index in 0..self.goals.as_slice().len() {
            if let Some(&NamedGoal { name, goal }) = self.goals.as_slice().get(index) {
                self.send(DeviceMessage::Goal { name, goal }, now, out);
            }
        }
    }
}
