//! Lines into rows of numbers, each line held to the layout: a quick way for plain rows, and a slow one for all the rest.

mod decimal;
mod field;
mod layout;
mod line;
mod quick;
mod store;

use memchr::{memchr, memrchr};

pub(crate) use layout::Layout;
pub(crate) use store::Rows;

use crate::table::TextError;

impl Layout<'_> {
    /// Reads `text` up to `end`: whole lines, the last of which may lack its line feed.
    pub(crate) fn read(&self, text: &[u8], end: usize, rows: &mut Rows) -> Result<(), TextError> {
        let mut start = 0;
        // A row has at least one byte for each of its fields.
        rows.room(end / self.dialect.columns.max(1) + 1)?;
        // The quick way goes on until a line ends, so that there must be an end.
        let ended = if self.quick { memrchr(b'\n', &text[..end]).map_or(0, |last| last + 1) } else { 0 };
        while start < end {
            if text[start] == b'\n' && rows.skip == 0 {
                // Blank lines by the billion are a few megabytes of compressed ones.
                let blank = text[start..end].iter().take_while(|&&b| b == b'\n').count();
                rows.lines += blank;
                start += blank;
                continue;
            }
            if rows.skip == 0 && self.dialect.tag.is_some() {
                let line = &text[start..end];
                let line = memchr(b'\n', line).map_or(line, |length| &line[..length]);
                if !self.is_tagged(line) {
                    rows.lines += 1;
                    start += line.len() + 1;
                    continue;
                }
            }
            // The first line may begin with a byte order mark.
            if start < ended && rows.skip == 0 && !(rows.at_start && rows.lines == 0) {
                if let Some(next) = self.quick_row(text, start, rows) {
                    start = next;
                    continue;
                }
            }
            let line = &text[start..end];
            let line = memchr(b'\n', line).map_or(line, |length| &line[..length]);
            self.line(line, rows)?;
            start += line.len() + 1;
        }
        Ok(())
    }
}
