//! A file read in pieces on several threads: the same table, and the same error, as read from one end to the other.
//!
//! Each thread takes the next piece, reads it at its position, and makes rows of the lines that begin in it. The rows are
//! put together in the order of the file, by whichever thread has the next ones; the first error in that order is the
//! error. The end of the file is where a piece finds it, not where its length said it would be.

use std::collections::BTreeMap;
use std::io;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use memchr::{memchr, memchr_iter, memrchr};

use crate::rows::{Layout, Rows};
use crate::source::{Source, fill};
use crate::table::{Table, TextError};

/// Pieces a thread may be ahead of the one that is waited for.
const AHEAD: usize = 4;

/// Room for more rows than the first piece lets expect, as a part of them.
const SPARE_ROOM: f64 = 0.01;

/// Bytes read at first to find the end of the last line of a piece.
const TAIL: usize = 1 << 10;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Sizes {
    pub(crate) piece: usize,
    /// The longest line; no shorter than a piece.
    pub(crate) longest: usize,
}

/// Reads a table in pieces on `threads` threads.
pub(crate) fn read(
    source: &impl Source,
    layout: &Layout<'_>,
    sizes: Sizes,
    threads: usize,
) -> Result<Table, TextError> {
    let mut whole = layout.rows(false);
    let Some(origin) = after_head(source, layout.dialect.skip_lines, sizes.longest, &mut whole.lines)? else {
        return Err(TextError::Empty);
    };
    let shared = Shared {
        state: Mutex::new(State { whole: Some(whole), ..State::default() }),
        changed: Condvar::new(),
        job: Job { source, layout, sizes, origin },
        window: AHEAD * threads,
    };
    // Threads of their own: some wait for others, and a process that was forked has no pool to ask.
    std::thread::scope(|scope| {
        for _ in 1..threads {
            // A thread that cannot be had is done without.
            if std::thread::Builder::new().spawn_scoped(scope, || shared.work()).is_err() {
                break;
            }
        }
        shared.work();
    });
    let state = shared.state.into_inner().unwrap_or_else(PoisonError::into_inner);
    state.outcome.unwrap_or(Ok(()))?;
    let table = state.whole.map_or(Err(TextError::Empty), Rows::finish)?;
    let mut last = [b'\n'];
    fill(source, &mut last, source.length().saturating_sub(1)).map_err(|e| TextError::Io(e.to_string()))?;
    Ok(Table { open_end: last != [b'\n'], ..table })
}

/// Where the line after the first `lines` ones begins; nothing if there are no more.
fn after_head(
    source: &impl Source,
    lines: usize,
    longest: usize,
    seen: &mut usize,
) -> Result<Option<u64>, TextError> {
    let (mut at, mut buffer) = (0, vec![0; if lines > 0 { longest } else { 0 }]);
    while *seen < lines {
        let got = fill(source, &mut buffer, at).map_err(|e| TextError::Io(e.to_string()))?;
        let ends: Vec<usize> = memchr_iter(b'\n', &buffer[..got]).take(lines - *seen).collect();
        match ends.last() {
            Some(last) => at += *last as u64 + 1,
            None if got == longest => return Err(TextError::TooLong { line: *seen + 1 }),
            None => return Ok(None),
        }
        *seen += ends.len();
    }
    Ok(Some(at))
}

struct Job<'a, S> {
    source: &'a S,
    layout: &'a Layout<'a>,
    sizes: Sizes,
    /// Where the lines begin that are read.
    origin: u64,
}

impl<S: Source> Job<'_, S> {
    fn buffer(&self) -> Vec<u8> {
        vec![0; 1 + self.sizes.piece + self.sizes.longest]
    }

    /// Reads the lines that begin in piece number `index`; false if the file ends with them.
    fn read(&self, index: usize, buffer: &mut [u8], rows: &mut Rows) -> Result<bool, TextError> {
        let Sizes { piece, longest } = self.sizes;
        // With the byte before, which says whether a line begins where the piece does.
        let before = usize::from(index > 0);
        let at = self.origin + (index * piece - before) as u64;
        let border = before + piece;
        let failed = |e: io::Error| TextError::Io(e.to_string());
        let mut filled = fill(self.source, &mut buffer[..border], at).map_err(failed)?;
        let mut more = filled == border;
        let inner = filled.min(border - 1);
        let start = match (before, memchr(b'\n', &buffer[..inner])) {
            (0, _) => 0,
            (_, Some(end)) => end + 1,
            (_, None) => return Ok(more),
        };
        // The last line that begins in the piece, and where it ends: mostly beyond the piece.
        let last = memrchr(b'\n', &buffer[start..inner]).map_or(start, |end| start + end + 1);
        let (mut searched, mut step) = (last, TAIL);
        let end = loop {
            if let Some(end) = memchr(b'\n', &buffer[searched..filled.min(last + longest)]) {
                break searched + end + 1;
            }
            if !more {
                break filled;
            }
            if filled >= last + longest {
                self.layout.read(&buffer[start..], last - start, rows)?;
                return Err(TextError::TooLong { line: rows.lines + 1 });
            }
            searched = filled;
            let upto = (filled + step).min(last + longest);
            filled += fill(self.source, &mut buffer[filled..upto], at + filled as u64).map_err(failed)?;
            more = filled == upto;
            step *= 4;
        };
        self.layout.read(&buffer[start..], end - start, rows)?;
        Ok(more || end < filled)
    }
}

/// The rows of one piece, and whether more come after them.
struct Done {
    rows: Rows,
    more: Result<bool, TextError>,
}

/// What the threads share.
struct Shared<'a, S> {
    job: Job<'a, S>,
    state: Mutex<State>,
    changed: Condvar,
    /// Pieces that may be under way or waiting at a time.
    window: usize,
}

#[derive(Default)]
struct State {
    /// Pieces handed out.
    taken: usize,
    /// Pieces put together.
    joined: usize,
    waiting: BTreeMap<usize, Done>,
    /// The rows of the pieces put together; absent while a thread appends to them.
    whole: Option<Rows>,
    /// Rows of no use, for their memory.
    spare: Vec<Rows>,
    /// Set when there is no more to do.
    outcome: Option<Result<(), TextError>>,
}

impl<S: Source> Shared<'_, S> {
    /// Reads pieces until there are no more.
    fn work(&self) {
        let _guard = Guard(self);
        let mut buffer = self.job.buffer();
        while let Some((index, mut rows)) = self.take() {
            let more = self.job.read(index, &mut buffer, &mut rows);
            let mut state = self.lock();
            state.waiting.insert(index, Done { rows, more });
            self.join(state);
        }
    }

    /// The next piece, and rows to read it into; waits while too many are under way.
    fn take(&self) -> Option<(usize, Rows)> {
        let mut state = self.lock();
        // The thread that reads the piece that is waited for never waits here.
        while state.outcome.is_none() && state.taken >= state.joined + self.window {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if state.outcome.is_some() {
            return None;
        }
        let index = state.taken;
        state.taken += 1;
        let layout = self.job.layout;
        let at_start = index == 0 && self.job.origin == 0;
        let rows = match state.spare.pop() {
            Some(rows) if !at_start => rows,
            _ => layout.rows(at_start),
        };
        Some((index, rows))
    }

    /// Puts together what is there in the order of the file, if no other thread is at it.
    fn join<'s>(&'s self, mut state: MutexGuard<'s, State>) {
        let Some(mut whole) = state.whole.take() else { return };
        while state.outcome.is_none() {
            let next = state.joined;
            let Some(Done { mut rows, more }) = state.waiting.remove(&next) else { break };
            drop(state);
            let outcome = match more {
                Ok(true) => None,
                Ok(false) => Some(Ok(())),
                Err(error) => Some(Err(whole.moved(error))),
            };
            let outcome = whole.append(&rows).err().map_or(outcome, |error| Some(Err(error)));
            if next == 0 {
                let rest = self.job.source.length().saturating_sub(self.job.origin);
                whole.reserve(rest as f64 / self.job.sizes.piece as f64 * (1.0 + SPARE_ROOM));
            }
            self.job.layout.clear(&mut rows);
            state = self.lock();
            state.joined += 1;
            state.spare.push(rows);
            state.outcome = outcome;
            self.changed.notify_all();
        }
        state.whole = Some(whole);
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Stops the other threads if this one panics: they would wait for its piece for ever.
struct Guard<'a, 'b, S: Source>(&'a Shared<'b, S>);

impl<S: Source> Drop for Guard<'_, '_, S> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.lock().outcome = Some(Ok(()));
            self.0.changed.notify_all();
        }
    }
}

#[cfg(test)]
#[path = "pieces_tests.rs"]
mod tests;
