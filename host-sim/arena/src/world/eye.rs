//! Eyes that may look the same way again and again.

use std::ops::Range;

use super::geometry::Point;
use super::lobe::Lobe;
use super::neighborhoods::Neighborhoods;
use super::steady::Aim;

/// One of several eyes, of which each may look along the same axis again and again.
#[derive(Debug, Clone, Default)]
pub(super) struct Eye {
    pub aim: Aim,
    /// In which world.
    world: u64,
    /// Of faces that rays of the lobe can meet at right angles.
    pub upright: Vec<Upright>,
}

/// Faces that are met at right angles by rays along a unit vector.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Upright {
    pub inward: Point,
    /// Their places among all directions.
    pub places: Range<usize>,
}

impl Eye {
    /// Looks along a lobe. Returns whether it has before: whoever turns looks once.
    #[inline]
    pub fn looks(&mut self, lobe: &Lobe, around: &Neighborhoods) -> bool {
        let is_steady = self.aim.axis == lobe.axis
            && self.world == around.worlds()
            && self.aim.offset_m == lobe.offset_m
            && self.aim.cone == lobe.cone;
        if !is_steady {
            self.aim_anew(lobe, around);
        }
        is_steady
    }

    #[cold]
    fn aim_anew(&mut self, lobe: &Lobe, around: &Neighborhoods) {
        self.aim = Aim::new(self.aim.number + 1, lobe.offset_m, lobe.axis, lobe.cone);
        self.world = around.worlds();
        self.find_upright(around);
    }

    fn find_upright(&mut self, around: &Neighborhoods) {
        let to = self.aim;
        self.upright.clear();
        if let Some(feet) = around.surfaces().map(|surfaces| &surfaces.feet) {
            for place in feet.between(to.right, to.left) {
                let Some(group) = feet.group(place) else {
                    continue;
                };
                let inward = group.inward;
                if inward.dot(to.axis) < to.cone.cos {
                    continue;
                }
                let last = self.upright.last_mut();
                match last.filter(|last| last.inward == inward && last.places.end == place) {
                    Some(last) => last.places.end += 1,
                    None => self.upright.push(Upright {
                        inward,
                        places: place..place + 1,
                    }),
                }
            }
        }
    }
}
