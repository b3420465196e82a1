//! Least squares in floating point, for the controls.

/// What each actuator's whole action changes.
pub(super) type Rows<const V: usize, const A: usize> = [[f64; V]; A];

/// Ridge of a fit: less than the square of a typical action.
const RIDGE: f64 = 1e-3;
/// Weight of the squared action.
const DAMPING: f64 = 1e-4;
/// Weight of keeping off a region.
const KEEP_OFF_WEIGHT: f64 = 100.0;
/// Rounds over all actuators, at most.
const SWEEPS: usize = 100;

/// The linear model that fits moves best: (action, change) pairs.
pub(super) fn fit<const V: usize, const A: usize>(
    moves: impl Iterator<Item = ([f64; A], [f64; V])>,
) -> Rows<V, A> {
    let (mut normal, mut rows) = ([[0.0; A]; A], [[0.0; V]; A]);
    for (i, row) in normal.iter_mut().enumerate() {
        row[i] = RIDGE;
    }
    for (action, change) in moves {
        for i in 0..A {
            for j in 0..A {
                normal[i][j] += action[i] * action[j];
            }
            for v in 0..V {
                rows[i][v] += action[i] * change[v];
            }
        }
    }
    // The matrix is positive definite: no pivot is zero.
    for i in 0..A {
        let pivot = normal[i][i];
        normal[i].iter_mut().for_each(|part| *part /= pivot);
        rows[i].iter_mut().for_each(|part| *part /= pivot);
        let (row, right) = (normal[i], rows[i]);
        for other in (0..A).filter(|other| *other != i) {
            let factor = normal[other][i];
            for j in 0..A {
                normal[other][j] -= factor * row[j];
            }
            for v in 0..V {
                rows[other][v] -= factor * right[v];
            }
        }
    }
    rows
}

/// A half space that the sensed values stay in: its normal, the least change along it, and the
/// longest action.
pub(super) struct Limit {
    pub(super) normal: [f64; 3],
    pub(super) least: f64,
    pub(super) longest: f64,
}

/// The action that brings values nearest to their intervals, by coordinate descent, as in
/// `amp::couple`.
pub(super) fn solve<const V: usize, const A: usize>(
    rows: &Rows<V, A>,
    situation: &[f64; V],
    bounds: &[[f64; 2]; V],
    limit: Option<&Limit>,
) -> [f64; A] {
    let (mut values, mut action, mut along) = (*situation, [0.0; A], 0.0);
    let longest = limit.map_or(1.0, |limit| limit.longest);
    let across = |row: &[f64; V]| {
        limit.map_or(0.0, |limit| {
            let products = row.iter().zip(&limit.normal);
            products.map(|(effect, part)| effect * part).sum()
        })
    };
    for _ in 0..SWEEPS {
        let mut largest: f64 = 0.0;
        for (share, row) in action.iter_mut().zip(rows) {
            let (mut slope, mut curvature) = (DAMPING * *share, DAMPING);
            for v in 0..V {
                let nearest = values[v].max(bounds[v][0]).min(bounds[v][1]);
                slope += row[v] * (values[v] - nearest);
                curvature += row[v] * row[v];
            }
            let effect: f64 = across(row);
            if let Some(limit) = limit {
                slope += KEEP_OFF_WEIGHT * effect * (along - limit.least).min(0.0);
                curvature += KEEP_OFF_WEIGHT * effect * effect;
            }
            let next = (*share - slope / curvature).clamp(-longest, longest);
            let step = next - *share;
            for v in 0..V {
                values[v] += row[v] * step;
            }
            along += effect * step;
            *share = next;
            largest = largest.max(step.abs());
        }
        if largest < if limit.is_some() { 3e-5 } else { 1e-3 } {
            break;
        }
    }
    action
}

#[cfg(test)]
mod tests {
    use super::*;
    use arena::noise::Noise;

    #[test]
    fn a_linear_body_is_fitted_and_its_goal_reached() {
        let mut noise = Noise::new(4);
        let mut draw = || noise.uniform_in(-0.5, 0.5);
        let rows: Rows<3, 2> = std::array::from_fn(|_| std::array::from_fn(|_| draw()));
        let moves: Vec<_> = (0..50)
            .map(|_| {
                let action = [draw(), draw()];
                let change =
                    std::array::from_fn(|v| action[0] * rows[0][v] + action[1] * rows[1][v]);
                (action, change)
            })
            .collect();
        let found = fit(moves.into_iter());
        for (found, exact) in found.as_flattened().iter().zip(rows.as_flattened()) {
            assert!((found - exact).abs() < 2e-3, "{found} {exact}");
        }
        // An action that is known is found again.
        let to: [f64; 3] = std::array::from_fn(|v| 0.3 * rows[0][v] - 0.4 * rows[1][v]);
        let action = solve(&found, &[0.0; 3], &to.map(|value| [value; 2]), None);
        assert!(
            (action[0] - 0.3).abs() < 0.02 && (action[1] + 0.4).abs() < 0.02,
            "{action:?}"
        );
    }
}
