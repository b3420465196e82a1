//! How deep the stack has been: start-up code fills it with a pattern that use overwrites.

/// The pattern: content of a stack word that was never used.
pub const PAINT: u32 = 0xcccc_cccc;

/// Greatest depth of the stack since the start, bytes. `read_word(i)` reads the i-th word,
/// counted from the lowest address.
///
/// Reads the unused words and one more: some 1500 of an 8 KiB stack that is a quarter full.
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
