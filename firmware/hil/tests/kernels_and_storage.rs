//! Kernels in assembly and saved images, on a board and on an emulated chip.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("These tests are for the chip: firmware/README.md says how to run them.");
}

#[cfg(target_os = "none")]
#[embedded_test::tests]
mod tests {
    use amp::action_map::{ActionMap, Effect};
    use amp::body::HeldRing;
    use amp::config::Config;
    use amp::controller::{State, StatePart};
    use amp::fixed::{Mask, Weight};
    use amp::goal::{Component, Goal, NamedGoals};
    use amp::som::Update;
    use amp::som::{Grid, Neighborhood, Som};
    use amp::store::{Contents, ContentsMut, MAX_NOMAD};
    use amp::wire::checksum;
    use amp::wire::message::FlashError;
    use core::array::from_fn;
    use core::cell::RefCell;
    use cortex_m::interrupt::{Mutex, free};
    use cortex_m4::KERNELS;
    use firmware::persist::{Store, slot_bytes};
    use stm32f4xx_hal::pac;
    use stm32f4xx_hal::rcc::{self, RccExt};
    use stm32f405::chip::SupplyMonitor;
    use stm32f405::flash::StoreFlash;

    /// The contents of a saved image.
    struct StoredContents {
        config: Config<16>,
        state: State<16, 16, 100>,
        goal: Goal<16>,
        goals: NamedGoals<16>,
    }

    impl StoredContents {
        const fn new() -> Self {
            Self {
                config: Config::recommended(),
                state: State::new(Grid::rectangle(4, 4)),
                goal: Goal::of([Component::ANY; 16]),
                goals: NamedGoals::new(),
            }
        }

        /// Fills maps and memory with bytes derived from `number`.
        fn fill(&mut self, number: u8, buffers: &mut Image) {
            for (place, byte) in buffers.iter_mut().enumerate() {
                *byte = (place as u8).wrapping_mul(7).wrapping_add(number);
            }
            for part in [
                StatePart::Situations,
                StatePart::Changes,
                StatePart::Actions,
                StatePart::Memory,
            ] {
                let length = match part {
                    StatePart::Memory => 100 * State::<16, 16, 100>::SAMPLE_BYTES,
                    _ => self.state.part_len(part),
                };
                let written = self.state.write_part(part, 0, &buffers[..length]);
                assert!(written.is_ok());
            }
        }

        fn contents(&self) -> Contents<'_, 16, 16, 100> {
            Contents {
                body: &HeldRing,
                config: &self.config,
                state: &self.state,
                goal: &self.goal,
                goals: &self.goals,
            }
        }

        /// Loads the newest image.
        fn load(&mut self, store: &mut Store<&mut StoreFlash>) -> Result<(), FlashError> {
            store.load(|read, most| {
                let mut contents = ContentsMut {
                    body: &mut HeldRing,
                    config: &mut self.config,
                    state: &mut self.state,
                    goal: &mut self.goal,
                    goals: &mut self.goals,
                };
                contents.read(read, most).map(drop)
            })
        }

        /// Writes the image to `buffers`; returns its length.
        fn image(&self, buffers: &mut Image) -> usize {
            let mut length = 0;
            let written = self.contents().write(1, &mut |bytes| {
                let end = length + bytes.len();
                buffers[length..end].copy_from_slice(bytes);
                length = end;
                Ok::<_, ()>(())
            });
            assert!(written.is_ok());
            length
        }
    }

    type Image = [u8; MAX_NOMAD];

    /// Contents before, saved and loaded; images of the latter two. Too large for the stack.
    type TestBuffers = ([StoredContents; 3], [Image; 2]);

    static TEST_BUFFERS: Mutex<RefCell<TestBuffers>> = Mutex::new(RefCell::new((
        [const { StoredContents::new() }; 3],
        [[0; MAX_NOMAD]; 2],
    )));

    /// Pseudo-random numbers (G. Marsaglia, Xorshift RNGs, 2003).
    struct TestRng(u32);

    impl TestRng {
        /// A component from -1 to 1; every fourth one is -1 or 1.
        fn weight(&mut self) -> Weight {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 17;
            self.0 ^= self.0 << 5;
            let value = match self.0 >> 30 {
                0 if self.0 & 1 == 0 => -8_192,
                0 => 8_192,
                _ => (self.0 % 16_385) as i16 - 8_192,
            };
            Weight::from_bits(value)
        }

        fn weights<const COUNT: usize>(&mut self) -> [Weight; COUNT] {
            from_fn(|_| self.weight())
        }

        /// Components so close together that a neuron's action decides the winner.
        fn near<const COUNT: usize>(&mut self) -> [Weight; COUNT] {
            self.weights().map(|weight| weight / 64)
        }
    }

    /// Shares of the neighbors: none, half, all.
    fn updates() -> [Update; 3] {
        [0, 1 << 15, 1 << 16].map(|share| Update::from_q16(Neighborhood::Direct, 13_107, share))
    }

    /// Erases both sectors, and finally saves the newest previous image again as the only one.
    #[test]
    fn a_saved_image_is_loaded_unchanged() {
        free(|section| keep(&mut TEST_BUFFERS.borrow(section).borrow_mut()));
    }

    fn keep(buffers: &mut TestBuffers) {
        let ([before, saved, loaded], [wanted, found]) = buffers;
        let device = pac::Peripherals::take().expect("not taken yet");
        let mut clocks = device.RCC.freeze(rcc::Config::hsi());
        let supply = SupplyMonitor::watch(device.PWR, &mut clocks);
        assert!(!supply.is_low(), "a saved image would not last");
        let mut kept = StoreFlash::new(device.FLASH);
        let mut store = Store::mount(&mut kept, slot_bytes::<HeldRing>());
        let had_image = before.load(&mut store).is_ok();
        assert_eq!(store.erase(), Ok(()));
        assert_eq!(loaded.load(&mut store), Err(FlashError::Empty));
        for number in 1..=3 {
            saved.fill(number, wanted);
            assert_eq!(store.save(&saved.contents()), Ok(()));
            // As after a restart.
            store = Store::mount(&mut kept, slot_bytes::<HeldRing>());
            assert_eq!(store.generation(), u32::from(number));
            assert_eq!(loaded.load(&mut store), Ok(()));
            let length = saved.image(wanted);
            assert_eq!(loaded.image(found), length);
            assert!(wanted[..length] == found[..length]);
        }
        assert_eq!(store.erase(), Ok(()));
        if had_image {
            assert_eq!(store.save(&before.contents()), Ok(()));
        }
    }

    #[test]
    fn the_situation_map_is_the_same_with_the_kernels_in_assembly() {
        let mut rng = TestRng(1);
        for _ in 0..8 {
            let mut portable =
                Som::<16, 16>::new(Grid::rectangle(4, 4), from_fn(|_| rng.weights()));
            let mut simd = portable.clone();
            simd.use_kernels(&KERNELS);
            for update in updates() {
                let probe = rng.weights();
                let winner = portable.bmu(&probe, Mask::ALL);
                assert_eq!(simd.bmu(&probe, Mask::ALL), winner);
                portable.update(winner, &probe, Mask::ALL, &update);
                simd.update(winner, &probe, Mask::ALL, &update);
                assert!(simd == portable);
            }
        }
    }

    #[test]
    fn the_action_map_is_the_same_with_the_kernels_in_assembly() {
        let mut rng = TestRng(2);
        for _ in 0..8 {
            let (code, actions) = (from_fn(|_| rng.near()), from_fn(|_| rng.weights()));
            let mut portable = ActionMap::<16, 16>::new(Grid::rectangle(4, 4), code, actions);
            let mut simd = portable.clone();
            simd.use_kernels(&KERNELS);
            for (update, weight) in updates().into_iter().zip([0, 256, 600]) {
                let effect = Effect {
                    change: rng.near(),
                    action: rng.weights(),
                    mask: Mask::ALL,
                };
                let winner = portable.bmu(&effect, weight);
                assert_eq!(simd.bmu(&effect, weight), winner);
                portable.update(winner, &effect, &update);
                simd.update(winner, &effect, &update);
                assert!(simd == portable);
            }
        }
    }

    /// The check value of CRC-32/ISO-HDLC.
    #[test]
    fn the_checksum_is_the_protocols() {
        assert_eq!(checksum(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    #[cfg(feature = "failing")]
    fn a_failure_is_reported() {
        assert_eq!(checksum(b"123456789"), 0);
    }
}
