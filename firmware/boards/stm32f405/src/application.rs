//! The tasks of the STM32F405 boards, their interrupts and priorities.
//!
//! | task | runs | priority | does |
//! |---|---|---|---|
//! | `serial` | when a byte has arrived or can be sent | 3 | moves it from or to a queue |
//! | `ring` | when the sonars' timer is due, or at an echo | 2 | fires, listens, queues readings |
//! | `clock` | each millisecond | 2 | counts, sets the LED, feeds the watchdog, wakes `control` |
//! | `control` | when a frame has arrived, each 10 ms, and while work is left | 1 | runs the node |
//! | `supply` | when the supply voltage falls too low | 1 | wakes `control`, which reads it |
//! | `idle` | otherwise | 0 | sleeps |
//!
//! Tasks share queues and atomics, never a lock. Only a line of the log masks the receive
//! interrupt, for at most 334 instructions (counted in an emulated chip with the board's logger):
//! 2 µs of the 87 µs per byte.

/// The program of a board. `$board` is its module in this crate, `$link` the interrupt of its port.
///
/// A macro, because RTIC needs interrupt names as literals and the boards use different ports.
#[macro_export]
macro_rules! application {
    ($board:ident, $link:ident) => {
        #[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
        mod app {
            use $crate::chip::{
                BoardSafetyLines, Devices, RingPin, StatusLed, SupplyInterrupt, SupplyMonitor, Watchdog,
            };
            use $crate::flash::StoreFlash;
            use $crate::ring_timer::RingTimer;
            use $crate::serial::SerialPort;
            use $crate::{RobotBody, clocks, fault};
            use $crate::$board as board;
            use amp::node::Identity;
            use amp::units::Millis;
            use amp::wire::message::{Oscillator, ResetCause};
            use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
            use firmware::BUILD;
            use firmware::control::{Control, RobotNode};
            use firmware::crash::{ResetFlags, reset_cause, reset_name};
            use firmware::persist::{Store, slot_bytes};
            use firmware::sonar_ring::{
                ChannelDriver, EchoCapture, FiringOrder, RingPins, RingReading, SonarRing, SpeedOfSound, Timing,
            };
            use firmware::status_led;
            use firmware::task_monitor::{MonitoredTask, TaskMonitor};
            use firmware::uart::{ErrorCounters, TxQueue, UartDriver};
            use heapless::spsc::{Producer, Queue};
            use stm32f4xx_hal::pac::Interrupt;

            /// Longest time between two runs of `control`, and between feedings of the watchdog.
            const CONTROL_PERIOD_MS: u32 = 10;
            /// Period of `housekeeping`.
            const HOUSEKEEPING_MS: u32 = 1_000;
            /// The interrupt vector of `control`; the 64-pin package has no external memory (FSMC).
            const CONTROL: Interrupt = Interrupt::FSMC;
            /// An emulated chip has no pins.
            const HAS_PINS: bool = cfg!(not(feature = "qemu"));
            /// Temperature of the air around the ring, tenths of a degree Celsius.
            const AIR_DECIDEGREES: i16 = 200;

            #[shared]
            struct SharedResources {
                now_ms: AtomicU32,
                linked: AtomicBool,
                ring_wanted: AtomicBool,
                reset: ResetCause,
                task_monitor: TaskMonitor,
                errors: &'static ErrorCounters,
            }

            #[local]
            struct LocalResources {
                driver: UartDriver<'static>,
                port: SerialPort<board::LinkUart>,
                led: StatusLed,
                watchdog: Watchdog,
                ring: SonarRing<'static, RingPin>,
                timer: RingTimer,
                control: Control<'static, RobotBody, StoreFlash>,
                safety: BoardSafetyLines,
                supply: SupplyMonitor,
                supply_alarm: SupplyInterrupt,
            }

            #[init(local = [
                node: RobotNode<RobotBody> = RobotNode::new(),
                received: Queue<u8, 512> = Queue::new(),
                to_send: Queue<u8, 2048> = Queue::new(),
                errors: ErrorCounters = ErrorCounters::new(),
                readings: Queue<RingReading, 16> = Queue::new(),
            ])]
            fn init(cx: init::Context) -> (SharedResources, LocalResources) {
                let mut devices: Devices<board::LinkUart> = board::init(cx.device, cx.core);
                let reset = reset_reason(devices.flags);
                let errors: &'static ErrorCounters = cx.local.errors;
                let (received_in, received_out) = cx.local.received.split();
                let (to_send_in, to_send_out) = cx.local.to_send.split();
                let tx = TxQueue::new(to_send_in);
                cx.local.node.use_kernels(&cortex_m4::KERNELS);
                let (readings_in, readings_out) = cx.local.readings.split();
                let store = Store::mount(devices.flash, slot_bytes::<RobotBody>());
                let control = Control::new(cx.local.node, received_out, tx, errors, Some(store));
                let mut control = control.with_ring(readings_out);
                // A sector of flash may be erased.
                devices.watchdog.set_long_timeout(true);
                control.start(identity(reset, devices.oscillator), Millis::from_ms(0));
                devices.watchdog.set_long_timeout(false);
                // Sends the Hello, which waits in the queue.
                rtic::pend(Interrupt::$link);
                let shared = SharedResources {
                    now_ms: AtomicU32::new(0),
                    linked: AtomicBool::new(false),
                    ring_wanted: AtomicBool::new(false),
                    reset,
                    task_monitor: TaskMonitor::new(),
                    errors,
                };
                let mut timer = devices.ring_timer;
                let ring = sonar_ring(devices.ring_pins, timer.now_us(), readings_in, errors);
                let local = LocalResources {
                    driver: UartDriver::new(received_in, to_send_out),
                    port: devices.port,
                    led: devices.led,
                    watchdog: devices.watchdog,
                    ring,
                    timer,
                    control,
                    safety: devices.safety,
                    supply: devices.supply,
                    supply_alarm: devices.supply_alarm,
                };
                (shared, local)
            }

            #[idle]
            fn idle(_: idle::Context) -> ! {
                loop {
                    cortex_m::asm::wfi();
                }
            }

            #[task(binds = $link, priority = 3, local = [driver, port], shared = [&errors, &task_monitor])]
            fn serial(cx: serial::Context) {
                if cx.local.driver.transfer(cx.local.port, cx.shared.errors) {
                    rtic::pend(CONTROL);
                }
                cx.shared.task_monitor.check_in(MonitoredTask::Serial);
            }

            #[task(binds = SysTick, priority = 2, local = [led, watchdog], shared = [&now_ms, &linked, &reset, &task_monitor])]
            fn clock(cx: clock::Context) {
                let shared = cx.shared;
                let now_ms = shared
                    .now_ms
                    .fetch_add(1, Ordering::Relaxed)
                    .wrapping_add(1);
                shared.task_monitor.check_in(MonitoredTask::Clock);
                if now_ms == clocks::PROVEN_AFTER_MS {
                    clocks::mark_proven();
                }
                let watchdog = &mut *cx.local.watchdog;
                shared
                    .task_monitor
                    .apply_timeout(|long| watchdog.set_long_timeout(long));
                if now_ms.is_multiple_of(CONTROL_PERIOD_MS) {
                    if shared.task_monitor.all_checked_in() {
                        watchdog.feed();
                    }
                    // Both must check in before the next feeding.
                    rtic::pend(CONTROL);
                    rtic::pend(Interrupt::$link);
                }
                let linked = shared.linked.load(Ordering::Relaxed);
                let lit = status_led::is_lit(Millis::from_ms(now_ms), linked, *shared.reset);
                cx.local.led.set(lit);
            }

            #[task(binds = TIM3, priority = 2, local = [ring, timer], shared = [&now_ms, &ring_wanted])]
            fn ring(cx: ring::Context) {
                let (timer, shared) = (cx.local.timer, cx.shared);
                timer.clear();
                let now = Millis::from_ms(shared.now_ms.load(Ordering::Relaxed));
                let wanted = shared.ring_wanted.load(Ordering::Relaxed);
                let Ok(next_us) = cx.local.ring.serve(timer, now, wanted);
                timer.wake_at(next_us, cx.local.ring.is_listening());
            }

            #[task(binds = FSMC, priority = 1, local = [control, safety, supply, housekeeping_ms: u32 = 0], shared = [&now_ms, &linked, &ring_wanted, &task_monitor])]
            fn control(cx: control::Context) {
                let (control, shared) = (cx.local.control, cx.shared);
                let now_ms = shared.now_ms.load(Ordering::Relaxed);
                control.set_has_long_timeout(shared.task_monitor.has_long_timeout());
                let now = Millis::from_ms(now_ms);
                if HAS_PINS {
                    let alarms = cx.local.safety.read(now);
                    control.apply_alarms(alarms, cx.local.supply.is_low(), now);
                }
                let work_left = control.run(now);
                if HAS_PINS {
                    cx.local.safety.toggle_permit(control.may_move(now), now);
                }
                shared.task_monitor.request_long_timeout(control.needs_long_timeout());
                if control.take_queued() {
                    rtic::pend(Interrupt::$link);
                }
                let wanted = HAS_PINS && control.needs_ring();
                if shared.ring_wanted.swap(wanted, Ordering::Relaxed) != wanted {
                    rtic::pend(Interrupt::TIM3);
                }
                shared.linked.store(control.is_linked(), Ordering::Relaxed);
                if now_ms.wrapping_sub(*cx.local.housekeeping_ms) >= HOUSEKEEPING_MS {
                    *cx.local.housekeeping_ms = now_ms;
                    housekeeping(control);
                }
                shared.task_monitor.check_in(MonitoredTask::Control);
                if work_left {
                    rtic::pend(CONTROL);
                }
            }

            #[task(binds = PVD, priority = 1, local = [supply_alarm])]
            fn supply(cx: supply::Context) {
                cx.local.supply_alarm.clear();
                rtic::pend(CONTROL);
            }

            /// What the Hello says about this device.
            const fn identity(reset: ResetCause, oscillator: Oscillator) -> Identity {
                Identity {
                    build: BUILD,
                    reset,
                    oscillator,
                    ring: HAS_PINS,
                }
            }

            /// The ring of sonars, at rest.
            fn sonar_ring(
                pins: RingPins<RingPin>,
                now_us: u32,
                readings: Producer<'static, RingReading>,
                errors: &'static ErrorCounters,
            ) -> SonarRing<'static, RingPin> {
                let timing = Timing::relays().with_self_test();
                let Ok(driver) = ChannelDriver::new(pins, timing, FiringOrder::NOMAD, now_us);
                SonarRing::new(driver, timing, SpeedOfSound::at(AIR_DECIDEGREES), readings, errors)
            }

            /// Measures the stack and logs changes.
            fn housekeeping(control: &mut Control<'static, RobotBody, StoreFlash>) {
                control.set_stack_peak(fault::stack_peak_bytes());
                if let Some(log_event) = control.next_log_event() {
                    log_event.log();
                }
            }

            /// Logs why the program started, and returns it for the Hello.
            fn reset_reason(flags: ResetFlags) -> ResetCause {
                let crash = fault::take_crash();
                let reset = reset_cause(flags, crash.as_ref());
                defmt::info!(
                    "build {=str} starts {=str}",
                    str::from_utf8(&BUILD).unwrap_or_default(),
                    reset_name(reset)
                );
                match crash {
                    Some(crash) if crash.program_counter != 0 => {
                        defmt::error!(
                            "the last run faulted at {=u32:#x}: {=str}",
                            crash.program_counter,
                            crash.text.as_str()
                        );
                    }
                    Some(crash) => defmt::error!("the last run crashed: {=str}", crash.text.as_str()),
                    None => {}
                }
                reset
            }
        }
    };
}
