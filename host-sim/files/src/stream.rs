//! Reads a pipe or device with time limits, in a thread: opening and reading may block forever.

use std::fs::File;
use std::io::{self, ErrorKind, Read as _};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

/// Time limits of all streams.
const STREAM_LIMITS: StreamLimits = StreamLimits {
    writer: Duration::from_secs(5),
    silence: Duration::from_secs(60),
    whole: Duration::from_secs(10 * 60),
};

/// Bytes of a stream read at once.
const STREAM_CHUNK_BYTES: usize = 1 << 16;

/// Time limits of a stream.
struct StreamLimits {
    /// Longest wait for a writer at the other end of a FIFO.
    writer: Duration,
    /// Longest time without data.
    silence: Duration,
    /// Longest time from its start to its end.
    whole: Duration,
}

/// Message of a stream's thread.
enum StreamEvent {
    Opened,
    Chunk(Vec<u8>),
    End,
}

/// Reads at most one chunk more than `limit`.
pub(crate) fn read_stream(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let (sender, receiver) = sync_channel(1);
    let path = path.to_owned();
    std::thread::spawn(move || {
        if let Err(error) = send_stream(&path, &sender) {
            // The receiver may have timed out.
            let _ = sender.send(Err(error));
        }
    });
    collect_stream(&receiver, limit, &STREAM_LIMITS)
}

fn send_stream(path: &Path, to: &SyncSender<io::Result<StreamEvent>>) -> io::Result<()> {
    let mut file = File::open(path)?;
    let mut is_wanted = to.send(Ok(StreamEvent::Opened)).is_ok();
    while is_wanted {
        let mut chunk = vec![0; STREAM_CHUNK_BYTES];
        let count = file.read(&mut chunk)?;
        chunk.truncate(count);
        let event = match count {
            0 => StreamEvent::End,
            _ => StreamEvent::Chunk(chunk),
        };
        is_wanted = to.send(Ok(event)).is_ok() && count > 0;
    }
    Ok(())
}

fn collect_stream(
    from: &Receiver<io::Result<StreamEvent>>,
    limit: u64,
    limits: &StreamLimits,
) -> io::Result<Vec<u8>> {
    let timed_out = |why: String| Err(io::Error::new(ErrorKind::TimedOut, why));
    let mut bytes = Vec::new();
    // Deadline of the stream, once it is open.
    let mut end: Option<Instant> = None;
    while bytes.len() as u64 <= limit {
        let left = end.map(|end| end.saturating_duration_since(Instant::now()));
        if left == Some(Duration::ZERO) {
            let seconds = limits.whole.as_secs();
            return timed_out(format!("it has not ended within {seconds} s"));
        }
        let patience = left.map_or(limits.writer, |left| left.min(limits.silence));
        match from.recv_timeout(patience) {
            Ok(Ok(StreamEvent::Opened)) => end = Some(Instant::now() + limits.whole),
            Ok(Ok(StreamEvent::Chunk(chunk))) => bytes.extend(chunk),
            Ok(Ok(StreamEvent::End)) | Err(RecvTimeoutError::Disconnected) => break,
            Ok(Err(error)) => return Err(error),
            Err(RecvTimeoutError::Timeout) if left.is_none() => {
                return timed_out("no program writes to it".to_owned());
            }
            Err(RecvTimeoutError::Timeout) if patience == limits.silence => {
                let seconds = limits.silence.as_secs();
                return timed_out(format!("nothing has come from it for {seconds} s"));
            }
            // The deadline has passed: the loop ends.
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stream with a byte every 10 ms, without end.
    fn trickle() -> Receiver<io::Result<StreamEvent>> {
        let (sender, receiver) = sync_channel(1);
        std::thread::spawn(move || {
            let mut next = StreamEvent::Opened;
            while sender.send(Ok(next)).is_ok() {
                std::thread::sleep(Duration::from_millis(10));
                next = StreamEvent::Chunk(vec![0]);
            }
        });
        receiver
    }

    #[test]
    fn a_stream_without_end_is_given_up_however_slowly_it_comes() {
        let limits = |silence_ms, whole_ms| StreamLimits {
            writer: Duration::from_secs(5),
            silence: Duration::from_millis(silence_ms),
            whole: Duration::from_millis(whole_ms),
        };
        let given_up = collect_stream(&trickle(), 1_000, &limits(60_000, 1_000));
        let why = given_up.unwrap_err().to_string();
        assert_eq!(why, "it has not ended within 1 s");
        let given_up = collect_stream(&trickle(), 1_000, &limits(1, 60_000));
        let why = given_up.unwrap_err().to_string();
        assert!(why.starts_with("nothing has come from it for"), "{why}");
        let read = collect_stream(&trickle(), 3, &limits(60_000, 60_000));
        assert_eq!(read.unwrap(), [0; 4]);
        assert_eq!(STREAM_LIMITS.whole, Duration::from_secs(600));
    }
}
