//! Behaviors by name as goals: what a ring would perceive if the robot did what is asked.
//!
//! All in the frame of travel: component 0 looks where the robot goes. Weights and preferences were
//! found by measurement (the project's documentation has the table); none is learned by the robot.

use super::{Component, Goal, GoalFrame};
use crate::config::Config;
use crate::fixed::Weight;
use crate::units::{Bearing, Range};
use micromath::F32Ext;

/// A side of the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// To the left of the way.
    Left,
    /// To the right of the way.
    Right,
}

/// Half a place of a ring of 16, in binary turns: what lies this far from a bearing still looks
/// along it.
const HALF_PLACE: u16 = 2_048;

/// Binary turns between two bearings, at most half a turn.
const fn apart(a: Bearing, b: Bearing) -> u16 {
    a.minus(b).as_signed_turns().unsigned_abs()
}

/// Cosine of at most 79°, to three digits; a unit vector's would be a millimeter off.
fn cosine(turns: u16) -> f32 {
    let radians = f32::from(turns) * (core::f32::consts::PI / 32_768.0);
    let square = radians * radians;
    1.0 - square / 2.0 + square * square / 24.0 - square * square * square / 720.0
}

impl<const SENSORS: usize> Goal<SENSORS> {
    /// A goal in the frame of travel from what is asked at each bearing, to be mirrored for the
    /// left.
    fn along_the_way(side: Side, ask: impl Fn(Bearing) -> Component) -> Self {
        let components = core::array::from_fn(|place| {
            let bearing = Bearing::of_place(place, SENSORS);
            ask(match side {
                Side::Right => bearing,
                Side::Left => Bearing::ZERO.minus(bearing),
            })
        });
        Self {
            frame: GoalFrame::Travel,
            ..Self::of(components)
        }
    }

    /// A wall at `range` from the ring on one side, along which the robot goes on.
    ///
    /// Straight to the side the value is that of the range; beside it nothing may be nearer than a
    /// straight wall would be, behind less than in front, so that the robot turns around corners;
    /// ahead there is room to turn.
    #[must_use]
    pub fn wall(side: Side, range: Range, config: &Config<SENSORS>) -> Self {
        const RIGHT: Bearing = Bearing::from_turns(49_152);
        let face = u32::from(config.robot.face_radius_mm);
        // How far a straight wall is along a lobe whose axis lies so far beside the normal.
        let slanted = |off: u16| {
            let edge = off.saturating_sub(config.robot.half_cone.as_turns());
            let stretch_q10 = F32Ext::round(1_024.0 / cosine(edge)) as u32;
            let from_center = ((u32::from(range.as_mm()) + face) * stretch_q10) >> 10;
            u16::try_from(from_center.saturating_sub(face)).unwrap_or(u16::MAX)
        };
        let value = |mm: u16| config.encoding.value(Some(Range::from_mm(mm)));
        let at_most = |mm: u16, weight: u8| Component {
            weight,
            ..Component::at_most(value(mm))
        };
        let further = |mm: u16| range.as_mm().saturating_add(mm);
        let ask = |bearing: Bearing| {
            let off = apart(bearing, RIGHT);
            let behind = bearing.minus(RIGHT).as_signed_turns() < 0;
            match (off.saturating_add(HALF_PLACE) >> 12, behind) {
                (0, _) => Component {
                    weight: 15,
                    ..Component::equal(value(range.as_mm()))
                },
                (1, true) => at_most(slanted(off), 17),
                (1, false) => at_most(slanted(off), 2),
                (2, false) => at_most(slanted(off), 6),
                (3, false) => at_most(further(500).min(slanted(off)), 2),
                _ if apart(bearing, Bearing::ZERO) < 3 * HALF_PLACE * 2 => at_most(further(500), 2),
                _ if apart(bearing, Bearing::from_turns(16_384)) <= 3 * HALF_PLACE => {
                    at_most(further(300), 2)
                }
                _ => Component::ANY,
            }
        };
        Self {
            progress_q16: 2_800,
            heading_hold_q16: 350,
            ..Self::along_the_way(side, ask)
        }
    }

    /// Obstacle avoidance in which what stands in the way is left on the robot's left
    /// (`Side::Right`: it passes by the right) or on its right. On the side to pass by nothing is
    /// to be within `room`, ahead nothing within two thirds of it, elsewhere nothing within the
    /// clearance and a bit: turning away to the wrong side would cost more.
    #[must_use]
    pub fn passing(side: Side, room: Range, config: &Config<SENSORS>) -> Self {
        let at_most = |mm: u16, weight: u8| Component {
            weight,
            ..Component::at_most(config.encoding.value(Some(Range::from_mm(mm))))
        };
        let ahead = room.as_mm() / 3 * 2;
        let elsewhere = config.clearance_mm.saturating_add(200);
        let ask = |bearing: Bearing| match bearing.as_signed_turns() {
            // From 135° to 22.5° on the side to pass by; from there to 67.5° on the other.
            -26_000..=-2_049 => at_most(room.as_mm(), 1),
            -2_048..=14_000 => at_most(ahead, 1),
            _ => at_most(elsewhere, 4),
        };
        Self {
            progress_q16: 650,
            heading_hold_q16: 130,
            ..Self::along_the_way(side, ask)
        }
    }

    /// Something at `range` ahead, nothing nearer beside it, and room around: a thing that stands
    /// free. Strongly on course, for such a thing does not jump from one side to another.
    #[must_use]
    pub fn following(range: Range, config: &Config<SENSORS>) -> Self {
        let value = |mm: u16| config.encoding.value(Some(Range::from_mm(mm)));
        let ask = |bearing: Bearing| match apart(bearing, Bearing::ZERO) {
            0..HALF_PLACE => Component {
                weight: 15,
                ..Component::equal(value(range.as_mm()))
            },
            HALF_PLACE..6_144 => Component {
                weight: 3,
                ..Component::at_most(value(range.as_mm()))
            },
            6_144..=18_432 => Component {
                weight: 3,
                ..Component::at_most(value(range.as_mm().saturating_add(550)))
            },
            _ => Component::at_most(value(670)),
        };
        Self {
            heading_hold_q16: 8_700,
            tolerance: Weight::from_bits(400),
            ..Self::along_the_way(Side::Right, ask)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixed::Mask;
    use crate::goal::GoalFrame;

    fn config() -> Config<16> {
        Config::recommended()
    }

    /// What an exact ring of cones perceives beside an endless wall on its right, heading along it.
    fn beside_a_wall(config: &Config<16>, half_cone_deg: f64, range_mm: f64) -> [Weight; 16] {
        let face = f64::from(config.robot.face_radius_mm);
        core::array::from_fn(|place| {
            let off = (place as f64 - 12.0).abs() * 22.5 - half_cone_deg;
            let mm = (range_mm + face) / libm::cos(off.max(0.0).to_radians()) - face;
            let heard = (off < 89.0 && mm < 6_000.0).then(|| Range::from_mm(mm as u16));
            config.encoding.value(heard)
        })
    }

    #[test]
    fn a_wall_at_the_asked_distance_is_the_goal() {
        for (half_cone, half_cone_deg) in [(2_276, 12.5), (4_551, 25.0)] {
            let mut config = config();
            config.robot.half_cone = Bearing::from_turns(half_cone);
            let goal = Goal::wall(Side::Right, Range::from_mm(600), &config);
            let deviation = |mm: f64, places: usize| {
                let seen = beside_a_wall(&config, half_cone_deg, mm);
                goal.cost(places, Mask::ALL, &seen, i64::MAX)
            };
            let here = deviation(600.0, 0);
            assert!(here < 2_000, "{here}");
            for (mm, places) in [(500.0, 0), (700.0, 0), (600.0, 2), (600.0, 14), (600.0, 8)] {
                let elsewhere = deviation(mm, places);
                assert!(elsewhere > 10 * here.max(1_000), "{mm} {places}");
            }
        }
    }

    /// What is asked of each place of the ring: (at least, at most) in millimeters, weight.
    fn asks(goal: &Goal<16>, table: [(Option<u16>, Option<u16>, u8); 16]) {
        let value = |mm: u16| config().encoding.value(Some(Range::from_mm(mm)));
        for (place, (farthest, nearest, weight)) in table.into_iter().enumerate() {
            let wanted = Component {
                low: farthest.map_or(Weight::ZERO, value),
                high: nearest.map_or(Weight::ONE, value),
                weight,
            };
            assert_eq!(goal.components[place], wanted, "{place}");
        }
    }

    /// No nearer than this, so strongly.
    const fn room(mm: u16, weight: u8) -> (Option<u16>, Option<u16>, u8) {
        (None, Some(mm), weight)
    }

    const ANY: (Option<u16>, Option<u16>, u8) = (None, None, 0);

    #[test]
    fn a_wall_is_asked_for_as_in_this_table() {
        let goal = Goal::wall(Side::Right, Range::from_mm(600), &config());
        let (ahead, left) = (room(1_100, 2), room(900, 2));
        // From ahead counter-clockwise; the wall stands at place 12, seen slanted beside it.
        #[rustfmt::skip]
        asks(&goal, [
            ahead, ahead, ahead, left, left, left, ANY, ANY, ANY, ANY, ANY,
            room(612, 17), (Some(600), Some(600), 15), room(612, 2), room(754, 6), ahead,
        ]);
        assert_eq!((goal.progress_q16, goal.heading_hold_q16), (2_800, 350));
        assert_eq!(
            (goal.frame, goal.cap, goal.tolerance),
            (GoalFrame::Travel, Weight::ONE, Weight::ZERO)
        );
    }

    #[test]
    fn passing_and_following_ask_as_in_these_tables() {
        let passing = Goal::passing(Side::Right, Range::from_mm(1_500), &config());
        let (side, ahead, else_) = (room(1_500, 1), room(1_000, 1), room(800, 4));
        #[rustfmt::skip]
        asks(&passing, [
            ahead, ahead, ahead, ahead, else_, else_, else_, else_, else_, else_,
            side, side, side, side, side, side,
        ]);
        assert_eq!((passing.progress_q16, passing.heading_hold_q16), (650, 130));
        let following = Goal::following(Range::from_mm(700), &config());
        let (beside, around, behind) = (room(700, 3), room(1_250, 3), room(670, 1));
        #[rustfmt::skip]
        asks(&following, [
            (Some(700), Some(700), 15), beside, around, around, around, behind, behind, behind, behind,
            behind, behind, behind, around, around, around, beside,
        ]);
        assert_eq!(
            (following.heading_hold_q16, following.tolerance),
            (8_700, Weight::from_bits(400))
        );
    }

    #[test]
    fn left_is_right_in_the_mirror() {
        let of = |side| Goal::wall(side, Range::from_mm(600), &config()).components;
        let (left, right) = (of(Side::Left), of(Side::Right));
        for place in 0..16 {
            assert_eq!(left[place], right[(16 - place) % 16], "{place}");
        }
        assert_eq!((right[12].weight, left[4].weight), (15, 15));
    }

    #[test]
    fn the_side_to_pass_by_is_kept_clear_farther() {
        let goal = Goal::passing(Side::Right, Range::from_mm(1_500), &config());
        let bit = |place: usize| goal.components[place].high;
        assert!(bit(15) < bit(1) && bit(12) < bit(4) && bit(0) == bit(3));
    }

    /// What is followed is right ahead at the asked distance, and nowhere else.
    #[test]
    fn what_is_followed_is_kept_ahead() {
        let range = Range::from_mm(700);
        let goal = Goal::following(range, &config());
        let value = |mm: u16| config().encoding.value(Some(Range::from_mm(mm)));
        let deviation = |place: usize, mm: u16| {
            let mut values = [Weight::ZERO; 16];
            values[place] = value(mm);
            goal.cost(0, Mask::ALL, &values, i64::MAX)
        };
        assert_eq!(deviation(0, 700), 0);
        for (place, mm) in [
            (0, 500),
            (0, 1_500),
            (1, 500),
            (15, 500),
            (4, 700),
            (12, 700),
        ] {
            assert!(deviation(place, mm) > 0, "{place} {mm}");
        }
        // The ring's mirror: left is as right.
        for place in 1..16 {
            assert_eq!(deviation(place, 400), deviation(16 - place, 400));
        }
        assert_eq!((goal.frame, goal.progress_q16), (GoalFrame::Travel, 0));
    }
}
