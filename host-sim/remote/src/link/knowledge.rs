//! Configuration, knowledge, body, places and goals of a controller, and what a robot perceived
//! beside ranges: read from a device, written to one, or kept in a [file](file).

mod file;

use super::{Fingerprint, LinkError, Session, next_number};
use amp::body::Body as _;
use amp::config::Config;
use amp::config::MAX_CONFIG;
use amp::controller::StatePart;
use amp::goal::{Goal, Name, NamedGoal, NamedGoals};
use amp::som::Grid;
use amp::turret::BodySpec;
use amp::units::Millis;
use amp::wire::message::{
    Clock, DeviceMessage, GoalSpec, MAX_CHUNK, ModeReport, Refusal, RobotCommand, TransferPart,
};
use amp::wire::{CRC, HostMessage};
use sim::pilot::SimState;
use sim::robot::AnyRobot;
use sim::senses::SavedSenses;
use sim::sim_controller::SimController;
use sim::turret_pilot::SimBody;

/// The parts of the state, in the order of reading.
const PARTS: [(TransferPart, StatePart); 4] = [
    (TransferPart::Situations, StatePart::Situations),
    (TransferPart::Changes, StatePart::Changes),
    (TransferPart::Actions, StatePart::Actions),
    (TransferPart::Memory, StatePart::Memory),
];

/// Bytes of places in one piece: whole places.
pub(super) const PLACES_PIECE: usize = MAX_CHUNK / SimBody::PLACE_BYTES * SimBody::PLACE_BYTES;

/// Configuration, maps, memory, body, places and goals of a controller.
#[derive(Debug, Clone, PartialEq)]
pub struct Knowledge {
    config: Config<16>,
    state: Box<SimState>,
    /// The body and its places; nothing is known of that of a ring on a held turret.
    body: Box<SimBody>,
    goal: Goal<16>,
    named_goals: NamedGoals<16>,
    senses: SavedSenses,
}

impl Knowledge {
    /// That of a controller in this process; its goal is to avoid obstacles.
    #[must_use]
    pub fn of(config: &Config<16>, state: &SimState) -> Self {
        Self::new(config.clone(), state.clone())
    }

    /// That of a controller in this process, with its body, its places and what it perceived there.
    #[must_use]
    pub fn of_controller(controller: &SimController) -> Self {
        let mut knowledge = Self::of(controller.config(), controller.state());
        if let Some(turret) = controller.as_turret() {
            knowledge.body = Box::new(turret.body_state().clone());
            knowledge.senses = turret.senses().saved();
        }
        knowledge
    }

    /// A controller of a robot of the same kind, in this process, gets all of it but the goals.
    pub fn give_to(&self, controller: &mut SimController, at: Millis) {
        controller.replace(&self.config, &self.state, self.body());
        controller.restore_senses(&self.senses, at);
    }

    /// The robot perceived this beside ranges.
    pub(super) fn add_senses(&mut self, senses: SavedSenses) {
        self.senses = senses;
    }

    fn new(config: Config<16>, state: SimState) -> Self {
        Self {
            body: Box::default(),
            goal: Goal::avoiding(&config),
            named_goals: NamedGoals::new(),
            senses: SavedSenses::default(),
            state: Box::new(state),
            config,
        }
    }

    /// Reads everything from a controller at rest.
    ///
    /// # Errors
    /// [`LinkError`]; a refusal while the robot explores, learns or seeks.
    pub fn download(session: &mut Session) -> Result<Self, LinkError> {
        require_idle(session)?;
        let mut knowledge = Self::read(session)?;
        knowledge.read_body(session)?;
        for report in session.query(&HostMessage::ListGoals)? {
            let DeviceMessage::Goal { name, goal } = report.message else {
                continue;
            };
            if name == Name::NONE {
                knowledge.goal = goal;
            } else {
                let saved = knowledge.named_goals.save(NamedGoal { name, goal });
                saved.map_err(|_| LinkError::Mismatch { what: "goals" })?;
            }
        }
        Ok(knowledge)
    }

    /// Reads body and places as well. A ring on a held turret has neither; any other robot has to
    /// stand: its places change while it drives.
    ///
    /// # Errors
    /// [`LinkError`]; a refusal while the robot explores, learns or seeks.
    pub fn read_body(&mut self, session: &mut Session) -> Result<(), LinkError> {
        let body = session.read_part(TransferPart::Body)?;
        if !self.body.replace(&body) {
            return Err(LinkError::Mismatch { what: "body" });
        }
        if body.is_empty() {
            return Ok(());
        }
        require_idle(session)?;
        let places = session.read_part(TransferPart::Places)?;
        for (index, piece) in places.chunks(PLACES_PIECE).enumerate() {
            let written = self.body.write_places(index * PLACES_PIECE, piece);
            written.map_err(|_| LinkError::Mismatch { what: "places" })?;
        }
        Ok(())
    }

    /// Reads everything but body, places and goals, in any mode.
    pub fn read(session: &mut Session) -> Result<Self, LinkError> {
        let config = session.read_part(TransferPart::Config)?;
        let config = Config::from_bytes(&config).ok_or(LinkError::Refused(Refusal::Config))?;
        let mut parts = Vec::new();
        for (part, ours) in PARTS {
            parts.push((ours, session.read_part(part)?));
        }
        let mut state = SimState::new(Grid::rectangle(4, 4));
        let is_map = |part: StatePart| part != StatePart::Memory;
        // Maps that were never learned are all zeros and do not count as learned.
        let learned = parts
            .iter()
            .any(|(part, bytes)| is_map(*part) && bytes.iter().any(|byte| *byte != 0));
        for (part, bytes) in parts {
            if is_map(part) && !learned {
                continue;
            }
            let written = state.write_part(part, 0, &bytes);
            written.map_err(|why| LinkError::Refused(Refusal::Transfer(why)))?;
            if state.part_len(part) != bytes.len() {
                return Err(LinkError::Mismatch { what: "maps" });
            }
        }
        Ok(Self::new(config, state))
    }

    /// Writes everything to a controller at rest, and checks configuration, maps and memory in a
    /// new session. One without a memory of places gets none.
    ///
    /// # Errors
    /// [`LinkError`]; a refusal while the robot explores, learns or seeks.
    pub fn upload(&self, session: &mut Session) -> Result<(), LinkError> {
        require_idle(session)?;
        // It comes first: what is refused changes nothing.
        let mut buffer = [0; MAX_CONFIG];
        session.write_part(TransferPart::Body, self.body.to_bytes(&mut buffer))?;
        session.command(session.elapsed_ms(), RobotCommand::Forget)?;
        // The configuration comes after the maps, which match the old one if a transfer breaks.
        for (part, ours) in PARTS.into_iter().rev() {
            if part == TransferPart::Memory || self.state.has_learned() {
                session.write_part(part, &self.part(ours))?;
            }
        }
        session.write_part(TransferPart::Config, &Self::encode_config(&self.config)?)?;
        let places = self.places();
        if !places.is_empty() {
            match session.write_part(TransferPart::Places, &places) {
                Ok(()) | Err(LinkError::Refused(Refusal::NoPlaces)) => {}
                Err(error) => return Err(error),
            }
        }
        for NamedGoal { name, goal } in self.named_goals.as_slice() {
            let goal = RobotCommand::Goal(GoalSpec::Components(*goal));
            session.command(session.elapsed_ms(), goal)?;
            session.query(&HostMessage::SaveGoal { name: *name })?;
        }
        let goal = RobotCommand::Goal(GoalSpec::Components(self.goal));
        session.command(session.elapsed_ms(), goal)?;
        let hello = session.open(next_number(session.number()), Clock::Device)?;
        match Fingerprint::from(&hello)
            .differences(&self.fingerprint())
            .first()
        {
            Some(what) => Err(LinkError::Mismatch { what }),
            None => Ok(()),
        }
    }

    /// A configuration as it is sent.
    pub(super) fn encode_config(config: &Config<16>) -> Result<Vec<u8>, LinkError> {
        match config.to_bytes(&mut [0; MAX_CONFIG]) {
            [] => Err(LinkError::Refused(Refusal::Config)),
            bytes => Ok(bytes.to_vec()),
        }
    }

    fn part(&self, part: StatePart) -> Vec<u8> {
        let mut bytes = vec![0; self.state.part_len(part)];
        self.state.read_part(part, 0, &mut bytes);
        bytes
    }

    fn places(&self) -> Vec<u8> {
        let mut bytes = vec![0; self.body.places_len()];
        self.body.read_places(0, &mut bytes);
        bytes
    }

    /// The checksums that a controller would report.
    #[must_use]
    pub fn fingerprint(&self) -> Fingerprint {
        let mut maps = CRC.digest();
        for map in [
            StatePart::Situations,
            StatePart::Changes,
            StatePart::Actions,
        ] {
            maps.update(&self.part(map));
        }
        Fingerprint {
            config_crc: CRC.checksum(self.config.to_bytes(&mut [0; MAX_CONFIG])),
            maps_crc: maps.finalize(),
            memory_crc: CRC.checksum(&self.part(StatePart::Memory)),
        }
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &Config<16> {
        &self.config
    }

    /// Maps and memory.
    #[must_use]
    pub fn state(&self) -> &SimState {
        &self.state
    }

    /// The body and its places; `None` for a ring on a held turret.
    #[must_use]
    pub fn body(&self) -> Option<&SimBody> {
        (*self.body.known() != BodySpec::NONE).then_some(&*self.body)
    }

    /// Whether a robot can use it (`None` = the Nomad).
    ///
    /// # Errors
    /// A clause that says whose it is.
    pub fn check_robot(&self, robot: Option<&AnyRobot>) -> Result<(), &'static str> {
        match (self.body(), robot) {
            (None, None) => Ok(()),
            (None, Some(_)) => Err("it is of the Nomad's own ring"),
            (Some(_), None) => Err("it is of a robot behind points (--robot, --places)"),
            (Some(body), Some(robot)) => {
                let told = robot.body();
                // It may have found out where its sensors look, and what its base does.
                let found = BodySpec {
                    mounts: told.mounts,
                    enabled: told.enabled,
                    actuation: told.actuation,
                    ..body.known().clone()
                };
                let is_its = found == told;
                is_its
                    .then_some(())
                    .ok_or("it is of another robot, or its guard (--shield) was another one")
            }
        }
    }

    /// Maps and memory, without a copy.
    #[must_use]
    pub(super) fn into_state(self) -> Box<SimState> {
        self.state
    }

    /// Samples in the memory.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.state.memory().samples().len()
    }
}

/// Refuses before anything is written while the robot is not at rest.
fn require_idle(session: &mut Session) -> Result<(), LinkError> {
    match session.mode()? {
        ModeReport::Idle | ModeReport::Stopped(_) => Ok(()),
        ModeReport::Explore { .. }
        | ModeReport::Learn
        | ModeReport::Seek
        | ModeReport::Babble { .. }
        | ModeReport::Calibrate => Err(LinkError::Refused(Refusal::Moving)),
    }
}
