//! Runs jobs on all cores and delivers their results in the order of the jobs.

use rayon::ThreadPool;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, mpsc};

/// Largest number of jobs started before the oldest one ends: bounds the waiting results.
const AHEAD: u64 = 1_024;

/// Runs `work` on each job in `pool`; `sink` receives the results in the order of the jobs.
///
/// # Errors
/// The first error of `sink`. Running jobs are then discarded and no new job starts.
pub fn in_order<J: Send, R: Send, E>(
    pool: &ThreadPool,
    jobs: impl Iterator<Item = J> + Send,
    work: impl Fn(J) -> R + Sync,
    mut sink: impl FnMut(R) -> Result<(), E>,
) -> Result<(), E> {
    let gate = Gate::default();
    let paced = (0..)
        .zip(jobs)
        .take_while(|(number, _)| gate.passes(*number));
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        scope.spawn(|| {
            pool.install(|| {
                paced
                    .par_bridge()
                    .for_each_with(sender, |sender, (number, job)| {
                        // After an error the receiver is gone.
                        let _ = sender.send((number, work(job)));
                    });
            });
        });
        let mut early = BTreeMap::new();
        let mut next = 0;
        for (number, result) in receiver {
            early.insert(number, result);
            while let Some(result) = early.remove(&next) {
                if let Err(error) = sink(result) {
                    gate.close();
                    return Err(error);
                }
                next += 1;
                gate.open_to(next);
            }
        }
        Ok(())
    })
}

/// Delays jobs that are too far ahead of the received results.
#[derive(Default)]
struct Gate {
    state: Mutex<GateState>,
    changed: Condvar,
}

#[derive(Default)]
struct GateState {
    /// Number of received results.
    taken: u64,
    /// No further job may start.
    closed: bool,
}

impl Gate {
    fn lock(&self) -> MutexGuard<'_, GateState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until job `number` may start; false if it is canceled.
    fn passes(&self, number: u64) -> bool {
        let mut state = self.lock();
        while !state.closed && number >= state.taken + AHEAD {
            state = self
                .changed
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
        !state.closed
    }

    fn open_to(&self, taken: u64) {
        self.lock().taken = taken;
        self.changed.notify_all();
    }

    fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};
    use std::time::Duration;

    fn pool(threads: usize) -> ThreadPool {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool")
    }

    #[test]
    fn results_come_in_order_however_long_each_takes() {
        for threads in [1, 2, 5] {
            let mut seen = Vec::new();
            let slow = |job: u64| {
                std::thread::sleep(Duration::from_micros(job * 7_919 % 500));
                job
            };
            let done: Result<(), ()> = in_order(&pool(threads), 0..300, slow, |job| {
                seen.push(job);
                Ok(())
            });
            assert_eq!(done, Ok(()));
            assert_eq!(seen, (0..300).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_first_job_holds_back_those_far_ahead() {
        let begun = AtomicU64::new(0);
        let work = |job: u64| {
            begun.fetch_add(1, Ordering::Relaxed);
            if job == 0 {
                std::thread::sleep(Duration::from_millis(150));
                assert!(begun.load(Ordering::Relaxed) <= AHEAD);
            }
        };
        let done: Result<(), ()> = in_order(&pool(3), 0..5_000, work, |()| Ok(()));
        assert_eq!((done, begun.into_inner()), (Ok(()), 5_000));
    }

    #[test]
    fn after_an_error_nothing_new_is_begun() {
        let done = in_order(
            &pool(3),
            0_u64..,
            |job| job,
            |job| {
                if job < 10 { Ok(()) } else { Err(job) }
            },
        );
        assert_eq!(done, Err(10));
    }
}
