//! Serial arms: joints, links, limits, and what is seen of the hand.

use arena::noise::Noise;

/// A position or direction, m.
pub type Vector = [f64; 3];

/// Axis of a joint in the frame of the link before it, whose x lies along that link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Up from the plane of x and y: the joint turns to the left.
    Z,
    /// To the left: the joint bends downwards.
    Y,
}

/// A revolute joint and the link after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// Its axis.
    pub axis: Axis,
    /// Length of the link, m.
    pub link_m: f64,
    /// Limits of the angle, degrees.
    pub limits_deg: [f64; 2],
}

/// A pinhole camera that looks at the arm's base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Its position, m.
    pub position_m: Vector,
    /// Width of the image in units of the focal length: the image is square.
    pub width: f64,
}

/// What is sensed of the hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum View {
    /// Three Cartesian coordinates.
    Space,
    /// Two Cartesian coordinates, of an arm in the plane.
    Plane,
    /// Two image coordinates.
    Image(Camera),
}

impl View {
    /// Number of values.
    #[must_use]
    pub const fn values(self) -> usize {
        match self {
            Self::Space => 3,
            Self::Plane | Self::Image(_) => 2,
        }
    }
}

/// An arm.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmBody {
    /// Its name.
    pub name: String,
    /// Joints from the base to the hand.
    pub joints: Vec<Joint>,
    /// Longest move of each joint, degrees.
    pub step_deg: f64,
    /// What is sensed of the hand.
    pub view: View,
}

const fn joint(axis: Axis, link_m: f64, limits_deg: [f64; 2]) -> Joint {
    Joint {
        axis,
        link_m,
        limits_deg,
    }
}

impl ArmBody {
    /// The arm for the experiment of Coiton et al.: waist, shoulder, elbow. Its lengths and limits
    /// are ours; the paper has none.
    #[must_use]
    pub fn coiton(view: View) -> Self {
        Self {
            name: "waist, shoulder, elbow".to_owned(),
            joints: vec![
                joint(Axis::Z, 0.0, [-150.0, 150.0]),
                joint(Axis::Y, 0.4, [-120.0, 30.0]),
                joint(Axis::Y, 0.4, [0.0, 140.0]),
            ],
            step_deg: 30.0,
            view,
        }
    }

    /// Another body, for control: two joints turn left and right, the last one bends.
    #[must_use]
    pub fn sideways(view: View) -> Self {
        Self {
            name: "two turns, one bend".to_owned(),
            joints: vec![
                joint(Axis::Z, 0.55, [-110.0, 110.0]),
                joint(Axis::Z, 0.2, [-20.0, 150.0]),
                joint(Axis::Y, 0.35, [-100.0, 80.0]),
            ],
            step_deg: 30.0,
            view,
        }
    }

    /// An arm in the plane with this many joints, 1 m long in all; each turns by 180° in all
    /// divided by the root of their number, so that longer chains do not coil.
    #[must_use]
    pub fn planar(joints: usize) -> Self {
        let count = joints.max(1) as f64;
        let most_deg = 180.0 / count.sqrt();
        Self {
            name: format!("{joints} joints in the plane"),
            joints: vec![joint(Axis::Z, 1.0 / count, [-most_deg, most_deg]); joints],
            step_deg: 40.0 / count.sqrt(),
            view: View::Plane,
        }
    }

    /// An eye: it turns to both sides and up and down.
    #[must_use]
    pub fn eye() -> Self {
        Self {
            name: "eye".to_owned(),
            joints: vec![
                joint(Axis::Z, 0.0, [-70.0, 70.0]),
                joint(Axis::Y, 1.0, [-60.0, 60.0]),
            ],
            step_deg: 20.0,
            view: View::Plane,
        }
    }

    /// A stiff arm of 0.6 m that turns at the shoulder.
    #[must_use]
    pub fn pointing() -> Self {
        Self {
            name: "pointing arm".to_owned(),
            joints: vec![
                joint(Axis::Z, 0.0, [-80.0, 80.0]),
                joint(Axis::Y, 0.6, [-80.0, 60.0]),
            ],
            step_deg: 20.0,
            view: View::Plane,
        }
    }

    /// The camera of the second variant: at the right of the arm, in front of it and above.
    #[must_use]
    pub const fn camera() -> Camera {
        Camera {
            position_m: [1.6, -1.2, 0.9],
            width: 0.9,
        }
    }

    /// Length of the stretched arm, m.
    #[must_use]
    pub fn reach_m(&self) -> f64 {
        self.joints.iter().map(|joint| joint.link_m).sum()
    }

    /// Positions of the base and of the end of each link, m; angles in radians.
    #[must_use]
    pub fn chain_m(&self, angles: &[f64]) -> Vec<Vector> {
        let mut ends = vec![[0.0; 3]];
        // Axes of the link's frame, in the base's frame.
        let mut frame = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut end = [0.0; 3];
        for (joint, angle) in self.joints.iter().zip(angles) {
            frame = turned(frame, joint.axis, *angle);
            end = plus(end, frame[0], joint.link_m);
            ends.push(end);
        }
        ends
    }

    /// Position of the hand, m.
    #[must_use]
    pub fn hand_m(&self, angles: &[f64]) -> Vector {
        let mut hand = [0.0; 3];
        for (joint, angle) in self.joints.iter().zip(angles).rev() {
            hand[0] += joint.link_m;
            hand = about(joint.axis, *angle, hand);
        }
        hand
    }

    /// The situation: what is sensed of the hand, then the joint angles, each in [0, 1]. A length
    /// of one is twice the reach, or the width of the image.
    #[must_use]
    pub fn situation<const V: usize>(&self, angles: &[f64]) -> [f64; V] {
        let mut values = [0.0; V];
        let hand = self.seen(self.hand_m(angles));
        let sensed = self.view.values();
        values[..sensed].copy_from_slice(&hand[..sensed]);
        let joints = self.joints.iter().zip(angles);
        for (value, (joint, angle)) in values[sensed..].iter_mut().zip(joints) {
            let [low, high] = joint.limits_deg.map(f64::to_radians);
            *value = (angle - low) / (high - low);
        }
        values
    }

    /// What is sensed of a hand at this position; the first values of the view count.
    #[must_use]
    pub fn seen(&self, hand_m: Vector) -> Vector {
        match self.view {
            View::Space | View::Plane => {
                let width_m = 2.0 * self.reach_m();
                hand_m.map(|part| 0.5 + part / width_m)
            }
            View::Image(camera) => camera.image(hand_m),
        }
    }

    /// The posture after an action, in radians: joints stop at their limits.
    #[must_use]
    pub fn moved<const A: usize>(&self, angles: &[f64; A], action: &[f64; A]) -> [f64; A] {
        let mut next = *angles;
        let moves = self.joints.iter().zip(action);
        for (angle, (joint, share)) in next.iter_mut().zip(moves) {
            let [low, high] = joint.limits_deg.map(f64::to_radians);
            let step = share.clamp(-1.0, 1.0) * self.step_deg.to_radians();
            *angle = (*angle + step).clamp(low, high);
        }
        next
    }

    /// The action that leads from one posture to another, each joint by its longest move at most.
    #[must_use]
    pub fn action<const A: usize>(&self, from: &[f64; A], to: &[f64; A]) -> [f64; A] {
        let step = self.step_deg.to_radians();
        std::array::from_fn(|j| ((to[j] - from[j]) / step).clamp(-1.0, 1.0))
    }

    /// The middle of all joints.
    #[must_use]
    pub fn middle<const A: usize>(&self) -> [f64; A] {
        std::array::from_fn(|j| {
            let [low, high] = self.joints[j].limits_deg.map(f64::to_radians);
            (low + high) / 2.0
        })
    }

    /// A random posture, uniform within the limits.
    pub fn random_posture<const A: usize>(&self, noise: &mut Noise) -> [f64; A] {
        std::array::from_fn(|j| {
            let [low, high] = self.joints[j].limits_deg.map(f64::to_radians);
            noise.uniform_in(low, high)
        })
    }
}

impl Camera {
    /// Image coordinates of a point: right and up, each in [0, 1] where the image shows it.
    fn image(&self, point_m: Vector) -> Vector {
        let forward = unit(self.position_m.map(|part| -part));
        let right = unit(cross(forward, [0.0, 0.0, 1.0]));
        let up = cross(right, forward);
        let from = [0, 1, 2].map(|i| point_m[i] - self.position_m[i]);
        let depth = dot(from, forward).max(1e-6);
        let at = |axis: Vector| 0.5 + dot(from, axis) / depth / self.width;
        [at(right), at(up), 0.0]
    }
}

/// A vector in a frame that is turned about one of its axes.
fn about(axis: Axis, angle: f64, [x, y, z]: Vector) -> Vector {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    match axis {
        Axis::Z => [cos * x - sin * y, sin * x + cos * y, z],
        Axis::Y => [cos * x + sin * z, y, cos * z - sin * x],
    }
}

fn turned([x, y, z]: [Vector; 3], axis: Axis, angle: f64) -> [Vector; 3] {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let mix = |a: Vector, b: Vector, sign: f64| [0, 1, 2].map(|i| cos * a[i] + sign * sin * b[i]);
    match axis {
        Axis::Z => [mix(x, y, 1.0), mix(y, x, -1.0), z],
        Axis::Y => [mix(x, z, -1.0), y, mix(z, x, 1.0)],
    }
}

fn plus(a: Vector, b: Vector, factor: f64) -> Vector {
    [0, 1, 2].map(|i| a[i] + factor * b[i])
}

/// Dot product.
#[must_use]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The vector at length one.
#[must_use]
pub fn unit(vector: Vector) -> Vector {
    let length = dot(vector, vector).sqrt().max(1e-12);
    vector.map(|part| part / length)
}

/// Distance of two points.
#[must_use]
pub fn distance(a: Vector, b: Vector) -> f64 {
    let gap = plus(a, b, -1.0);
    dot(gap, gap).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hand_is_the_end_of_the_chain_and_in_view() {
        let image = View::Image(ArmBody::camera());
        let bodies = [
            ArmBody::coiton(View::Space),
            ArmBody::coiton(image),
            ArmBody::sideways(View::Space),
        ];
        let mut noise = Noise::new(1);
        for body in &bodies {
            for _ in 0..200 {
                let angles: [f64; 3] = body.random_posture(&mut noise);
                let chain = body.chain_m(&angles);
                assert_eq!(chain.len(), 4);
                assert!(distance(chain[3], body.hand_m(&angles)) < 1e-12);
                for (ends, joint) in chain.windows(2).zip(&body.joints) {
                    assert!((distance(ends[0], ends[1]) - joint.link_m).abs() < 1e-12);
                }
                let values: [f64; 6] = body.situation(&angles);
                assert!(values.iter().all(|value| (0.0..=1.0).contains(value)));
            }
        }
    }

    #[test]
    fn a_stretched_arm_and_a_bent_one_are_where_they_should_be() {
        let body = ArmBody::coiton(View::Space);
        let quarter = std::f64::consts::FRAC_PI_2;
        let at = |angles: [f64; 3], hand_m: Vector| distance(body.hand_m(&angles), hand_m) < 1e-12;
        assert!(at([0.0; 3], [0.8, 0.0, 0.0]));
        assert!(at([quarter, 0.0, 0.0], [0.0, 0.8, 0.0]));
        // Shoulder up, elbow forward.
        assert!(at([0.0, -quarter, quarter], [0.4, 0.0, 0.4]));
        // The base is in the middle of the image.
        let [x, y, _] = ArmBody::camera().image([0.0; 3]);
        assert!((x - 0.5).abs() < 1e-12 && (y - 0.5).abs() < 1e-12);
        let [_, higher, _] = ArmBody::camera().image([0.0, 0.0, 0.2]);
        assert!(higher > 0.5);
    }

    #[test]
    fn joints_move_by_a_step_at_most_and_stop_at_their_limits() {
        let body = ArmBody::coiton(View::Space);
        // The shoulder's limit is 30° upwards, the elbow's 0°.
        let from = [0.0, 0.2, 0.1];
        let to = body.moved(&from, &[2.0, 1.0, -1.0]);
        let degrees = to.map(f64::to_degrees);
        assert!((degrees[0] - 30.0).abs() < 1e-9 && (degrees[1] - 30.0).abs() < 1e-9);
        assert_eq!(degrees[2], 0.0);
        let executed = body.action(&from, &to);
        assert!((executed[0] - 1.0).abs() < 1e-9);
        assert!((executed[2] + 0.1_f64.to_degrees() / 30.0).abs() < 1e-9);
    }
}
