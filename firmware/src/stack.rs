//! How deep the stack has been: it is painted before the program starts, and what is used loses its paint.

/// What the words of the stack hold until they are used.
pub const PAINT: u32 = 0xcccc_cccc;

/// The deepest the stack has been, in bytes. `word(i)` is the i-th word from the stack's far end (its lowest address).
///
/// Reads only what was never used, one word beyond, and stops: some 1500 words of an 8 KiB stack that is a quarter full.
#[must_use]
pub fn peak_bytes(words: usize, read_word: impl Fn(usize) -> u32) -> usize {
    let unused = (0..words)
        .take_while(|&index| read_word(index) == PAINT)
        .count();
    (words - unused) * size_of::<u32>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_counts_overwritten_words() {
        let stack = [PAINT, PAINT, 7, PAINT, 0];
        assert_eq!(peak_bytes(stack.len(), |index| stack[index]), 12);
    }

    #[test]
    fn an_unused_and_a_full_stack() {
        assert_eq!(peak_bytes(4, |_| PAINT), 0);
        assert_eq!(peak_bytes(4, |_| 0), 16);
        assert_eq!(peak_bytes(0, |_| 0), 0);
    }
}
