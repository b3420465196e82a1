//! The kernels and what outlives a loss of power: on a board, and on an emulated chip.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("These tests are for the chip: firmware/README.md says how to run them.");
}

#[cfg(target_os = "none")]
#[embedded_test::tests]
mod tests {
    use amp::action_map::{ActionMap, Effect};
    use amp::config::Config;
    use amp::controller::{State, StatePart};
    use amp::fixed::{Mask, Weight};
    use amp::goal::{Component, Goal, NamedGoals};
    use amp::som::neighborhood::Update;
    use amp::som::{Grid, Neighborhood, Som};
    use amp::store::{Contents, ContentsMut, MAX_NOMAD};
    use amp::wire::checksum;
    use amp::wire::message::FlashError;
    use core::array::from_fn;
    use core::cell::RefCell;
    use cortex_m::interrupt::{Mutex, free};
    use cortex_m4::KERNELS;
    use firmware::persist::{SLOT_BYTES, Store};
    use stm32f4xx_hal::pac;
    use stm32f4xx_hal::rcc::{self, RccExt};
    use stm32f405::chip::Supply;
    use stm32f405::flash::Kept;

    /// What a flash keeps.
    struct Mind {
        config: Config<16>,
        state: State<16, 16, 100>,
        goal: Goal<16>,
        kept: NamedGoals<16>,
    }

    impl Mind {
        const fn new() -> Self {
            Self {
                config: Config::recommended(),
                state: State::new(Grid::rectangle(4, 4)),
                goal: Goal::of([Component::ANY; 16]),
                kept: NamedGoals::new(),
            }
        }

        /// Fills maps and memory with bytes that are told by this number.
        fn fill(&mut self, number: u8, room: &mut Image) {
            for (place, byte) in room.iter_mut().enumerate() {
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
                let written = self.state.write_part(part, 0, &room[..length]);
                assert!(written.is_ok());
            }
        }

        fn contents(&self) -> Contents<'_, 16, 16, 100> {
            Contents {
                config: &self.config,
                state: &self.state,
                goal: &self.goal,
                kept: &self.kept,
            }
        }

        /// Becomes what was saved last.
        fn recall(&mut self, store: &mut Store<&mut Kept>) -> Result<(), FlashError> {
            store.recall(|read, most| {
                let mut contents = ContentsMut {
                    config: &mut self.config,
                    state: &mut self.state,
                    goal: &mut self.goal,
                    kept: &mut self.kept,
                };
                contents.read(read, most).map(drop)
            })
        }

        /// The image it would be saved as, and its length.
        fn image(&self, room: &mut Image) -> usize {
            let mut length = 0;
            let written = self.contents().write(1, &mut |bytes| {
                let end = length + bytes.len();
                room[length..end].copy_from_slice(bytes);
                length = end;
                Ok::<_, ()>(())
            });
            assert!(written.is_ok());
            length
        }
    }

    type Image = [u8; MAX_NOMAD];

    /// Too large for the stack: what was saved before, is saved, is recalled; and images of the latter two.
    type Room = ([Mind; 3], [Image; 2]);

    static ROOM: Mutex<RefCell<Room>> = Mutex::new(RefCell::new((
        [const { Mind::new() }; 3],
        [[0; MAX_NOMAD]; 2],
    )));

    /// Numbers in no order (G. Marsaglia, Xorshift RNGs, 2003).
    struct Noise(u32);

    impl Noise {
        /// A component from -1 to 1; every fourth one is an end of that range.
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

        /// So close together that a neuron's action decides who wins.
        fn near<const COUNT: usize>(&mut self) -> [Weight; COUNT] {
            self.weights().map(|weight| weight / 64)
        }
    }

    /// Alone, with half as much for the neighbors, and with all of it.
    fn pulls() -> [Update<16>; 3] {
        [0, 1 << 15, 1 << 16].map(|share| Update::new(Neighborhood::Direct, 13_107, share))
    }

    /// Erases both sectors; what was saved last is saved again at the end, as the only image.
    #[test]
    fn an_image_outlives_erasing_and_saving() {
        free(|section| keep(&mut ROOM.borrow(section).borrow_mut()));
    }

    fn keep(room: &mut Room) {
        let ([before, saved, recalled], [wanted, found]) = room;
        let device = pac::Peripherals::take().expect("nobody has them");
        let mut clocks = device.RCC.freeze(rcc::Config::hsi());
        let supply = Supply::watch(device.PWR, &mut clocks);
        assert!(!supply.is_low(), "a saved image would not last");
        let mut kept = Kept::new(device.FLASH);
        let mut store = Store::mount(&mut kept, SLOT_BYTES);
        let was_there = before.recall(&mut store).is_ok();
        assert_eq!(store.erase(), Ok(()));
        assert_eq!(recalled.recall(&mut store), Err(FlashError::Empty));
        for number in 1..=3 {
            saved.fill(number, wanted);
            assert_eq!(store.save(&saved.contents()), Ok(()));
            // As a new start finds it.
            store = Store::mount(&mut kept, SLOT_BYTES);
            assert_eq!(store.generation(), u32::from(number));
            assert_eq!(recalled.recall(&mut store), Ok(()));
            let length = saved.image(wanted);
            assert_eq!(recalled.image(found), length);
            assert!(wanted[..length] == found[..length]);
        }
        assert_eq!(store.erase(), Ok(()));
        if was_there {
            assert_eq!(store.save(&before.contents()), Ok(()));
        }
    }

    #[test]
    fn the_situation_map_is_the_same_with_the_kernels_in_assembly() {
        let mut noise = Noise(1);
        for _ in 0..8 {
            let mut portable =
                Som::<16, 16>::new(Grid::rectangle(4, 4), from_fn(|_| noise.weights()));
            let mut by_hand = portable.clone();
            by_hand.use_kernels(&KERNELS);
            for pull in pulls() {
                let probe = noise.weights();
                let winner = portable.winner(&probe, Mask::ALL);
                assert_eq!(by_hand.winner(&probe, Mask::ALL), winner);
                let alignments = portable.alignments(&probe, Mask::ALL);
                assert_eq!(by_hand.alignments(&probe, Mask::ALL), alignments);
                portable.learn(winner, &probe, Mask::ALL, &pull);
                by_hand.learn(winner, &probe, Mask::ALL, &pull);
                assert!(by_hand == portable);
            }
        }
    }

    #[test]
    fn the_action_map_is_the_same_with_the_kernels_in_assembly() {
        let mut noise = Noise(2);
        for _ in 0..8 {
            let (code, actions) = (from_fn(|_| noise.near()), from_fn(|_| noise.weights()));
            let mut portable = ActionMap::<16, 16>::new(Grid::rectangle(4, 4), code, actions);
            let mut by_hand = portable.clone();
            by_hand.use_kernels(&KERNELS);
            for (pull, weight) in pulls().into_iter().zip([0, 256, 512]) {
                let effect = Effect {
                    change: noise.near(),
                    action: noise.weights(),
                    mask: Mask::ALL,
                };
                let winner = portable.winner(&effect, weight);
                assert_eq!(by_hand.winner(&effect, weight), winner);
                portable.learn(winner, &effect, &pull);
                by_hand.learn(winner, &effect, &pull);
                assert!(by_hand == portable);
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
