//! The fixed-point map against the same map in 64-bit floats.

use super::*;

/// The same map in 64-bit floats: what the fixed-point one is compared with.
struct Twin {
    code: Vec<[f64; 16]>,
}

impl Twin {
    fn of(map: &Som<16, 16>) -> Self {
        let code = map
            .code()
            .iter()
            .map(|row| row.map(|w| w.to_num::<f64>()))
            .collect();
        Self { code }
    }

    fn nearest(&self, probe: &[f64; 16]) -> (usize, f64) {
        let squared = |row: &[f64; 16]| {
            row.iter()
                .zip(probe)
                .map(|(w, x)| (w - x) * (w - x))
                .sum::<f64>()
        };
        let distances = self.code.iter().map(squared).enumerate();
        let (k, least) = distances.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        (k, libm::sqrt(least))
    }

    fn learn(&mut self, winner: usize, probe: &[f64; 16], rate: f64, radius: f64) {
        for (k, row) in self.code.iter_mut().enumerate() {
            let (dx, dy) = SQUARE.offsets(winner, k);
            let gain = rate * libm::exp(-((dx * dx + dy * dy) as f64) / (2.0 * radius * radius));
            for (w, x) in row.iter_mut().zip(probe) {
                *w += gain * (x - *w);
            }
        }
    }
}

/// A ring in a rectangular room: smooth values in [0, 1] with a little noise, as a situation has
/// them.
fn sonar_like(generator: &mut Xoshiro256PlusPlus) -> [Weight; 16] {
    let mut uniform = || f64::from(generator.next_u32() >> 8) / f64::from(1 << 24);
    let sides = [3.0 + 5.0 * uniform(), 3.0 + 5.0 * uniform()];
    let place = sides.map(|side| 0.4 + (side - 0.8) * uniform());
    let heading = uniform();
    core::array::from_fn(|sensor| {
        let angle = core::f64::consts::TAU * (heading + sensor as f64 / 16.0);
        let ahead = |along: f64, place: f64, side: f64| {
            let gap = if along > 0.0 { side - place } else { place };
            gap / along.abs().max(1e-9)
        };
        let (x, y) = (
            ahead(libm::cos(angle), place[0], sides[0]),
            ahead(libm::sin(angle), place[1], sides[1]),
        );
        let range = x.min(y) * (0.98 + 0.04 * uniform());
        let value = ((3.0 - range) / 2.75).clamp(0.0, 1.0);
        unit_weight((value * f64::from(ONE_BITS)) as i32)
    })
}

// Miri takes some thousand times as long.
const SEEDS: u64 = if cfg!(miri) { 1 } else { 10 };
const STEPS: u32 = if cfg!(miri) { 40 } else { 20_000 };
const PROBES: usize = if cfg!(miri) { 40 } else { 10_000 };

/// 20 000 presentations in fixed point and, from the same start and on the same sequence, in 64-bit
/// floats, each map learning at its own winners: the winner is the same for at least 99.5 % of 10
/// 000 probes afterwards (and of the presentations), the quantization error within 0.5 %.
///
/// Where two neurons are equally near the last bit decides, and two maps that once learned at
/// different neurons may part for good. That the two stay together needs all of it: 32-bit code
/// vectors, winners in full precision, fine gains.
#[test]
fn the_fixed_point_map_is_its_twin_in_floats() {
    let rate = Schedule::from_q16(32_768, 655, Decay::Exponential);
    let radius = Schedule::from_q16(2 << 16, 19_661, Decay::Exponential);
    let q16 = |value: u32| f64::from(value) / 65_536.0;
    for seed in 1..=SEEDS {
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
        let start = core::array::from_fn(|_| sonar_like(&mut generator));
        let mut map = Som::<16, 16>::new(SQUARE, start);
        let mut twin = Twin::of(&map);
        let mut agreed = 0;
        for step in 0..STEPS {
            let probe = sonar_like(&mut generator);
            let exact = probe.map(|w| w.to_num());
            let (rate, radius) = (rate.at(step, STEPS), radius.at(step, STEPS));
            let update = Update::from_q16(Neighborhood::Gaussian, rate, radius);
            let winner = map.train_step(&probe, Mask::ALL, &update);
            let twins = twin.nearest(&exact).0;
            agreed += u32::from(twins == winner);
            twin.learn(twins, &exact, q16(rate), q16(radius));
        }
        let probes: Vec<_> = (0..PROBES).map(|_| sonar_like(&mut generator)).collect();
        let found = probes.iter().map(|p| twin.nearest(&p.map(|w| w.to_num())));
        let (winners, distances): (Vec<_>, Vec<_>) = found.unzip();
        let exact = distances.iter().sum::<f64>() / PROBES as f64;
        let error = map.quality(&probes).0.quantization_error();
        let same = probes.iter().zip(&winners);
        let same = same.filter(|(p, w)| map.bmu(p, Mask::ALL) == **w).count();
        let share = f64::from(agreed) / f64::from(STEPS);
        assert!(share >= 0.995, "seed {seed}: {share}");
        assert!(same as f64 >= 0.995 * PROBES as f64, "seed {seed}: {same}");
        assert!(
            (error / exact - 1.0).abs() <= 0.005,
            "seed {seed}: {error} {exact}"
        );
    }
}
