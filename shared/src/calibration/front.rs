//! Where the body's front is, and how far the base goes, from straight moves.

use super::fit::Fits;
use super::slopes::Slopes;
use crate::units::Bearing;
use micromath::F32Ext;

/// Rounds of reweighted least squares.
const FITS: u8 = 10;
/// A slope that is off by this counts half.
const USUAL_OFF: f32 = 0.1;
/// Below this the slopes do not tell both the cosine and the sine.
const LEAST_DETERMINANT: f32 = 0.1;

/// By how much all bearings are to be turned so that the body's front is at 0, as a vector whose
/// length is the true length of what the base takes for 1.
///
/// Along a straight move a range's slope is −cos b: least squares for the cosine and sine of the
/// turn, where what fits badly counts less from round to round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Front {
    x: f32,
    y: f32,
    rounds: u8,
}

impl Front {
    /// Before the first round.
    pub(super) const UNKNOWN: Self = Self {
        x: 0.0,
        y: 0.0,
        rounds: 0,
    };
    /// Where too little is known.
    const AS_IS: Self = Self {
        x: 1.0,
        y: 0.0,
        rounds: FITS,
    };

    /// Whether no round is left.
    pub(super) const fn is_found(&self) -> bool {
        self.rounds >= FITS
    }

    /// The turn.
    pub(super) fn turn(&self) -> Bearing {
        let turns = F32Ext::atan2(self.y, self.x) * (32_768.0 / core::f32::consts::PI);
        Bearing::from_turns(F32Ext::round(turns) as i32 as u16)
    }

    /// True length of what the base takes for 4 096.
    pub(super) fn length_q12(&self) -> u16 {
        let square = (self.x * self.x + self.y * self.y).clamp(0.25 * 0.25, 4.0 * 4.0);
        crate::fixed::isqrt_u32((square * (1 << 24) as f32) as u32) as u16
    }

    /// The next round.
    pub(super) fn improve<const BEAMS: usize>(
        &mut self,
        slopes: &Slopes<BEAMS>,
        fits: &Fits<BEAMS>,
        bearings: &[Option<Bearing>; BEAMS],
    ) {
        let (mut xx, mut xy, mut yy, mut xr, mut yr) =
            (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
        for (sensor, bearing) in bearings.iter().enumerate() {
            let Some(bearing) = bearing else {
                continue;
            };
            let direction = bearing.direction();
            let (u, v) = (
                f32::from(direction.x_q14) / -16_384.0,
                f32::from(direction.y_q14) / 16_384.0,
            );
            let expected = u * self.x + v * self.y;
            let factor = fits.factor(sensor);
            for (slope, weight) in slopes.of(sensor) {
                let slope = slope / factor;
                let off = if self.rounds == 0 {
                    0.0
                } else {
                    (slope - expected) / USUAL_OFF
                };
                let weight = weight / (1.0 + off * off);
                xx += weight * u * u;
                xy += weight * u * v;
                yy += weight * v * v;
                xr += weight * u * slope;
                yr += weight * v * slope;
            }
        }
        let determinant = xx * yy - xy * xy;
        *self = if F32Ext::abs(determinant) < LEAST_DETERMINANT {
            Self::AS_IS
        } else {
            Self {
                x: (xr * yy - yr * xy) / determinant,
                y: (yr * xx - xr * xy) / determinant,
                rounds: self.rounds.saturating_add(1),
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::Reading;

    /// Two sensors at 45° to either side, of which one reads 1.15 times as far as it should and the
    /// other 1/1.15 times. As they read, the front would be 8° off.
    #[test]
    fn the_front_is_where_equal_sensors_would_show_it() {
        let mut fits = Fits::<2>::NEW;
        let [left, right] = [(0, 143), (1, -143)].map(|(sensor, excess)| Reading {
            sensor,
            turned: 30 * i16::from(sensor),
            value: 1_000 + excess,
        });
        for _ in 0..1_000 {
            fits.compare(&left, &right, false);
        }
        let mut slopes = Slopes::<2>::NEW;
        slopes.note(0, 500, -406);
        slopes.note(1, 500, -307);
        let bearings = [Bearing::of_place(1, 8), Bearing::of_place(7, 8)].map(Some);
        let front = |fits| {
            let mut front = Front::UNKNOWN;
            while !front.is_found() {
                front.improve(&slopes, fits, &bearings);
            }
            f64::from(front.turn().as_signed_turns()) * 360.0 / 65_536.0
        };
        let (equal, unequal) = (front(&fits), front(&Fits::NEW));
        assert!(equal.abs() < 1.0, "{equal}");
        assert!(unequal.abs() > 6.0, "{unequal}");
    }
}
