//! Compares a situation with another one in every rotation of the ring, without copying it.

use super::learning::Values;

/// The values twice: rotated by p steps they begin at index 16 − p.
#[derive(Debug, Clone, PartialEq)]
pub struct RotatableRing([f64; 32]);

impl RotatableRing {
    /// Stores these values.
    #[must_use]
    pub fn new(values: &Values) -> Self {
        Self(std::array::from_fn(|i| values[i % 16]))
    }

    /// The values rotated by `places`.
    fn rotated(&self, places: usize) -> &[f64] {
        let first = 16 - places % 16;
        self.0.get(first..first + 16).unwrap_or(&[])
    }

    /// Squared distance of `values` to these, rotated by `places`.
    #[must_use]
    pub fn squared_distance(&self, values: &Values, places: usize) -> f64 {
        sum(values, self.rotated(places), |a, b| (a - b) * (a - b))
    }

    /// Scalar product of `values` and these, rotated by `places`.
    #[must_use]
    pub fn product(&self, values: &Values, places: usize) -> f64 {
        sum(values, self.rotated(places), |a, b| a * b)
    }
}

/// Four partial sums in a fixed order, for SIMD.
fn sum(a: &Values, b: &[f64], term: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sums = [0.0; 4];
    for (a, b) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += term(*a, *b);
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turned_values_are_those_of_the_turned_situation() {
        let a: Values = std::array::from_fn(|i| i as f64);
        let b: Values = std::array::from_fn(|i| (i * i % 7) as f64);
        for places in 0..16 {
            let rotated = amp::scan::rotated(&b, places);
            let pairs = || a.iter().zip(&rotated);
            let apart: f64 = pairs().map(|(a, b)| (a - b) * (a - b)).sum();
            let product: f64 = pairs().map(|(a, b)| a * b).sum();
            // Whole numbers: no rounding.
            assert_eq!(RotatableRing::new(&b).squared_distance(&a, places), apart);
            assert_eq!(RotatableRing::new(&b).product(&a, places), product);
        }
    }
}
