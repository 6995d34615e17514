//! Conversion of lines to rows of numbers; each line must match the layout.

mod field;
mod layout;
mod line;
mod store;

use memchr::memchr;

pub(crate) use layout::Layout;
pub(crate) use store::Rows;

use crate::table::TextError;

impl Layout<'_> {
    /// Reads whole lines; the last one may lack a line feed.
    pub(crate) fn read(&self, text: &[u8], rows: &mut Rows) -> Result<(), TextError> {
        let (mut start, end) = (0, text.len());
        // A row has at least one byte per field.
        rows.room(end / self.dialect.columns.max(1) + 1)?;
        while start < end {
            if text[start] == b'\n' && rows.skip == 0 {
                // A few compressed megabytes may contain billions of blank lines.
                let blank = text[start..].iter().take_while(|&&b| b == b'\n').count();
                rows.lines += blank;
                start += blank;
                continue;
            }
            if rows.skip == 0 && self.dialect.tag.is_some() {
                let line = &text[start..];
                let line = memchr(b'\n', line).map_or(line, |length| &line[..length]);
                if !self.is_tagged(line) {
                    rows.lines += 1;
                    start += line.len() + 1;
                    continue;
                }
            }
            let line = &text[start..];
            let line = memchr(b'\n', line).map_or(line, |length| &line[..length]);
            self.line(line, rows)?;
            start += line.len() + 1;
        }
        Ok(())
    }
}
