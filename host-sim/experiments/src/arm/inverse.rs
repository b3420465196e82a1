//! Analytic inverse kinematics of the two bodies of three joints: the upper bound.

use super::body::{ArmBody, Axis, Vector, distance};
use std::f64::consts::PI;

/// Postures within the limits that bring the hand to a position, in radians.
pub(super) fn postures<const A: usize>(body: &ArmBody, hand_m: Vector) -> Vec<[f64; A]> {
    let axes: Vec<Axis> = body.joints.iter().map(|joint| joint.axis).collect();
    let found = match axes[..] {
        [Axis::Z, Axis::Y, Axis::Y] => bent(body, hand_m),
        [Axis::Z, Axis::Z, Axis::Y] => turned(body, hand_m),
        _ => Vec::new(),
    };
    let inside = |angles: &[f64; 3]| {
        let pairs = body.joints.iter().zip(angles);
        pairs.into_iter().all(|(joint, angle)| {
            let [low, high] = joint.limits_deg.map(f64::to_radians);
            (low - 1e-9..=high + 1e-9).contains(angle)
        })
    };
    let found = found.into_iter().filter(inside);
    let exact = found.filter(|angles| distance(body.hand_m(angles), hand_m) < 1e-6);
    let sized = exact.map(|angles| std::array::from_fn(|j| angles.get(j).copied().unwrap_or(0.0)));
    sized.collect()
}

/// Both postures of two links in a plane, as turns from x towards y of the first link and of the
/// second one from the first, that end at (x, y).
fn two_links(first_m: f64, second_m: f64, x: f64, y: f64) -> [[f64; 2]; 2] {
    let squared = x * x + y * y;
    let cos = (squared - first_m * first_m - second_m * second_m) / (2.0 * first_m * second_m);
    let bend = libm::acos(cos.clamp(-1.0, 1.0));
    [bend, -bend].map(|bend| {
        let across = second_m * libm::sin(bend);
        let along = first_m + second_m * libm::cos(bend);
        [libm::atan2(y, x) - libm::atan2(across, along), bend]
    })
}

/// Waist, shoulder and elbow: two links in the plane that the waist turns.
fn bent(body: &ArmBody, [x, y, z]: Vector) -> Vec<[f64; 3]> {
    let [_, upper, fore] = [0, 1, 2].map(|j| body.joints[j].link_m);
    let radius = libm::hypot(x, y);
    let front = libm::atan2(y, x);
    let mut found = Vec::new();
    for (waist, radius) in [(front, radius), (front + PI, -radius)] {
        // A bend about y lowers the link.
        for [shoulder, elbow] in two_links(upper, fore, radius, -z) {
            found.push([waist, shoulder, elbow].map(wrapped));
        }
    }
    found
}

/// Two turns and one bend: the last link's height tells its bend, and two links remain.
fn turned(body: &ArmBody, [x, y, z]: Vector) -> Vec<[f64; 3]> {
    let [upper, middle, fore] = [0, 1, 2].map(|j| body.joints[j].link_m);
    let bend = libm::asin((-z / fore).clamp(-1.0, 1.0));
    let mut found = Vec::new();
    for bend in [bend, PI - bend] {
        let second = middle + fore * libm::cos(bend);
        for [first, turn] in two_links(upper, second, x, y) {
            found.push([first, turn, bend].map(wrapped));
        }
    }
    found
}

/// An angle in (−π, π].
fn wrapped(angle: f64) -> f64 {
    let turns = libm::ceil(angle / (2.0 * PI) - 0.5);
    angle - turns * 2.0 * PI
}

#[cfg(test)]
mod tests {
    use super::super::body::View;
    use super::*;
    use arena::noise::Noise;

    #[test]
    fn a_posture_is_found_for_every_position_of_the_hand() {
        for body in [ArmBody::coiton(View::Space), ArmBody::sideways(View::Space)] {
            let mut noise = Noise::new(3);
            for _ in 0..500 {
                let angles: [f64; 3] = body.random_posture(&mut noise);
                let hand_m = body.hand_m(&angles);
                let found = postures::<3>(&body, hand_m);
                let errors = found.iter().map(|found| {
                    let gaps = found.iter().zip(&angles).map(|(a, b)| (a - b).abs());
                    gaps.fold(0.0, f64::max)
                });
                let nearest = errors.fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-5, "{}: {angles:?} {found:?}", body.name);
            }
        }
    }
}
