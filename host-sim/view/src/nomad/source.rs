//! The view's interface to a Nomad: steps, commands, snapshots, shutdown.

use super::{NomadActivity, WatchedNomad};
use crate::command::{CommandOutcome, PageCommand};
use crate::snapshot::Snapshot;
use crate::source::{Capabilities, CommandRefused, StepOutcome, ViewSource};
use nomad200::bridge::POLL_INTERVAL;
use remote::log::SharedLog;
use std::time::Duration;

impl ViewSource for WatchedNomad {
    fn abilities(&self) -> Capabilities {
        Capabilities {
            drive: true,
            configure: true,
            save: true,
            ..Capabilities::default()
        }
    }

    fn step(&mut self) -> StepOutcome {
        if self.failure.is_some() {
            return StepOutcome::Idle;
        }
        std::thread::sleep(POLL_INTERVAL);
        let whole = match self.update() {
            Ok(whole) => whole,
            Err(trouble) => {
                self.fail(&trouble);
                return StepOutcome::Idle;
            }
        };
        let before_s = std::mem::replace(&mut self.time_s, self.session.time_s());
        StepOutcome::Took {
            took_s: self.time_s - before_s,
            whole,
        }
    }

    fn execute(&mut self, command: &PageCommand) -> Result<CommandOutcome, CommandRefused> {
        if let Some(why) = &self.failure {
            return Err(why.clone().into());
        }
        self.execute_command(command)
    }

    fn snapshot(&mut self) -> Snapshot {
        self.parts()
    }

    fn steering_lost(&mut self, silence: Duration) {
        if self.failure.is_some()
            || !matches!(self.activity, NomadActivity::Explore | NomadActivity::Seek)
        {
            return;
        }
        match self.stop() {
            Ok(()) => {
                let seconds = silence.as_secs_f64();
                self.note = Some(format!(
                    "It stopped: no page has steered it for {seconds} s"
                ));
            }
            Err(trouble) => self.fail(&trouble),
        }
    }

    fn end(&mut self) -> Result<(), String> {
        if self.failure.is_none() {
            self.session.finish(false);
        }
        self.log.as_ref().map_or(Ok(()), SharedLog::finish)
    }
}
