//! Serialization: (grid, components of a code vector, all components in units of 2⁻²⁹).
//!
//! `Som` and `DynSom` have the same format; each can read the other's if the sizes match.

use crate::fixed::Weight32;
use crate::grid::Grid;
use crate::som::Som;
use core::fmt;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{Serialize, Serializer};

/// Components as a sequence of their bits.
struct Components<'a>(&'a [Weight32]);

impl Serialize for Components<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().map(|component| component.to_bits()))
    }
}

impl<const NEURONS: usize, const DIMS: usize> Serialize for Som<NEURONS, DIMS> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let code = Components(self.code().as_flattened());
        (self.grid(), DIMS as u32, code).serialize(serializer)
    }
}

impl<'de, const NEURONS: usize, const DIMS: usize> Deserialize<'de> for Som<NEURONS, DIMS> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (grid, dims, Code(mut map)) =
            <(Grid, u32, Code<NEURONS, DIMS>)>::deserialize(deserializer)?;
        if dims as usize != DIMS {
            return Err(Error::custom("code vectors of another length"));
        }
        map.set_grid(grid);
        Ok(map)
    }
}

/// Code vectors without their grid.
struct Code<const NEURONS: usize, const DIMS: usize>(Som<NEURONS, DIMS>);

impl<'de, const NEURONS: usize, const DIMS: usize> Deserialize<'de> for Code<NEURONS, DIMS> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(CodeVisitor::<NEURONS, DIMS>)
    }
}

struct CodeVisitor<const NEURONS: usize, const DIMS: usize>;

impl<'de, const NEURONS: usize, const DIMS: usize> Visitor<'de> for CodeVisitor<NEURONS, DIMS> {
    type Value = Code<NEURONS, DIMS>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{NEURONS} code vectors of {DIMS} components")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut components: A) -> Result<Self::Value, A::Error> {
        let mut map = Som::zeroed(Grid::rectangle(1, 1));
        let mut count = 0;
        while let Some(bits) = components.next_element()? {
            map.set_component(count, Weight32::from_bits(bits));
            count += 1;
        }
        if count == NEURONS * DIMS {
            Ok(Code(map))
        } else {
            Err(Error::invalid_length(count, &self))
        }
    }
}

#[cfg(feature = "alloc")]
impl Serialize for crate::DynSom {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let code = Components(self.codebook().code);
        (self.grid(), self.dims() as u32, code).serialize(serializer)
    }
}

#[cfg(feature = "alloc")]
impl<'de> Deserialize<'de> for crate::DynSom {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (grid, dims, bits) = <(Grid, u32, alloc::vec::Vec<i32>)>::deserialize(deserializer)?;
        let dims = dims as usize;
        if bits.len() != grid.len().saturating_mul(dims) {
            return Err(Error::invalid_length(
                bits.len(),
                &"neurons times components",
            ));
        }
        let code = bits.into_iter().map(Weight32::from_bits).collect();
        Self::new(grid, dims, code).map_err(Error::custom)
    }
}
