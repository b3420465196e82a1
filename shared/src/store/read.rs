//! From an image to a mind.

use super::*;

/// What a whole image says of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Found {
    /// Its generation; the higher, the newer.
    pub generation: u32,
    /// Its length in bytes.
    pub bytes: usize,
}

/// Why bytes were not read into a mind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// They could not be read.
    Source,
    /// They are no whole image: never finished, cut off or damaged.
    Torn,
    /// Another version of the program wrote them.
    Version,
    /// They are of a robot with another ring, other maps, or more samples.
    Dimensions,
}

impl core::fmt::Display for Fault {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Source => "it cannot be read",
            Self::Torn => "it is cut off or damaged",
            Self::Version => "it was written by another version of this program",
            Self::Dimensions => "it is of a mind with other sonars, neurons or more samples",
        })
    }
}

impl core::error::Error for Fault {}

/// Reads bytes from a place on; false if they cannot be had.
type Read<'r> = &'r mut dyn FnMut(usize, &mut [u8]) -> bool;

/// Looks whether there is a whole image in the first `most` bytes; any version's.
///
/// # Errors
/// [`Fault::Torn`] if there is none, [`Fault::Source`].
pub fn check(read: Read<'_>, most: usize) -> Result<Found, Fault> {
    look(read, most).map(|(_, bytes, generation)| Found { generation, bytes })
}

/// The first record, if it can be read at all; the image's length; its generation.
fn look(read: Read<'_>, most: usize) -> Result<(Option<Head>, usize, u32), Fault> {
    let mut digest = CRC.digest();
    let mut walk = Walk::begin(read, most)?;
    digest.update(&MAGIC);
    walk.next(read)?;
    digest.update(walk.bytes());
    // Its generation stands where it always does, whatever else has changed.
    let head = match postcard::take_from_bytes::<Record<0>>(walk.body()) {
        Ok((Record::Head(head), _)) => head,
        _ => return Err(Fault::Torn),
    };
    loop {
        walk.next(read)?;
        if let [END, crc @ ..] = walk.body()
            && crc.len() == size_of::<u32>()
        {
            let whole = *crc == digest.finalize().to_le_bytes();
            let known = (head.layout, head.grammar) == (LAYOUT, GRAMMAR);
            let found = (known.then_some(head), walk.at, head.generation);
            return whole.then_some(found).ok_or(Fault::Torn);
        }
        digest.update(walk.bytes());
    }
}

/// Goes from record to record.
struct Walk {
    at: usize,
    most: usize,
    buffer: [u8; MOST_RECORD],
    /// Lengths of the record just read: its body's and its own.
    body: usize,
    length: usize,
}

impl Walk {
    fn begin(read: Read<'_>, most: usize) -> Result<Self, Fault> {
        let mut magic = [0; WORD];
        if most < WORD || !read(0, &mut magic) {
            return Err(Fault::Source);
        }
        if magic != MAGIC {
            return Err(Fault::Torn);
        }
        Ok(Self {
            at: WORD,
            most,
            buffer: [0; MOST_RECORD],
            body: 0,
            length: 0,
        })
    }

    /// Reads the next record.
    fn next(&mut self, read: Read<'_>) -> Result<(), Fault> {
        let left = self.most.saturating_sub(self.at);
        let first = self.buffer.get_mut(..WORD).ok_or(Fault::Torn)?;
        if left < WORD {
            return Err(Fault::Torn);
        }
        if !read(self.at, first) {
            return Err(Fault::Source);
        }
        let body = usize::from(first.first().copied().unwrap_or(0));
        let whole = body.wrapping_add(1).next_multiple_of(WORD);
        if body == 0 || whole > left {
            return Err(Fault::Torn);
        }
        let rest = self.buffer.get_mut(WORD..whole).ok_or(Fault::Torn)?;
        if !rest.is_empty() && !read(self.at.wrapping_add(WORD), rest) {
            return Err(Fault::Source);
        }
        self.at = self.at.wrapping_add(whole);
        (self.body, self.length) = (body, whole);
        Ok(())
    }

    /// The body of the record just read.
    fn body(&self) -> &[u8] {
        self.buffer.get(1..=self.body).unwrap_or(&[])
    }

    /// The whole record, length and zeros included.
    fn bytes(&self) -> &[u8] {
        self.buffer.get(..self.length).unwrap_or(&[])
    }
}

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    ContentsMut<'_, SENSORS, NEURONS, SAMPLES>
{
    /// Replaces everything by what the image says. The mind has to stand still.
    ///
    /// # Errors
    /// [`Fault`]; nothing has changed then, except by an image that is sound and yet none of a program's: that leaves a mind
    /// as new, with [`Fault::Version`].
    pub fn read(&mut self, read: Read<'_>, most: usize) -> Result<Found, Fault> {
        let (head, bytes, generation) = look(read, most)?;
        let head = head.ok_or(Fault::Version)?;
        let ours = (SENSORS as u8, NEURONS as u8);
        if (head.sensors, head.neurons) != ours || usize::from(head.samples) > SAMPLES {
            return Err(Fault::Dimensions);
        }
        *self.config = told(read, most)?;
        self.state.forget();
        self.kept.clear();
        *self.goal = Goal::avoiding(self.config);
        let mut walk = Walk::begin(read, most)?;
        loop {
            walk.next(read)?;
            let record = postcard::from_bytes(walk.body()).map_err(|_| Fault::Version);
            match record.and_then(|record| self.take(record)) {
                Ok(true) => return Ok(Found { generation, bytes }),
                Ok(false) => {}
                Err(fault) => {
                    self.state.forget();
                    return Err(fault);
                }
            }
        }
    }

    /// Takes a record; true for the last.
    fn take(&mut self, record: Record<'_, SENSORS>) -> Result<bool, Fault> {
        match record {
            Record::Head(_) => {}
            Record::Piece {
                part,
                offset,
                bytes,
            } => {
                let known = STATE_PARTS.iter().find(|(known, _)| *known == part);
                if let Some((_, ours)) = known {
                    let written = self.state.write_part(*ours, offset.into(), bytes);
                    written.map_err(|_| Fault::Version)?;
                }
            }
            Record::Random { seed } => self.state.seed(seed),
            Record::Goal(kept) if kept.name == Name::NONE => *self.goal = kept.goal,
            Record::Goal(kept) => self.kept.keep(kept).map_err(|_| Fault::Version)?,
            Record::End { .. } => return Ok(true),
        }
        Ok(false)
    }
}

/// The configuration in an image.
fn told<const SENSORS: usize>(read: Read<'_>, most: usize) -> Result<Config<SENSORS>, Fault> {
    let mut staged = Vec::<u8, MOST_CONFIG>::new();
    let mut walk = Walk::begin(read, most)?;
    loop {
        walk.next(read)?;
        match postcard::from_bytes::<Record<SENSORS>>(walk.body()) {
            Ok(Record::Head(_)) => {}
            Ok(Record::Piece {
                part: Part::Config,
                bytes,
                ..
            }) => staged
                .extend_from_slice(bytes)
                .map_err(|_| Fault::Version)?,
            _ => break,
        }
    }
    postcard::from_bytes(&staged).map_err(|_| Fault::Version)
}
