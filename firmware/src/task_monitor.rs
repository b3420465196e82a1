//! Whether the watchdog may be fed: only when every task has run since the last feeding.
//!
//! So the watchdog resets the chip when any one task hangs, even if the timer interrupt still runs.

use portable_atomic::{AtomicBool, AtomicU32, Ordering};

/// A task that must check in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MonitoredTask {
    /// The serial interrupt.
    Serial,
    /// The millisecond interrupt.
    Clock,
    /// The control task.
    Control,
}

impl MonitoredTask {
    /// Every task.
    pub const ALL: [Self; 3] = [Self::Serial, Self::Clock, Self::Control];

    /// The task's bit.
    const fn bit(self) -> u32 {
        match self {
            Self::Serial => 1,
            Self::Clock => 2,
            Self::Control => 4,
        }
    }
}

/// The bits of [`MonitoredTask::ALL`].
const ALL_TASKS: u32 = 0b111;

/// Whether every task's bit is set.
#[must_use]
const fn has_all(checked_in: u32) -> bool {
    checked_in & ALL_TASKS == ALL_TASKS
}

/// The tasks that have checked in, and the requested timeout of the watchdog.
#[derive(Debug, Default)]
pub struct TaskMonitor {
    checked_in: AtomicU32,
    /// A task is about to block all others for longer than the normal timeout.
    long_timeout_requested: AtomicBool,
    /// The watchdog has the long timeout.
    has_long_timeout: AtomicBool,
}

impl TaskMonitor {
    /// No task has checked in; the timeout is the normal one.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            checked_in: AtomicU32::new(0),
            long_timeout_requested: AtomicBool::new(false),
            has_long_timeout: AtomicBool::new(false),
        }
    }

    /// Notes that a task has run.
    pub fn check_in(&self, task: MonitoredTask) {
        self.checked_in.fetch_or(task.bit(), Ordering::Relaxed);
    }

    /// Requests the long watchdog timeout (flash is erased or written), or the normal one again.
    pub fn request_long_timeout(&self, wanted: bool) {
        self.long_timeout_requested.store(wanted, Ordering::Relaxed);
    }

    /// Whether the watchdog has the long timeout.
    #[must_use]
    pub fn has_long_timeout(&self) -> bool {
        self.has_long_timeout.load(Ordering::Relaxed)
    }

    /// Called by the watchdog's owner: passes a changed request to `set_timeout`.
    pub fn apply_timeout(&self, set_timeout: impl FnOnce(bool)) {
        let wanted = self.long_timeout_requested.load(Ordering::Relaxed);
        if wanted != self.has_long_timeout() {
            set_timeout(wanted);
            self.has_long_timeout.store(wanted, Ordering::Relaxed);
        }
    }

    /// Whether every task has checked in since this last returned true.
    #[must_use]
    pub fn all_checked_in(&self) -> bool {
        let all = has_all(self.checked_in.load(Ordering::Relaxed));
        if all {
            self.checked_in.store(0, Ordering::Relaxed);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_task_has_its_own_bit() {
        let checked_in = MonitoredTask::ALL
            .iter()
            .fold(0, |checked_in, task| checked_in + task.bit());
        assert_eq!(checked_in, ALL_TASKS);
    }

    #[test]
    fn one_missing_task_stops_the_feeding() {
        for missing in MonitoredTask::ALL {
            let task_monitor = TaskMonitor::new();
            for task in MonitoredTask::ALL
                .into_iter()
                .filter(|&task| task != missing)
            {
                task_monitor.check_in(task);
                task_monitor.check_in(task);
            }
            assert!(!task_monitor.all_checked_in(), "fed without {missing:?}");
            task_monitor.check_in(missing);
            assert!(task_monitor.all_checked_in());
        }
    }

    #[test]
    fn the_long_timeout_is_reported_once_it_is_set() {
        let task_monitor = TaskMonitor::new();
        task_monitor.apply_timeout(|_| panic!("no change requested"));
        task_monitor.request_long_timeout(true);
        assert!(!task_monitor.has_long_timeout());
        let mut made = None;
        task_monitor.apply_timeout(|long| made = Some(long));
        assert!(made == Some(true) && task_monitor.has_long_timeout());
        task_monitor.apply_timeout(|_| panic!("no change requested"));
        task_monitor.request_long_timeout(false);
        task_monitor.apply_timeout(|long| made = Some(long));
        assert!(made == Some(false) && !task_monitor.has_long_timeout());
    }

    #[test]
    fn after_a_feeding_every_task_must_check_in_again() {
        let task_monitor = TaskMonitor::new();
        for task in MonitoredTask::ALL {
            task_monitor.check_in(task);
        }
        assert!(task_monitor.all_checked_in());
        assert!(!task_monitor.all_checked_in());
    }
}
