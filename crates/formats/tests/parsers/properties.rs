//! Laws of the parsers, for any input: 2000 drawn inputs each.

use std::fmt::Write;
use std::io::Cursor;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
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
        dates: None,
        arrow: false,
        most: u64::MAX,
        tag: None,
    }
}

/// Runs a law on 2000 inputs; the seed is the name of the law.
fn for_any(name: &str, law: impl Fn(&mut ChaCha8Rng)) {
    let mut seed = [0; 32];
    seed.iter_mut().zip(name.bytes()).for_each(|(s, byte)| *s = byte);
    let mut rng = ChaCha8Rng::from_seed(seed);
    (0..2000).for_each(|_| law(&mut rng));
}

/// Any finite number: all exponents are equally likely, with some zeros and subnormal numbers.
fn finite(rng: &mut ChaCha8Rng) -> f64 {
    loop {
        let bits = rng.random::<u64>();
        let x = f64::from_bits(if rng.random_bool(0.1) { bits & 0x8000_0000_ffff_ffff } else { bits });
        if x.is_finite() {
            return if rng.random_bool(0.02) { 0.0 * x } else { x };
        }
    }
}

/// A number in a form that programs write: digits, with or without a point, an exponent and a sign.
fn written(rng: &mut ChaCha8Rng) -> String {
    let digits = |rng: &mut ChaCha8Rng, least: usize, most: usize| -> String {
        let count = rng.random_range(least..=most);
        (0..count).map(|_| char::from(rng.random_range(b'0'..=b'9'))).collect()
    };
    let sign = ["", "+", "-"][rng.random_range(0..3)];
    let x = finite(rng);
    match rng.random_range(0..6) {
        0 => format!("{x:?}"),
        1 => format!("{x:.0$e}", rng.random_range(0..20)),
        2 => format!("{:.1$}", rng.random_range(-1e6..1e6), rng.random_range(0..18)),
        3 => rng.random::<i64>().to_string(),
        4 => format!("{sign}{}.{}", digits(rng, 1, 25), digits(rng, 0, 25)),
        _ => {
            let exponent = match rng.random_range(0..4) {
                0 => String::new(),
                k => format!("{}{}{}", ["e", "E"][k % 2], ["", "+", "-"][k - 1], digits(rng, 1, 2)),
            };
            format!("{sign}.{}{exponent}", digits(rng, 1, 25))
        }
    }
}

/// The checksum of 8 bits after the `*`.
fn checksum(body: &str) -> u8 {
    body.bytes().fold(0, |sum, byte| sum ^ byte)
}

/// The nearest double to the text is read.
#[test]
fn a_number_is_read_as_the_standard_library_reads_it() {
    for_any("a number", |rng| {
        let text = written(rng);
        let nearest: f64 = text.parse().unwrap();
        match read_columns(format!("{text}\n").as_bytes(), &table(1), &[0], None) {
            Ok(read) => {
                for value in &read.columns[0] {
                    assert_eq!(value.to_bits(), nearest.to_bits(), "{text}");
                }
            }
            Err(_) => assert!(nearest.is_infinite(), "{text} was refused"),
        }
    });
}

/// A written table is read back bit by bit.
#[test]
fn a_table_comes_back() {
    for_any("a table", |rng| {
        let rows = rng.random_range(1..40);
        let columns: Vec<Vec<f64>> = (0..3).map(|_| (0..rows).map(|_| finite(rng)).collect()).collect();
        let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let mut text = Vec::new();
        write_columns(&mut text, b',', &slices).unwrap();
        let read = read_columns(text.as_slice(), &table(3), &[0, 1, 2], None).unwrap();
        assert_eq!(read.rows, rows);
        for (column, back) in columns.iter().zip(&read.columns) {
            assert!(column.iter().zip(back).all(|(a, b)| a.to_bits() == b.to_bits()), "{column:?}");
        }
    });
}

/// A line with too many or too few fields, or with a word, is an error that names the line, and never a shorter table.
#[test]
fn a_spoiled_line_is_named() {
    for_any("a spoiled line", |rng| {
        let lines = rng.random_range(2..50);
        let (at, kind) = (rng.random_range(0..lines), rng.random_range(0..3));
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
        assert_eq!(line, at + 1, "{error:?}");
    });
}

/// Every sentence is read or counted as broken.
#[test]
fn sentences_are_all_accounted_for() {
    for_any("sentences", |rng| {
        let count = rng.random_range(1..60);
        let values: Vec<(f64, bool)> =
            (0..count).map(|_| (rng.random_range(-1e3..1e3), rng.random())).collect();
        let mut text = String::new();
        for (value, whole) in &values {
            let body = format!("VNYMR,{value:+08.3},1,2");
            let right = checksum(&body);
            let said = if *whole { right } else { right.wrapping_add(1) };
            writeln!(text, "${body}*{said:02X}\r").unwrap();
        }
        let found = read_sentences(text.as_bytes(), b"VNYMR", 3, &[0], u64::MAX).unwrap();
        let whole = values.iter().filter(|(_, whole)| *whole).count();
        assert_eq!((found.rows, found.broken), (whole, values.len() - whole), "{text}");
        for (read, (value, _)) in found.columns[0].iter().zip(values.iter().filter(|(_, whole)| *whole)) {
            assert!((read - value).abs() <= 5e-4);
        }
    });
}

/// For any bytes there is a result, with no more rows than bytes.
#[test]
fn any_bytes_are_survived() {
    for_any("any bytes", |rng| {
        let mut bytes = vec![0; rng.random_range(0..2000)];
        rng.fill_bytes(&mut bytes);
        if let Ok(read) = read_columns(bytes.as_slice(), &table(2), &[0, 1], Some(0)) {
            assert!(read.rows <= bytes.len());
        }
        let _ = scan_dataflash(Cursor::new(&bytes));
        let log = [&b"ULog\x01\x12\x35\x01"[..], &[0; 8], &bytes].concat();
        if let Ok(scan) = scan_ulog(Cursor::new(&log)) {
            assert!(scan.end <= log.len() as u64);
            for topic in &scan.topics {
                let columns = ulog_columns(Cursor::new(&log), scan.end, topic, &[(0, topic.size)]).unwrap();
                assert_eq!(columns[0].len(), topic.rows * topic.size);
            }
        }
    });
}

/// A message is decoded completely or not at all, wherever it is cut.
#[test]
fn a_message_is_whole_or_refused() {
    let steps =
        [("string", 1, -1), ("f8", 1, 0)].map(|(word, count, column)| (word.to_owned(), count, column));
    let program = Program::compile(&steps, false, &[0], None).unwrap();
    for_any("a message", |rng| {
        let x = f64::from_bits(rng.random());
        let name = &b"abcdefghi"[..rng.random_range(0..=9)];
        let mut message = (name.len() as u32).to_le_bytes().to_vec();
        message.extend(name);
        message.extend(x.to_le_bytes());
        let mut columns = program.columns();
        assert!(program.decode(&message, &[message.len()], &[0], &mut columns));
        assert_eq!(columns.floats[0][0].to_bits(), x.to_bits());
        let length = rng.random_range(0..message.len());
        let mut columns = program.columns();
        assert!(!program.decode(&message[..length], &[length], &[0], &mut columns));
        assert!(columns.floats[0].is_empty());
    });
}
