//! Writes a controller as an image.

use super::*;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize, B: Body<SENSORS>>
    Contents<'_, SENSORS, NEURONS, SAMPLES, B>
{
    /// Writes the image of this generation, front to back, each time a whole record of at most 256
    /// bytes and a multiple of [`WORD`]. No more than one of them is in memory.
    ///
    /// # Errors
    /// The sink's.
    pub fn write<E>(
        &self,
        generation: u32,
        sink: &mut impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut digest = Checksum::new();
        digest.update(&MAGIC);
        sink(&MAGIC)?;
        // One copy of the code for all records.
        let put: &mut dyn FnMut(&Draft) -> Result<(), E> = &mut |record| {
            digest.update(record.as_bytes());
            sink(record.as_bytes())
        };
        put(&self.head(generation))?;
        let mut buffer = [0; MAX_CONFIG];
        let config = self.config.to_bytes(&mut buffer);
        for (index, bytes) in config.chunks(MAX_CHUNK).enumerate() {
            put(&piece(whole::CONFIG, index.wrapping_mul(MAX_CHUNK), bytes))?;
        }
        let body = self.body.to_bytes(&mut buffer);
        for (index, bytes) in body.chunks(MAX_CHUNK).enumerate() {
            put(&piece(whole::BODY, index.wrapping_mul(MAX_CHUNK), bytes))?;
        }
        let parts = (1..).zip(PARTS.map(Some)).chain([(PLACES, None)]);
        for part in parts {
            let mut offset = 0_usize;
            while let Some((record, count)) = self.piece(part, offset) {
                put(&record)?;
                offset = offset.saturating_add(count);
            }
        }
        if let Some(seed) = self.state.next_seed() {
            put(&Draft::of(kind::RANDOM, &[&seed.to_le_bytes()]))?;
        }
        put(&goal(Name::NONE, self.goal))?;
        for named in self.goals.as_slice() {
            put(&goal(named.name, &named.goal))?;
        }
        let crc = digest.finalize().to_le_bytes();
        sink(Draft::of(kind::END, &[&crc]).as_bytes())
    }

    fn head(&self, generation: u32) -> Draft {
        let samples = self.state.memory().samples().len() as u16;
        let fields: [&[u8]; 5] = [
            &LAYOUT.to_le_bytes(),
            &GRAMMAR.to_le_bytes(),
            &generation.to_le_bytes(),
            &[SENSORS as u8, NEURONS as u8],
            &samples.to_le_bytes(),
        ];
        Draft::of(kind::HEAD, &fields)
    }

    /// The piece of a part from `offset` on, and its bytes, if it has any; `None` = of the places.
    fn piece(
        &self,
        (number, part): (u8, Option<StatePart>),
        offset: usize,
    ) -> Option<(Draft, usize)> {
        let sample = State::<SENSORS, NEURONS, SAMPLES>::SAMPLE_BYTES;
        let mut buffer = [0; MAX_CHUNK];
        let count = match part {
            None => {
                let most = places_piece::<SENSORS, B>();
                self.body.read_places(offset, buffer.get_mut(..most)?)
            }
            // Pieces of the memory end where samples do.
            Some(part @ StatePart::Memory) => {
                let most = MAX_CHUNK.checked_div(sample)?.wrapping_mul(sample);
                self.state.read_part(part, offset, buffer.get_mut(..most)?)
            }
            Some(_) if !self.state.has_learned() => 0,
            Some(part) => self.state.read_part(part, offset, &mut buffer),
        };
        let bytes = buffer.get(..count).filter(|bytes| !bytes.is_empty())?;
        Some((piece(number, offset, bytes), count))
    }
}

#[inline(never)]
fn piece(part: u8, offset: usize, bytes: &[u8]) -> Draft {
    let offset = (offset as u16).to_le_bytes();
    Draft::of(kind::CHUNK, &[&[part], &offset, bytes])
}

#[inline(never)]
fn goal<const SENSORS: usize>(name: Name, goal: &Goal<SENSORS>) -> Draft {
    let mut buffer = [0; MAX_RECORD];
    let bytes = postcard::to_slice(goal, &mut buffer).map_or(&[][..], |bytes| bytes);
    Draft::of(kind::GOAL, &[&name.to_bytes(), bytes])
}

/// A record that is being written.
struct Draft {
    bytes: [u8; MAX_RECORD],
    length: usize,
}

impl Draft {
    /// A record of this kind with these fields. None is too long for its room: a piece takes 164
    /// bytes, a goal of 32 transducers at most 248.
    #[inline(never)]
    fn of(kind: u8, fields: &[&[u8]]) -> Self {
        let mut draft = Self {
            bytes: [0; MAX_RECORD],
            length: 1,
        };
        for field in [&[kind][..]].iter().chain(fields) {
            let end = draft.length.saturating_add(field.len());
            if let Some(place) = draft.bytes.get_mut(draft.length..end) {
                for (place, byte) in place.iter_mut().zip(*field) {
                    *place = *byte;
                }
                draft.length = end;
            }
        }
        if let Some(length) = draft.bytes.first_mut() {
            *length = draft.length.wrapping_sub(1) as u8;
        }
        draft
    }

    /// The record with its zeros.
    fn as_bytes(&self) -> &[u8] {
        let whole = self.length.next_multiple_of(WORD);
        self.bytes.get(..whole).unwrap_or(&[])
    }
}
