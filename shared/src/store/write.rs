//! From a mind to an image.

use super::*;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    Contents<'_, SENSORS, NEURONS, SAMPLES>
{
    /// Writes the image of this generation, front to back, each time whole records of at most 256 bytes and a multiple of
    /// [`WORD`]. No more than one of them is in memory.
    ///
    /// # Errors
    /// The sink's.
    pub fn write<E>(
        &self,
        generation: u32,
        sink: &mut impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut digest = CRC.digest();
        {
            let mut put = |bytes: &[u8]| {
                digest.update(bytes);
                sink(bytes)
            };
            put(&MAGIC)?;
            let mut put = |record: &Record<SENSORS>| put(packed(record, &mut [0; MOST_RECORD]));
            put(&Record::Head(Head {
                layout: LAYOUT,
                grammar: GRAMMAR,
                generation,
                sensors: SENSORS as u8,
                neurons: NEURONS as u8,
                samples: self.state.memory().samples().len() as u16,
            }))?;
            self.config(&mut put)?;
            self.state(&mut put)?;
            self.goals(&mut put)?;
        }
        let crc = digest.finalize().to_le_bytes();
        let end: Record<SENSORS> = Record::End { crc };
        sink(packed(&end, &mut [0; MOST_RECORD]))
    }

    fn config<E>(&self, put: &mut impl FnMut(&Record<SENSORS>) -> Result<(), E>) -> Result<(), E> {
        let mut buffer = [0; MOST_CONFIG];
        let whole = postcard::to_slice(self.config, &mut buffer).map_or(&[][..], |bytes| bytes);
        for (index, bytes) in whole.chunks(MOST_PIECE).enumerate() {
            put(&Record::Piece {
                part: Part::Config,
                offset: index.wrapping_mul(MOST_PIECE) as u16,
                bytes,
            })?;
        }
        Ok(())
    }

    fn state<E>(&self, put: &mut impl FnMut(&Record<SENSORS>) -> Result<(), E>) -> Result<(), E> {
        let samples = MOST_PIECE
            .checked_div(State::<SENSORS, NEURONS, SAMPLES>::SAMPLE_BYTES)
            .unwrap_or(0);
        // Pieces of the memory end where samples do.
        let most = samples.wrapping_mul(State::<SENSORS, NEURONS, SAMPLES>::SAMPLE_BYTES);
        for (part, ours) in STATE_PARTS {
            let is_memory = part == Part::Memory;
            if !is_memory && !self.state.has_learnt() {
                continue;
            }
            let mut buffer = [0; MOST_PIECE];
            let most = if is_memory { most } else { MOST_PIECE };
            let piece = buffer.get_mut(..most).unwrap_or(&mut []);
            let mut offset = 0_usize;
            loop {
                let count = self.state.read_part(ours, offset, piece);
                if count == 0 {
                    break;
                }
                put(&Record::Piece {
                    part,
                    offset: offset as u16,
                    bytes: piece.get(..count).unwrap_or(&[]),
                })?;
                offset = offset.saturating_add(count);
            }
        }
        let seed = self.state.next_seed();
        seed.map_or(Ok(()), |seed| put(&Record::Random { seed }))
    }

    fn goals<E>(&self, put: &mut impl FnMut(&Record<SENSORS>) -> Result<(), E>) -> Result<(), E> {
        put(&Record::Goal(KeptGoal {
            name: Name::NONE,
            goal: *self.goal,
        }))?;
        for kept in self.kept.as_slice() {
            put(&Record::Goal(*kept))?;
        }
        Ok(())
    }
}

/// A record with its length and zeros. Nothing if it is too long, which none is: a piece takes 167 bytes, a goal of 32
/// transducers with the dearest of numbers 249.
fn packed<'b, const SENSORS: usize>(
    record: &Record<SENSORS>,
    buffer: &'b mut [u8; MOST_RECORD],
) -> &'b [u8] {
    let Some((length, rest)) = buffer.split_first_mut() else {
        return &[];
    };
    let Ok(used) = postcard::to_slice(record, rest).map(|used| used.len()) else {
        return &[];
    };
    // At most 255.
    *length = used as u8;
    let whole = used.wrapping_add(1).next_multiple_of(WORD);
    buffer.get(..whole).unwrap_or(&[])
}
