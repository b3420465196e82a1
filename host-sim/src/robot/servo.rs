//! Position servos with limited velocity and acceleration, one time step at a time.

/// What exceeds a square by this factor has a root that is greater, whatever the rounding.
const FAR: f64 = 1.0 + 1e-9;

/// One time step towards rest at `left`: returns how far it goes and the velocity after it. Neither the
/// limit nor the acceleration is exceeded, and the end is met exactly: on the braking curve v² = 2·a·left
/// each step stays on it.
pub(super) fn approach(left: f64, velocity: f64, limit: f64, a: f64, dt: f64) -> (f64, f64) {
    let sign = if left < 0.0 { -1.0 } else { 1.0 };
    let (left, v) = (left * sign, velocity * sign);
    let stopping = v * v / (2.0 * a);
    if (0.0..=a * dt).contains(&v) && left <= stopping + super::NEGLIGIBLE {
        return (left * sign, 0.0);
    }
    let half = a * dt / 2.0;
    let squared = half * half + 2.0 * a * (left - v * dt / 2.0).max(0.0);
    let (low, high) = (v - a * dt, v + a * dt);
    let most = limit.min(high);
    let next = if most > 0.0 && squared > (most + half) * (most + half) * FAR {
        // As the formula below, without its root.
        most.max(low)
    } else {
        (squared.sqrt() - half).min(limit).clamp(low, high)
    };
    ((v + next) / 2.0 * dt * sign, next * sign)
}

/// One time step of braking: how far it goes and the velocity after it.
pub(super) fn slow(velocity: f64, a: f64, dt: f64) -> (f64, f64) {
    let less = a * dt;
    if velocity.abs() <= less {
        return (velocity * velocity.abs() / (2.0 * a), 0.0);
    }
    let next = velocity - if velocity > 0.0 { less } else { -less };
    ((velocity + next) / 2.0 * dt, next)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// Without the short cut.
    fn by_root(left: f64, velocity: f64, limit: f64, a: f64, dt: f64) -> (f64, f64) {
        let sign = if left < 0.0 { -1.0 } else { 1.0 };
        let (left, v) = (left * sign, velocity * sign);
        let half = a * dt / 2.0;
        let wanted = (half * half + 2.0 * a * (left - v * dt / 2.0).max(0.0)).sqrt() - half;
        let next = wanted.min(limit).clamp(v - a * dt, v + a * dt);
        ((v + next) / 2.0 * dt * sign, next * sign)
    }

    #[test]
    fn no_root_is_missed() {
        let mut noise = Noise::new(1);
        for _ in 0..100_000 {
            let left = noise.uniform_in(-1.0, 1.0);
            let left = left * left * left;
            let velocity = noise.uniform_in(-0.6, 0.6);
            let limit = noise.uniform_in(0.01, 0.5);
            let at_rest = velocity.abs() <= 0.0076;
            if !at_rest {
                assert_eq!(
                    approach(left, velocity, limit, 0.762, 0.01),
                    by_root(left, velocity, limit, 0.762, 0.01),
                    "{left} {velocity} {limit}"
                );
            }
        }
    }
}
