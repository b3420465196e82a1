//! A goal situation as a file.
//!
//! ```toml
//! # A wall to the left (sonar 4), nothing ahead (sonars 15, 0, 1); the others may perceive whatever they like.
//! [[sonar]]
//! numbers = [4]
//! at_least = 0.6          # 1 = as near as the near limit, 0 = nothing within the far limit
//! at_most = 0.8
//! [[sonar]]
//! numbers = [15, 0, 1]
//! at_most = 0.1
//! weight = 2              # how much a deviation counts: 1 unless said otherwise
//! ```

use crate::error::BadInput;
use amp::fixed::Weight;
use amp::goal::{Component, Goal};
use serde::Deserialize;
use std::path::Path;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GoalFile {
    sonar: Vec<Wish>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Wish {
    numbers: Vec<u8>,
    at_least: Option<f64>,
    at_most: Option<f64>,
    weight: Option<u8>,
}

/// Reads a goal from a TOML file.
///
/// # Errors
/// A sentence that names the file and what is wrong in it.
pub fn read_goal(path: &Path) -> Result<Goal<16>, BadInput> {
    let text = std::fs::read_to_string(path).map_err(|error| BadInput::file(path, error))?;
    parse(&text).map_err(|why| BadInput::file(path, why.trim_end()))
}

fn parse(text: &str) -> Result<Goal<16>, String> {
    let file: GoalFile = toml::from_str(text).map_err(|error| error.message().to_owned())?;
    let mut goal = Goal::place([Component::ANY; 16]);
    for wish in &file.sonar {
        let component = component(wish)?;
        for &number in &wish.numbers {
            let place = goal.components.get_mut(usize::from(number));
            *place.ok_or(format!("there is no sonar {number}: they are 0 to 15"))? = component;
        }
    }
    if goal.components == [Component::ANY; 16] {
        return Err(
            "it asks for nothing: give a [[sonar]] its numbers and at_least or at_most".into(),
        );
    }
    Ok(goal)
}

fn component(wish: &Wish) -> Result<Component, String> {
    let (low, high) = (wish.at_least.unwrap_or(0.0), wish.at_most.unwrap_or(1.0));
    if !(0.0 <= low && low <= high && high <= 1.0) {
        return Err(format!(
            "at_least {low} and at_most {high} must be in order and lie between 0 and 1"
        ));
    }
    Ok(Component {
        low: Weight::from_num(low),
        high: Weight::from_num(high),
        weight: wish.weight.unwrap_or(1),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_goal_is_what_its_file_says() {
        let text = "[[sonar]]\nnumbers = [4]\nat_least = 0.5\nat_most = 0.75\n\
                    [[sonar]]\nnumbers = [15, 0]\nat_most = 0.25\nweight = 2\n";
        let goal = parse(text).unwrap();
        let left = Component {
            low: Weight::from_num(0.5),
            high: Weight::from_num(0.75),
            weight: 1,
        };
        let ahead = Component {
            weight: 2,
            ..Component::at_most(Weight::from_num(0.25))
        };
        assert_eq!(goal.components[4], left);
        assert_eq!([goal.components[15], goal.components[0]], [ahead; 2]);
        assert_eq!(goal.components[7], Component::ANY);
    }

    #[test]
    fn a_bad_goal_is_refused_by_name() {
        for (text, part) in [
            ("", "sonar"),
            ("[[sonar]]\nnumbers = []\n", "asks for nothing"),
            ("[[sonar]]\nnumbers = [16]\n", "no sonar 16"),
            ("[[sonar]]\nnumbers = [1]\nat_least = 2\n", "at_least 2"),
            ("[[sonar]]\nnumbers = [1]\nnearer = 1\n", "nearer"),
            ("[[sonar]]\nnumbers = [1]\nat_most = nan\n", "NaN"),
        ] {
            let why = parse(text).unwrap_err();
            assert!(why.contains(part), "{why}");
        }
    }
}
