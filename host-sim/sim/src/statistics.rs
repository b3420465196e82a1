//! Means, shares and rates with their confidence intervals.

use arena::noise::Noise;

/// A mean with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// The mean.
    pub mean: f64,
    /// The ends of the interval.
    pub interval: [f64; 2],
}

impl Mean {
    /// A share, in percent.
    #[must_use]
    pub fn percent(self) -> Self {
        Self {
            mean: self.mean * 100.0,
            interval: self.interval.map(|end| end * 100.0),
        }
    }
}

/// The mean and its interval, with three decimals if the format does not say how many.
impl std::fmt::Display for Mean {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = f.precision().unwrap_or(3);
        let ([low, high], mean) = (self.interval, self.mean);
        write!(f, "{mean:.digits$} [{low:.digits$}, {high:.digits$}]")
    }
}

/// Number of resamples.
const DRAWS: usize = 2_000;

/// Mean with its bootstrap percentile interval; worlds and the seeds within them are resampled.
#[must_use]
pub fn bootstrap(worlds: &[Vec<f64>]) -> Mean {
    let single = |world: &Vec<f64>| world.iter().map(|value| [*value]).collect();
    let rows: Vec<_> = worlds.iter().map(single).collect();
    bootstrap_of(&rows, |[sum], count| sum / count)
}

/// As [`bootstrap`], of a `statistic` of the columns' sums and the number of rows (at least 1), for
/// example a ratio of two sums.
#[must_use]
pub fn bootstrap_of<const COLUMNS: usize>(
    worlds: &[Vec<[f64; COLUMNS]>],
    statistic: impl Fn([f64; COLUMNS], f64) -> f64,
) -> Mean {
    let value_of = |(sums, count): Sums<COLUMNS>| statistic(sums, count.max(1) as f64);
    let mut noise = Noise::new(1);
    let mut values: Vec<f64> = (0..DRAWS)
        .map(|_| value_of(resample(worlds, &mut noise)))
        .collect();
    values.sort_by(f64::total_cmp);
    let mut all = ([0.0; COLUMNS], 0);
    worlds.iter().flatten().for_each(|row| add(&mut all, row));
    Mean {
        mean: value_of(all),
        interval: [quantile(&values, 0.025), quantile(&values, 0.975)],
    }
}

/// Sums of the columns, and number of rows.
type Sums<const COLUMNS: usize> = ([f64; COLUMNS], usize);

fn add<const COLUMNS: usize>((sums, count): &mut Sums<COLUMNS>, row: &[f64; COLUMNS]) {
    for (sum, value) in sums.iter_mut().zip(row) {
        *sum += value;
    }
    *count += 1;
}

/// Draws worlds with replacement, and rows with replacement within each.
fn resample<const COLUMNS: usize>(
    worlds: &[Vec<[f64; COLUMNS]>],
    noise: &mut Noise,
) -> Sums<COLUMNS> {
    let mut sums = ([0.0; COLUMNS], 0);
    for _ in worlds {
        let Some(world) = worlds.get(noise.index(worlds.len())) else {
            continue;
        };
        for _ in world {
            if let Some(row) = world.get(noise.index(world.len())) {
                add(&mut sums, row);
            }
        }
    }
    sums
}

/// The value at this share of a sorted sample; 0 without values.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let index = (share * (DRAWS - 1) as f64) as usize;
    sorted.get(index).copied().unwrap_or(0.0)
}

/// The mean; 0 without values.
#[must_use]
pub fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0_u32);
    for value in values {
        sum += value;
        count += 1;
    }
    sum / f64::from(count.max(1))
}

/// The median, the upper one of an even number; 0 without values.
#[must_use]
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Pearson correlation of pairs; 0 if either side is constant.
#[must_use]
pub fn pearson(pairs: &[[f64; 2]]) -> f64 {
    let means = [0, 1].map(|i| mean(pairs.iter().map(|pair| pair[i])));
    let product = |i: usize, j: usize| {
        pairs
            .iter()
            .map(|pair| (pair[i] - means[i]) * (pair[j] - means[j]))
            .sum::<f64>()
    };
    let scale = (product(0, 0) * product(1, 1)).sqrt();
    if scale > 0.0 {
        product(0, 1) / scale
    } else {
        0.0
    }
}

/// Share of successes in `count` independent trials with Wilson's score interval (E. B. Wilson,
/// *Journal of the American Statistical Association* 22, 1927). It has a width even if all trials
/// succeed. Without trials it is [0, 1].
#[must_use]
pub fn wilson(successes: usize, count: usize) -> Mean {
    /// The standard normal's 97.5 % quantile.
    const Z: f64 = 1.959_963_984_540_054;
    if count == 0 {
        return Mean {
            mean: 0.0,
            interval: [0.0, 1.0],
        };
    }
    let n = count as f64;
    let share = successes as f64 / n;
    let middle = share + Z * Z / (2.0 * n);
    let half = Z * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    let whole = 1.0 + Z * Z / n;
    let end = |value: f64| (value / whole).clamp(0.0, 1.0);
    Mean {
        mean: share,
        interval: [end(middle - half), end(middle + half)],
    }
}

/// Exact 95 % interval of a Poisson mean after `count` events (F. Garwood, "Fiducial limits for the
/// Poisson distribution", *Biometrika* 28, 1936).
#[must_use]
pub fn poisson_interval(count: u64) -> [f64; 2] {
    let low = match count {
        0 => 0.0,
        _ => mean_with_tail(count, 0.025),
    };
    [low, mean_with_tail(count.saturating_add(1), 0.975)]
}

/// Probability of `count` or more events where `mean` are expected. Takes time proportional to
/// `count`.
#[must_use]
pub fn poisson_tail(count: u64, mean: f64) -> f64 {
    // In logarithms, because e^−mean underflows from a mean of 746.
    let mut log_term = -mean;
    let mut fewer = 0.0;
    for number in 0..count {
        fewer += libm::exp(log_term);
        log_term += libm::log(mean / (number as f64 + 1.0));
    }
    (1.0 - fewer).max(0.0)
}

/// The mean for which `count` or more events have this probability.
fn mean_with_tail(count: u64, probability: f64) -> f64 {
    let (mut low, mut high) = (0.0, 2.0 * count as f64 + 20.0);
    for _ in 0..100 {
        let middle = (low + high) / 2.0;
        if poisson_tail(count, middle) < probability {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// Weighted least squares of a value by two coordinates, through the origin.
#[derive(Debug, Clone, Copy, Default)]
pub struct PlaneFit {
    xx: f64,
    xy: f64,
    yy: f64,
    xv: f64,
    yv: f64,
}

impl PlaneFit {
    /// A determinant below this share of its greatest possible value leaves the slopes open.
    const LEAST_DETERMINANT: f64 = 1e-9;

    /// Adds a value at a position; `weight` is at least 0.
    pub fn add(&mut self, weight: f64, [x, y]: [f64; 2], value: f64) {
        self.xx += weight * x * x;
        self.xy += weight * x * y;
        self.yy += weight * y * y;
        self.xv += weight * x * value;
        self.yv += weight * y * value;
    }

    /// Slope of the value along x and along y; `None` where the positions do not span the plane.
    #[must_use]
    pub fn slopes(&self) -> Option<[f64; 2]> {
        let Self { xx, xy, yy, xv, yv } = self;
        let determinant = xx * yy - xy * xy;
        (determinant > Self::LEAST_DETERMINANT * xx * yy).then(|| {
            [
                (yy * xv - xy * yv) / determinant,
                (xx * yv - xy * xv) / determinant,
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_found_and_its_weights_count() {
        let mut fit = PlaneFit::default();
        for [x, y] in [[1.0, 0.0], [0.5, 2.0], [-1.0, 1.0]] {
            fit.add(1.0, [x, y], 3.0 * x - 2.0 * y);
        }
        let [x, y] = fit.slopes().unwrap();
        assert!((x - 3.0).abs() < 1e-12 && (y + 2.0).abs() < 1e-12);
        // Two values at one position: the slope is that of their weighted mean, 1/4 · 4 + 3/4 · 8.
        let mut weighted = PlaneFit::default();
        weighted.add(1.0, [1.0, 0.0], 4.0);
        weighted.add(3.0, [1.0, 0.0], 8.0);
        weighted.add(1.0, [0.0, 1.0], 5.0);
        assert_eq!(weighted.slopes(), Some([7.0, 5.0]));
    }

    #[test]
    fn positions_on_a_line_leave_the_slopes_open() {
        let mut fit = PlaneFit::default();
        assert_eq!(fit.slopes(), None);
        for x in [0.1, 0.2, 0.7] {
            fit.add(1.0, [x, 3.0 * x], x);
        }
        assert_eq!(fit.slopes(), None);
    }

    /// Garwood's table: 0 events (0, 3.689), 1 (0.0253, 5.572), 10 (4.795, 18.39).
    #[test]
    fn the_poisson_interval_is_that_of_the_tables() {
        for (count, low, high) in [(0, 0.0, 3.689), (1, 0.0253, 5.572), (10, 4.795, 18.39)] {
            let [found_low, found_high] = poisson_interval(count);
            assert!((found_low - low).abs() < 5e-4, "{count}: {found_low}");
            assert!((found_high - high).abs() < 5e-3, "{count}: {found_high}");
        }
        // For thousands of events, Wilson and Hilferty's approximation of chi-squared (1931).
        let [low, high] = poisson_interval(4_380);
        assert!((low - 4_251.24).abs() < 0.01, "{low}");
        assert!((high - 4_511.67).abs() < 0.01, "{high}");
        assert_eq!((poisson_tail(0, 0.0), poisson_tail(1, 0.0)), (1.0, 0.0));
        assert_eq!(poisson_tail(0, 3.0), 1.0);
        assert!((poisson_tail(1, 0.5) - (1.0 - libm::exp(-0.5))).abs() < 1e-12);
    }

    #[test]
    fn the_interval_holds_the_mean_and_narrows() {
        let worlds = |count: usize| vec![vec![0.0, 1.0, 0.0, 1.0]; count];
        let (few, many) = (bootstrap(&worlds(3)), bootstrap(&worlds(300)));
        for found in [few, many] {
            assert!((found.mean - 0.5).abs() < 1e-12);
            assert!(found.interval[0] < 0.5 && found.interval[1] > 0.5);
        }
        let width = |found: Mean| found.interval[1] - found.interval[0];
        assert!(width(many) < width(few) / 5.0);
        assert_eq!(bootstrap(&[]).mean, 0.0);
    }
    #[test]
    fn a_ratio_is_that_of_the_sums() {
        // 6 contacts on 4 m and none on 8 m: half a contact per meter, not the mean of 1.5 and 0.
        let rows = vec![vec![[6.0, 4.0], [0.0, 8.0]]; 40];
        let found = bootstrap_of(&rows, |[contacts, way], _| contacts / way);
        assert!((found.mean - 0.5).abs() < 1e-12);
        assert!(found.interval[0] < 0.5 && found.interval[1] > 0.5);
    }

    #[test]
    fn mean_median_and_correlation() {
        assert_eq!((mean([1.0, 3.0]), mean([])), (2.0, 0.0));
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert!((pearson(&[[0.0, 1.0], [1.0, 3.0], [2.0, 5.0]]) - 1.0).abs() < 1e-12);
        assert!((pearson(&[[0.0, 1.0], [1.0, 0.0], [2.0, -1.0]]) + 1.0).abs() < 1e-12);
        assert_eq!(pearson(&[[0.0, 1.0], [1.0, 1.0]]), 0.0);
    }

    /// The examples of R. G. Newcombe, *Statistics in Medicine* 17, 1998, table I, method 3.
    #[test]
    fn wilsons_intervals_are_the_published_ones() {
        for (successes, count, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let found = wilson(successes, count);
            assert_eq!(found.mean, successes as f64 / count as f64);
            assert!((found.interval[0] - low).abs() < 5.1e-5, "{found}");
            assert!((found.interval[1] - high).abs() < 5.1e-5, "{found}");
        }
        assert_eq!(wilson(0, 0).interval, [0.0, 1.0]);
        assert_eq!(wilson(20, 20).interval[1], 1.0);
    }
}
