//! The faces, circles and corners in the lobe of one transducer.
//!
//! [`LobeView::cast`] casts single rays. [`LobeView::nearest_answer`] casts only those rays of a
//! fan that determine its nearest echo.

use std::sync::Arc;

use super::answer::{Fan, NearestAnswer};
use super::candidates::Candidates;
use super::seen::{LobeHit, SLACK_M, SeenCircle, SeenFace, SonarLobe, Things};
use crate::geometry::Point;
use crate::surfaces::{Circle, Surfaces};

/// A ray that ends at most this much before a corner still reaches it, m.
const CORNER_SLACK_M: f64 = 1e-6;

/// The surfaces in one lobe. It can be aimed repeatedly; a small move in the same direction is
/// fast.
#[derive(Debug, Clone, Default)]
pub(crate) struct LobeView {
    candidates: Candidates,
    lobe: SonarLobe,
    /// From near to far.
    faces: Vec<SeenFace>,
    circles: Vec<SeenCircle>,
    /// Position relative to the tip, and distance, m.
    corners: Vec<(Point, f64)>,
}

impl LobeView {
    /// Collects the surfaces in a lobe that have their front to its tip.
    pub(super) fn aim(&mut self, surfaces: &Arc<Surfaces>, posts: &[Circle], lobe: &SonarLobe) {
        self.candidates.prepare(surfaces, lobe);
        self.lobe = *lobe;
        self.faces.clear();
        for face in &self.candidates.faces {
            if let Some(seen) = lobe.see(face) {
                self.faces.push(seen);
            }
        }
        self.faces
            .sort_unstable_by(|a, b| a.near.total_cmp(&b.near));
        self.circles.clear();
        for circle in self.candidates.circles.iter().chain(posts) {
            self.circles.extend(lobe.see_circle(circle));
        }
    }

    /// The corners in the lobe from `least` to `most` m from its tip, hidden or not: position
    /// relative to the tip, and distance.
    pub fn corners(&mut self, least: f64, most: f64) -> &mut [(Point, f64)] {
        let SonarLobe {
            tip, axis, cone, ..
        } = self.lobe;
        self.corners.clear();
        for &corner in &self.candidates.corners {
            let corner = corner - tip;
            let (along, across) = (axis.dot(corner), axis.cross(corner).abs());
            if along > most + SLACK_M || across * cone.cos > along * cone.sin {
                continue;
            }
            let range = corner.length();
            if range >= least && range <= most {
                self.corners.push((corner, range));
            }
        }
        &mut self.corners
    }

    /// Distance of the nearest visible corner from `least` to `most` m from the tip, m.
    pub fn nearest_corner(&mut self, least: f64, most: f64) -> Option<f64> {
        let axis = self.lobe.axis;
        let corners = self.corners(least, most);
        corners.sort_unstable_by(|a, b| a.1.total_cmp(&b.1));
        let things = self.things();
        let visible = self.corners.iter().find(|&&(corner, range)| {
            let towards = if range > 0.0 {
                corner * (1.0 / range)
            } else {
                axis
            };
            !things.hide(towards, range - CORNER_SLACK_M, f64::NEG_INFINITY)
        });
        visible.map(|(_, range)| *range)
    }

    /// Length of the shortest ray with an echo, m; infinite if there is none.
    ///
    /// The rays are those of a [narrow](Fan::is_narrow) fan as wide as the lobe, and `others`: the
    /// directions of [`LobeView::promising`] in the lobe. A ray has an echo if it first hits a
    /// circle, or a face with a cosine of at least `least_cos`. A face whose normal has a cosine
    /// below `least_facing` to the axis returns no echo.
    #[must_use]
    pub fn nearest_answer(
        &self,
        fan: &Fan,
        others: &[Point],
        least_cos: f64,
        least_facing: f64,
    ) -> f64 {
        let mut search = NearestAnswer {
            things: self.things(),
            fan,
            axis: self.lobe.axis,
            others,
            least_cos,
            least_facing,
            best: f64::INFINITY,
        };
        search.run();
        search.best
    }

    /// The aimed lobe.
    #[must_use]
    pub fn lobe(&self) -> &SonarLobe {
        &self.lobe
    }

    /// The first hit of a ray along the unit vector `ray`, which must be inside the lobe.
    #[must_use]
    pub fn cast(&self, ray: Point) -> Option<LobeHit> {
        self.things().cast(ray)
    }

    fn things(&self) -> Things<'_> {
        Things {
            faces: &self.faces,
            circles: &self.circles,
        }
    }

    /// Unit vectors from the tip towards likely reflectors: the foot of the perpendicular on each
    /// face that contains it, and the center of each circle. They may be outside the lobe.
    pub fn promising(&self) -> impl Iterator<Item = Point> + '_ {
        let feet = self.faces.iter();
        let feet = feet.filter(|face| face.has_foot());
        let feet = feet.map(|face| Point::new(face.u.y, -face.u.x));
        let middles = self.circles.iter().map(|circle| {
            let length = circle.center.length();
            circle.center * (1.0 / length)
        });
        feet.chain(middles)
    }
}
