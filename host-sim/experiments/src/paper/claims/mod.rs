//! The table of claims: statement of the paper, rule, measurement, verdict.
//!
//! The rules are ours and equal for all readings of the paper. A claim *holds* when all presets
//! meet its rule, and *holds partly* when some do.

mod behaviors;
mod chaining;
mod controls;
mod maps;
mod other_systems;
mod planning;
mod reinforcement;
mod repetition;
pub mod sequences;

use super::measure::Measured;

/// Result of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClaimVerdict {
    /// The measurement confirms it.
    Holds,
    /// Confirmed for some readings or cases only.
    Partly,
    /// The measurement contradicts it.
    DoesNotHold,
    /// Not testable here.
    NotTestable,
}

impl ClaimVerdict {
    /// All verdicts, most favorable first.
    pub const ALL: [Self; 4] = [
        Self::Holds,
        Self::Partly,
        Self::DoesNotHold,
        Self::NotTestable,
    ];

    /// The verdict in words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Partly => "holds partly",
            Self::DoesNotHold => "does not hold",
            Self::NotTestable => "not testable here",
        }
    }

    /// From the cases: all meet the rule, some do, or none.
    fn of(cases: &[bool]) -> Self {
        match cases.iter().filter(|&&met| met).count() {
            0 => Self::DoesNotHold,
            met if met == cases.len() => Self::Holds,
            _ => Self::Partly,
        }
    }
}

/// One line of the table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Claim {
    /// Section or figure of the paper: a number or "Fig.".
    pub section: &'static str,
    /// The claim, in words of the paper.
    pub words: &'static str,
    /// The rule for the verdict.
    pub rule: String,
    /// The measurement, or the reason why there is none.
    pub measured: String,
    /// Size of the sample.
    pub sample: String,
    /// The verdict.
    pub verdict: ClaimVerdict,
}

impl Claim {
    fn new(section: &'static str, words: &'static str) -> Self {
        Self {
            section,
            words,
            rule: String::new(),
            measured: String::new(),
            sample: String::new(),
            verdict: ClaimVerdict::NotTestable,
        }
    }

    /// Place in the paper: "§ 2.3", "Fig. 5".
    #[must_use]
    pub fn place(&self) -> String {
        let mark = if self.section.starts_with(|c: char| c.is_ascii_digit()) {
            "§ "
        } else {
            ""
        };
        format!("{mark}{}", self.section)
    }

    fn holds_if(mut self, rule: impl Into<String>) -> Self {
        self.rule = rule.into();
        self
    }

    fn measured(mut self, what: impl Into<String>, sample: impl Into<String>) -> Self {
        (self.measured, self.sample) = (what.into(), sample.into());
        self
    }

    fn verdict(mut self, verdict: ClaimVerdict) -> Self {
        self.verdict = verdict;
        self
    }

    /// The design guarantees the claim: no measurement.
    fn by_construction(mut self, why: &'static str) -> Self {
        self.rule = "by construction".to_owned();
        self.measured = why.to_owned();
        self.verdict = ClaimVerdict::Holds;
        self
    }

    /// The claim cannot be measured, for this reason.
    fn untestable(mut self, why: &'static str) -> Self {
        self.measured = why.to_owned();
        self
    }
}

/// The whole table, in the order of the paper.
#[must_use]
pub fn claims(measured: &Measured) -> Vec<Claim> {
    let mut claims = maps::claims(measured);
    claims.extend(repetition::claims(measured));
    claims.extend(planning::claims(measured));
    claims.extend(behaviors::claims(measured));
    let later = claims
        .iter()
        .position(|claim| claim.section.starts_with('5'));
    let later = later.unwrap_or(claims.len());
    let related = other_systems::related_works(measured);
    let related = related.into_iter().chain(sequences::claims(measured));
    claims.splice(later..later, related.collect::<Vec<_>>());
    claims.extend(chaining::claims(measured));
    claims.push(other_systems::pointing(measured));
    claims
}

/// Names of the presets, in the order of the readings.
const PRESETS: [&str; 3] = ["default", "probe", "touzet"];

/// A value for each preset: "default 1, probe 2".
fn by_preset<T>(presets: &[&str], values: &[T], text: impl Fn(&T) -> String) -> String {
    let parts = presets.iter().zip(values);
    let parts: Vec<_> = parts
        .map(|(name, v)| format!("{name} {}", text(v)))
        .collect();
    parts.join(", ")
}

/// Part of a whole in percent; 0 if the whole is 0.
fn percent(part: u32, whole: u32) -> f64 {
    100.0 * f64::from(part) / f64::from(whole.max(1))
}

/// A percentage as text.
fn percents(value: f64) -> String {
    format!("{value:.1} %")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_follow_the_cases() {
        let of = ClaimVerdict::of;
        assert_eq!(of(&[true, true]), ClaimVerdict::Holds);
        assert_eq!(of(&[true, false]), ClaimVerdict::Partly);
        assert_eq!(of(&[false]), ClaimVerdict::DoesNotHold);
        assert_eq!(by_preset(&["a", "b"], &[1, 2], i32::to_string), "a 1, b 2");
    }
}
