//! May the watchdog be fed? Only when every task has run since it was fed last.
//!
//! A watchdog fed from a timer interrupt alone would be content with a control task that hangs. Here each task leaves its
//! mark, and one task that stays away is enough to let the watchdog bite.

use portable_atomic::{AtomicBool, AtomicU32, Ordering};

/// A task that has to show itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MonitoredTask {
    /// The serial interrupt.
    Serial,
    /// The clock's interrupt.
    Clock,
    /// The task that owns the mind.
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

/// The marks of [`MonitoredTask::ALL`] together.
const ALL_TASKS: u32 = 0b111;

/// Whether these marks are everyone's.
#[must_use]
const fn has_all(checked_in: u32) -> bool {
    checked_in & ALL_TASKS == ALL_TASKS
}

/// Who has run since the watchdog was fed last.
#[derive(Debug, Default)]
pub struct TaskMonitor {
    checked_in: AtomicU32,
    /// Somebody is about to hold up everybody for longer than the watchdog bears.
    long_timeout_requested: AtomicBool,
    /// The watchdog bears it.
    has_long_timeout: AtomicBool,
}

impl TaskMonitor {
    /// Nobody has run yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            checked_in: AtomicU32::new(0),
            long_timeout_requested: AtomicBool::new(false),
            has_long_timeout: AtomicBool::new(false),
        }
    }

    /// A task has run.
    pub fn check_in(&self, task: MonitoredTask) {
        self.checked_in.fetch_or(task.bit(), Ordering::Relaxed);
    }

    /// Says whether somebody wants to hold up everybody.
    pub fn request_long_timeout(&self, wanted: bool) {
        self.long_timeout_requested.store(wanted, Ordering::Relaxed);
    }

    /// Whether the watchdog bears it by now.
    #[must_use]
    pub fn has_long_timeout(&self) -> bool {
        self.has_long_timeout.load(Ordering::Relaxed)
    }

    /// For the watchdog's owner: how patient it is to be from now on, if that has changed; and then has been made so.
    pub fn apply_timeout(&self, set_timeout: impl FnOnce(bool)) {
        let wanted = self.long_timeout_requested.load(Ordering::Relaxed);
        if wanted != self.has_long_timeout() {
            set_timeout(wanted);
            self.has_long_timeout.store(wanted, Ordering::Relaxed);
        }
    }

    /// Whether the watchdog may be fed now; if so, everyone has to show himself anew.
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
