//! Laws of the parsers, for any input.

use std::fmt::Write;
use std::io::Cursor;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use sigmatau_formats::ros::Program;
use sigmatau_formats::{
    Delimiter, Dialect, TextError, read_columns, read_sentences, scan_dataflash, scan_ulog, ulog_columns,
    write_columns,
};

fn table(columns: usize) -> Dialect {
    Dialect {
        delimiter: Delimiter::Byte(b','),
        comment: vec![b"#".to_vec()],
        skip_lines: 0,
        columns,
        dates: false,
        most: u64::MAX,
    }
}

/// A number as programs write it: digits, perhaps a point, perhaps an exponent, perhaps a sign.
fn written() -> impl Strategy<Value = String> {
    prop_oneof![
        any::<f64>().prop_filter("finite", |x| x.is_finite()).prop_map(|x| format!("{x:?}")),
        (any::<f64>().prop_filter("finite", |x| x.is_finite()), 0..20usize)
            .prop_map(|(x, n)| format!("{x:.n$e}")),
        (-1e6..1e6, 0..18usize).prop_map(|(x, n)| format!("{x:.n$}")),
        any::<i64>().prop_map(|x| x.to_string()),
        "[+-]?[0-9]{1,25}\\.[0-9]{0,25}",
        "[+-]?\\.[0-9]{1,25}([eE][+-]?[0-9]{1,2})?",
    ]
}

/// The checksum of 8 bits that stands after the `*`.
fn checksum(body: &str) -> u8 {
    body.bytes().fold(0, |sum, byte| sum ^ byte)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(u64::from_be_bytes(*b"property")),
        ..ProptestConfig::default()
    })]

    /// Whatever is written, the number nearest to it is read.
    #[test]
    fn a_number_is_read_as_the_standard_library_reads_it(text in written()) {
        let nearest: f64 = text.parse().unwrap();
        // The first line is read in the slow way, the second in the quick one.
        match read_columns(format!("{text}\n{text}\n").as_bytes(), &table(1), &[0], None) {
            Ok(read) => {
                for value in &read.columns[0] {
                    prop_assert_eq!(value.to_bits(), nearest.to_bits(), "{}", text);
                }
            }
            Err(_) => prop_assert!(nearest.is_infinite(), "{} was refused", text),
        }
    }

    /// What is written is read again to the last bit.
    #[test]
    fn a_table_comes_back(
        rows in prop::collection::vec(prop::array::uniform3(any::<f64>().prop_filter("finite", |x| x.is_finite())), 1..40)
    ) {
        let columns: Vec<Vec<f64>> = (0..3).map(|k| rows.iter().map(|row| row[k]).collect()).collect();
        let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let mut text = Vec::new();
        write_columns(&mut text, None, b',', &slices).unwrap();
        let read = read_columns(text.as_slice(), &table(3), &[0, 1, 2], None).unwrap();
        prop_assert_eq!(read.rows, rows.len());
        for (column, back) in columns.iter().zip(&read.columns) {
            prop_assert!(column.iter().zip(back).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }

    /// A line too many or too few fields, or a word, is an error that names its line; never a shorter table.
    #[test]
    fn a_spoiled_line_is_named(lines in 2..50usize, at in 0..50usize, kind in 0..3usize) {
        let at = at % lines;
        let text: String = (0..lines)
            .map(|k| match (k == at, kind) {
                (true, 0) => "1.5,2.5\n",
                (true, 1) => "1.5,2.5,3.5,4.5\n",
                (true, _) => "1.5,word,3.5\n",
                _ => "1.5,2.5,3.5\n",
            })
            .collect();
        let error = read_columns(text.as_bytes(), &table(3), &[0, 1, 2], None).unwrap_err();
        let line = match &error {
            TextError::Ragged { line, .. } | TextError::NotANumber { line, .. } => *line,
            _ => 0,
        };
        prop_assert_eq!(line, at + 1, "{:?}", error);
    }

    /// Every sentence is read or counted as broken.
    #[test]
    fn sentences_are_all_accounted_for(values in prop::collection::vec((-1e3..1e3, any::<bool>()), 1..60)) {
        let mut text = String::new();
        for (value, whole) in &values {
            let body = format!("VNYMR,{value:+08.3},1,2");
            let right = checksum(&body);
            let said = if *whole { right } else { right.wrapping_add(1) };
            writeln!(text, "${body}*{said:02X}\r").unwrap();
        }
        let found = read_sentences(text.as_bytes(), b"VNYMR", 3, &[0], u64::MAX).unwrap();
        let whole = values.iter().filter(|(_, whole)| *whole).count();
        prop_assert_eq!(found.rows, whole);
        prop_assert_eq!(found.broken, values.len() - whole);
        for (read, (value, _)) in found.columns[0].iter().zip(values.iter().filter(|(_, whole)| *whole)) {
            prop_assert!((read - value).abs() <= 5e-4);
        }
    }

    /// Any bytes: an answer, and no more rows than bytes.
    #[test]
    fn any_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        if let Ok(read) = read_columns(bytes.as_slice(), &table(2), &[0, 1], Some(0)) {
            prop_assert!(read.rows <= bytes.len());
        }
        let _ = scan_dataflash(Cursor::new(&bytes));
        let log = [&b"ULog\x01\x12\x35\x01"[..], &[0; 8], &bytes].concat();
        if let Ok(scan) = scan_ulog(Cursor::new(&log)) {
            prop_assert!(scan.end <= log.len() as u64);
            for topic in &scan.topics {
                let columns = ulog_columns(Cursor::new(&log), scan.end, topic, &[(0, topic.size)]).unwrap();
                prop_assert_eq!(columns[0].len(), topic.rows * topic.size);
            }
        }
    }

    /// A message is decoded whole or not at all, wherever it is cut.
    #[test]
    fn a_message_is_whole_or_refused(x in any::<f64>(), name in "[a-z]{0,9}", cut in any::<prop::sample::Index>()) {
        let steps = [("string", 1, -1), ("f8", 1, 0)].map(|(word, count, column)| (word.to_owned(), count, column));
        let program = Program::compile(&steps, false, &[0], None).unwrap();
        let mut message = (name.len() as u32).to_le_bytes().to_vec();
        message.extend(name.bytes());
        message.extend(x.to_le_bytes());
        let mut columns = program.columns();
        prop_assert!(program.decode(&message, &[message.len()], &[0], &mut columns));
        prop_assert_eq!(columns.floats[0][0].to_bits(), x.to_bits());
        let length = cut.index(message.len());
        let mut columns = program.columns();
        prop_assert!(!program.decode(&message[..length], &[length], &[0], &mut columns));
        prop_assert!(columns.floats[0].is_empty());
    }
}
