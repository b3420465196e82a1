//! What outlives a loss of power, and goals under names.
//!
//! The node itself has no flash. It notes what a host asks for; whoever has the flash looks at [`Node::flash_task`], does
//! it and says how it ended.

use super::{FrameSink, Node};
use crate::goal::{KeptGoal, Name};
use crate::store::{Contents, ContentsMut, Fault};
use crate::units::Millis;
use crate::wire::message::{Flash, FlashError, FromMind, Refusal};

/// A request that waits for the flash; all zeros while there is none.
#[derive(Debug, Clone, Copy)]
pub(super) struct FlashTask {
    /// Number of the frame that asked.
    seq: Option<u16>,
    what: Flash,
}

impl FlashTask {
    /// No request.
    pub(super) const NONE: Self = Self {
        seq: None,
        what: Flash::Save,
    };
}

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    Node<SENSORS, NEURONS, SAMPLES>
{
    /// What is to be saved of it.
    #[must_use]
    pub const fn contents(&self) -> Contents<'_, SENSORS, NEURONS, SAMPLES> {
        Contents {
            config: &self.config,
            state: &self.state,
            goal: &self.goal,
            kept: &self.goals,
        }
    }

    /// Replaces all it was told and has learned by an image's; for a node that stands still.
    ///
    /// # Errors
    /// [`Fault`]; nothing has changed then, see [`ContentsMut::read`].
    pub fn recall(
        &mut self,
        read: &mut dyn FnMut(usize, &mut [u8]) -> bool,
        most: usize,
    ) -> Result<(), Fault> {
        let mut contents = ContentsMut {
            config: &mut self.config,
            state: &mut self.state,
            goal: &mut self.goal,
            kept: &mut self.goals,
        };
        let open_space = contents.config.open_space;
        contents.read(read, most)?;
        // Whether open space is expected is up to the session.
        self.config.open_space = open_space;
        self.underway = None;
        Ok(())
    }

    /// What is to be done with the flash, until [`flash_done`](Self::flash_done). Frames and time should wait meanwhile.
    #[must_use]
    pub const fn flash_task(&self) -> Option<Flash> {
        match self.flash.seq {
            Some(_) => Some(self.flash.what),
            None => None,
        }
    }

    /// Says that nothing will be heard or said for at most `ms` milliseconds.
    pub fn announce_pause(&mut self, ms: u32, now: Millis, out: &mut impl FrameSink) {
        self.say(FromMind::Busy { ms }, now, out);
    }

    /// Answers the request for the flash; from now on the host is waited for as usual.
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
        self.kept.end();
    }

    /// Notes a request for the flash.
    pub(super) fn ask_flash(&mut self, seq: u16, what: Flash) -> Result<(), Refusal> {
        self.standing()?;
        let seq = Some(seq);
        self.flash = FlashTask { seq, what };
        Ok(())
    }

    pub(super) fn keep_goal(&mut self, name: Name) -> Result<(), Refusal> {
        let goal = self.goal;
        let kept = self.goals.keep(KeptGoal { name, goal });
        kept.map_err(|_| Refusal::GoalName)
    }

    pub(super) fn drop_goal(&mut self, name: Name) -> Result<(), Refusal> {
        let dropped = self.goals.drop(name);
        dropped.then_some(()).ok_or(Refusal::NoSuchGoal)
    }

    /// Says every goal, the present one first. Not a part of every request's stack.
    #[inline(never)]
    pub(super) fn say_goals(&mut self, now: Millis, out: &mut impl FrameSink) {
        let (name, goal) = (Name::NONE, self.goal);
        self.say(FromMind::Goal { name, goal }, now, out);
        for index in 0..self.goals.as_slice().len() {
            if let Some(&KeptGoal { name, goal }) = self.goals.as_slice().get(index) {
                self.say(FromMind::Goal { name, goal }, now, out);
            }
        }
    }
}
