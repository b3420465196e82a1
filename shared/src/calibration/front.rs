//! Where the body's front is, and how far the base goes, from straight moves.

use super::Slope;
use crate::units::Bearing;
use micromath::F32Ext;

/// Rounds of reweighted least squares.
const FITS: u8 = 10;

/// By how much all bearings are to be turned so that the body's front is at 0, as a vector whose
/// length is the true length of what the base takes for 1.
///
/// Along a straight move of l a range changes by −l cos b: least squares for the cosine and sine of
/// the turn, where what fits badly counts less from round to round.
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
    pub(super) fn improve(&mut self, slopes: &[Slope], bearings: &[Option<Bearing>]) {
        let (mut xx, mut xy, mut yy, mut xr, mut yr) =
            (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
        for slope in slopes {
            let Some(bearing) = bearings.get(usize::from(slope.sensor)).copied().flatten() else {
                continue;
            };
            let direction = bearing.direction();
            let ahead = f32::from(slope.ahead_4mm) * 4e-3;
            let unit = ahead / 16_384.0;
            let (u, v) = (
                -unit * f32::from(direction.x_q14),
                unit * f32::from(direction.y_q14),
            );
            let change = f32::from(slope.change_mm) / 1e3;
            let weight = if self.rounds == 0 {
                1.0
            } else {
                let off = (change - (u * self.x + v * self.y)) / ahead / 0.1;
                1.0 / (1.0 + off * off)
            };
            xx += weight * u * u;
            xy += weight * u * v;
            yy += weight * v * v;
            xr += weight * u * change;
            yr += weight * v * change;
        }
        let determinant = xx * yy - xy * xy;
        *self = if F32Ext::abs(determinant) < 1e-9 {
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
