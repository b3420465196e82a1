//! Settings that a page may change, and knowledge as a file.

use super::command::{CommandOutcome, PageCommand, PageFile};
use super::source::CommandRefused;
use amp::config::Config;
use amp::shield::ShieldConfig;
use files::hex::hex;
use remote::link::Knowledge;

/// The configuration after a command switched something; `whole` has everything switched on.
///
/// # Errors
/// Why it cannot be switched.
pub(super) fn switched(
    command: &PageCommand,
    config: &Config<16>,
    whole: &Config<16>,
) -> Result<Config<16>, CommandRefused> {
    let mut config = config.clone();
    match *command {
        PageCommand::Shield { on } => {
            let shield = whole.shield.unwrap_or(ShieldConfig::nomad200());
            config.shield = on.then_some(shield);
        }
        PageCommand::Online { on } => {
            let online = whole.online.or(Config::recommended().online);
            config.online = online.filter(|_| on);
        }
        PageCommand::Sonar { number, .. } if number >= 16 => {
            return Err(format!("there is no sonar {number}: they are 0 to 15").into());
        }
        PageCommand::Sonar { number, on: true } => config.enabled = config.enabled.with(number),
        PageCommand::Sonar { number, on: false } => {
            let after = config.enabled.without(number);
            if (0..16).all(|sensor| !after.contains(sensor)) {
                let why = "one sonar must stay on: without any the robot never decides";
                return Err(why.into());
            }
            config.enabled = after;
        }
        _ => {}
    }
    Ok(config)
}

/// Configuration and knowledge as a file.
pub(super) fn knowledge_file(knowledge: &Knowledge) -> CommandOutcome {
    CommandOutcome::File(PageFile {
        name: "robot.mind",
        text: None,
        hex: Some(hex(&knowledge.to_bytes())),
    })
}
