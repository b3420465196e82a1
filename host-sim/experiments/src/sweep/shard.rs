//! The part of a sweep that one process runs.

use files::error::BadInput;
use std::str::FromStr;

/// Shard `index` of `count`: the episodes whose number modulo `count` is `index`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    count: u64,
}

impl Shard {
    /// The whole sweep.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Shard `index` of `count`; `None` unless `index < count`.
    #[must_use]
    pub fn new(index: u64, count: u64) -> Option<Self> {
        (index < count).then_some(Self { index, count })
    }

    /// Whether it is the whole sweep.
    #[must_use]
    pub fn is_whole(self) -> bool {
        self.count == 1
    }

    /// Number of its episodes in a sweep of `episodes`.
    #[must_use]
    pub fn len(self, episodes: u64) -> u64 {
        (episodes / self.count) + u64::from(self.index < episodes % self.count)
    }

    /// The number of its `nth` episode, counted from 0.
    #[must_use]
    pub fn number(self, nth: u64) -> u64 {
        nth * self.count + self.index
    }

    /// The shard that a scheduler's environment defines, with the names of the variables; `None`
    /// without them.
    ///
    /// Slurm array jobs (`SLURM_ARRAY_TASK_ID` of `SLURM_ARRAY_TASK_COUNT`) and Kubernetes indexed
    /// Jobs (`JOB_COMPLETION_INDEX` of `SWEEP_SHARDS`, which the manifest sets).
    ///
    /// # Errors
    /// A variable without its partner, a value that is no number, or an index that is not below the
    /// count.
    pub fn from_environment(
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Option<(Self, &'static str)>, BadInput> {
        for (index, count, hint) in [
            (
                "SLURM_ARRAY_TASK_ID",
                "SLURM_ARRAY_TASK_COUNT",
                "number the array from 0 without gaps (--array=0-3), or give --shard I/N",
            ),
            (
                "JOB_COMPLETION_INDEX",
                "SWEEP_SHARDS",
                "set SWEEP_SHARDS to the Job's completions, or give --shard I/N",
            ),
        ] {
            let Some(given) = variable(index) else {
                continue;
            };
            let Some(of) = variable(count) else {
                return Err(BadInput::new(format!(
                    "{index} is set, {count} is not: {hint}"
                )));
            };
            let shard = given.parse().ok().zip(of.parse().ok());
            let shard = shard.and_then(|(index, count)| Self::new(index, count));
            let wrong =
                || BadInput::new(format!("{index}={given} is not below {count}={of}: {hint}"));
            return Ok(Some((shard.ok_or_else(wrong)?, index)));
        }
        Ok(None)
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        let parts = text.split_once('/');
        let numbers = parts.and_then(|(index, count)| index.parse().ok().zip(count.parse().ok()));
        let shard = numbers.and_then(|(index, count)| Self::new(index, count));
        shard.ok_or_else(|| {
            BadInput::new(format!(
                "\"{text}\" is not I/N with whole numbers 0 ≤ I < N, such as 0/4"
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_every_episode_once() {
        for episodes in [0, 1, 2, 7, 12] {
            let mut all = Vec::new();
            for index in 0..3 {
                let shard = Shard::new(index, 3).expect("below 3");
                all.extend((0..shard.len(episodes)).map(|nth| shard.number(nth)));
            }
            all.sort_unstable();
            assert_eq!(all, (0..episodes).collect::<Vec<_>>());
        }
        assert_eq!(Shard::WHOLE.len(5), 5);
    }

    #[test]
    fn only_an_index_below_the_count_is_one() {
        assert_eq!("2/3".parse(), Ok(Shard { index: 2, count: 3 }));
        for text in ["3/3", "0/0", "1", "-1/3", "1/3/5", "a/b", ""] {
            let error = text.parse::<Shard>().expect_err(text).to_string();
            assert!(error.contains("I/N"), "{error}");
        }
    }

    fn of(set: &[(&str, &str)]) -> Result<Option<(Shard, &'static str)>, BadInput> {
        Shard::from_environment(|name| {
            let found = set.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn schedulers_name_the_shard() {
        assert_eq!(of(&[]), Ok(None));
        let slurm = [
            ("SLURM_ARRAY_TASK_ID", "1"),
            ("SLURM_ARRAY_TASK_COUNT", "4"),
        ];
        let shard = Shard { index: 1, count: 4 };
        assert_eq!(of(&slurm), Ok(Some((shard, "SLURM_ARRAY_TASK_ID"))));
        let job = [("JOB_COMPLETION_INDEX", "1"), ("SWEEP_SHARDS", "4")];
        assert_eq!(of(&job), Ok(Some((shard, "JOB_COMPLETION_INDEX"))));
    }

    #[test]
    fn an_array_that_begins_at_one_is_refused() {
        let say = |set: &[(&str, &str)]| of(set).expect_err("a bad environment").to_string();
        // A rerun of task 2 alone must not run the whole sweep.
        let alone = [
            ("SLURM_ARRAY_TASK_ID", "2"),
            ("SLURM_ARRAY_TASK_COUNT", "1"),
        ];
        assert!(
            say(&alone).contains("SLURM_ARRAY_TASK_ID=2 is not below SLURM_ARRAY_TASK_COUNT=1")
        );
        assert!(say(&[("JOB_COMPLETION_INDEX", "0")]).contains("SWEEP_SHARDS is not"));
        let text = [("JOB_COMPLETION_INDEX", "x"), ("SWEEP_SHARDS", "4")];
        assert!(say(&text).contains("JOB_COMPLETION_INDEX=x"));
    }
}
