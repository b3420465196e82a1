//! A base whose commands and odometry do not mean what they say.

use super::units::meters;
use crate::robot::Miswiring;
use amp::units::{Bearing, Displacement};
use arena::world::{Point, wrap_angle};

/// Turns, mirrors and scales what the base is told and what it tells.
#[derive(Debug, Default)]
pub(super) struct WrongBase {
    /// `None` = it does what it is told.
    miswiring: Option<Miswiring>,
    /// What rounding left over of the reports: mm, mm, 1/65 536 turn.
    rest: [f64; 3],
}

impl WrongBase {
    pub(super) fn new(miswiring: Option<Miswiring>) -> Self {
        Self {
            miswiring,
            rest: [0.0; 3],
        }
    }

    /// Where the base goes when it is told to go by a displacement, m ahead and to the left.
    pub(super) fn executed(&self, told: Displacement) -> [f64; 2] {
        let [x, y] = meters(told);
        let Some(wrong) = self.miswiring else {
            return [x, y];
        };
        let told = Point::new(x, y);
        let turn = wrap_angle(told.angle() - wrong.front_rad);
        let way = Point::unit(turn * wrong.turn * wrong.side()) * (told.length() * wrong.length);
        [way.x, way.y]
    }

    /// What the base tells when it has moved and turned.
    pub(super) fn reported(
        &mut self,
        moved: Displacement,
        turned: Bearing,
    ) -> (Displacement, Bearing) {
        let Some(wrong) = self.miswiring else {
            return (moved, turned);
        };
        let (x, y) = (f64::from(moved.dx_mm), f64::from(moved.dy_mm));
        let way = Point::new(x, y * wrong.side()).turned(Point::unit(wrong.front_rad));
        let turns = f64::from(turned.as_signed_turns()) * wrong.side() / wrong.turn;
        let [x, y, turns] = [way.x / wrong.length, way.y / wrong.length, turns];
        let [rest_x, rest_y, rest_turns] = &mut self.rest;
        let moved = Displacement::saturating(whole(x, rest_x), whole(y, rest_y));
        (moved, Bearing::from_turns(whole(turns, rest_turns) as u16))
    }
}

/// The nearest whole number; the rest stays for the next one.
fn whole(value: f64, rest: &mut f64) -> i32 {
    let sum = value + *rest;
    let whole = libm::rint(sum);
    *rest = sum - whole;
    whole as i32
}
