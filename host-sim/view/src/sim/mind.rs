//! What the robot knows, as a file.

use super::Simulator;
use crate::command::CommandOutcome;
use crate::configure::knowledge_file;
use crate::source::CommandRefused;
use files::hex::unhex;
use remote::link::Knowledge;

impl Simulator {
    pub(super) fn save_mind(&mut self) -> Result<CommandOutcome, CommandRefused> {
        Ok(knowledge_file(&self.controller.pilot().saved()?))
    }

    pub(super) fn load_mind(&mut self, hex: &str) -> Result<(), CommandRefused> {
        if !self.controller.inner().is_local() {
            return Err(
                "load the file into a remote controller with `host-sim link … upload`".into(),
            );
        }
        let bytes = unhex(hex).ok_or("the file is incomplete")?;
        let knowledge = Knowledge::from_bytes(&bytes)?;
        knowledge.check_robot(self.start.setup.robot.as_ref())?;
        self.renew(self.start.clone(), knowledge.config())?;
        self.controller.load(self.body.now(), &knowledge);
        self.learned = knowledge.state().has_learned();
        // It knows where its sensors look.
        self.is_calibrated = self.learned;
        if self.has_places() {
            // Of this world, for all that is known. Where in it the robot is it has to find out.
            self.begin_places();
            self.carry_places();
        }
        Ok(())
    }
}
