//! Goals saved under names.

use super::Goal;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most named goals.
pub const MAX_NAMED_GOALS: usize = 8;

/// Most bytes of a name.
const MAX_NAME: usize = 12;

/// A name of 1 to 12 printable ASCII characters without blanks; padded with zeros.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Name([u8; MAX_NAME]);

impl Name {
    /// No name: stands for the goal that is pursued, wherever a goal has a name.
    pub const NONE: Self = Self([0; MAX_NAME]);

    /// The name, if it may be one.
    #[must_use]
    pub fn new(text: &str) -> Option<Self> {
        let mut name = Self::NONE;
        if text.len() > MAX_NAME {
            return None;
        }
        for (place, byte) in name.0.iter_mut().zip(text.bytes()) {
            *place = byte;
        }
        name.is_valid().then_some(name)
    }

    /// Whether goals may be saved under it; whatever bytes the link brought.
    #[must_use]
    fn is_valid(&self) -> bool {
        let text = self.as_bytes();
        let rest = self.0.get(text.len()..).unwrap_or(&[]);
        !text.is_empty()
            && text.iter().all(u8::is_ascii_graphic)
            && rest.iter().all(|byte| *byte == 0)
    }

    /// The name; empty for [`Name::NONE`] and for bytes that are no text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        core::str::from_utf8(self.as_bytes()).unwrap_or("")
    }

    #[cfg(feature = "store")]
    pub(crate) const fn to_bytes(self) -> [u8; MAX_NAME] {
        self.0
    }

    #[cfg(feature = "store")]
    pub(crate) const fn from_bytes(bytes: [u8; MAX_NAME]) -> Self {
        Self(bytes)
    }

    fn as_bytes(&self) -> &[u8] {
        let end = self.0.iter().position(|byte| *byte == 0);
        self.0.get(..end.unwrap_or(MAX_NAME)).unwrap_or(&[])
    }
}

/// A goal and its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedGoal<const SENSORS: usize> {
    /// Its name.
    pub name: Name,
    /// The goal.
    pub goal: Goal<SENSORS>,
}

/// Why a goal was not saved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SaveGoalError {
    /// The name is not valid.
    Name,
    /// There is no room for another goal.
    Full,
}

impl core::fmt::Display for SaveGoalError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Name => "a name has 1 to 12 printable characters without blanks",
            Self::Full => "the memory for goals is full",
        })
    }
}

impl core::error::Error for SaveGoalError {}

/// At most [`MAX_NAMED_GOALS`] goals by name, in the order they came.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct NamedGoals<const SENSORS: usize> {
    goals: Vec<NamedGoal<SENSORS>, MAX_NAMED_GOALS>,
}

impl<const SENSORS: usize> NamedGoals<SENSORS> {
    /// No goals. All zeros, as a [`Node`](crate::node::Node) has to be before it starts.
    #[must_use]
    pub const fn new() -> Self {
        Self { goals: Vec::new() }
    }

    /// Saves a goal; it replaces the one of the same name.
    ///
    /// # Errors
    /// [`SaveGoalError`].
    pub fn save(&mut self, goal: NamedGoal<SENSORS>) -> Result<(), SaveGoalError> {
        if !goal.name.is_valid() {
            return Err(SaveGoalError::Name);
        }
        let mut goals = self.goals.iter_mut();
        if let Some(place) = goals.find(|saved| saved.name == goal.name) {
            *place = goal;
            return Ok(());
        }
        self.goals.push(goal).map_err(|_| SaveGoalError::Full)
    }

    /// Deletes the goal of this name; false if there is none.
    pub fn delete(&mut self, name: Name) -> bool {
        let before = self.goals.len();
        self.goals.retain(|goal| goal.name != name);
        self.goals.len() < before
    }

    /// The goal of this name.
    #[must_use]
    pub fn find(&self, name: Name) -> Option<&Goal<SENSORS>> {
        let found = self.goals.iter().find(|goal| goal.name == name);
        found.map(|found| &found.goal)
    }

    /// All of them.
    #[must_use]
    pub fn as_slice(&self) -> &[NamedGoal<SENSORS>] {
        &self.goals
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.goals.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::goal::Component;

    fn named(name: &str, weight: u8) -> NamedGoal<4> {
        let component = Component {
            weight,
            ..Component::ANY
        };
        NamedGoal {
            name: Name::new(name).unwrap(),
            goal: Goal::of([component; 4]),
        }
    }

    #[test]
    fn refusals_say_what_a_name_may_be() {
        let words = [SaveGoalError::Name, SaveGoalError::Full].map(|error| std::format!("{error}"));
        assert!(words[0].contains("1 to 12 printable") && words[1].contains("full"));
        assert_eq!(Name::from_bytes([0xff; 12]).as_str(), "", "no text");
    }

    #[test]
    fn names_are_short_words() {
        assert_eq!(Name::new("nest").unwrap().as_str(), "nest");
        assert_eq!(Name::new("twelve-chars").unwrap().as_str(), "twelve-chars");
        for wrong in ["", "thirteen-char", "two words", "nést", "a\0b"] {
            assert_eq!(Name::new(wrong), None, "{wrong:?}");
        }
        assert!(!Name([0; 12]).is_valid());
        assert!(!Name([b'a', 0, b'b', 0, 0, 0, 0, 0, 0, 0, 0, 0]).is_valid());
    }

    #[test]
    fn a_name_has_one_goal_and_there_are_eight() {
        let mut goals = NamedGoals::new();
        for name in ["a", "b", "c", "d", "e", "f", "g", "h"] {
            goals.save(named(name, 1)).unwrap();
        }
        assert_eq!(goals.save(named("i", 1)), Err(SaveGoalError::Full));
        goals.save(named("c", 2)).unwrap();
        let c = named("c", 2);
        assert_eq!(goals.find(c.name), Some(&c.goal));
        assert!(goals.delete(c.name) && !goals.delete(c.name));
        goals.save(named("i", 3)).unwrap();
        let names: std::vec::Vec<_> = goals.as_slice().iter().map(|goal| goal.name.0[0]).collect();
        assert_eq!(names, *b"abdefghi");
    }
}
