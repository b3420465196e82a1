//! Goal situations as files, for `run --behavior seek:FILE` and `--goal FILE`, `link goal FILE`,
//! `capture` and `goal`.
//!
//! A file holds either a perceived situation:
//!
//! ```toml
//! # By sonar (0 ahead, counter-clockwise): 1 = near limit, 0 = nothing within the far limit,
//! # nan = not asked for.
//! situation = [0.5, 0.4, 0.2, 0.0, 0.0, 0.1, 0.3, 0.2, 0.1, 0.0, 0.0, 0.0, 0.2, 0.4, 0.5, 0.5]
//! place_m = [1.5, -0.5]   # optional; only measures success, the controller never uses it
//! ```
//!
//! or bounds for some sonars; the others may perceive anything:
//!
//! ```toml
//! [[sonar]]
//! numbers = [4]
//! at_least = 0.6
//! at_most = 0.8
//! [[sonar]]
//! numbers = [15, 0, 1]
//! at_most = 0.1
//! weight = 2              # weight of a deviation; 1 by default
//! ```
//!
//! Either may say more of the goal, as [`Goal`] has it; by default it is a place to be:
//!
//! ```toml
//! frame = "travel"        # sonar 0 looks where the robot goes; or "ring"
//! progress = 0.04         # a whole step ahead counts as much as this squared deviation, below 1
//! heading_hold = 0.005    # so does keeping the heading
//! cap = 0.333             # greatest deviation that counts
//! tolerance = 0.035       # the goal holds up to this deviation: root of the mean square
//! ```

use amp::fixed::{Mask, Weight};
use amp::goal::{Component, Goal, GoalFrame};
use amp::scan::{Encoding, Situation};
use arena::world::{MAX_COORDINATE_M, Point};
use files::error::BadInput;
use files::read_text;
use files::toml_reader::{Keyed, TomlText, TwoNumbers};
use serde::Deserialize;
use std::ops;
use std::path::Path;
use toml::Spanned;

/// Maximum file size, bytes.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// A goal situation from a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GoalFile {
    /// The file's name.
    pub path: String,
    /// The goal.
    pub goal: Goal<16>,
    /// Where the situation was captured, millimeters, if known.
    pub place_mm: Option<[i32; 2]>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GoalToml {
    situation: Option<Spanned<Vec<Spanned<f64>>>>,
    place_m: Option<Spanned<TwoNumbers>>,
    sonar: Option<Vec<Keyed<SonarBounds>>>,
    frame: Option<FrameName>,
    progress: Option<Spanned<f64>>,
    heading_hold: Option<Spanned<f64>>,
    cap: Option<Spanned<f64>>,
    tolerance: Option<Spanned<f64>>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum FrameName {
    Ring,
    Travel,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SonarBounds {
    numbers: Spanned<Vec<u8>>,
    at_least: Option<f64>,
    at_most: Option<f64>,
    weight: Option<u8>,
}

/// Position in the text, if it is at one place, and a description.
type ParseError = (Option<ops::Range<usize>>, String);

impl GoalFile {
    /// What was known of a situation at a place.
    #[must_use]
    pub fn perceived(path: &str, situation: &Situation<16>, known: Mask, place: Point) -> Self {
        let millimeters = |m: f64| libm::rint(m * 1e3) as i32;
        Self {
            path: path.to_owned(),
            goal: Goal::perceived(situation).for_known(known),
            place_mm: Some([place.x, place.y].map(millimeters)),
        }
    }

    /// Reads a goal file.
    ///
    /// # Errors
    /// When the file is bad: the message names the file and the line.
    pub fn load(path: &Path) -> Result<Self, BadInput> {
        let text = read_text(path, MAX_FILE_BYTES)?;
        Self::read(&text, &path.display().to_string())
    }

    /// Reads the text of a goal file; `name` is the file's name in errors.
    ///
    /// # Errors
    /// As [`GoalFile::load`].
    pub fn read(text: &str, name: &str) -> Result<Self, BadInput> {
        let text = TomlText { text, source: name };
        let (goal, place_mm) = parse(text.read()?).map_err(|(at, what)| match at {
            Some(at) => text.error(at, what),
            None => BadInput::file(name.as_ref(), what),
        })?;
        Ok(Self {
            path: name.to_owned(),
            goal,
            place_mm,
        })
    }

    /// Where the situation was captured, meters.
    #[must_use]
    pub fn place(&self) -> Option<Point> {
        let meters = |mm: i32| f64::from(mm) / 1e3;
        self.place_mm.map(|[x, y]| Point::new(meters(x), meters(y)))
    }
}

/// Text of a goal file for a captured situation; `remark` becomes a comment.
#[must_use]
pub fn text(situation: &Situation<16>, known: Mask, place: Point, remark: &str) -> String {
    let value = |(sonar, value): (usize, &Weight)| {
        if known.contains(sonar) {
            format!("{:?}", value.to_num::<f64>())
        } else {
            "nan".to_owned()
        }
    };
    let values: Vec<_> = situation.iter().enumerate().map(value).collect();
    format!(
        "# {remark}\n# By sonar (0 ahead, counter-clockwise): 1 = as near as the near limit, 0 = nothing within the far \
         limit, nan = not asked for.\nsituation = [{}]\nplace_m = [{:?}, {:?}]\n",
        values.join(", "),
        place.x,
        place.y
    )
}

/// On which scale the values of a situation are.
#[must_use]
pub fn scale(encoding: Encoding) -> String {
    let [near_m, far_m] = [encoding.near_mm, encoding.far_mm].map(|mm| f64::from(mm) / 1e3);
    format!("on a scale of {near_m} to {far_m} m")
}

/// Writes the text of a goal file, completely or not at all.
///
/// # Errors
/// When the file cannot be written.
pub fn write(path: &Path, text: &str) -> Result<(), BadInput> {
    let written = files::write(path, text.as_bytes());
    written.map_err(|error| files::unwritable(path, &error))
}

/// Text of a goal file for any goal, without a place; its name and its [`scale`] become a comment.
#[must_use]
pub fn whole_text(goal: &Goal<16>, name: &str, scale: &str) -> String {
    let (frame, first) = match goal.frame {
        GoalFrame::Ring => ("ring", "is the first sonar"),
        GoalFrame::Travel => ("travel", "looks where the robot goes"),
    };
    let name = name.replace(char::is_control, " ");
    let share = |q16: u16| f64::from(q16) / 65_536.0;
    let value = |weight: Weight| weight.to_num::<f64>();
    let mut text = format!(
        "# The goal \"{name}\" {scale}.\n\
         # numbers: 0 {first}, counter-clockwise. Values: 1 = as near as the near limit, 0 = nothing within the far limit.\n\
         frame = {frame:?}\nprogress = {:?}\nheading_hold = {:?}\ncap = {:?}\ntolerance = {:?}\n",
        share(goal.progress_q16),
        share(goal.heading_hold_q16),
        value(goal.cap),
        value(goal.tolerance),
    );
    let mut said = [false; 16];
    for (first, component) in goal.components.iter().enumerate() {
        if said[first] || component.weight == 0 {
            continue;
        }
        let alike = (0..16).filter(|sonar| goal.components[*sonar] == *component);
        let numbers: Vec<_> = alike.collect();
        for sonar in &numbers {
            said[*sonar] = true;
        }
        let Component { low, high, weight } = component;
        text += &format!(
            "[[sonar]]\nnumbers = {numbers:?}\nat_least = {:?}\nat_most = {:?}\nweight = {weight}\n",
            value(*low),
            value(*high),
        );
    }
    text
}

type Parsed = (Goal<16>, Option<[i32; 2]>);

fn parse(file: GoalToml) -> Result<Parsed, ParseError> {
    let place = file.place_m.as_ref().map(place).transpose()?;
    let components = components(&file, place.is_some())?;
    let mut goal = Goal::place(components);
    if let Some(FrameName::Travel) = file.frame {
        goal.frame = GoalFrame::Travel;
    }
    for (preference, key, given) in [
        (&mut goal.progress_q16, "progress", &file.progress),
        (
            &mut goal.heading_hold_q16,
            "heading_hold",
            &file.heading_hold,
        ),
    ] {
        if let Some(number) = given {
            let q16 = libm::rint(share(key, number)? * 65_536.0);
            *preference = q16.min(f64::from(u16::MAX)) as u16;
        }
    }
    for (deviation, key, given) in [
        (&mut goal.cap, "cap", &file.cap),
        (&mut goal.tolerance, "tolerance", &file.tolerance),
    ] {
        if let Some(number) = given {
            *deviation = Weight::from_num(share(key, number)?);
        }
    }
    Ok((goal, place))
}

/// A number from 0 to 1.
fn share(key: &str, number: &Spanned<f64>) -> Result<f64, ParseError> {
    let value = *number.get_ref();
    if (0.0..=1.0).contains(&value) {
        return Ok(value);
    }
    let what = format!("{key} must lie in 0..=1, not {value}");
    Err((Some(number.span()), what))
}

fn components(file: &GoalToml, has_place: bool) -> Result<[Component; 16], ParseError> {
    match (&file.situation, &file.sonar) {
        (Some(values), None) => situation(values),
        (None, Some(_)) if has_place => {
            let what = "place_m goes with a situation, not with [[sonar]]";
            Err((None, what.to_owned()))
        }
        (None, Some(sonars)) => bounds(sonars),
        _ => {
            let what = "a goal file holds either a situation of 16 values or some [[sonar]]";
            Err((None, what.to_owned()))
        }
    }
}

fn situation(values: &Spanned<Vec<Spanned<f64>>>) -> Result<[Component; 16], ParseError> {
    let mut components = [Component::ANY; 16];
    let count = values.get_ref().len();
    if count != components.len() {
        let what = format!("situation must hold 16 values, one per sonar, not {count}");
        return Err((Some(values.span()), what));
    }
    for (component, value) in components.iter_mut().zip(values.get_ref()) {
        let number = *value.get_ref();
        if number.is_nan() {
            continue;
        }
        if !(0.0..=1.0).contains(&number) {
            let what = format!(
                "each value of situation must lie in 0..=1 or be nan (not asked for), not {number}"
            );
            return Err((Some(value.span()), what));
        }
        *component = Component::equal(Weight::from_num(number));
    }
    if components == [Component::ANY; 16] {
        let what = "situation: 16 times nan asks for nothing".to_owned();
        return Err((Some(values.span()), what));
    }
    Ok(components)
}

fn place(meters: &Spanned<TwoNumbers>) -> Result<[i32; 2], ParseError> {
    let TwoNumbers(place) = meters.get_ref();
    let within = |m: &f64| m.abs() <= MAX_COORDINATE_M;
    match place.iter().find(|m| !within(m)) {
        Some(m) => {
            let what = format!("place_m must lie within 100 km of the origin, not at {m}");
            Err((Some(meters.span()), what))
        }
        None => Ok(place.map(|m| libm::rint(m * 1e3) as i32)),
    }
}

fn bounds(sonars: &[Keyed<SonarBounds>]) -> Result<[Component; 16], ParseError> {
    let mut components = [Component::ANY; 16];
    for Keyed(sonar) in sonars {
        let at = || Some(sonar.numbers.span());
        let component = component(sonar).map_err(|what| (at(), what))?;
        for &number in sonar.numbers.get_ref() {
            let place = components.get_mut(usize::from(number));
            *place.ok_or_else(|| {
                (
                    at(),
                    format!("there is no sonar {number}: they are 0 to 15"),
                )
            })? = component;
        }
    }
    if components == [Component::ANY; 16] {
        let what = "it asks for nothing: give a [[sonar]] its numbers and at_least or at_most";
        return Err((None, what.to_owned()));
    }
    Ok(components)
}

fn component(sonar: &SonarBounds) -> Result<Component, String> {
    let (low, high) = (sonar.at_least.unwrap_or(0.0), sonar.at_most.unwrap_or(1.0));
    if !(0.0 <= low && low <= high && high <= 1.0) {
        return Err(format!(
            "at_least {low} and at_most {high} must be in order and lie between 0 and 1"
        ));
    }
    Ok(Component {
        low: Weight::from_num(low),
        high: Weight::from_num(high),
        weight: sonar.weight.unwrap_or(1),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::config::Config;
    use amp::goal::Side;
    use amp::units::Range;

    fn read(text: &str) -> Result<GoalFile, String> {
        GoalFile::read(text, "g.toml").map_err(|error| error.to_string())
    }

    #[test]
    fn a_goal_is_what_its_file_says() {
        let text = "[[sonar]]\nnumbers = [4]\nat_least = 0.5\nat_most = 0.75\n\
                    [[sonar]]\nnumbers = [15, 0]\nat_most = 0.25\nweight = 2\n";
        let file = read(text).unwrap();
        let components = file.goal.components;
        let left = Component {
            low: Weight::from_num(0.5),
            high: Weight::from_num(0.75),
            weight: 1,
        };
        let ahead = Component {
            weight: 2,
            ..Component::at_most(Weight::from_num(0.25))
        };
        assert_eq!(components[4], left);
        assert_eq!([components[15], components[0]], [ahead; 2]);
        assert_eq!((components[7], file.place_mm), (Component::ANY, None));
    }

    #[test]
    fn a_captured_situation_comes_back_to_the_bit() {
        let perceived: Situation<16> =
            core::array::from_fn(|i| Weight::from_bits(i as i16 * 545 + 17));
        let known = Mask::ALL.without(3);
        let written = text(&perceived, known, Point::new(1.5, -0.25), "as perceived");
        let file = read(&written).unwrap();
        for (sonar, (component, value)) in file.goal.components.iter().zip(perceived).enumerate() {
            let expected = if sonar == 3 {
                Component::ANY
            } else {
                Component::equal(value)
            };
            assert_eq!(*component, expected, "{sonar}");
        }
        assert_eq!(file.place_mm, Some([1_500, -250]));
    }

    /// Those of the behaviors, in both frames.
    #[test]
    fn any_goal_comes_back_to_the_bit() {
        let config = Config::recommended();
        let range = Range::from_mm(600);
        let mut odd = Goal::wall(Side::Left, range, &config);
        (odd.progress_q16, odd.heading_hold_q16) = (u16::MAX, 1);
        (odd.cap, odd.tolerance) = (Weight::from_bits(1), Weight::ONE);
        for goal in [
            Goal::avoiding(&config),
            Goal::wall(Side::Right, range, &config),
            Goal::passing(Side::Right, range, &config),
            Goal::following(range, &config),
            Goal::perceived(&[Weight::from_bits(17); 16]),
            odd,
        ] {
            let file = read(&whole_text(&goal, "a \r\ngoal", &scale(config.encoding))).unwrap();
            assert_eq!((file.goal, file.place_mm), (goal, None));
        }
    }

    #[test]
    fn a_file_that_says_no_more_is_a_place_to_be() {
        let sonar = "[[sonar]]\nnumbers = [4]\nat_most = 0.5\n";
        let place = read(sonar).unwrap().goal;
        assert_eq!(place, Goal::place(place.components));
        let more = |key: &str| read(&format!("{key}\n{sonar}")).unwrap().goal;
        assert_eq!(more("frame = \"travel\"").frame, GoalFrame::Travel);
        assert_eq!(more("frame = \"ring\""), place);
        assert_eq!(more("progress = 0.25").progress_q16, 16_384);
        assert_eq!(more("heading_hold = 0.5").heading_hold_q16, 32_768);
        assert_eq!(more("cap = 0.5").cap, Weight::from_num(0.5));
        assert_eq!(more("tolerance = 0.25").tolerance, Weight::from_num(0.25));
    }

    #[test]
    fn a_bad_goal_is_refused_by_name_and_line() {
        let sixteen = |value: &str| format!("\nsituation = [{}]\n", [value; 16].join(", "));
        for (text, line, part) in [
            ("", None, "the file is empty"),
            ("sonar = []", None, "asks for nothing"),
            ("[[sonar]]\nnumbers = []\n", None, "asks for nothing"),
            ("[[sonar]]\nnumbers = [16]\n", Some(2), "no sonar 16"),
            (
                "frame = \"travle\"\n[[sonar]]\nnumbers = [1]\n",
                Some(1),
                "travel",
            ),
            (
                "\nprogress = 1.5\n[[sonar]]\nnumbers = [1]\nat_most = 0\n",
                Some(2),
                "progress must lie in 0..=1, not 1.5",
            ),
            (
                "tolerance = nan\n[[sonar]]\nnumbers = [1]\nat_most = 0\n",
                Some(1),
                "tolerance must lie in 0..=1, not NaN",
            ),
            (
                "[[sonar]]\nnumbers = [1]\nat_least = 2\n",
                Some(2),
                "at_least 2",
            ),
            (
                "[[sonar]]\nnumbers = [1]\nat_last = 1\n",
                Some(3),
                "sonar has no key \"at_last\", did you mean \"at_least\"?",
            ),
            (
                "[[sonar]]\nnumbers = [-1]\n",
                Some(2),
                "sonar.numbers: expected a whole number from 0 to 255, found -1",
            ),
            (
                "[[sonar]]\nat_most = 1\n",
                Some(1),
                "sonar needs the key \"numbers\"",
            ),
            ("[[sonar]]\nnumbers = [1]\nat_most = nan\n", Some(2), "NaN"),
            ("situation = [0.5, 1]\n", Some(1), "16 values"),
            (
                &sixteen("1.5"),
                Some(2),
                "0..=1 or be nan (not asked for), not 1.5",
            ),
            (&sixteen("nan"), Some(2), "asks for nothing"),
            (
                &sixteen("\"near\""),
                Some(2),
                "situation: expected a number, found \"near\"",
            ),
            (
                &(sixteen("0") + "place_m = [1, 2, 3]\n"),
                Some(3),
                "place_m: expected two numbers: [x, y], found 3",
            ),
            (&(sixteen("0") + "place_m = [1e9, 0]\n"), Some(3), "place_m"),
            (
                &(sixteen("0") + "[[sonar]]\nnumbers = [1]\n"),
                None,
                "either a situation",
            ),
            (
                "place_m = [0, 0]\n[[sonar]]\nnumbers = [1]\nat_most = 0\n",
                None,
                "place_m",
            ),
        ] {
            let why = read(text).unwrap_err();
            let line = line.map_or("g.toml: ".to_owned(), |line| {
                format!("g.toml, line {line}: ")
            });
            assert!(
                why.starts_with(&line) && why.contains(part),
                "{text}: {why}"
            );
        }
    }
}
