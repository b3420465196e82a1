//! Compares the chip's kernels with the portable ones: same winners, same code vectors.

use amp::action_map::{ActionMap, Effect};
use amp::fixed::{Mask, Weight};
use amp::som::Update;
use amp::som::{Edges, Grid, Neighborhood, Som};
use core::array::from_fn;
use cortex_m4::KERNELS;

/// Pairs of maps, and updates of each.
const MAPS: u32 = 24;
const STEPS: u32 = 16;

/// Panics if the kernels differ anywhere. In every third map the code vectors are close together,
/// so that ranks rarely decide the winner; in every third they are at the ends of their range.
pub fn compare() {
    let mut rng = XorShift(1);
    for number in 0..MAPS {
        let spread = [16_384, 40, 16_384][number as usize % 3];
        let ends = number % 3 == 2;
        let mut weight = |middle: i16| {
            let value = i32::from(middle) + rng.below(spread) - spread / 2;
            let value = value.clamp(-8_192, 8_192);
            let end = if value < 0 { -8_192 } else { 8_192 };
            Weight::from_bits(if ends { end } else { value } as i16)
        };
        let middle: [i16; 16] = from_fn(|_| weight(0).to_bits() / 2);
        let code = from_fn(|_| middle.map(&mut weight));
        let actions = from_fn(|_| [0, 0].map(&mut weight));
        let edges = [Edges::Open, Edges::Wrapped][number as usize % 2];
        let grid = Grid::rectangle(4, 4).with_edges(edges);
        let (situations, actions) = (Som::new(grid, code), ActionMap::new(grid, code, actions));
        learn(&mut rng, situations, actions, &middle, spread);
    }
}

fn learn(
    rng: &mut XorShift,
    mut situations: Som<16, 16>,
    mut actions: ActionMap<16, 16>,
    middle: &[i16; 16],
    spread: i32,
) {
    let (mut simd, mut actions_simd) = (situations.clone(), actions.clone());
    simd.use_kernels(&KERNELS);
    actions_simd.use_kernels(&KERNELS);
    for step in 0..STEPS {
        let mut near = |middle: i16| {
            let value = i32::from(middle) + rng.below(spread) - spread / 2;
            Weight::from_bits(value.clamp(-8_192, 8_192) as i16)
        };
        // At an even and an odd offset: the kernels load whole words.
        let mut room = [Weight::ZERO; 17];
        let place = step as usize % 2;
        for (value, middle) in room[place..].iter_mut().zip(middle) {
            *value = near(*middle);
        }
        let probe: &[Weight; 16] = room[place..].first_chunk().expect("there are 17");
        let effect = Effect {
            change: *probe,
            action: [near(0), near(0)],
            mask: Mask::ALL,
        };
        let winner = situations.bmu(probe, Mask::ALL);
        assert_eq!(simd.bmu(probe, Mask::ALL), winner);
        let weight = [0, 256, 511, u16::MAX][step as usize % 4];
        let neuron = actions.bmu(&effect, weight);
        assert_eq!(actions_simd.bmu(&effect, weight), neuron);
        // Rates and shares from 0 to 1, most below 1/2.
        let (rate, share) = (rng.below(40_000) as u32, rng.below(65_536) as u32);
        let update = Update::from_q16(Neighborhood::Direct, rate, share * (step % 3));
        situations.update(winner, probe, Mask::ALL, &update);
        simd.update(winner, probe, Mask::ALL, &update);
        actions.update(neuron, &effect, &update);
        actions_simd.update(neuron, &effect, &update);
        assert!(simd == situations && actions_simd == actions);
    }
}

/// Pseudo-random numbers (G. Marsaglia, Xorshift RNGs, 2003).
struct XorShift(u32);

impl XorShift {
    fn below(&mut self, bound: i32) -> i32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        (self.0 % bound.unsigned_abs().max(1)) as i32
    }
}
