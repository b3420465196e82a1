//! The transport of the log: the debugger (RTT), or the standard error of the emulator.
//!
//! The emulator's standard output is not used, because it may carry the link.

#[cfg(not(feature = "qemu"))]
use defmt_rtt as _;

#[cfg(feature = "qemu")]
mod semihosting {
    #![allow(unsafe_code)]

    use core::cell::UnsafeCell;
    use core::sync::atomic::{AtomicBool, Ordering};
    use cortex_m_semihosting::hio::{HostStream, hstderr};
    use critical_section::RestoreState;

    #[defmt::global_logger]
    struct Logger;

    static STATE: LoggerState = LoggerState {
        acquired: AtomicBool::new(false),
        inner: UnsafeCell::new(LoggerInner {
            restore: RestoreState::invalid(),
            encoder: defmt::Encoder::new(),
            stream: None,
        }),
    };

    struct LoggerState {
        acquired: AtomicBool,
        inner: UnsafeCell<LoggerInner>,
    }

    // SAFETY: `inner` is accessed only between `acquire` and `release`: a critical section.
    unsafe impl Sync for LoggerState {}

    struct LoggerInner {
        restore: RestoreState,
        encoder: defmt::Encoder,
        stream: Option<HostStream>,
    }

    impl LoggerInner {
        /// Bytes that cannot be written are dropped.
        fn write(&mut self, encode: impl FnOnce(&mut defmt::Encoder, &mut dyn FnMut(&[u8]))) {
            let stream = &mut self.stream;
            encode(&mut self.encoder, &mut |bytes| {
                if let Some(stream) = stream {
                    let _ = stream.write_all(bytes);
                }
            });
        }
    }

    /// # Safety
    /// Only between `acquire` and `release`, with no other such reference alive.
    unsafe fn inner() -> &'static mut LoggerInner {
        // SAFETY: guaranteed by the caller.
        unsafe { &mut *STATE.inner.get() }
    }

    // SAFETY: `acquire` begins a critical section and panics if entered twice; `release` ends it.
    unsafe impl defmt::Logger for Logger {
        fn acquire() {
            // SAFETY: `release` ends it.
            let restore = unsafe { critical_section::acquire() };
            assert!(
                !STATE.acquired.swap(true, Ordering::Relaxed),
                "logged while logging"
            );
            // SAFETY: the critical section has begun.
            let inner = unsafe { inner() };
            inner.restore = restore;
            if inner.stream.is_none() {
                inner.stream = hstderr().ok();
            }
            inner.write(|encoder, sink| encoder.start_frame(sink));
        }

        unsafe fn flush() {
            // Each byte reaches the host as soon as it is written.
        }

        unsafe fn release() {
            // SAFETY: the caller has acquired the logger.
            let inner = unsafe { inner() };
            inner.write(|encoder, sink| encoder.end_frame(sink));
            STATE.acquired.store(false, Ordering::Relaxed);
            // SAFETY: the state comes from `acquire`.
            unsafe { critical_section::release(inner.restore) };
        }

        unsafe fn write(bytes: &[u8]) {
            // SAFETY: the caller has acquired the logger.
            unsafe { inner() }.write(|encoder, sink| encoder.write(bytes, sink));
        }
    }
}
