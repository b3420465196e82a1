//! A region that the hand must not enter.

/// A ball in the values that are sensed of the hand, in their units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// Its center; as many values count as are sensed.
    pub center: [f64; 3],
    /// Its radius.
    pub radius: f64,
}

impl Region {
    /// Distance of sensed values from the region, negative inside.
    #[must_use]
    pub fn clearance(&self, sensed: &[f64]) -> f64 {
        let pairs = sensed.iter().zip(&self.center);
        pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt() - self.radius
    }

    /// The outward normal at sensed values.
    #[must_use]
    pub fn normal(&self, sensed: &[f64]) -> [f64; 3] {
        let away = (self.clearance(sensed) + self.radius).max(1e-9);
        let mut normal = [0.0; 3];
        for (part, (value, center)) in normal.iter_mut().zip(sensed.iter().zip(&self.center)) {
            *part = (value - center) / away;
        }
        normal
    }
}
