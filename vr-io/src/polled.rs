//! Streams that end with an error where the work that reads or writes them is cancelled.

use std::io::{self, Read, Seek, SeekFrom, Write};

use vr_core::cancel::CancelToken;

/// Largest number of bytes between two looks at the cancel flag: some milliseconds of decompressing, or of a slow disk.
const BLOCK: usize = 1 << 18;

/// A stream that asks with each block for the cancel flag that was current when it was made.
///
/// Its error is a [`Cancelled`](vr_core::cancel::Cancelled) inside an [`io::Error`]; decoders on the way may wrap it or call it damage, which [`crate::FileError`] makes
/// good.
#[derive(Debug)]
pub(crate) struct Polled<S> {
    stream: S,
    token: CancelToken,
}

impl<S> Polled<S> {
    pub fn new(stream: S) -> Self {
        Self { stream, token: CancelToken::current() }
    }

    pub fn get_ref(&self) -> &S {
        &self.stream
    }
}

impl<R: Read> Read for Polled<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.token.check()?;
        let length = out.len().min(BLOCK);
        self.stream.read(&mut out[..length])
    }
}

impl<W: Write> Write for Polled<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.token.check()?;
        self.stream.write(&bytes[..bytes.len().min(BLOCK)])
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

impl<S: Seek> Seek for Polled<S> {
    fn seek(&mut self, place: SeekFrom) -> io::Result<u64> {
        self.stream.seek(place)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    use vr_core::Control;
    use vr_core::cancel::Cancelled;

    use super::*;

    fn is_cancellation(error: &io::Error) -> bool {
        error.get_ref().is_some_and(|inner| inner.is::<Cancelled>())
    }

    #[test]
    fn a_stream_ends_within_a_block_of_the_flag() {
        let control = Control::default();
        let flag = control.cancel_flag();
        let outcome = control.cancellable(|| {
            let mut zeros = Polled::new(io::repeat(0));
            let mut read = vec![1; 3 * BLOCK];
            assert_eq!(zeros.read(&mut read).unwrap(), BLOCK);
            flag.store(true, Ordering::Relaxed);
            let error = zeros.read_exact(&mut read).unwrap_err();
            let mut sink = Polled::new(Vec::new());
            (is_cancellation(&error), is_cancellation(&sink.write_all(&read).unwrap_err()), sink.get_ref().len())
        });
        assert_eq!(outcome, Ok((true, true, 0)));
        // The flag is that of the work, not of the control: outside of it, nothing is cancelled.
        assert!(Polled::new(io::repeat(0)).read_exact(&mut [0; 9]).is_ok());
    }
}
