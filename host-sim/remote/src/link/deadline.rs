//! Bounds a wait for a message, even if the other end never stops sending.

use std::time::Instant;

/// Reads of 1 KiB that are allowed after the deadline, for data that arrived before it.
const MAX_LATE_READS: u32 = 16;

/// Bounds the reads of one wait. A wait may skip other messages and read again; all reads with the
/// same deadline belong to one wait.
#[derive(Debug, Default)]
pub struct Deadline {
    until: Option<Instant>,
    /// Reads after the deadline.
    late: u32,
}

impl Deadline {
    /// Whether the wait until `until` may read once more: always before `until`, a few times after
    /// it.
    pub fn allows_read(&mut self, until: Instant) -> bool {
        if self.until != Some(until) {
            *self = Self {
                until: Some(until),
                late: 0,
            };
        }
        if Instant::now() >= until {
            self.late = self.late.saturating_add(1);
        }
        self.late <= MAX_LATE_READS
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn before_the_deadline_all_reads_are_allowed_and_after_it_sixteen() {
        let mut deadline = Deadline::default();
        let now = Instant::now();
        let far = now + Duration::from_secs(3_600);
        assert!((0..1_000).all(|_| deadline.allows_read(far)));
        // Already passed.
        let count = |deadline: &mut Deadline, until| {
            let reads = (0..1_000).take_while(|_| deadline.allows_read(until));
            reads.count()
        };
        assert_eq!(count(&mut deadline, now), 16);
        assert_eq!(count(&mut deadline, now), 0);
        // Another wait.
        let earlier = now.checked_sub(Duration::from_nanos(1)).unwrap();
        assert_eq!(count(&mut deadline, earlier), 16);
    }
}
