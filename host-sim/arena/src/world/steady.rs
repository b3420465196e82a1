//! What may lie in the lobes of an eye that looks the same way again and again, chosen and prepared once for a neighborhood.
//!
//! The transducers of a turret that is held are such eyes. What of the first look at a thing does not depend on where the eye
//! is within the neighborhood is worked out beforehand; what is left are comparisons.

use wide::f32x8;

use super::faces::{LANES, max, min};
use super::geometry::Point;
use super::nearby::lanes;
use super::outline::slack;
use super::view::ConeShape;

/// How an eye looks from some place: from how far off it, m, along its axis, and within which edges, unit vectors.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Aim {
    /// Another one for every aim of an eye.
    pub number: u64,
    pub offset_m: f64,
    pub axis: Point,
    pub left: Point,
    pub right: Point,
    pub cone: ConeShape,
}

impl Aim {
    pub fn new(number: u64, offset_m: f64, axis: Point, cone: ConeShape) -> Self {
        let edge = |sin: f64| axis.turned(Point::new(cone.cos, sin));
        Self {
            number,
            offset_m,
            axis,
            left: edge(cone.sin),
            right: edge(-cone.sin),
            cone,
        }
    }
}

/// Where the eye is: how far left of the edges through the middle, and how far along the axis, m.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Station {
    left: f32,
    right: f32,
    along: f32,
    slack: f32,
}

impl Station {
    /// An eye at `tip` from a middle, among things within `reach` m of it.
    #[inline]
    pub fn new(tip: Point, aim: &Aim, reach: f64) -> Self {
        Self {
            left: aim.left.cross(tip) as f32,
            right: aim.right.cross(tip) as f32,
            along: aim.axis.dot(tip) as f32,
            slack: slack(reach),
        }
    }
}

/// Where [`LANES`] things lie as the eye looks. A place without one is no number and lies nowhere.
#[derive(Debug, Clone, Copy)]
struct Lie {
    /// Distance from the middle to the nearest of them, m.
    from_m: f64,
    /// How far left of the edges through the middle, m: the rightmost point of each by the left edge, the leftmost by the
    /// right one.
    left: [f32; LANES],
    right: [f32; LANES],
    /// How far along the axis the first point of each, m.
    along: [f32; LANES],
    /// Which they are.
    numbers: [u32; LANES],
}

impl Default for Lie {
    fn default() -> Self {
        Self {
            from_m: f64::INFINITY,
            left: [f32::NAN; LANES],
            right: [f32::NAN; LANES],
            along: [f32::NAN; LANES],
            numbers: [0; LANES],
        }
    }
}

impl Lie {
    /// Which may lie in the lobe, no farther than `far` m along its axis: bit i for the one at place i.
    #[inline(always)]
    fn inside(&self, station: &Station, far: f64) -> u32 {
        let Station {
            left,
            right,
            along,
            slack,
        } = *station;
        let inside = f32x8::new(self.left).simd_le(f32x8::splat(left + slack))
            & f32x8::new(self.right).simd_ge(f32x8::splat(right - slack))
            & f32x8::new(self.along).simd_le(f32x8::splat(along + slack + far as f32));
        inside.to_bitmask()
    }
}

/// Things that lie between two points each, from near to far.
#[derive(Debug, Clone, Default)]
pub(super) struct Steady {
    /// Most often no others are asked for: they are found without a detour.
    first: Lie,
    more: Vec<Lie>,
    count: usize,
}

impl Steady {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.first = Lie::default();
        self.more.clear();
        self.count = 0;
    }

    /// Appends thing `number`, `distance` m from the middle, which lies between these points, seen from there.
    pub fn push(&mut self, distance: f64, number: usize, [begin, end]: [Point; 2], aim: &Aim) {
        let lane = self.count % LANES;
        if lane == 0 && self.count > 0 {
            self.more.push(Lie::default());
        }
        let block = self.more.last_mut().unwrap_or(&mut self.first);
        block.from_m = min(block.from_m, distance);
        block.left[lane] = min(aim.left.cross(begin), aim.left.cross(end)) as f32;
        block.right[lane] = max(aim.right.cross(begin), aim.right.cross(end)) as f32;
        block.along[lane] = min(aim.axis.dot(begin), aim.axis.dot(end)) as f32;
        // There are fewer things than 2³² in a world.
        block.numbers[lane] = number as u32;
        self.count += 1;
    }

    /// Shows the things up to `most` m from the middle that may lie in the lobe within `far` m along its axis, and others.
    #[inline]
    pub fn each_in(&self, station: &Station, most: f64, far: f64, mut look: impl FnMut(usize)) {
        let (mut block, mut more) = (&self.first, self.more.iter());
        while block.from_m <= most {
            for lane in lanes(block.inside(station, far)) {
                look(block.numbers[lane] as usize);
            }
            match more.next() {
                Some(next) => block = next,
                None => break,
            }
        }
    }
}
