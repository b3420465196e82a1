//! May the watchdog be fed? Only when every task has run since it was fed last.
//!
//! A watchdog fed from a timer interrupt alone would be content with a control task that hangs. Here each task leaves its
//! mark, and one task that stays away is enough to let the watchdog bite.

use portable_atomic::{AtomicBool, AtomicU32, Ordering};

/// A task that has to show itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// The serial interrupt.
    Serial,
    /// The clock's interrupt.
    Clock,
    /// The task that owns the mind.
    Control,
}

impl Task {
    /// Every task.
    pub const ALL: [Self; 3] = [Self::Serial, Self::Clock, Self::Control];

    /// The task's bit.
    const fn mark(self) -> u32 {
        match self {
            Self::Serial => 1,
            Self::Clock => 2,
            Self::Control => 4,
        }
    }
}

/// The marks of [`Task::ALL`] together.
const EVERYONE: u32 = 0b111;

/// Whether these marks are everyone's.
#[must_use]
const fn complete(marks: u32) -> bool {
    marks & EVERYONE == EVERYONE
}

/// Who has run since the watchdog was fed last.
#[derive(Debug, Default)]
pub struct TaskMonitor {
    marks: AtomicU32,
    /// Somebody is about to hold up everybody for longer than the watchdog bears.
    patience_wanted: AtomicBool,
    /// The watchdog bears it.
    is_patient: AtomicBool,
}

impl TaskMonitor {
    /// Nobody has run yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            marks: AtomicU32::new(0),
            patience_wanted: AtomicBool::new(false),
            is_patient: AtomicBool::new(false),
        }
    }

    /// A task has run.
    pub fn seen(&self, task: Task) {
        self.marks.fetch_or(task.mark(), Ordering::Relaxed);
    }

    /// Says whether somebody wants to hold up everybody.
    pub fn want_patience(&self, wanted: bool) {
        self.patience_wanted.store(wanted, Ordering::Relaxed);
    }

    /// Whether the watchdog bears it by now.
    #[must_use]
    pub fn is_patient(&self) -> bool {
        self.is_patient.load(Ordering::Relaxed)
    }

    /// For the watchdog's owner: how patient it is to be from now on, if that has changed; and then has been made so.
    pub fn change_patience(&self, make: impl FnOnce(bool)) {
        let wanted = self.patience_wanted.load(Ordering::Relaxed);
        if wanted != self.is_patient() {
            make(wanted);
            self.is_patient.store(wanted, Ordering::Relaxed);
        }
    }

    /// Whether the watchdog may be fed now; if so, everyone has to show himself anew.
    #[must_use]
    pub fn all_checked_in(&self) -> bool {
        let all = complete(self.marks.load(Ordering::Relaxed));
        if all {
            self.marks.store(0, Ordering::Relaxed);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_task_has_a_mark_of_its_own() {
        let marks = Task::ALL.iter().fold(0, |marks, task| marks + task.mark());
        assert_eq!(marks, EVERYONE);
    }

    #[test]
    fn one_task_that_stays_away_starves_the_watchdog() {
        for missing in Task::ALL {
            let task_monitor = TaskMonitor::new();
            for task in Task::ALL.into_iter().filter(|&task| task != missing) {
                task_monitor.seen(task);
                task_monitor.seen(task);
            }
            assert!(!task_monitor.all_checked_in(), "fed without {missing:?}");
            task_monitor.seen(missing);
            assert!(task_monitor.all_checked_in());
        }
    }

    #[test]
    fn patience_is_there_when_the_watchdog_has_it() {
        let task_monitor = TaskMonitor::new();
        task_monitor.change_patience(|_| panic!("nobody wants it"));
        task_monitor.want_patience(true);
        assert!(!task_monitor.is_patient());
        let mut made = None;
        task_monitor.change_patience(|patient| made = Some(patient));
        assert!(made == Some(true) && task_monitor.is_patient());
        task_monitor.change_patience(|_| panic!("it has it"));
        task_monitor.want_patience(false);
        task_monitor.change_patience(|patient| made = Some(patient));
        assert!(made == Some(false) && !task_monitor.is_patient());
    }

    #[test]
    fn after_a_feed_everyone_has_to_come_again() {
        let task_monitor = TaskMonitor::new();
        for task in Task::ALL {
            task_monitor.seen(task);
        }
        assert!(task_monitor.all_checked_in());
        assert!(!task_monitor.all_checked_in());
    }
}
