//! The straight path of a motion: how far the robot may follow it before an arc comes within the
//! margin.

use super::ShieldConfig;
use super::arc::{Arc, ArcView, BEFORE, LobeShape, nearest_mm};
use crate::config::Config;
use crate::disc::{direction_of, until_contact};
use crate::fixed::Mask;
use crate::units::{Direction, Displacement, Millis, Range};

/// The straight path of a motion.
pub(super) struct StraightPath<'a> {
    pub(super) limits: &'a ShieldConfig,
    /// In the shield's frame.
    pub(super) direction: Direction,
    /// In the ring's.
    in_ring: Direction,
    lobe: &'a LobeShape,
    /// Body and margin.
    reach_mm: i32,
    pub(super) now: Millis,
}

impl<'a> StraightPath<'a> {
    pub(super) fn new<const SENSORS: usize>(
        config: &Config<SENSORS>,
        limits: &'a ShieldConfig,
        lobe: &'a LobeShape,
        wanted: Displacement,
        length: i32,
        now: Millis,
    ) -> Self {
        let direction = direction_of(wanted, length);
        Self {
            limits,
            direction,
            in_ring: direction,
            lobe,
            reach_mm: i32::from(config.robot.body_radius_mm) + i32::from(limits.margin_mm),
            now,
        }
    }

    /// Whether the path leads through the sector of a disabled transducer, where a post stays
    /// unheard. The sector reaches to 30° from its axis, beyond those of the neighbors in a ring of
    /// 16: the robot is wider than the gap.
    pub(super) fn is_blind<const SENSORS: usize>(
        &self,
        config: &Config<SENSORS>,
        enabled: Mask,
    ) -> bool {
        const COS_30_Q14: i32 = 14_189;
        let mut ring = config.robot.directions.iter().enumerate();
        ring.any(|(sensor, axis)| {
            let (x, y) = (i32::from(axis.x_q14), i32::from(axis.y_q14));
            !enabled.contains(sensor) && self.in_ring.along(x, y) > COS_30_Q14
        })
    }

    /// Whether the transducer looks where the robot would go.
    pub(super) fn is_covered_by(&self, axis: Direction) -> bool {
        const COS_45_Q14: i32 = 11_585;
        let (x, y) = (i32::from(axis.x_q14), i32::from(axis.y_q14));
        self.in_ring.along(x, y) > COS_45_Q14
    }

    /// Distance until the body would come within the margin of any of these arcs; `limit` where it
    /// would not before that.
    pub(super) fn until_any<'b>(&self, arcs: impl Iterator<Item = &'b Arc>, limit: i32) -> i32 {
        let far_mm = limit.saturating_add(self.reach_mm);
        arcs.fold(limit, |limit, arc| self.until(arc, far_mm, limit))
    }

    /// The same for one arc. Nothing farther from the robot than `far_mm` is in the way.
    // Worth 1 100 instructions of a decision on the chip.
    #[inline(always)]
    fn until(&self, arc: &Arc, far_mm: i32, limit: i32) -> i32 {
        let Some(range) = arc.range else { return limit };
        let (x, y) = arc.face_mm();
        let range_mm = self.range_now(range, arc.at);
        // As short as the shortest range it may be anywhere between there and the face.
        let least_mm = i32::from(self.limits.least_range_mm);
        // A quick test: most arcs are far away.
        if nearest_mm((x, y), range_mm) > far_mm && range_mm > least_mm {
            return limit;
        }
        if self.leaves_behind((x, y), arc.axis) {
            return limit;
        }
        let seen = ArcView::along(self.direction, (x, y), arc.axis, range_mm.max(least_mm));
        let mut distance = limit;
        if range_mm <= least_mm && arc.stands(BEFORE) {
            let before = seen.on_axis(self.limits.before_mm());
            distance = self.until_point(before, distance);
        }
        let bounds = seen.bounds(self.lobe);
        if bounds.along.1 <= 0
            || bounds.aside >= self.reach_mm
            || bounds.along.0.wrapping_sub(distance) >= self.reach_mm
        {
            return distance;
        }
        for (_, at) in seen
            .points(self.lobe)
            .filter(|(point, _)| arc.stands(*point))
        {
            distance = self.until_point(at, distance);
        }
        distance
    }

    /// Whether a face and every point that may be heard from it along this axis lie behind.
    fn leaves_behind(&self, (x, y): (i32, i32), axis: Direction) -> bool {
        let (_, sin) = self.lobe.edge_q14();
        let (axis_x, axis_y) = (i32::from(axis.x_q14), i32::from(axis.y_q14));
        self.direction.along(axis_x, axis_y) <= -sin && self.direction.along(x, y) <= 0
    }

    /// A range less what something may have come nearer since.
    fn range_now(&self, range: Range, at: Millis) -> i32 {
        let approach = u32::from(self.limits.approach_mm_s);
        if approach == 0 {
            return range.as_mm().into();
        }
        let nearer = self.now.since(at).saturating_mul(approach) / 1_000;
        i32::from(
            range
                .as_mm()
                .saturating_sub(nearer.min(u16::MAX.into()) as u16),
        )
    }

    /// Distance until the body would come within the margin of a point along the way and aside of
    /// it.
    pub(super) fn until_point(&self, point: (i32, i32), limit: i32) -> i32 {
        until_contact(point, self.reach_mm, limit)
    }
}
