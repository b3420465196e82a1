//! Arrays of any length for serde, which knows them up to 32 only: the elements one after another,
//! no length before them. For `#[serde(with = "crate::arrays")]`.

use core::fmt;
use core::marker::PhantomData;
use heapless::Vec;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{Serialize, SerializeTuple, Serializer};

pub(crate) fn serialize<S: Serializer, T: Serialize, const N: usize>(
    array: &[T; N],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut elements = serializer.serialize_tuple(N)?;
    for element in array {
        elements.serialize_element(element)?;
    }
    elements.end()
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>, T: Deserialize<'de>, const N: usize>(
    deserializer: D,
) -> Result<[T; N], D::Error> {
    deserializer.deserialize_tuple(N, Elements(PhantomData))
}

struct Elements<T, const N: usize>(PhantomData<T>);

impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for Elements<T, N> {
    type Value = [T; N];

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("as many elements as the array has")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<[T; N], A::Error> {
        let mut array = Vec::<T, N>::new();
        while !array.is_full() {
            let Some(element) = elements.next_element()? else {
                break;
            };
            // There is room: the loop asked.
            let _ = array.push(element);
        }
        let whole = array.into_array::<N>();
        whole.map_err(|array| Error::invalid_length(array.len(), &"as many as the array has"))
    }
}

#[cfg(test)]
mod tests {
    use serde::{Deserialize, Serialize};

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Forty(#[serde(with = "crate::arrays")] [u16; 40]);

    #[test]
    fn the_elements_stand_one_after_another() {
        let array = Forty(core::array::from_fn(|i| i as u16));
        let mut room = [0; 64];
        let bytes = postcard::to_slice(&array, &mut room).unwrap();
        assert!(bytes.iter().copied().eq(0..40));
        assert_eq!(postcard::from_bytes(bytes), Ok(array));
        assert!(postcard::from_bytes::<Forty>(&bytes[..39]).is_err());
    }
}
