use super::sim::SimFlash;
use super::*;
use amp::body::HeldRing;
use amp::config::Config;
use amp::controller::{State, StatePart};
use amp::goal::{Component, Goal, NamedGoals};
use amp::node::Node;
use amp::som::Grid;
use amp::store::ContentsMut;
use std::boxed::Box;
use std::vec;
use std::vec::Vec;

/// Contents that are derived from one number.
struct TestContents<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize> {
    config: Config<SENSORS>,
    state: Box<State<SENSORS, NEURONS, SAMPLES>>,
    goal: Goal<SENSORS>,
    goals: NamedGoals<SENSORS>,
}

type Nomad = TestContents<16, 16, 100>;
/// Its images take some 180 bytes: hundreds of thousands are written in seconds.
type Small = TestContents<4, 2, 2>;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    TestContents<SENSORS, NEURONS, SAMPLES>
{
    fn of(number: u32) -> Self {
        let mut stored = Self {
            config: supervisable(Node::<SENSORS, NEURONS, SAMPLES>::new().config()),
            state: Box::new(State::new(Grid::rectangle(1, 2))),
            goal: Goal::of([Component::ANY; SENSORS]),
            goals: NamedGoals::new(),
        };
        stored.goal.progress_q16 = number as u16;
        let mut bytes = number.to_le_bytes().into_iter().cycle();
        for part in [
            StatePart::Situations,
            StatePart::Changes,
            StatePart::Actions,
            StatePart::Memory,
        ] {
            let length = match part {
                StatePart::Memory => SAMPLES * State::<SENSORS, NEURONS, SAMPLES>::SAMPLE_BYTES,
                _ => stored.state.part_len(part),
            };
            let bytes: Vec<u8> = bytes.by_ref().take(length).collect();
            stored.state.write_part(part, 0, &bytes).expect("a part");
        }
        stored
    }

    fn contents(&self) -> Contents<'_, SENSORS, NEURONS, SAMPLES> {
        Contents {
            body: &HeldRing,
            config: &self.config,
            state: &self.state,
            goal: &self.goal,
            goals: &self.goals,
        }
    }

    /// The image that the store writes for this generation.
    fn image(&self, generation: u32) -> Vec<u8> {
        let mut image = Vec::new();
        let _ = self.contents().write(generation, &mut |bytes| {
            image.extend_from_slice(bytes);
            Ok::<_, ()>(())
        });
        image
    }

    /// The contents of the newest image in the store.
    fn loaded<F: NorFlash>(store: &mut Store<F>) -> Result<Self, FlashError> {
        let mut stored = Self::of(0);
        store.load(|read, most| {
            let mut contents = ContentsMut {
                body: &mut HeldRing,
                config: &mut stored.config,
                state: &mut stored.state,
                goal: &mut stored.goal,
                goals: &mut stored.goals,
            };
            contents.read(read, most).map(drop)
        })?;
        Ok(stored)
    }
}

/// A configuration of zeros, except where a zero would not be loaded.
fn supervisable<const SENSORS: usize>(zeroed: &Config<SENSORS>) -> Config<SENSORS> {
    let mut config = zeroed.clone();
    (config.robot.ring_period_ms, config.robot.speed_mm_s) = (640, 508);
    config.robot.braking_mm_s2 = 762;
    config
}

/// The number of the newest image. Panics unless the image equals one of the candidates.
fn number<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize, F: NorFlash>(
    store: &mut Store<F>,
    candidates: &[u32],
) -> Option<u32> {
    let kept = match TestContents::<SENSORS, NEURONS, SAMPLES>::loaded(store) {
        Ok(stored) => stored.image(1),
        Err(FlashError::Empty) => return None,
        Err(error) => panic!("the store cannot be read: {error}"),
    };
    let same =
        |number: &&u32| TestContents::<SENSORS, NEURONS, SAMPLES>::of(**number).image(1) == kept;
    let found = candidates.iter().find(same);
    Some(*found.expect("a mixture, or something older"))
}

/// For the image of a ring on a held turret.
const NOMAD_SLOT: u32 = slot_bytes::<HeldRing>();
const NOMAD_SECTOR: usize = 2 * NOMAD_SLOT as usize + MARK_BYTES as usize;

fn nomad(flash: SimFlash<NOMAD_SECTOR>) -> Store<SimFlash<NOMAD_SECTOR>> {
    Store::mount(flash, NOMAD_SLOT)
}

#[test]
fn power_loss_at_any_operation_of_a_save_keeps_an_image() {
    let mut store = nomad(SimFlash::new(1));
    let mut cuts = 0;
    // The first save; one beside an older image; one that erases the other sector.
    for save in 1..=3 {
        let (old, new) = (save - 1, save);
        let candidates = if save == 1 { vec![new] } else { vec![old, new] };
        let stored = Nomad::of(new);
        let before = store.flash.clone();
        let mut operations = 0;
        loop {
            let mut flash = before.clone();
            flash.cut_after(operations);
            let mut cut = nomad(flash);
            if cut.save(&stored.contents()).is_ok() {
                break;
            }
            assert!(!cut.flash.has_power());
            let mut flash = cut.flash;
            flash.power_on();
            let mut after = nomad(flash);
            let found = number::<16, 16, 100, _>(&mut after, &candidates);
            assert!(
                found.is_some() || save == 1,
                "save {save}, cut {operations}"
            );
            // A later save succeeds, wherever the first one was interrupted.
            if operations % 16 == 0 {
                after.ensure_free_slot().expect("power is back");
                after.save(&stored.contents()).expect("power is back");
                assert_eq!(number::<16, 16, 100, _>(&mut after, &[new]), Some(new));
            }
            operations += 1;
        }
        cuts += operations;
        store.save(&stored.contents()).expect("there is power");
        assert_eq!(store.generation(), save);
    }
    std::println!("{cuts} cuts");
    assert!(cuts > 3 * 1_000, "{cuts}");
}

const SMALL_SLOT: u32 = 320;

/// Starts and saves until `cuts` runs have lost power at a random operation. Returns how many
/// of them left the old image, and how many the new one.
fn cut_again_and_again<const SECTOR: usize>(cuts: u32, seed: u64) -> [u32; 2] {
    let mut flash = SimFlash::<SECTOR>::new(seed);
    let mut kept = None;
    let mut counts = [0; 2];
    let mut attempt = 0_u32;
    let words = Small::of(1).image(1).len() as u32 / 4;
    while counts[0] + counts[1] < cuts {
        attempt += 1;
        // An erasure and its mark are 1 + 3 operations. Cuts are early, anywhere, or near the end.
        let operations = match flash.below(3) {
            0 => flash.below(6),
            1 => flash.below(words + 4),
            _ => words - 1 + 4 * flash.below(2),
        };
        flash.cut_after(operations);
        let mut store = Store::mount(flash, SMALL_SLOT);
        let stored = Small::of(attempt);
        let saved = store
            .ensure_free_slot()
            .and_then(|()| store.save(&stored.contents()));
        let lost = !store.flash.has_power();
        assert_eq!(saved.is_ok(), !lost, "only the cut makes it fail");
        flash = store.flash;
        flash.power_on();
        let mut store = Store::mount(flash, SMALL_SLOT);
        let candidates: Vec<u32> = kept.into_iter().chain([attempt]).collect();
        let found = number::<4, 2, 2, _>(&mut store, &candidates);
        assert!(lost || found == Some(attempt));
        assert!(found.is_some() || kept.is_none(), "what was kept is gone");
        if lost {
            counts[usize::from(found == Some(attempt))] += 1;
        }
        kept = found;
        flash = store.flash;
    }
    counts
}

/// 200 000 cuts. Most follow each other without a complete save between them, so a cut also
/// strikes the run that recovers from the cut before.
#[test]
fn power_loss_again_and_again_keeps_an_image() {
    let mut all = [0; 2];
    for seed in 0..10 {
        for counts in [
            cut_again_and_again::<332>(10_000, seed),
            cut_again_and_again::<{ 12 + 3 * 320 }>(10_000, 100 + seed),
        ] {
            assert!(counts[0] > 1_000 && counts[1] > 20, "{counts:?}");
            all = [all[0] + counts[0], all[1] + counts[1]];
        }
    }
    std::println!("{} left the old image, {} the new one", all[0], all[1]);
}

#[test]
fn an_interrupted_erasure_leaves_whole_images() {
    let mut store = nomad(SimFlash::new(4));
    for number in 1..=3 {
        store.save(&Nomad::of(number).contents()).expect("room");
    }
    let before = store.flash.clone();
    for operations in 0..5 {
        let mut flash = before.clone();
        flash.cut_after(operations);
        let mut store = nomad(flash);
        let erased = store.erase();
        assert_eq!(erased.is_ok(), store.flash.has_power());
        let mut flash = store.flash;
        flash.power_on();
        let mut store = nomad(flash);
        // The newest image goes last; whichever image is left is whole.
        let _ = number::<16, 16, 100, _>(&mut store, &[1, 2, 3]);
        store.save(&Nomad::of(9).contents()).expect("room");
        assert_eq!(number::<16, 16, 100, _>(&mut store, &[9]), Some(9));
    }
    let erasures = before.erasures.iter().sum::<u32>();
    let mut store = nomad(before);
    assert_eq!(store.pause_ms(FlashOperation::Erase), 2 * ERASE_MS);
    assert_eq!(store.erase(), Ok(()));
    assert_eq!(store.flash.erasures.iter().sum::<u32>(), erasures + 2);
    assert_eq!(number::<16, 16, 100, _>(&mut store, &[]), None);
    assert_eq!(store.pause_ms(FlashOperation::Save), 207, "there is room");
    assert_eq!(nomad(store.flash).generation(), 0);
}

#[test]
fn a_save_erases_only_when_a_sector_has_filled_since_the_start() {
    const SECTOR: usize = MARK_BYTES as usize + 15 * SMALL_SLOT as usize;
    let mut flash = SimFlash::<SECTOR>::new(6);
    for number in 1..=150 {
        let mut store = Store::mount(flash, SMALL_SLOT);
        store.ensure_free_slot().expect("there is power");
        assert_eq!(
            store.pause_ms(FlashOperation::Save),
            8,
            "room after each start"
        );
        store.save(&Small::of(number).contents()).expect("room");
        flash = store.flash;
    }
    // One erasure at the first start, and one for each sector of fifteen slots that had filled.
    assert_eq!(flash.erasures, [5, 5]);
    let mut store = Store::mount(flash, SMALL_SLOT);
    assert_eq!(store.pause_ms(FlashOperation::Save), 8 + ERASE_MS);
    store.save(&Small::of(151).contents()).expect("room");
    assert_eq!(store.flash.erasures, [6, 5]);
    // The previous image is in the other sector: it becomes the newest.
    assert_eq!(store.erase_sector(0), Ok(()));
    let mut store = Store::mount(store.flash, SMALL_SLOT);
    assert_eq!(number::<4, 2, 2, _>(&mut store, &[150]), Some(150));
}
