//! Selects components of a vector.

/// A set of components: bit `i` selects component `i`. Components from 32 on are always selected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mask(u32);

impl Mask {
    /// Selects all components.
    pub const ALL: Self = Self(u32::MAX);

    /// Selects none of the first 32 components.
    pub const NONE: Self = Self(0);

    /// The mask with these raw bits.
    #[must_use]
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// Raw bits.
    #[must_use]
    pub const fn to_bits(self) -> u32 {
        self.0
    }

    /// Whether component `index` is selected.
    #[must_use]
    pub const fn contains(self, index: usize) -> bool {
        index >= 32 || self.0 & (1 << index) != 0
    }

    /// Whether each of the first `dims` components is selected.
    #[must_use]
    pub const fn covers(self, dims: usize) -> bool {
        let low = first_bits(dims);
        self.0 & low == low
    }

    /// The selected ones of the first `count` (at most 32) components, in order.
    pub fn indices(self, count: usize) -> impl Iterator<Item = usize> {
        let mut remaining = self.0 & first_bits(count);
        core::iter::from_fn(move || {
            let first = remaining.trailing_zeros();
            (remaining != 0).then(|| {
                remaining &= remaining.wrapping_sub(1);
                first as usize
            })
        })
    }

    /// This mask without component `index`.
    #[must_use]
    pub const fn without(self, index: usize) -> Self {
        if index < 32 {
            Self(self.0 & !(1 << index))
        } else {
            self
        }
    }

    /// This mask with component `index`.
    #[must_use]
    pub const fn with(self, index: usize) -> Self {
        if index < 32 {
            Self(self.0 | (1 << index))
        } else {
            self
        }
    }

    /// The components that are not selected.
    #[must_use]
    pub const fn complement(self) -> Self {
        Self(!self.0)
    }

    /// The components selected in both masks.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

/// A set of components or neurons, whatever its capacity.
pub trait Selection: Copy + PartialEq {
    /// Selects all.
    const ALL: Self;

    /// Whether `index` is selected.
    #[must_use]
    fn contains(self, index: usize) -> bool;

    /// This set without `index`.
    #[must_use]
    fn without(self, index: usize) -> Self;
}

impl Selection for Mask {
    const ALL: Self = Self::ALL;

    #[inline]
    fn contains(self, index: usize) -> bool {
        Self::contains(self, index)
    }

    #[inline]
    fn without(self, index: usize) -> Self {
        Self::without(self, index)
    }
}

/// As [`Mask`], for up to 64 components: larger ones are always selected. Twice as large, so only
/// for maps that need it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WideMask(u64);

impl Selection for WideMask {
    const ALL: Self = Self(u64::MAX);

    fn contains(self, index: usize) -> bool {
        index >= 64 || self.0 & (1 << index) != 0
    }

    fn without(self, index: usize) -> Self {
        if index < 64 {
            Self(self.0 & !(1 << index))
        } else {
            self
        }
    }
}

const fn first_bits(count: usize) -> u32 {
    if count >= 32 {
        u32::MAX
    } else {
        (1 << count) - 1
    }
}
