//! The sectors of a ring that a bearing belongs to.

use crate::fixed::Mask;
use crate::units::Bearing;

/// A mask with the sectors that a bearing belongs to.
pub(super) fn with_views(mask: Mask, views: [SectorView; 2]) -> Mask {
    let sectors = views.into_iter().filter_map(|view| view.sector);
    sectors.fold(mask, Mask::with)
}

/// A sector that a bearing belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SectorView {
    pub(super) sector: Option<usize>,
    /// The bearing is within a quarter of a sector of the axis.
    pub(super) is_central: bool,
}

/// The sector of a ring whose axis is nearest to a bearing; `None` for a ring without sectors.
pub(crate) fn sector_at<const SECTORS: usize>(bearing: Bearing) -> Option<usize> {
    let [own, _] = sectors_at::<SECTORS>(bearing);
    own.sector
}

/// The sectors that a bearing belongs to: the nearest, and the next if it is within 1/18 of a
/// sector of their border: 12.5° from the axis in a ring of 16.
pub(super) fn sectors_at<const SECTORS: usize>(bearing: Bearing) -> [SectorView; 2] {
    const OVERLAP: u16 = (65_536_u32 / 18) as u16;
    const QUARTER: u16 = 1 << 14;
    let ring = SECTORS as u32;
    // Sectors in units of 1/65 536, from the border before the first one.
    let position = u32::from(bearing.as_turns())
        .wrapping_mul(ring)
        .wrapping_add(1 << 15);
    let within = position as u16;
    let sector = |steps: u32| {
        let index = (position >> 16).wrapping_add(steps).checked_rem(ring);
        index.map(|index| index as usize)
    };
    let other = if within < OVERLAP {
        sector(ring.wrapping_sub(1))
    } else if within >= u16::MAX - OVERLAP {
        sector(1)
    } else {
        None
    };
    let own = SectorView {
        sector: sector(0),
        is_central: (QUARTER..=3 * QUARTER).contains(&within),
    };
    let other = SectorView {
        sector: other,
        is_central: false,
    };
    [own, other]
}

/// Replaces a sector's squared distance by a smaller one.
pub(super) fn keep_least(squares: &mut [Option<u32>], sector: Option<usize>, square: u32) {
    if let Some(least) = sector.and_then(|sector| squares.get_mut(sector))
        && least.is_none_or(|least| square < least)
    {
        *least = Some(square);
    }
}
