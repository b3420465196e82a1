//! Where the log goes: over the debugger's real-time transfer, or to the emulator's standard error.
//!
//! Not to its standard output: that may be the wire.

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

    // SAFETY: `inner` is touched only between `acquire` and `release`, which is a critical section.
    unsafe impl Sync for LoggerState {}

    struct LoggerInner {
        restore: RestoreState,
        encoder: defmt::Encoder,
        stream: Option<HostStream>,
    }

    impl LoggerInner {
        /// Bytes that cannot be written are lost; there is nobody to tell.
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
    /// Only between `acquire` and `release`, and not while another such reference is alive.
    unsafe fn inner() -> &'static mut LoggerInner {
        // SAFETY: the caller's promise.
        unsafe { &mut *STATE.inner.get() }
    }

    // SAFETY: `acquire` begins a critical section and refuses to be entered twice; `release` ends it.
    unsafe impl defmt::Logger for Logger {
        fn acquire() {
            // SAFETY: `release` is its counterpart.
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
            // The host has every byte as soon as it is written.
        }

        unsafe fn release() {
            // SAFETY: the caller has acquired the logger.
            let inner = unsafe { inner() };
            inner.write(|encoder, sink| encoder.end_frame(sink));
            STATE.acquired.store(false, Ordering::Relaxed);
            // SAFETY: it is the state that `acquire` got.
            unsafe { critical_section::release(inner.restore) };
        }

        unsafe fn write(bytes: &[u8]) {
            // SAFETY: the caller has acquired the logger.
            unsafe { inner() }.write(|encoder, sink| encoder.write(bytes, sink));
        }
    }
}
