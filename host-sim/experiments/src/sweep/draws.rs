//! The points of `[random]`.

use super::points::Row;
use arena::noise::Noise;

/// What a value is drawn from.
#[derive(Debug, Clone, PartialEq)]
pub enum Drawn {
    /// One of these.
    OneOf(Vec<String>),
    /// A number of a range, to six significant digits.
    Between {
        /// Its lower end.
        min: f64,
        /// Its upper end.
        max: f64,
        /// Evenly by its logarithm.
        log: bool,
        /// Whole numbers, both ends among them.
        whole: bool,
    },
}

/// Draws points, each key once per point in the order in which they were added.
#[derive(Debug)]
pub struct Draws {
    noise: Noise,
    keys: Vec<(String, Drawn)>,
}

impl Draws {
    /// Draws of `seed`; no keys yet.
    pub fn new(seed: u64) -> Self {
        Self {
            noise: Noise::new(seed),
            keys: Vec::new(),
        }
    }

    /// One more key.
    pub fn add(&mut self, key: &str, drawn: Drawn) {
        self.keys.push((key.to_owned(), drawn));
    }

    /// The next point.
    pub fn draw(&mut self) -> Row {
        let Self { noise, keys } = self;
        let value = |(key, drawn): &(String, Drawn)| (key.clone(), value(noise, drawn));
        keys.iter().map(value).collect()
    }
}

fn value(noise: &mut Noise, drawn: &Drawn) -> String {
    match *drawn {
        Drawn::OneOf(ref texts) => {
            let index = noise.index(texts.len());
            texts.get(index).cloned().unwrap_or_default()
        }
        Drawn::Between {
            min,
            max,
            log,
            whole,
        } => {
            // Whole numbers: each has a stretch of length 1 of its own.
            let top = if whole { max + 1.0 } else { max };
            let number = if log {
                libm::exp(noise.uniform_in(libm::log(min), libm::log(top)))
            } else {
                noise.uniform_in(min, top)
            };
            let number = if whole {
                number.floor()
            } else {
                shortened(number)
            };
            number.clamp(min, max).to_string()
        }
    }
}

/// Six significant digits.
fn shortened(number: f64) -> f64 {
    format!("{number:.5e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(drawn: Drawn) -> Vec<f64> {
        let mut draws = Draws::new(3);
        draws.add("key", drawn);
        let mut number = || draws.draw().first().and_then(|(_, text)| text.parse().ok());
        (0..2_000).map(|_| number().expect("a number")).collect()
    }

    fn share(values: &[f64], of: impl Fn(f64) -> bool) -> f64 {
        values.iter().filter(|value| of(**value)).count() as f64 / values.len() as f64
    }

    #[test]
    fn draws_are_even_within_their_range() {
        let (log, whole) = (false, false);
        let values = drawn(Drawn::Between {
            min: 1.0,
            max: 3.0,
            log,
            whole,
        });
        assert!(values.iter().all(|value| (1.0..=3.0).contains(value)));
        assert!((share(&values, |value| value < 1.5) - 0.25).abs() < 0.04);
        // By the logarithm, each of the two decades has half of them.
        let values = drawn(Drawn::Between {
            min: 0.01,
            max: 1.0,
            log: true,
            whole,
        });
        assert!((share(&values, |value| value < 0.1) - 0.5).abs() < 0.04);
        assert!(values.iter().all(|value| value.to_string().len() <= 9));
    }

    #[test]
    fn whole_numbers_reach_both_ends_and_choices_all_texts() {
        let values = drawn(Drawn::Between {
            min: 2.0,
            max: 4.0,
            log: false,
            whole: true,
        });
        for number in [2.0, 3.0, 4.0] {
            assert!((share(&values, |value| value == number) - 1.0 / 3.0).abs() < 0.04);
        }
        let values = drawn(Drawn::OneOf(vec!["5".into(), "6".into()]));
        assert!((share(&values, |value| value == 5.0) - 0.5).abs() < 0.04);
    }

    #[test]
    fn the_seed_fixes_the_points() {
        let points = |seed| {
            let mut draws = Draws::new(seed);
            let (min, max, log, whole) = (1.0, 9.0, false, false);
            draws.add(
                "far",
                Drawn::Between {
                    min,
                    max,
                    log,
                    whole,
                },
            );
            [draws.draw(), draws.draw()]
        };
        assert_eq!(points(1), points(1));
        assert_ne!(points(1), points(2));
        let [first, second] = points(1);
        assert_ne!(first, second);
    }
}
