//! Consistent overhead byte stuffing (S. Cheshire and M. Baker, IEEE/ACM Transactions on Networking 7(2), 1999): bytes
//! without a zero, so that a zero can end a frame.
//!
//! For at most [`MOST`] bytes, the coded form is exactly one byte longer. Cost: one pass over the bytes.

/// Most bytes that can be coded.
pub const MOST: usize = 254;

/// Codes `data` into `coded`; returns the number of bytes, one more than the data's. Nothing for more than [`MOST`] bytes or
/// too little room.
#[must_use]
pub fn encode(data: &[u8], coded: &mut [u8]) -> Option<usize> {
    if data.len() > MOST {
        return None;
    }
    let length = data.len().wrapping_add(1);
    let coded = coded.get_mut(..length)?;
    let (mut code, mut distance) = (0_usize, 1_u8);
    for (index, &byte) in data.iter().enumerate() {
        let place = index.wrapping_add(1);
        if byte == 0 {
            *coded.get_mut(code)? = distance;
            (code, distance) = (place, 1);
        } else {
            *coded.get_mut(place)? = byte;
            distance = distance.wrapping_add(1);
        }
    }
    *coded.get_mut(code)? = distance;
    Some(length)
}

/// Undoes [`encode`]; returns the number of bytes. Nothing for a coded form that nothing has, or too little room.
#[must_use]
pub fn decode(coded: &[u8], data: &mut [u8]) -> Option<usize> {
    let (&first, rest) = coded.split_first()?;
    if rest.len() > MOST || first == 0 {
        return None;
    }
    let data = data.get_mut(..rest.len())?;
    let mut left = first.wrapping_sub(1);
    for (place, &byte) in data.iter_mut().zip(rest) {
        if byte == 0 {
            return None;
        }
        if left == 0 {
            *place = 0;
            left = byte.wrapping_sub(1);
        } else {
            *place = byte;
            left = left.wrapping_sub(1);
        }
    }
    (left == 0).then_some(data.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Examples of the paper's Table I and of the article on the method.
    #[test]
    fn known_examples() {
        for (data, coded) in [
            (&[][..], &[1][..]),
            (&[0], &[1, 1]),
            (&[0, 0], &[1, 1, 1]),
            (&[0x11, 0x22, 0, 0x33], &[3, 0x11, 0x22, 2, 0x33]),
            (&[0x11, 0, 0, 0], &[2, 0x11, 1, 1, 1]),
        ] {
            let mut buffer = [0; 16];
            assert_eq!(encode(data, &mut buffer), Some(coded.len()));
            assert_eq!(&buffer[..coded.len()], coded);
            assert_eq!(decode(coded, &mut buffer), Some(data.len()));
            assert_eq!(&buffer[..data.len()], data);
        }
        let mut buffer = [0; 256];
        assert_eq!(encode(&[1; 255], &mut buffer), None);
        assert_eq!(decode(&[3, 1], &mut buffer), None);
        assert_eq!(decode(&[0, 1], &mut buffer), None);
        assert_eq!(decode(&[], &mut buffer), None);
    }

    proptest! {
        #[test]
        fn what_is_coded_comes_back(data in prop::collection::vec(prop_oneof![Just(0_u8), any::<u8>()], 0..=MOST)) {
            let (mut coded, mut back) = ([0; 255], [0; MOST]);
            let length = encode(&data, &mut coded).unwrap();
            prop_assert!(!coded[..length].contains(&0));
            prop_assert_eq!(decode(&coded[..length], &mut back), Some(data.len()));
            prop_assert_eq!(&back[..data.len()], &data[..]);
        }

        #[test]
        fn any_bytes_decode_or_not(coded in prop::collection::vec(any::<u8>(), 0..300)) {
            let (mut data, mut again) = ([0; MOST], [0; 255]);
            if let Some(length) = decode(&coded, &mut data) {
                prop_assert_eq!(encode(&data[..length], &mut again), Some(coded.len()));
                prop_assert_eq!(&again[..coded.len()], &coded[..]);
            }
        }
    }
}
