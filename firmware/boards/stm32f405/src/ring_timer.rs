//! The timer of the ring of sonars: timer 3, whose channel 1 captures the rise of ECHO at PC6.

use crate::chip::CORE_HZ;
use firmware::sonar_ring::{EchoCapture, EchoLine};
use stm32f4xx_hal::gpio::{Alternate, PC6};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc};

/// Counts microseconds and captures the rise of ECHO.
pub struct RingTimer {
    timer: pac::TIM3,
    echo: PC6<Alternate<2>>,
    /// Microseconds before the present turn of the 16-bit counter.
    overflow_us: u32,
}

impl RingTimer {
    /// Clock of the timer: twice that of its bus.
    const CLOCK_HZ: u32 = CORE_HZ / 2;
    /// Longest time to the next interrupt, microseconds: half a turn, so no overflow is missed.
    const MAX_SLEEP_US: u32 = 32_768;

    /// Starts counting.
    pub fn start(timer: pac::TIM3, echo: PC6<Alternate<2>>, rcc: &mut Rcc) -> Self {
        pac::TIM3::enable(rcc);
        timer
            .psc()
            .write(|w| w.psc().set((Self::CLOCK_HZ / 1_000_000 - 1) as u16));
        timer.egr().write(|w| w.ug().set_bit());
        // Input filter: an edge needs eight equal samples.
        timer
            .ccmr1_input()
            .modify(|_, w| w.cc1s().ti1().ic1f().fck_int_n8());
        timer.ccer().modify(|_, w| w.cc1e().set_bit());
        timer.cr1().modify(|_, w| w.cen().set_bit());
        Self {
            timer,
            echo,
            overflow_us: 0,
        }
    }

    /// Clears the timer's interrupt.
    pub fn clear(&mut self) {
        self.timer.sr().modify(|_, w| w.cc2if().clear_bit());
    }

    /// Interrupts at `at_us`, and at a rise of ECHO if `listens`; `None` disables both.
    pub fn wake_at(&mut self, at_us: Option<u32>, listens: bool) {
        let Some(at_us) = at_us else {
            self.timer.dier().reset();
            return;
        };
        let now_us = self.now_us();
        let wait_us = at_us.wrapping_sub(now_us);
        // A time in the past interrupts at once. Less than 5 µs ahead could be missed.
        let wait_us = if wait_us > 1 << 31 { 0 } else { wait_us };
        let wait_us = wait_us.clamp(5, Self::MAX_SLEEP_US);
        let then = now_us.wrapping_add(wait_us) as u16;
        self.timer.ccr2().write(|w| w.ccr().set(then));
        self.timer
            .dier()
            .write(|w| w.cc1ie().bit(listens).cc2ie().set_bit());
    }
}

impl EchoCapture for RingTimer {
    fn now_us(&mut self) -> u32 {
        let count = |timer: &pac::TIM3| u32::from(timer.cnt().read().cnt().bits());
        let mut now = count(&self.timer);
        if self.timer.sr().read().uif().bit_is_set() {
            self.timer.sr().modify(|_, w| w.uif().clear_bit());
            self.overflow_us = self.overflow_us.wrapping_add(1 << 16);
            // The overflow may have come before or after the count was read: read it again.
            now = count(&self.timer);
        }
        self.overflow_us.wrapping_add(now)
    }

    fn arm(&mut self) {
        // Reading the captured time clears its flag.
        let _ = self.timer.ccr1().read();
        self.timer.sr().modify(|_, w| w.cc1of().clear_bit());
    }

    fn echo_line(&mut self) -> EchoLine {
        // Reads the level first: a rise in between is then captured.
        let high = self.echo.is_high();
        let rose = self.timer.sr().read().cc1if().bit_is_set();
        let now_us = self.now_us();
        let rose_us = rose.then(|| {
            let caught = self.timer.ccr1().read().ccr().bits();
            now_us.wrapping_sub(u32::from((now_us as u16).wrapping_sub(caught)))
        });
        EchoLine { high, rose_us }
    }
}
