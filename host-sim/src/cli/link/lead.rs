//! Where the places of a controller on a chip are to lead its robot.

use amp::places::Aim;
use amp::units::Displacement;
use files::error::BadInput;

/// The frame of its places reaches so far, m.
const FRAME_M: f64 = 32.0;

/// Parses where to; `None` = nowhere.
pub(super) fn aim(text: &str) -> Result<Option<Aim>, BadInput> {
    Ok(Some(match text {
        "off" => return Ok(None),
        "home" => Aim::Position(Displacement::ZERO),
        "frontier" => Aim::Frontier,
        "everywhere" => Aim::Everywhere,
        "situation" => Aim::Situation,
        place => Aim::Position(position(place)?),
    }))
}

fn position(text: &str) -> Result<Displacement, BadInput> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let place = text.split_once(',');
    let place = place.and_then(|(x, y)| Some([number(x)?, number(y)?]));
    let known = ["home", "frontier", "everywhere", "situation", "off", "X,Y"];
    let place = place.ok_or_else(|| BadInput::unknown("aim", text, &known))?;
    if place.iter().any(|m| !(-FRAME_M..=FRAME_M).contains(m)) {
        return Err(BadInput::new(format!(
            "aim {text}: places reach {FRAME_M} m to each side of where the random moves began"
        )));
    }
    let [x, y] = place.map(|m| libm::round(m * 1e3) as i32);
    Ok(Displacement::saturating(x, y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_aim_is_a_name_or_a_position_in_meters() {
        let at = |dx_mm, dy_mm| Some(Aim::Position(Displacement { dx_mm, dy_mm }));
        for (text, wanted) in [
            ("off", None),
            ("home", at(0, 0)),
            ("1.25,-3", at(1_250, -3_000)),
            ("-32, 32", at(-32_000, 32_000)),
            ("frontier", Some(Aim::Frontier)),
            ("everywhere", Some(Aim::Everywhere)),
            ("situation", Some(Aim::Situation)),
        ] {
            assert_eq!(aim(text).unwrap(), wanted, "{text}");
        }
        for (text, part) in [
            ("hom", "did you mean \"home\"?"),
            ("1.25", "X,Y"),
            ("1,2,3", "X,Y"),
            ("33,0", "places reach 32 m"),
            ("nan,0", "places reach 32 m"),
        ] {
            let sentence = aim(text).unwrap_err().to_string();
            assert!(sentence.contains(part), "{text}: {sentence}");
        }
    }
}
