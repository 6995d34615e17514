//! Columns written as text, with the shortest digits that read back to the same bits.

use std::io::{self, Write};

/// Number of bytes that are collected before a write. \[bytes\]
const PIECE: usize = 1 << 16;

/// Writes a table, one line per row.
///
/// # Errors
///
/// Errors of the writer; [`io::ErrorKind::InvalidInput`] if the columns differ in length.
pub fn write_columns(mut writer: impl Write, delimiter: u8, columns: &[&[f64]]) -> io::Result<()> {
    let rows = columns.first().map_or(0, |column| column.len());
    if columns.iter().any(|column| column.len() != rows) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the columns are of unequal length"));
    }
    let mut text = Vec::with_capacity(PIECE + 32 * columns.len() + 2);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Delimiter, Dialect};
    use crate::text::read_columns;

    #[test]
    fn the_shortest_digits() {
        let mut text = Vec::new();
        write_columns(&mut text, b',', &[&[0.01, 1.0], &[-0.1, 1e300]]).unwrap();
        assert_eq!(text, b"0.01,-0.1\n1.0,1e+300\n");
    }

    #[test]
    fn unequal_columns_are_refused() {
        let error = write_columns(Vec::new(), b',', &[&[1.0], &[]]).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
    }

    /// Random bit patterns (splitmix64, fixed seed): every finite double, including subnormals, is read back.
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
        for (delimiter, reader) in
            [(b',', Delimiter::Byte(b',')), (b'\t', Delimiter::Byte(b'\t')), (b' ', Delimiter::Whitespace)]
        {
            let mut text = Vec::new();
            write_columns(&mut text, delimiter, &[&a, &b]).unwrap();
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
            let table = read_columns(text.as_slice(), &dialect, &[1, 0], None).unwrap();
            for (column, written) in table.columns.iter().zip([&b, &a]) {
                let same = column.iter().zip(written).all(|(x, y)| x.to_bits() == y.to_bits());
                assert!(same && column.len() == written.len());
            }
        }
    }
}
