//! What a person may switch and keep, whatever robot it is.

use super::order::{Done, File, Order};
use super::source::Refused;
use amp::config::Config;
use amp::shield::ShieldConfig;
use files::hex::hex;
use remote::link::Knowledge;
use sim::pilot::SimState;

/// The open choices after something was switched; `whole` has everything switched on.
///
/// # Errors
/// What cannot be switched.
pub(super) fn switched(
    order: &Order,
    config: &Config<16>,
    whole: &Config<16>,
) -> Result<Config<16>, Refused> {
    let mut config = config.clone();
    match *order {
        Order::Shield { on } => {
            let shield = whole.shield.unwrap_or(ShieldConfig::nomad200());
            config.shield = on.then_some(shield);
        }
        Order::Online { on } => {
            let online = whole.online.or(Config::recommended().online);
            config.online = online.filter(|_| on);
        }
        Order::Sonar { number, .. } if number >= 16 => {
            return Err(format!("there is no sonar {number}: they are 0 to 15").into());
        }
        Order::Sonar { number, on: true } => config.enabled = config.enabled.with(number),
        Order::Sonar { number, on: false } => {
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

/// What a mind was told and has learned, as a file.
pub(super) fn mind_file(config: &Config<16>, known: &SimState) -> Done {
    let knowledge = Knowledge::of(config, known);
    Done::File(File {
        name: "robot.mind",
        text: None,
        hex: Some(hex(&knowledge.to_bytes())),
    })
}
