//! The mind's open choices by name, for `--set KEY=VALUE`.
//!
//! One table names every key, what it means and how it is read and written, so that the help, the
//! parser and the ablation cannot disagree. The table is most of this file's length.

use amp::action_map::{ActionCode, Recall};
use amp::config::{AtGoal, Choice, Config, Online, Order, Start, Subgoal, Taught, Wander};
use amp::fixed::{Mask, Weight};
use amp::shield::{ARCS_PER_SENSOR, Shielding};
use amp::som::{Decay, Edges, Neighborhood, Schedule};
use amp::units::Bearing;
use files::error::BadInput;

/// One open choice.
pub struct Setting {
    /// Its name.
    pub key: &'static str,
    /// What it means and what it takes.
    pub help: &'static str,
    read: fn(&Config<16>) -> String,
    write: fn(&mut Config<16>, &str) -> Result<(), String>,
}

impl Setting {
    /// The present value as text that [`apply`] takes.
    #[must_use]
    pub fn value(&self, config: &Config<16>) -> String {
        (self.read)(config)
    }
}

/// Applies several `KEY=VALUE`, in order.
///
/// # Errors
/// A sentence that names the key or the value when a text is not `KEY=VALUE`, a key is unknown (with
/// the nearest known one), a value is not among those it takes, or the values do not go together.
pub fn apply<T: AsRef<str>>(config: &mut Config<16>, assignments: &[T]) -> Result<(), BadInput> {
    for assignment in assignments {
        apply_one(config, assignment.as_ref())?;
    }
    let (near, far) = (config.encoding.near_mm, config.encoding.far_mm);
    if far <= near {
        let (near, far) = (meters(near), meters(far));
        return Err(BadInput::new(format!(
            "setting far ({far} m) must lie above setting near ({near} m)"
        )));
    }
    Ok(())
}

fn apply_one(config: &mut Config<16>, assignment: &str) -> Result<(), BadInput> {
    let Some((key, value)) = assignment.split_once('=') else {
        return Err(BadInput::new(format!(
            "--set takes KEY=VALUE, got \"{assignment}\""
        )));
    };
    set(config, key, value)
}

/// Gives one choice another value; whether it goes with the others is not looked at.
///
/// # Errors
/// A sentence that names the key, if it is unknown, or the value, if it is not among those the key takes.
pub fn set(config: &mut Config<16>, key: &str, value: &str) -> Result<(), BadInput> {
    let Some(setting) = SETTINGS.iter().find(|setting| setting.key == key) else {
        let keys: Vec<_> = SETTINGS.iter().map(|setting| setting.key).collect();
        return Err(BadInput::unknown("setting", key, &keys));
    };
    (setting.write)(config, value)
        .map_err(|why| BadInput::new(format!("setting {key} cannot be \"{value}\": {why}")))
}

macro_rules! setting {
    ($key:literal, $help:literal, $read:expr, $write:expr) => {
        Setting {
            key: $key,
            help: $help,
            read: $read,
            write: $write,
        }
    };
}

type Table = &'static [Setting];
type Written = Result<(), String>;

/// Every open choice, in the order of the data's way through the mind.
pub static SETTINGS: Table = &[
    setting!(
        "near",
        "range at which a value is 1, meters",
        |c| meters(c.encoding.near_mm),
        |c: &mut Config<16>, t| put(&mut c.encoding.near_mm, millimeters(t, 0.0, 6.5))
    ),
    setting!(
        "far",
        "range from which on a value is 0, meters",
        |c| meters(c.encoding.far_mm),
        |c: &mut Config<16>, t| put(&mut c.encoding.far_mm, millimeters(t, 0.01, 10.0))
    ),
    setting!(
        "mask",
        "transducers not to believe: none, or numbers joined by +, e.g. 3+7",
        |c| mask_text(c.believed),
        |c: &mut Config<16>, t| put(&mut c.believed, mask(t))
    ),
    setting!(
        "fault-detection",
        "whether sonars that misbehave are no longer believed: on | off",
        |c| on_off(c.fault_detection),
        |c: &mut Config<16>, t| put(&mut c.fault_detection, switch(t))
    ),
    setting!(
        "open-space",
        "whether rings without any echo are expected; otherwise three in a row stop the robot: on | off",
        |c| on_off(c.open_space),
        |c: &mut Config<16>, t| put(&mut c.open_space, switch(t))
    ),
    setting!(
        "step",
        "longest displacement per decision, meters",
        |c| meters(c.robot.step_mm),
        |c: &mut Config<16>, t| put(&mut c.robot.step_mm, millimeters(t, 0.01, 1.0))
    ),
    setting!(
        "explore.shortest",
        "shortest random move, meters (the longest is step)",
        |c| meters(c.exploration.shortest_mm),
        |c: &mut Config<16>, t| put(&mut c.exploration.shortest_mm, millimeters(t, 0.0, 1.0))
    ),
    setting!(
        "explore.draws",
        "draws until the shield leaves half of a random move: 1..255",
        |c| c.exploration.draws.to_string(),
        |c: &mut Config<16>, t| put(
            &mut c.exploration.draws,
            number(t, 1.0, 255.0).map(|v| v as u8)
        )
    ),
    setting!(
        "action",
        "what an action is: displacement | turn-step",
        |c| word(ACTION_CODES, &c.action_code),
        |c: &mut Config<16>, t| put(&mut c.action_code, choice(ACTION_CODES, t))
    ),
    setting!(
        "epochs",
        "presentations of the whole memory: 1..65535",
        |c| c.learning.epochs.to_string(),
        |c: &mut Config<16>, t| put(
            &mut c.learning.epochs,
            number(t, 1.0, 65_535.0).map(|v| v as u16)
        )
    ),
    setting!(
        "order",
        "order of the samples: recorded | random",
        |c| word(ORDERS, &c.learning.order),
        |c: &mut Config<16>, t| put(&mut c.learning.order, choice(ORDERS, t))
    ),
    setting!(
        "start",
        "starting code vectors: samples | random | plane",
        |c| word(STARTS, &c.learning.start),
        |c: &mut Config<16>, t| put(&mut c.learning.start, choice(STARTS, t))
    ),
    setting!(
        "turned",
        "samples also learned turned by ring steps: on | off",
        |c| on_off(c.learning.turned),
        |c: &mut Config<16>, t| put(&mut c.learning.turned, switch(t))
    ),
    setting!(
        "action-weight",
        "weight of the action beside the change when learning: 0..255",
        |c| (f64::from(c.learning.action_weight_q8) / 256.0).to_string(),
        |c: &mut Config<16>, t| put(
            &mut c.learning.action_weight_q8,
            number(t, 0.0, 255.0).map(|v| (v * 256.0) as u16)
        )
    ),
    setting!(
        "taught",
        "displacement a sample teaches: commanded | executed",
        |c| word(TAUGHT, &c.learning.taught),
        |c: &mut Config<16>, t| put(&mut c.learning.taught, choice(TAUGHT, t))
    ),
    setting!(
        "edges",
        "border of the grids: open | wrapped",
        |c| word(EDGES, &c.learning.edges),
        |c: &mut Config<16>, t| put(&mut c.learning.edges, choice(EDGES, t))
    ),
    setting!(
        "situation.neighborhood",
        "situation map: direct | gaussian",
        |c| word(NEIGHBORHOODS, &c.learning.situations.neighborhood),
        |c: &mut Config<16>, t| put(
            &mut c.learning.situations.neighborhood,
            choice(NEIGHBORHOODS, t)
        )
    ),
    setting!(
        "situation.rate",
        "situation map's learning rate, START:END:linear|exponential|inverse",
        |c| schedule_text(c.learning.situations.rate),
        |c: &mut Config<16>, t| put(&mut c.learning.situations.rate, schedule(t, 1.0))
    ),
    setting!(
        "situation.radius",
        "situation map's radius (direct: neighbors' share), likewise",
        |c| schedule_text(c.learning.situations.radius),
        |c: &mut Config<16>, t| put(&mut c.learning.situations.radius, schedule(t, 64.0))
    ),
    setting!(
        "action.neighborhood",
        "action map: direct | gaussian",
        |c| word(NEIGHBORHOODS, &c.learning.actions.neighborhood),
        |c: &mut Config<16>, t| put(
            &mut c.learning.actions.neighborhood,
            choice(NEIGHBORHOODS, t)
        )
    ),
    setting!(
        "action.rate",
        "action map's learning rate, START:END:linear|exponential|inverse",
        |c| schedule_text(c.learning.actions.rate),
        |c: &mut Config<16>, t| put(&mut c.learning.actions.rate, schedule(t, 1.0))
    ),
    setting!(
        "action.radius",
        "action map's radius (direct: neighbors' share), likewise",
        |c| schedule_text(c.learning.actions.radius),
        |c: &mut Config<16>, t| put(&mut c.learning.actions.radius, schedule(t, 64.0))
    ),
    setting!(
        "online.situation-rate",
        "situation map's learning rate while seeking, at first: 0..1",
        |c| q16_text(c.online.map_or(0, |o| o.situation_rate_q16)),
        |c: &mut Config<16>, t| put_online(c, t, |o| &mut o.situation_rate_q16)
    ),
    setting!(
        "online.action-rate",
        "action map's learning rate while seeking, at first: 0..1",
        |c| q16_text(c.online.map_or(0, |o| o.action_rate_q16)),
        |c: &mut Config<16>, t| put_online(c, t, |o| &mut o.action_rate_q16)
    ),
    setting!(
        "online.share",
        "neighbors' share of it: 0..1",
        |c| q16_text(c.online.map_or(0, |o| o.share_q16)),
        |c: &mut Config<16>, t| put_online(c, t, |o| &mut o.share_q16)
    ),
    setting!(
        "online.learner",
        "action neuron that learns while seeking: best | recalled",
        |c| word(LEARNERS, &c.online.is_some_and(|o| o.blame_recalled)),
        |c: &mut Config<16>, t| {
            let chosen = choice(LEARNERS, t)?;
            if let Some(online) = &mut c.online {
                online.blame_recalled = chosen;
            }
            Ok(())
        }
    ),
    setting!(
        "choose",
        "how the action is found: recall (probe by the change) | neurons | headings (look-ahead)",
        |c| word(CHOICES, &c.planning.choice),
        |c: &mut Config<16>, t| put(&mut c.planning.choice, choice(CHOICES, t))
    ),
    setting!(
        "wander",
        "off on a new course when a place comes no nearer: PATIENCE:MOVES decisions, or off",
        |c| wander_text(c.planning.wander),
        |c: &mut Config<16>, t| put(&mut c.planning.wander, wander(t))
    ),
    setting!(
        "intermediate",
        "neuron aimed at: hops | code | goal",
        |c| word(INTERMEDIATES, &c.planning.intermediate),
        |c: &mut Config<16>, t| put(&mut c.planning.intermediate, choice(INTERMEDIATES, t))
    ),
    setting!(
        "recall",
        "probe of the action map: distance | direction | projection",
        |c| word(RECALLS, &c.planning.recall),
        |c: &mut Config<16>, t| put(&mut c.planning.recall, choice(RECALLS, t))
    ),
    setting!(
        "from",
        "the wanted change starts from: measured | code",
        |c| word(FROMS, &c.planning.from_measured),
        |c: &mut Config<16>, t| put(&mut c.planning.from_measured, choice(FROMS, t))
    ),
    setting!(
        "full-steps",
        "recalled moves stretched to the longest step: on | off",
        |c| on_off(c.planning.full_steps),
        |c: &mut Config<16>, t| put(&mut c.planning.full_steps, switch(t))
    ),
    setting!(
        "at-goal",
        "what to do while the goal holds: course | ahead",
        |c| word(AT_GOALS, &c.planning.at_goal),
        |c: &mut Config<16>, t| put(&mut c.planning.at_goal, choice(AT_GOALS, t))
    ),
    setting!(
        "wanted",
        "components whose change is wanted: all | unmet (only what the goal does not have yet)",
        |c| word(WANTED, &c.planning.unmet_only),
        |c: &mut Config<16>, t| put(&mut c.planning.unmet_only, choice(WANTED, t))
    ),
    setting!(
        "answer",
        "who answers the probe of the action map: best | together (all, by how well they match)",
        |c| word(ANSWERS, &c.planning.together),
        |c: &mut Config<16>, t| put(&mut c.planning.together, choice(ANSWERS, t))
    ),
    setting!(
        "straight",
        "preference for actions that keep the course, beside 1 for the wanted change: 0..255",
        |c| (f64::from(c.planning.straight_q8) / 256.0).to_string(),
        |c: &mut Config<16>, t| put(
            &mut c.planning.straight_q8,
            number(t, 0.0, 255.0).map(|v| (v * 256.0) as u16)
        )
    ),
    setting!(
        "inertia",
        "share of the course added to the recalled action: 0..255",
        |c| (f64::from(c.planning.inertia_q8) / 256.0).to_string(),
        |c: &mut Config<16>, t| put(
            &mut c.planning.inertia_q8,
            number(t, 0.0, 255.0).map(|v| (v * 256.0) as u16)
        )
    ),
    setting!(
        "clearance",
        "what free of obstacles means: nothing nearer than this, meters",
        |c| meters(c.clearance_mm),
        |c: &mut Config<16>, t| put(&mut c.clearance_mm, millimeters(t, 0.01, 10.0))
    ),
    setting!(
        "tolerance",
        "deviation with which the goal still holds: 0..1",
        |c| c.planning.tolerance.to_string(),
        |c: &mut Config<16>, t| put(
            &mut c.planning.tolerance,
            number(t, 0.0, 1.0).map(Weight::from_num)
        )
    ),
    setting!(
        "inhibition",
        "decisions an action neuron rests after its move was cut: 0..255",
        |c| c.planning.inhibition.to_string(),
        |c: &mut Config<16>, t| put(
            &mut c.planning.inhibition,
            number(t, 0.0, 255.0).map(|v| v as u8)
        )
    ),
    setting!(
        "shield.margin",
        "distance the shield keeps, meters",
        |c| meters(c.shield.map_or(0, |s| s.margin_mm)),
        |c: &mut Config<16>, t| put_shield(c, millimeters(t, 0.0, 2.0), |s, v| s.margin_mm = v)
    ),
    setting!(
        "shield.half-lobe",
        "half opening of a sonar's lobe as the shield sees it, degrees",
        |c| c
            .shield
            .map_or(0.0, |s| f64::from(s.half_lobe.as_turns()) * 360.0
                / 65_536.0)
            .to_string(),
        |c: &mut Config<16>, t| put_shield(c, number(t, 0.0, 45.0), |s, v| s.half_lobe =
            Bearing::from_turns((v * 65_536.0 / 360.0) as u16))
    ),
    setting!(
        "shield.places",
        "arcs the shield keeps per sonar: 1..4",
        |c| c.shield.map_or(0, |s| s.places).to_string(),
        |c: &mut Config<16>, t| put_shield(c, number(t, 1.0, ARCS_PER_SENSOR as f64), |s, v| s
            .places =
            v as u8)
    ),
    setting!(
        "shield.spacing",
        "echoes heard less than this apart come through one cone, meters",
        |c| meters(c.shield.map_or(0, |s| s.spacing_mm)),
        |c: &mut Config<16>, t| put_shield(c, millimeters(t, 0.0, 2.0), |s, v| s.spacing_mm = v)
    ),
    setting!(
        "shield.least-range",
        "shortest range the ring can report, meters: such a reading may be anything nearer",
        |c| meters(c.shield.map_or(0, |s| s.least_range_mm)),
        |c: &mut Config<16>, t| put_shield(c, millimeters(t, 0.0, 2.0), |s, v| s.least_range_mm =
            v)
    ),
    setting!(
        "shield.fresh",
        "a direction is open while heard within this time, seconds",
        |c| seconds(c.shield.map_or(0, |s| s.fresh_ms)),
        |c: &mut Config<16>, t| put_shield(c, milliseconds(t), |s, v| s.fresh_ms = v)
    ),
    setting!(
        "shield.forget",
        "a sonar silent for longer begins anew when heard again, seconds",
        |c| seconds(c.shield.map_or(0, |s| s.forget_ms)),
        |c: &mut Config<16>, t| put_shield(c, milliseconds(t), |s, v| s.forget_ms = v)
    ),
];

const CHOICES: &[(&str, Choice)] = &[
    ("recall", Choice::Recall),
    ("neurons", Choice::Neurons),
    ("headings", Choice::Headings),
];
const ACTION_CODES: &[(&str, ActionCode)] = &[
    ("displacement", ActionCode::Displacement),
    ("turn-step", ActionCode::TurnStep),
];
const ORDERS: &[(&str, Order)] = &[("recorded", Order::Recorded), ("random", Order::Random)];
const STARTS: &[(&str, Start)] = &[
    ("samples", Start::Samples),
    ("random", Start::Random),
    ("plane", Start::Plane),
];
const TAUGHT: &[(&str, Taught)] = &[
    ("commanded", Taught::Commanded),
    ("executed", Taught::Executed),
];
const EDGES: &[(&str, Edges)] = &[("open", Edges::Open), ("wrapped", Edges::Wrapped)];
const NEIGHBORHOODS: &[(&str, Neighborhood)] = &[
    ("direct", Neighborhood::Direct),
    ("gaussian", Neighborhood::Gaussian),
];
const LEARNERS: &[(&str, bool)] = &[("best", false), ("recalled", true)];
const INTERMEDIATES: &[(&str, Subgoal)] = &[
    ("hops", Subgoal::FewestHops),
    ("code", Subgoal::NearestCode),
    ("goal", Subgoal::Goal),
];
const RECALLS: &[(&str, Recall)] = &[
    ("distance", Recall::Distance),
    ("direction", Recall::Direction),
    ("projection", Recall::Projection),
];
const FROMS: &[(&str, bool)] = &[("measured", true), ("code", false)];
const WANTED: &[(&str, bool)] = &[("all", false), ("unmet", true)];
const ANSWERS: &[(&str, bool)] = &[("best", false), ("together", true)];
const AT_GOALS: &[(&str, AtGoal)] = &[
    ("course", AtGoal::KeepCourse),
    ("ahead", AtGoal::StraightAhead),
];
const SWITCH: &[(&str, bool)] = &[("on", true), ("off", false)];
/// Shapes of a schedule by name.
pub const DECAYS: &[(&str, Decay)] = &[
    ("linear", Decay::Linear),
    ("exponential", Decay::Exponential),
    ("inverse", Decay::Inverse),
];

fn wander(text: &str) -> Result<Option<Wander>, String> {
    let count = |text: &str| number(text, 1.0, 255.0).map(|value| value as u8);
    match text.split_once(':') {
        None if text == "off" => Ok(None),
        None => Err("it must be PATIENCE:MOVES or off".to_owned()),
        Some((patience, moves)) => Ok(Some(Wander {
            patience: count(patience)?,
            moves: count(moves)?,
        })),
    }
}

fn wander_text(wander: Option<Wander>) -> String {
    wander.map_or_else(
        || "off".to_owned(),
        |wander| format!("{}:{}", wander.patience, wander.moves),
    )
}

fn put<T>(place: &mut T, value: Result<T, String>) -> Written {
    *place = value?;
    Ok(())
}

fn put_online(config: &mut Config<16>, text: &str, place: fn(&mut Online) -> &mut u32) -> Written {
    let value = (number(text, 0.0, 1.0)? * 65_536.0) as u32;
    if let Some(online) = &mut config.online {
        *place(online) = value;
    }
    Ok(())
}

fn put_shield<T>(
    config: &mut Config<16>,
    value: Result<T, String>,
    set: fn(&mut Shielding, T),
) -> Written {
    let value = value?;
    if let Some(shield) = &mut config.shield {
        set(shield, value);
    }
    Ok(())
}

fn number(text: &str, least: f64, most: f64) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        Ok(_) => Err(format!("it must lie between {least} and {most}")),
        Err(_) => Err("it is not a number".to_owned()),
    }
}

fn millimeters(text: &str, least_m: f64, most_m: f64) -> Result<u16, String> {
    number(text, least_m, most_m).map(|m| (m * 1_000.0 + 0.5) as u16)
}

fn milliseconds(text: &str) -> Result<u32, String> {
    number(text, 0.1, 86_400.0).map(|s| (s * 1_000.0 + 0.5) as u32)
}

fn seconds(ms: u32) -> String {
    (f64::from(ms) / 1_000.0).to_string()
}

fn meters(mm: u16) -> String {
    (f64::from(mm) / 1_000.0).to_string()
}

fn choice<T: Copy>(choices: &[(&str, T)], text: &str) -> Result<T, String> {
    let found = choices.iter().find(|(name, _)| *name == text);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<_> = choices.iter().map(|(name, _)| *name).collect();
        format!("it must be one of {}", names.join(", "))
    })
}

fn word<T: PartialEq>(choices: &[(&str, T)], value: &T) -> String {
    let found = choices.iter().find(|(_, other)| other == value);
    found.map_or_else(String::new, |(name, _)| (*name).to_owned())
}

fn switch(text: &str) -> Result<bool, String> {
    choice(SWITCH, text)
}

fn on_off(value: bool) -> String {
    word(SWITCH, &value)
}

fn q16_text(value: u32) -> String {
    (f64::from(value) / 65_536.0).to_string()
}

/// A schedule from `START:END:SHAPE`, or a constant from one number; values in 0 … `most`.
pub fn schedule(text: &str, most: f64) -> Result<Schedule, String> {
    let q16 = |text: &str| number(text, 0.0, most).map(|value| (value * 65_536.0 + 0.5) as u32);
    let parts: Vec<_> = text.split(':').collect();
    let falling = |start: &str, end: &str, decay| {
        let (start, end) = (q16(start)?, q16(end)?);
        if end > start {
            return Err("its end must not lie above its start".to_owned());
        }
        Ok(Schedule::from_q16(start, end, decay))
    };
    match parts[..] {
        [value] => Ok(Schedule::constant(q16(value)?)),
        [start, end] => falling(start, end, Decay::Linear),
        [start, end, shape] => falling(start, end, choice(DECAYS, shape)?),
        _ => Err("it must be START:END:SHAPE".to_owned()),
    }
}

fn schedule_text(schedule: Schedule) -> String {
    let shape = word(DECAYS, &schedule.decay());
    format!(
        "{}:{}:{shape}",
        q16_text(schedule.start_q16()),
        q16_text(schedule.end_q16())
    )
}

fn mask(text: &str) -> Result<Mask, String> {
    if text == "none" {
        return Ok(Mask::ALL);
    }
    let mut mask = Mask::ALL;
    for part in text.split('+') {
        let sensor = number(part, 0.0, 15.0)?;
        mask = mask.without(sensor as usize);
    }
    Ok(mask)
}

fn mask_text(mask: Mask) -> String {
    let off: Vec<_> = (0..16)
        .filter(|&i| !mask.contains(i))
        .map(|i| i.to_string())
        .collect();
    if off.is_empty() {
        "none".to_owned()
    } else {
        off.join("+")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::config::Training;

    #[test]
    fn every_setting_takes_back_what_it_prints() {
        for preset in [Config::touzet(), Config::recommended()] {
            for setting in SETTINGS {
                let value = setting.value(&preset);
                let mut copy = preset.clone();
                apply(&mut copy, &[format!("{}={value}", setting.key)]).expect(setting.key);
                assert_eq!(setting.value(&copy), value, "{}", setting.key);
            }
        }
    }

    #[test]
    fn settings_change_what_they_name() {
        let mut config = Config::recommended();
        let sets = [
            "near=5",
            "far=5.5",
            "recall=projection",
            "mask=3+7",
            "action.rate=0.3:0.1:inverse",
        ];
        apply(&mut config, &sets).expect("good settings");
        assert_eq!(
            (config.encoding.near_mm, config.encoding.far_mm),
            (5_000, 5_500)
        );
        assert_eq!(config.planning.recall, Recall::Projection);
        assert!(!config.believed.contains(3) && !config.believed.contains(7));
        assert_eq!(config.learning.actions.rate.decay(), Decay::Inverse);
    }

    #[test]
    fn bad_assignments_name_the_trouble() {
        let say = |assignment: &str| {
            let refused = apply(&mut Config::recommended(), &[assignment]);
            refused.expect_err(assignment).to_string()
        };
        assert!(say("far").contains("KEY=VALUE"));
        assert!(say("fra=1").contains("did you mean \"far\""));
        assert!(say("far=NaN").contains("between"));
        assert!(say("recall=telepathy").contains("distance, direction, projection"));
        assert!(say("near=6").contains("setting far (4.5 m)"));
        assert!(say("mask=16").contains("between 0 and 15"));
        assert!(say("action.rate=0.1:0.3").contains("above its start"));
    }

    /// The two presets must not share a struct by accident: the literal one trains directly.
    #[test]
    fn the_presets_differ() {
        let training: Training = Config::touzet().learning.situations;
        assert_eq!(training.neighborhood, Neighborhood::Direct);
        assert_ne!(Config::touzet(), Config::recommended());
    }
}
