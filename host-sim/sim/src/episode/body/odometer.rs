//! Dead reckoning as the base reports it: whole millimeters and 1/65536 of a turn.
//!
//! What rounding leaves over goes into the next report. It never reads the world.

use super::units::{angle, bearing, meters, millimeters};
use amp::units::{Bearing, Displacement};
use arena::world::{Point, Pose};

/// What the base has reported so far.
#[derive(Debug)]
pub(super) struct Odometer {
    /// Sum of all reported displacements, m.
    position: Point,
    /// Odometry at the last report of no displacement: the same odometry gives none again.
    unmoved_at: Option<Point>,
    heading: f64,
    /// The heading, rounded.
    bearing: Bearing,
    /// Sum of all reported turns, from the start's heading.
    reported: Bearing,
    /// Sum of all turns that it did not measure, rad.
    drift_rad: f64,
    /// Unit vector along the bearing.
    axis: Point,
}

impl Odometer {
    /// Starts at a pose with nothing reported.
    pub(super) fn new(start: Pose) -> Self {
        let bearing = bearing(start.heading);
        Self {
            position: start.position,
            unmoved_at: None,
            heading: start.heading,
            bearing,
            reported: bearing,
            drift_rad: 0.0,
            axis: Point::unit(angle(bearing)),
        }
    }

    /// Displacement since the last report, in the ring's frame at that report.
    pub(super) fn moved(&mut self, odometry: Point) -> Displacement {
        if self.unmoved_at == Some(odometry) {
            return Displacement::ZERO;
        }
        let Point { x: cos, y: sin } = self.axis;
        let way = odometry - self.position;
        let (x, y) = (way.x * cos + way.y * sin, way.y * cos - way.x * sin);
        let moved = Displacement {
            dx_mm: millimeters(x),
            dy_mm: millimeters(y),
        };
        let [x, y] = meters(moved);
        self.position = self.position + Point::new(x * cos - y * sin, x * sin + y * cos);
        self.unmoved_at = (moved == Displacement::ZERO).then_some(odometry);
        moved
    }

    /// The ring has turned by this angle, rad, without its being measured.
    pub(super) fn drifted(&mut self, angle: f64) {
        self.drift_rad += angle;
    }

    /// Turn of the ring since the last report.
    pub(super) fn turned(&mut self, heading: f64) -> Bearing {
        let before = self.reported;
        if heading.to_bits() != self.heading.to_bits() {
            self.heading = heading;
            self.set_bearing(bearing(heading));
            self.reported = bearing(heading - self.drift_rad);
        }
        self.reported.minus(before)
    }

    fn set_bearing(&mut self, bearing: Bearing) {
        if bearing != self.bearing {
            self.bearing = bearing;
            self.axis = Point::unit(angle(bearing));
            self.unmoved_at = None;
        }
    }
}
