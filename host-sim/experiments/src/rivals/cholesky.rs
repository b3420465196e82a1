//! Cholesky factorization of a symmetric positive definite matrix (G. Golub, C. Van Loan, *Matrix
//! Computations*, section 4.2).

/// The lower triangle L with L Lᵀ = A; row i has i + 1 numbers.
#[derive(Debug, Clone)]
pub struct Cholesky {
    rows: Vec<Vec<f64>>,
}

impl Cholesky {
    /// Of the matrix of this size whose element in row i and column j ≤ i is `matrix(i, j)`;
    /// `None` if it is not positive definite.
    #[must_use]
    pub fn of(size: usize, matrix: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(size);
        for i in 0..size {
            let mut row = Vec::with_capacity(i + 1);
            for (j, above) in rows.iter().enumerate() {
                let rest = matrix(i, j) - dot(&row, &above[..j]);
                row.push(rest / above[j]);
            }
            let rest = matrix(i, i) - dot(&row, &row);
            if rest <= 0.0 {
                return None;
            }
            row.push(rest.sqrt());
            rows.push(row);
        }
        Some(Self { rows })
    }

    /// L⁻¹ b for several right sides at once: a row of `b` holds one number of each.
    #[must_use]
    pub fn forward<const N: usize>(&self, b: &[[f64; N]]) -> Vec<[f64; N]> {
        let mut x: Vec<[f64; N]> = Vec::with_capacity(b.len());
        for (row, b) in self.rows.iter().zip(b) {
            let mut rest = *b;
            for (factor, x) in row.iter().zip(&x) {
                subtract(&mut rest, *factor, x);
            }
            let diagonal = row[x.len()];
            x.push(rest.map(|rest| rest / diagonal));
        }
        x
    }

    /// A⁻¹ b, likewise.
    #[must_use]
    pub fn solve<const N: usize>(&self, b: &[[f64; N]]) -> Vec<[f64; N]> {
        let mut x = self.forward(b);
        for (i, row) in self.rows.iter().enumerate().rev() {
            let value = x[i].map(|value| value / row[i]);
            x[i] = value;
            for (x, factor) in x[..i].iter_mut().zip(row) {
                subtract(x, *factor, &value);
            }
        }
        x
    }

    /// Logarithm of the determinant of A.
    #[must_use]
    pub fn log_determinant(&self) -> f64 {
        let diagonal = self.rows.iter().filter_map(|row| row.last());
        2.0 * diagonal.map(|value| libm::log(*value)).sum::<f64>()
    }
}

fn subtract<const N: usize>(from: &mut [f64; N], factor: f64, x: &[f64; N]) {
    for (from, x) in from.iter_mut().zip(x) {
        *from -= factor * x;
    }
}

/// Scalar product of the common part: four partial sums in a fixed order, for SIMD.
#[must_use]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.0.iter().zip(b.0) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    let rest: f64 = a.1.iter().zip(b.1).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_solves_by_hand() {
        // [4 2; 2 5] = L Lᵀ with L = [2 0; 1 2]; determinant 16.
        let matrix = [[4.0, 2.0], [2.0, 5.0]];
        let factor = Cholesky::of(2, |i, j| matrix[i][j]).expect("positive definite");
        assert_eq!(factor.rows, [vec![2.0], vec![1.0, 2.0]]);
        assert_eq!(
            factor.forward(&[[2.0, 4.0], [5.0, 2.0]]),
            [[1.0, 2.0], [2.0, 0.0]]
        );
        assert_eq!(
            factor.solve(&[[8.0, 4.0], [12.0, 2.0]]),
            [[1.0, 1.0], [2.0, 0.0]]
        );
        assert!((factor.log_determinant() - libm::log(16.0)).abs() < 1e-12);
        assert!(Cholesky::of(2, |_, _| 1.0).is_none());
    }

    #[test]
    fn a_scalar_product_of_any_length() {
        let numbers: Vec<f64> = (1..=7).map(f64::from).collect();
        assert_eq!(dot(&numbers, &numbers), 140.0);
        assert_eq!(dot(&numbers[..3], &numbers[..3]), 14.0);
    }
}
