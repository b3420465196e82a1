//! Behaviours by name: goal situations, and where each begins. How well they go is [measured](crate::episode) by the
//! world, which the mind never sees.

use crate::error::BadInput;
use amp::config::Config;
use amp::fixed::Weight;
use amp::goal::{Goal, Side};
use amp::scan::Situation;
use amp::units::Range;
use std::str::FromStr;

/// Range to the wall that is followed, metres from the ring.
pub const WALL_RANGE_M: f64 = 0.6;
/// Room kept clear on the side by which obstacles are passed, metres.
pub const PASSING_ROOM_M: f64 = 1.5;
/// Range to the leader, metres from the ring.
pub const LEADER_RANGE_M: f64 = 0.34;
/// Decisions in which a behaviour without an end has to hold in a chain before the next begins.
pub const CHAIN_HOLDS: u32 = 20;

/// A behaviour by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Behavior {
    /// Obstacle avoidance, the paper's experiment: nothing nearer than the clearance.
    Avoid,
    /// The same, but obstacles are passed so that they stay on the robot's left.
    AvoidRight,
    /// A wall is followed on the left.
    WallLeft,
    /// A wall is followed on the right.
    WallRight,
    /// Back to where the robot stood before its first move.
    Nest,
    /// Behind another robot.
    Follow,
    /// To where a captured situation is perceived.
    Seek(Box<Captured>),
    /// One after the other: the next begins when the goal is reached.
    Chain(Vec<Self>),
}

/// A situation from a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Captured {
    /// The file.
    pub path: String,
    /// One value in [0, 1] per sonar.
    pub situation: Situation<16>,
    /// Where it was captured, millimetres, if the file says so.
    pub place_mm: Option<[i32; 2]>,
}

impl Behavior {
    /// Names of those that take nothing.
    pub const NAMES: [&str; 6] = [
        "avoid",
        "avoid-right",
        "wall-left",
        "wall-right",
        "nest",
        "follow",
    ];

    /// Its name, as it is written on the command line.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Avoid => "avoid".to_owned(),
            Self::AvoidRight => "avoid-right".to_owned(),
            Self::WallLeft => "wall-left".to_owned(),
            Self::WallRight => "wall-right".to_owned(),
            Self::Nest => "nest".to_owned(),
            Self::Follow => "follow".to_owned(),
            Self::Seek(captured) => format!("seek:{}", captured.path),
            Self::Chain(parts) => {
                let names: Vec<_> = parts.iter().map(Self::name).collect();
                names.join(",")
            }
        }
    }

    /// Its goal situation; `nest` is what was perceived before the first move. A chain's is that of its first part.
    #[must_use]
    pub fn goal(&self, config: &Config<16>, nest: &Situation<16>) -> Goal<16> {
        let range = |meters: f64| Range::from_mm((meters * 1e3) as u16);
        match self {
            Self::Avoid => Goal::avoiding(config),
            Self::AvoidRight => Goal::passing(Side::Right, range(PASSING_ROOM_M), config),
            Self::WallLeft => Goal::wall(Side::Left, range(WALL_RANGE_M), config),
            Self::WallRight => Goal::wall(Side::Right, range(WALL_RANGE_M), config),
            Self::Nest => Goal::perceived(nest),
            Self::Follow => Goal::following(range(LEADER_RANGE_M), config),
            Self::Seek(captured) => Goal::perceived(&captured.situation),
            Self::Chain(parts) => parts
                .first()
                .map_or_else(|| Goal::avoiding(config), |part| part.goal(config, nest)),
        }
    }

    /// What is pursued one after the other.
    #[must_use]
    pub fn parts(&self) -> &[Self] {
        match self {
            Self::Chain(parts) => parts,
            single => std::slice::from_ref(single),
        }
    }

    /// After exploring the robot is set down elsewhere.
    #[must_use]
    pub fn is_set_down_elsewhere(&self) -> bool {
        match self {
            Self::Nest | Self::Seek(_) => true,
            // In a chain the way is made by what comes before.
            _ => false,
        }
    }

    /// The choices as this behaviour needs them: where another robot moves, what was heard a second ago (a ring takes 0.64 s) is gone.
    #[must_use]
    pub fn adapted(&self, mut config: Config<16>) -> Config<16> {
        if let Some(shield) = config.shield.as_mut().filter(|_| self.has_leader()) {
            shield.forget_ms = shield.forget_ms.min(1_000);
        }
        config
    }

    /// There is another robot to follow.
    #[must_use]
    pub fn has_leader(&self) -> bool {
        self.parts().contains(&Self::Follow)
    }
}

impl FromStr for Behavior {
    type Err = BadInput;

    fn from_str(name: &str) -> Result<Self, BadInput> {
        if let Some((first, rest)) = name.split_once(',') {
            let mut parts = vec![first.parse()?];
            for part in rest.split(',') {
                parts.push(part.parse()?);
            }
            return Ok(Self::Chain(parts));
        }
        if let Some(path) = name.strip_prefix("seek:") {
            return Ok(Self::Seek(Box::new(Captured::load(path)?)));
        }
        match name {
            "avoid" => Ok(Self::Avoid),
            "avoid-right" => Ok(Self::AvoidRight),
            "wall-left" => Ok(Self::WallLeft),
            "wall-right" => Ok(Self::WallRight),
            "nest" => Ok(Self::Nest),
            "follow" => Ok(Self::Follow),
            _ => Err(BadInput::unknown("behavior", name, &Self::NAMES)),
        }
    }
}

impl Captured {
    /// Reads `{"situation": [16 values in 0..=1], "place_m": [x, y]}`; the place may be left out.
    ///
    /// # Errors
    /// A sentence that names the file when it cannot be read or holds something else.
    pub fn load(path: &str) -> Result<Self, BadInput> {
        #[derive(serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        struct File {
            situation: [f64; 16],
            place_m: Option<[f64; 2]>,
        }
        let bad = |why: String| BadInput::new(format!("situation {path}: {why}"));
        let text = std::fs::read_to_string(path).map_err(|error| bad(error.to_string()))?;
        let file: File = serde_json::from_str(&text).map_err(|error| bad(error.to_string()))?;
        if let Some(value) = file.situation.iter().find(|v| !(0.0..=1.0).contains(*v)) {
            return Err(bad(format!("each value must lie in 0..=1, not be {value}")));
        }
        if let Some(value) = file
            .place_m
            .iter()
            .flatten()
            .find(|v| !(-1e5..=1e5).contains(*v))
        {
            return Err(bad(format!(
                "a place must lie within 100 km, not at {value} m"
            )));
        }
        Ok(Self {
            path: path.to_owned(),
            situation: file.situation.map(Weight::from_num),
            place_mm: file.place_m.map(|place| place.map(|m| (m * 1e3) as i32)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back() {
        for name in Behavior::NAMES {
            assert_eq!(name.parse::<Behavior>().expect(name).name(), name);
        }
        let chain: Behavior = "avoid-right,wall-right,nest".parse().expect("a chain");
        assert_eq!(chain.name(), "avoid-right,wall-right,nest");
        assert_eq!(chain.parts().len(), 3);
    }

    #[test]
    fn bad_names_and_files_are_refused_by_name() {
        let say = |name: &str| name.parse::<Behavior>().expect_err(name).to_string();
        assert!(say("wall-rigth").contains("did you mean \"wall-right\""));
        assert!(say("avoid,").contains("behavior"));
        assert!(say("seek:/nowhere.json").contains("/nowhere.json"));
    }
}
