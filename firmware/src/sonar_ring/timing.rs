//! Durations of the ring, the firing order, and the range of a flight time.

use amp::units::Range;

/// Transducers of the ring.
pub const SENSORS: usize = 16;

/// Ends a firing order that is shorter than the ring.
pub const END_OF_ORDER: u8 = 255;

/// Greatest range, millimeters: 255 in. Such an echo takes 37.7 ms at 20 °C.
pub const MAX_MM: u16 = 6_477;

/// From when on the module can detect an echo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blanking {
    /// After the internal 2.38 ms (Polaroid 6500 data sheet), which is 16 in. The Nomad's manual
    /// says 17 in.
    Internal,
    /// From this time after the firing, microseconds, when BINH rises. The burst takes 324 µs, then
    /// the membrane rings; 900 µs is 6 in.
    Until(u32),
}

impl Blanking {
    /// Short blanking: 6 in.
    pub const SHORT: Self = Self::Until(900);

    /// Time after the firing in which no valid echo can come, microseconds.
    #[must_use]
    pub const fn us(self) -> u32 {
        match self {
            Self::Internal => 2_380,
            Self::Until(us) => us,
        }
    }
}

/// Timing of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// From a new address to the firing, microseconds: 25 ms for the Nomad's relays.
    pub settle_us: u32,
    /// When the module can detect an echo.
    pub blanking: Blanking,
    /// From the firing to the end of listening, microseconds.
    pub window_us: u32,
    /// Shortest time with INIT low before the next address, microseconds; ECHO falls in it.
    pub recycle_us: u32,
    /// Shortest time between two firings, in units of 4 ms as in the Nomad's `conf_sn`. It is
    /// longer if the other times add up to more.
    pub rate: u8,
    /// Delay of the first firing, microseconds; keeps channels apart.
    pub offset_us: u32,
    /// Part of the measured time that is not flight, microseconds: the detector needs some cycles
    /// of the echo. To be measured at a wall in a known distance.
    pub delay_us: u16,
    /// Each transducer's first firings are self-tests, until it passes one.
    pub self_test: bool,
}

/// When BINH rises in a self-test, microseconds after the firing: the burst of 324 µs is over and
/// the membrane rings.
pub const SELF_TEST_BINH_US: u32 = 400;

/// When a self-test ends, microseconds after the firing: the membrane rings until then. ECHO has
/// risen if module, supply, transducer and multiplexer work.
pub const RINGING_END_US: u32 = 900;

impl Timing {
    /// The Nomad's relays at their highest rate (64 ms, a ring in 1.02 s), with short blanking.
    #[must_use]
    pub const fn relays() -> Self {
        Self {
            settle_us: 25_000,
            blanking: Blanking::SHORT,
            window_us: 37_700,
            recycle_us: 1_000,
            rate: 16,
            offset_us: 0,
            delay_us: 0,
            self_test: false,
        }
    }

    /// The same with a self-test at the start.
    #[must_use]
    pub const fn with_self_test(self) -> Self {
        Self {
            self_test: true,
            ..self
        }
    }

    /// The same for channel `channel` of four, each a quadrant of the ring. Opposite quadrants fire
    /// 2 ms apart, the others half a slot later. Bursts of 324 µs never overlap, and neighbors
    /// never hear each other.
    #[must_use]
    pub const fn quadrant(self, channel: u8) -> Self {
        let half = self.slot_us() / 2;
        let offset_us = (channel as u32 % 2) * half + (channel as u32 / 2 % 2) * STAGGER_US;
        Self { offset_us, ..self }
    }

    /// Time between two firings, microseconds: a multiple of 4 ms.
    #[must_use]
    pub const fn slot_us(&self) -> u32 {
        let needed = self
            .settle_us
            .saturating_add(self.window_us)
            .saturating_add(self.recycle_us)
            .div_ceil(UNIT_US);
        let asked = self.rate as u32;
        let units = if asked > needed { asked } else { needed };
        units.saturating_mul(UNIT_US)
    }
}

/// Unit of the rate, microseconds.
const UNIT_US: u32 = 4_000;

/// Planned time between the firings of two channels, microseconds: a burst draws 2 A for 324 µs.
pub const STAGGER_US: u32 = 2_000;

/// A firing that is later than this is postponed by a slot, microseconds. It is half the stagger,
/// so two channels always fire at least the other half apart.
pub const MAX_LATE_US: u32 = STAGGER_US / 2;

/// The order in which transducers fire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FiringOrder([u8; SENSORS]);

impl FiringOrder {
    /// Front first, then alternating sides: the order that the Nomad's drivers set.
    pub const NOMAD: Self = Self([0, 2, 15, 1, 14, 3, 13, 4, 12, 5, 11, 6, 10, 7, 9, 8]);

    /// An order, ended by [`END_OF_ORDER`] or by its 16th transducer; `None` if a transducer does
    /// not exist or occurs twice.
    #[must_use]
    pub fn new(order: [u8; SENSORS]) -> Option<Self> {
        let mut seen = 0_u16;
        for sensor in order.into_iter().take_while(|&s| s != END_OF_ORDER) {
            let bit = 1_u16.checked_shl(sensor.into())?;
            if seen & bit != 0 {
                return None;
            }
            seen |= bit;
        }
        Some(Self(order))
    }

    /// The transducers of one quadrant; 0 in front, 1 to the left.
    #[must_use]
    pub fn quadrant(channel: u8) -> Self {
        let first = (channel % 4) * 4;
        let mut order = [END_OF_ORDER; SENSORS];
        for (place, step) in order.iter_mut().zip([0, 2, 1, 3]) {
            *place = first + step;
        }
        Self(order)
    }

    /// The transducer at a place of the order, and the next place; `None` for an empty order.
    #[must_use]
    pub fn at(&self, place: u8) -> Option<(u8, u8)> {
        let sensor = |place: u8| {
            let sensor = self.0.get(usize::from(place)).copied();
            sensor.filter(|&sensor| sensor != END_OF_ORDER)
        };
        match sensor(place) {
            Some(here) => Some((here, place.saturating_add(1))),
            None => sensor(0).map(|first| (first, 1)),
        }
    }
}

/// Time of flight (there and back) per meter of range, microseconds, from −20 °C in steps of 10 K:
/// 2 / c with c = 331.3 √(1 + T / 273.15) m/s.
const US_PER_M: [u16; 8] = [6_271, 6_150, 6_037, 5_929, 5_827, 5_730, 5_638, 5_550];

/// Speed of sound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SpeedOfSound {
    us_per_m: u16,
}

impl SpeedOfSound {
    /// At a temperature in tenths of a degree Celsius, limited to −20 … 50 °C.
    #[must_use]
    pub fn at(decidegrees: i16) -> Self {
        let above = i32::from(decidegrees).clamp(-200, 500) + 200;
        let (place, rest) = ((above / 100) as usize, above % 100);
        let entry = |place: usize| i32::from(US_PER_M.get(place).copied().unwrap_or(5_550));
        let (here, next) = (entry(place), entry(place + 1));
        let us_per_m = here + ((next - here) * rest - 50) / 100;
        Self {
            us_per_m: us_per_m as u16,
        }
    }

    /// The range of a time of flight; `None` from [`MAX_MM`] on.
    #[must_use]
    pub fn range(self, flight_us: u32) -> Option<Range> {
        let us_per_m = u32::from(self.us_per_m.max(1));
        // 65 535 times 1 000 fits 32 bits.
        let mm = (flight_us.min(65_535) * 1_000 + us_per_m / 2) / us_per_m;
        let mm = u16::try_from(mm).ok().filter(|&mm| mm < MAX_MM)?;
        Some(Range::from_mm(mm))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 / c by floating point, microseconds per meter.
    fn exact_us_per_m(celsius: f64) -> f64 {
        let ratio = 1.0 + celsius / 273.15;
        // Newton's method: `core` has no square root.
        let root = (0..60).fold(1.0, |root, _| 0.5 * (root + ratio / root));
        2e6 / (331.3 * root)
    }

    #[test]
    fn the_table_matches_the_formula() {
        for (step, &us) in US_PER_M.iter().enumerate() {
            let exact = exact_us_per_m(step as f64 * 10.0 - 20.0);
            assert!((f64::from(us) - exact).abs() <= 0.51, "{us} {exact}");
        }
        for decidegrees in -200..=500_i16 {
            let us = f64::from(SpeedOfSound::at(decidegrees).us_per_m);
            let exact = exact_us_per_m(f64::from(decidegrees) / 10.0);
            assert!((us - exact).abs() <= 2.0, "{decidegrees}: {us} {exact}");
        }
        assert_eq!(SpeedOfSound::at(-900), SpeedOfSound::at(-200));
        assert_eq!(SpeedOfSound::at(900), SpeedOfSound::at(500));
    }

    /// 148.0 µs per inch at 20 °C; the full range takes 37.7 ms.
    #[test]
    fn a_time_of_flight_gives_a_range() {
        let mm = |us| SpeedOfSound::at(200).range(us).map(Range::as_mm);
        assert_eq!(mm(0), Some(0));
        assert_eq!(mm(5_827), Some(1_000));
        assert_eq!(mm(148 * 6), Some(152));
        assert_eq!(mm(37_700), Some(6_470));
        assert_eq!((mm(37_800), mm(u32::MAX)), (None, None));
    }

    /// Nearest range: 16 in with internal blanking, 6 in with the short one.
    #[test]
    fn both_blankings_are_the_known_ranges() {
        let nearest = |blanking: Blanking| {
            let range = SpeedOfSound::at(200).range(blanking.us());
            range.map(|range| (range.as_mm() + 12) / 25)
        };
        assert_eq!(nearest(Blanking::Internal), Some(16));
        assert_eq!(nearest(Blanking::SHORT), Some(6));
    }

    #[test]
    fn an_order_repeats_and_rejects_duplicates() {
        let mut place = 0;
        for expected in [0, 2, 15, 1, 14, 3, 13, 4, 12, 5, 11, 6, 10, 7, 9, 8, 0, 2] {
            let (sensor, next) = FiringOrder::NOMAD.at(place).expect("a transducer");
            assert_eq!(sensor, expected);
            place = next;
        }
        let mut short = [END_OF_ORDER; 16];
        assert_eq!(FiringOrder::new(short).expect("an order").at(0), None);
        (short[0], short[1]) = (7, 3);
        let order = FiringOrder::new(short).expect("an order");
        assert_eq!((order.at(1), order.at(2)), (Some((3, 2)), Some((7, 1))));
        short[1] = 7;
        assert_eq!(FiringOrder::new(short), None);
        short[1] = 16;
        assert_eq!(FiringOrder::new(short), None);
    }

    #[test]
    fn the_quadrants_cover_the_ring() {
        let mut seen = [false; 16];
        for channel in 0..4 {
            for place in 0..4 {
                let (sensor, _) = FiringOrder::quadrant(channel)
                    .at(place)
                    .expect("a transducer");
                seen[usize::from(sensor)] = true;
            }
        }
        assert_eq!(seen, [true; 16]);
        let offsets = [0, 1, 2, 3].map(|channel| Timing::relays().quadrant(channel).offset_us);
        assert_eq!(offsets, [0, 32_000, 2_000, 34_000]);
    }

    #[test]
    fn a_rate_too_fast_for_the_relays_is_stretched() {
        assert_eq!(Timing::relays().slot_us(), 64_000);
        let hasty = Timing {
            rate: 10,
            ..Timing::relays()
        };
        assert_eq!(hasty.slot_us(), 64_000);
        let slow = Timing { rate: 20, ..hasty };
        assert_eq!(slow.slot_us(), 80_000);
    }
}
