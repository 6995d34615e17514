//! Columns into text: the shortest digits that read back to the same bits.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;

/// Bytes gathered before they are handed on.
const PIECE: usize = 1 << 16;

/// Writes a table, one line a row; a header first, if there is one.
///
/// # Errors
///
/// Those of the writer; [`io::ErrorKind::InvalidInput`] if the columns are of unequal length.
pub fn write_columns(
    mut writer: impl Write,
    header: Option<&str>,
    delimiter: u8,
    columns: &[&[f64]],
) -> io::Result<()> {
    let rows = columns.first().map_or(0, |column| column.len());
    if columns.iter().any(|column| column.len() != rows) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the columns are of unequal length"));
    }
    let mut text = Vec::with_capacity(PIECE + 32 * columns.len() + 2);
    if let Some(header) = header {
        text.extend_from_slice(header.as_bytes());
        text.push(b'\n');
    }
    let mut digits = zmij::Buffer::new();
    for row in 0..rows {
        for (i, column) in columns.iter().enumerate() {
            if i > 0 {
                text.push(delimiter);
            }
            text.extend_from_slice(digits.format(column[row]).as_bytes());
        }
        text.push(b'\n');
        if text.len() >= PIECE {
            writer.write_all(&text)?;
            text.clear();
        }
    }
    writer.write_all(&text)?;
    writer.flush()
}

/// Writes a table to a file, through gzip if so asked.
///
/// The same columns give the same bytes: no time stamp is put into a compressed file.
///
/// # Errors
///
/// Those of the file system, and of [`write_columns`].
pub fn write_file(
    path: &Path,
    header: Option<&str>,
    delimiter: u8,
    columns: &[&[f64]],
    gzip: bool,
) -> io::Result<()> {
    let file = File::create(path)?;
    if gzip {
        let mut encoder = GzEncoder::new(file, Compression::default());
        write_columns(&mut encoder, header, delimiter, columns)?;
        encoder.finish()?;
        Ok(())
    } else {
        write_columns(file, header, delimiter, columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::open;
    use crate::table::{Delimiter, Dialect};
    use crate::text::read_columns;

    fn text(header: Option<&str>, columns: &[&[f64]]) -> String {
        let mut out = Vec::new();
        write_columns(&mut out, header, b',', columns).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn the_shortest_digits() {
        assert_eq!(text(Some("a,b"), &[&[0.01, 1.0], &[-0.1, 1e300]]), "a,b\n0.01,-0.1\n1.0,1e+300\n");
        assert_eq!(text(None, &[]), "");
    }

    #[test]
    fn unequal_columns_are_refused() {
        let error = write_columns(Vec::new(), None, b',', &[&[1.0], &[]]).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
    }

    /// Random bit patterns (splitmix64, seed fixed): every finite double, subnormals included, comes back.
    #[test]
    fn the_same_bits_come_back() {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut next = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            f64::from_bits(z ^ (z >> 31))
        };
        let mut column = |n: usize| -> Vec<f64> {
            let mut values = vec![0.0, -0.0, f64::MIN_POSITIVE, f64::MAX, f64::from_bits(1)];
            while values.len() < n {
                let value = next();
                if value.is_finite() {
                    values.push(value);
                }
            }
            values
        };
        let (a, b) = (column(20_000), column(20_000));
        let path = std::env::temp_dir().join(format!("sigmatau-formats-{}.csv", std::process::id()));
        for (gzip, delimiter, reader) in [
            (false, b',', Delimiter::Byte(b',')),
            (true, b'\t', Delimiter::Byte(b'\t')),
            (false, b' ', Delimiter::Whitespace),
        ] {
            write_file(&path, None, delimiter, &[&a, &b], gzip).unwrap();
            let dialect = Dialect {
                delimiter: reader,
                comment: Vec::new(),
                skip_lines: 0,
                columns: 2,
                dates: None,
                arrow: false,
                most: u64::MAX,
                tag: None,
            };
            let table = read_columns(open(&path, u64::MAX).unwrap(), &dialect, &[1, 0], None).unwrap();
            std::fs::remove_file(&path).unwrap();
            for (column, written) in table.columns.iter().zip([&b, &a]) {
                let same = column.iter().zip(written).all(|(x, y)| x.to_bits() == y.to_bits());
                assert!(same && column.len() == written.len());
            }
        }
    }
}
