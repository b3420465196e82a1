//! Errors of user input: one clear sentence that names the file, key or value.

use std::fmt;
use std::path::Path;

/// Invalid input. Displays as one sentence for the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadInput(String);

impl BadInput {
    /// An error with this sentence.
    pub fn new(sentence: impl Into<String>) -> Self {
        Self(sentence.into())
    }

    /// An error about a whole file: "`path`: `what`".
    pub fn file(path: &Path, what: impl fmt::Display) -> Self {
        Self(format!("{}: {what}", path.display()))
    }

    /// An error about one line (counted from 1) of a file: "`source`, line `line`: `what`".
    pub fn line(source: &str, line: usize, what: impl fmt::Display) -> Self {
        Self(format!("{source}, line {line}: {what}"))
    }

    /// An unknown word: names it, suggests the nearest candidate, and lists them all.
    pub fn unknown(what: &str, word: &str, candidates: &[&str]) -> Self {
        let hint = suggestion(word, candidates);
        Self(format!(
            "unknown {what} \"{word}\"{hint} (known: {})",
            candidates.join(", ")
        ))
    }
}

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for BadInput {}

/// The candidate that `word` most likely means: at most one error (a letter added, missing, changed
/// or swapped with its neighbor) per three letters.
#[must_use]
pub fn did_you_mean<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let word = word.to_lowercase();
    let slips_allowed = (word.chars().count() / 3).max(1);
    candidates
        .iter()
        .map(|&candidate| (strsim::osa_distance(&word, candidate), candidate))
        .filter(|&(slips, _)| slips <= slips_allowed)
        .min_by_key(|&(slips, _)| slips)
        .map(|(_, candidate)| candidate)
}

/// `, did you mean "…"?`, or nothing without a near candidate.
pub fn suggestion(word: &str, candidates: &[&str]) -> String {
    did_you_mean(word, candidates)
        .map(|near| format!(", did you mean \"{near}\"?"))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_words_are_suggested_and_far_ones_are_not() {
        let known = ["paper", "corridor", "office"];
        assert_eq!(did_you_mean("paepr", &known), Some("paper"));
        assert_eq!(did_you_mean("Corridr", &known), Some("corridor"));
        assert_eq!(did_you_mean("ofice", &known), Some("office"));
        assert_eq!(did_you_mean("zebra", &known), None);
        assert_eq!(did_you_mean("", &known), None);
    }

    #[test]
    fn an_unknown_word_is_named_with_the_nearest_one() {
        let error = BadInput::unknown("world", "paepr", &["paper", "office"]).to_string();
        assert_eq!(
            error,
            "unknown world \"paepr\", did you mean \"paper\"? (known: paper, office)"
        );
    }
}
