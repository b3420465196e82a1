//! Reads an image into a controller.

use super::*;

/// Properties of a complete image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageInfo {
    /// Its generation; the higher, the newer.
    pub generation: u32,
    /// Its length in bytes.
    pub bytes: usize,
}

/// Why an image was not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageError {
    /// They could not be read.
    Source,
    /// They are no whole image: never finished, cut off or damaged.
    Torn,
    /// Another version of the program wrote them.
    Version,
    /// They are of a robot with another ring, other maps, or more samples.
    Dimensions,
}

impl core::fmt::Display for ImageError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Source => "it cannot be read",
            Self::Torn => "it is cut off or damaged",
            Self::Version => "it was written by another version of this program",
            Self::Dimensions => "it is of a mind with other sonars, neurons or more samples",
        })
    }
}

impl core::error::Error for ImageError {}

/// Reads bytes from a place on; false if they cannot be had.
type Read<'r> = &'r mut dyn FnMut(usize, &mut [u8]) -> bool;

/// Looks whether there is a whole image in the first `most` bytes; any version's.
///
/// # Errors
/// [`ImageError::Torn`] if there is none, [`ImageError::Source`].
pub fn check(read: Read<'_>, most: usize) -> Result<ImageInfo, ImageError> {
    look(read, most).map(|(head, bytes)| ImageInfo {
        generation: head.generation,
        bytes,
    })
}

/// The first record, the image's length.
#[inline(never)]
fn look(read: Read<'_>, most: usize) -> Result<(Head, usize), ImageError> {
    let mut digest = Checksum::new();
    let mut walk = RecordReader::begin(read, most)?;
    digest.update(&MAGIC);
    walk.next(read)?;
    digest.update(walk.bytes());
    let Some(ImageRecord::Head(head)) = ImageRecord::parse(walk.body()) else {
        return Err(ImageError::Torn);
    };
    loop {
        walk.next(read)?;
        if let Some(ImageRecord::End(crc)) = ImageRecord::parse(walk.body()) {
            let whole = crc == digest.finalize();
            return whole.then_some((head, walk.at)).ok_or(ImageError::Torn);
        }
        digest.update(walk.bytes());
    }
}

/// The content of a record.
enum ImageRecord<'a> {
    Head(Head),
    Chunk {
        part: u8,
        offset: u16,
        bytes: &'a [u8],
    },
    Random(u64),
    Goal {
        name: Name,
        goal: &'a [u8],
    },
    End(u32),
}

impl<'a> ImageRecord<'a> {
    /// `None` for a kind that later versions may have, and for too few bytes.
    fn parse(body: &'a [u8]) -> Option<Self> {
        let (kind, rest) = body.split_first()?;
        let mut rest = RecordFields(rest);
        Some(match *kind {
            // Stands for good.
            kind::HEAD => Self::Head(Head {
                layout: u16::from_le_bytes(rest.take()?),
                grammar: u32::from_le_bytes(rest.take()?),
                generation: u32::from_le_bytes(rest.take()?),
                sensors: u8::from_le_bytes(rest.take()?),
                neurons: u8::from_le_bytes(rest.take()?),
                samples: u16::from_le_bytes(rest.take()?),
            }),
            kind::CHUNK => Self::Chunk {
                part: u8::from_le_bytes(rest.take()?),
                offset: u16::from_le_bytes(rest.take()?),
                bytes: rest.0,
            },
            kind::RANDOM => Self::Random(u64::from_le_bytes(rest.take()?)),
            kind::GOAL => Self::Goal {
                name: Name::from_bytes(rest.take()?),
                goal: rest.0,
            },
            kind::END => Self::End(u32::from_le_bytes(rest.take()?)),
            _ => return None,
        })
    }
}

/// What is left of a record.
pub(crate) struct RecordFields<'a>(pub(crate) &'a [u8]);

impl RecordFields<'_> {
    /// Its next bytes; `None` if there are fewer.
    pub(crate) fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }
}

/// Goes from record to record.
struct RecordReader {
    at: usize,
    most: usize,
    buffer: [u8; MAX_RECORD],
    /// Lengths of the record just read: its body's and its own.
    body: usize,
    length: usize,
}

impl RecordReader {
    fn begin(read: Read<'_>, most: usize) -> Result<Self, ImageError> {
        let mut magic = [0; WORD];
        if most < WORD || !read(0, &mut magic) {
            return Err(ImageError::Source);
        }
        if magic != MAGIC {
            return Err(ImageError::Torn);
        }
        Ok(Self {
            at: WORD,
            most,
            buffer: [0; MAX_RECORD],
            body: 0,
            length: 0,
        })
    }

    /// Reads the next record.
    fn next(&mut self, read: Read<'_>) -> Result<(), ImageError> {
        let left = self.most.saturating_sub(self.at);
        let first = self.buffer.get_mut(..WORD).ok_or(ImageError::Torn)?;
        if left < WORD {
            return Err(ImageError::Torn);
        }
        if !read(self.at, first) {
            return Err(ImageError::Source);
        }
        let body = usize::from(first.first().copied().unwrap_or(0));
        let whole = body.wrapping_add(1).next_multiple_of(WORD);
        if body == 0 || whole > left {
            return Err(ImageError::Torn);
        }
        let rest = self.buffer.get_mut(WORD..whole).ok_or(ImageError::Torn)?;
        if !rest.is_empty() && !read(self.at.wrapping_add(WORD), rest) {
            return Err(ImageError::Source);
        }
        self.at = self.at.wrapping_add(whole);
        (self.body, self.length) = (body, whole);
        let zeros = self.bytes().iter().skip(body).skip(1);
        zeros
            .copied()
            .all(|byte| byte == 0)
            .then_some(())
            .ok_or(ImageError::Torn)
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

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize, B: Body<SENSORS>>
    ContentsMut<'_, SENSORS, NEURONS, SAMPLES, B>
{
    /// Replaces everything by the image's content. The robot has to stand still.
    ///
    /// # Errors
    /// [`ImageError`]; nothing has changed then, except by a sound image with invalid content: that
    /// leaves an empty state, with [`ImageError::Version`].
    pub fn read(&mut self, read: Read<'_>, most: usize) -> Result<ImageInfo, ImageError> {
        let (head, bytes) = look(read, most)?;
        if head.layout != LAYOUT || head.grammar != GRAMMAR {
            return Err(ImageError::Version);
        }
        let ours = (SENSORS as u8, NEURONS as u8);
        if (head.sensors, head.neurons) != ours || usize::from(head.samples) > SAMPLES {
            return Err(ImageError::Dimensions);
        }
        let mut buffer = [0; MAX_CONFIG];
        let config = read_whole(read, most, whole::CONFIG, &mut buffer)?;
        let config = Config::from_bytes(config).ok_or(ImageError::Version)?;
        let body = read_whole(read, most, whole::BODY, &mut buffer)?;
        if !self.body.replace(body) {
            return Err(ImageError::Dimensions);
        }
        *self.config = config;
        self.forget();
        let taken = self.take_all(read, most);
        if taken.is_none() {
            self.forget();
        }
        let generation = head.generation;
        taken.ok_or(ImageError::Version)?;
        Ok(ImageInfo { generation, bytes })
    }

    /// Nothing is known but the configuration and the body.
    #[inline(never)]
    fn forget(&mut self) {
        self.state.forget();
        let _ = self.body.write_places(0, &[]);
        self.goals.clear();
        *self.goal = Goal::avoiding(self.config);
    }

    fn take_all(&mut self, read: Read<'_>, most: usize) -> Option<()> {
        let mut walk = RecordReader::begin(read, most).ok()?;
        loop {
            walk.next(read).ok()?;
            match ImageRecord::parse(walk.body())? {
                ImageRecord::Head(_)
                | ImageRecord::Chunk {
                    part: whole::CONFIG | whole::BODY,
                    ..
                } => {}
                // A body without a memory of places, or with a smaller one, leaves the rest out.
                ImageRecord::Chunk {
                    part: PLACES,
                    offset,
                    bytes,
                } => {
                    let _ = self.body.write_places(offset.into(), bytes);
                }
                ImageRecord::Chunk {
                    part,
                    offset,
                    bytes,
                } => {
                    let part = PARTS.get(usize::from(part).wrapping_sub(1))?;
                    self.state.write_part(*part, offset.into(), bytes).ok()?;
                }
                ImageRecord::Random(seed) => self.state.seed(seed),
                ImageRecord::Goal { name, goal } => {
                    let goal = postcard::from_bytes(goal).ok()?;
                    if name == Name::NONE {
                        *self.goal = goal;
                    } else {
                        self.goals.save(NamedGoal { name, goal }).ok()?;
                    }
                }
                ImageRecord::End(_) => return Some(()),
            }
        }
    }
}

/// The bytes of a part in an image.
fn read_whole<'b>(
    read: Read<'_>,
    most: usize,
    number: u8,
    buffer: &'b mut [u8; MAX_CONFIG],
) -> Result<&'b [u8], ImageError> {
    let mut length = 0_usize;
    let mut walk = RecordReader::begin(read, most)?;
    loop {
        walk.next(read)?;
        match ImageRecord::parse(walk.body()) {
            Some(ImageRecord::Chunk { part, bytes, .. }) if part == number => {
                let end = length.saturating_add(bytes.len());
                let place = buffer.get_mut(length..end).ok_or(ImageError::Version)?;
                for (place, byte) in place.iter_mut().zip(bytes) {
                    *place = *byte;
                }
                length = end;
            }
            Some(ImageRecord::End(_)) => break,
            _ => {}
        }
    }
    Ok(buffer.get(..length).unwrap_or(&[]))
}
