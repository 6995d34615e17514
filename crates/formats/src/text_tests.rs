use std::io::{self, Write as _};

use flate2::Compression;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;

use super::*;
use crate::date::Order;
use crate::remarks::Remarks;
use crate::table::{Delimiter, Tag};

fn dialect(delimiter: Delimiter, columns: usize) -> Dialect {
    let comment = vec![b"#".to_vec(), b"%".to_vec(), b"//".to_vec()];
    Dialect {
        delimiter,
        comment,
        skip_lines: 0,
        columns,
        dates: None,
        arrow: false,
        most: u64::MAX,
        tag: None,
    }
}

const COMMA: Delimiter = Delimiter::Byte(b',');

fn read(text: &str, delimiter: Delimiter, columns: usize) -> Result<Table, TextError> {
    let all: Vec<usize> = (0..columns).collect();
    read_columns(text.as_bytes(), &dialect(delimiter, columns), &all, Some(0))
}

fn gzip(text: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(text).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn every_spelling_of_a_plain_table() {
    let expected = vec![vec![1.0, -3.5], vec![0.25, 4e-3]];
    for (text, delimiter) in [
        ("1,0.25\n-3.5,4e-3\n", COMMA),
        ("1,0.25\n-3.5,4e-3", COMMA),
        ("1,.25\r\n-3.5,+4E-3\r\n", COMMA),
        ("\u{feff}1,0.25\n-3.5,4e-3\n", COMMA),
        ("1,0.25,\n-3.5,4e-3, \n", COMMA),
        (" 1 , \"0.25\"\n\"-3.5\",\t4e-3 \n", COMMA),
        ("# c\n\n1,0.25\n  % d\n \n-3.5,4e-3\n// e\n\n", COMMA),
        ("1;0.25\n-3.5;4e-3\n", Delimiter::Byte(b';')),
        ("1\t0.25\n-3.5\t 4e-3\n", Delimiter::Byte(b'\t')),
        ("  1   0.25\r\n-3.5\t4e-3  \n", Delimiter::Whitespace),
        ("\"1\" 0.25\n-3.5 \"4e-3\"", Delimiter::Whitespace),
    ] {
        assert_eq!(read(text, delimiter, 2).map(|t| t.columns), Ok(expected.clone()), "{text:?}");
    }
}

#[test]
fn wanted_columns_in_any_order_and_the_others_unread() {
    let text = "h\n1,word,3\n4,\"a,b\",6\n";
    let dialect = Dialect { skip_lines: 1, ..dialect(COMMA, 3) };
    let table = read_columns(text.as_bytes(), &dialect, &[2, 0], None).unwrap();
    assert_eq!(table.columns, [[3.0, 6.0], [1.0, 4.0]]);
    assert_eq!((table.rows, table.first_line, table.integers), (2, 2, None));
}

#[test]
fn integers_are_exact_or_not_given() {
    let stamp = 1_403_636_579_758_555_393_i64; // odd: not a double
    let table = read(&format!("{stamp},0\n{},0\n", stamp + 1), COMMA, 2).unwrap();
    assert_eq!(table.integers, Some(vec![stamp, stamp + 1]));
    assert_eq!(read("1,0\n2.0,0\n3,0\n", COMMA, 2).unwrap().integers, None);
    assert_eq!(read("9223372036854775808,0\n", COMMA, 2).unwrap().integers, None);
}

#[test]
fn infinities_are_missing_numbers() {
    for text in ["Infinity", "-Inf", "inf", "1e400", "-1e400", "NaN", ""] {
        let table = read(&format!("1,2\n{text},3\n"), COMMA, 2).unwrap();
        assert!(table.columns[0][1].is_nan(), "{text}");
        assert_eq!((table.columns[0][0], table.columns[1][1]), (1.0, 3.0));
    }
}

#[test]
fn a_compressed_file_has_a_largest_size() {
    let path = std::env::temp_dir().join(format!("sigmatau-largest-{}.gz", std::process::id()));
    let mut file =
        flate2::write::GzEncoder::new(std::fs::File::create(&path).unwrap(), flate2::Compression::fast());
    file.write_all(&b"1,2\n".repeat(1000)).unwrap();
    file.finish().unwrap();
    let read = |most| read_file(&path, &Dialect { most, ..dialect(COMMA, 2) }, &[0], None);
    assert_eq!(read(4000).unwrap().rows, 1000);
    assert_eq!(read(3999), Err(TextError::TooLarge { most: 3999 }));
    std::fs::remove_file(&path).unwrap();
}

#[test]
fn faults_name_their_place() {
    let not = |line, row, column, text: &str| TextError::NotANumber { line, row, column, text: text.into() };
    let ragged = |line, row, got| TextError::Ragged { line, row, got, expected: 2 };
    for (text, expected) in [
        ("1,2\n\n3,x\n", not(3, 1, 1, "x")),
        ("1,0x10\n", not(1, 0, 1, "0x10")),
        ("1,1_000\n", not(1, 0, 1, "1_000")),
        ("1,1.0.0\n", not(1, 0, 1, "1.0.0")),
        ("1,2e\n", not(1, 0, 1, "2e")),
        ("1,\"2\n", not(1, 0, 1, "\"2")),
        ("1,2\0\n", not(1, 0, 1, "2\0")),
        ("1,2\n3\n", ragged(2, 1, 1)),
        ("1,2\n3,4,5\n", ragged(2, 1, 3)),
        ("1,2\n3,4,,\n", ragged(2, 1, 4)),
        ("1,2\nend of log\n", ragged(2, 1, 1)),
        ("", TextError::Empty),
        ("# only\n\n", TextError::Empty),
    ] {
        assert_eq!(read(text, COMMA, 2), Err(expected), "{text:?}");
    }
    let long = "y".repeat(100);
    assert_eq!(read(&format!("1,{long}\n"), COMMA, 2), Err(not(1, 0, 1, &long[..40])));
    assert_eq!(read("1 2\n3\n", Delimiter::Whitespace, 2), Err(ragged(2, 1, 1)));
    assert_eq!(read("1 2\n3 4 5\n", Delimiter::Whitespace, 2), Err(ragged(2, 1, 3)));
}

#[test]
fn a_time_and_an_arrow_before_each_row() {
    let read = |text: &str, wanted: &[usize]| {
        let dialect = Dialect { dates: Some(Order::DayFirst), arrow: true, ..dialect(COMMA, 3) };
        read_columns(text.as_bytes(), &dialect, wanted, Some(2))
    };
    let text = "0:00:01.5 -> 1,2\n0:00:01.6 -> \n# c\n\"0:00:02\"->3,4,\r\n0:00:03 -> # c\n ->5,6\n";
    let table = read(text, &[1, 2]).unwrap();
    assert_eq!(table.columns[0], [2.0, 4.0, 6.0]);
    assert_eq!(table.integers, Some(vec![1_500_000_000, 2_000_000_000, i64::MIN]));
    assert!(table.columns[1][2].is_nan());
    for (text, line, got, expected) in [
        ("1,2\n", 1, 2, 3),
        ("1,2,3\n", 1, 3, 4),
        ("0:00:01 -> 1,2\n0:00:02 -> 1\n", 2, 1, 2),
        ("0:00:01 -> 1,2,3\n", 1, 3, 2),
    ] {
        let row = line - 1;
        assert_eq!(read(text, &[0]).unwrap_err(), TextError::Ragged { line, row, got, expected }, "{text}");
    }
    let broken = read("0:00:01 -> 1,2\n0:0x:02 -> 1,2\n", &[0]).unwrap_err();
    assert!(matches!(broken, TextError::NotANumber { line: 2, row: 1, column: 2, .. }), "{broken}");
}

#[test]
fn missing_numbers_are_nan() {
    for text in ["nan", "NaN", "-nan", "NA", "N/A", "null", "None", "", "\"\"", " "] {
        let table = read(&format!("1,2\n3,{text}\n5,6\n"), COMMA, 2).unwrap();
        assert_eq!(table.columns[0], [1.0, 3.0, 5.0], "{text:?}");
        assert!(table.columns[1][1].is_nan() && table.columns[1][2..] == [6.0], "{text:?}");
        let table = read(&format!("1,2\n{text},4\n5,6\n"), COMMA, 2).unwrap();
        assert!(table.columns[0][1].is_nan() && table.columns[1] == [2.0, 4.0, 6.0], "{text:?}");
        assert_eq!(table.integers, Some(vec![1, i64::MIN, 5]), "{text:?}");
    }
    let table = read("1\t2\n\t\n", Delimiter::Byte(b'\t'), 2).unwrap();
    assert!(table.columns.iter().all(|column| column[1].is_nan()));
    // The smallest integer means a missing value, so it cannot be read exactly.
    assert_eq!(read("-9223372036854775808,1\n2,1\n", COMMA, 2).unwrap().integers, None);
}

#[test]
fn a_table_larger_than_a_piece() {
    let rows = 400_000_i32; // about 5 MiB
    let lines: Vec<String> = (0..rows).map(|i| format!("{i},{}", f64::from(i) / 8.0)).collect();
    let text = lines.join("\n");
    let expected: Vec<f64> = (0..rows).map(|i| f64::from(i) / 8.0).collect();
    let compressed = gzip(text.as_bytes());
    let table = read(&text, COMMA, 2).unwrap();
    assert_eq!(table.columns[1], expected);
    let unpacked =
        read_columns(MultiGzDecoder::new(&compressed[..]), &dialect(COMMA, 2), &[0, 1], Some(0)).unwrap();
    assert_eq!(unpacked, table);
}

/// Returns one byte at a time: no result may depend on how the bytes arrive.
struct Drip<'a>(&'a [u8]);

impl Read for Drip<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.0.take(1).read(out).inspect(|&n| self.0 = &self.0[n..])
    }
}

#[test]
fn pieces_do_not_matter() {
    let text = "# c\n1,2\r\n\n3,4\n5,6";
    let dripped = read_columns(Drip(text.as_bytes()), &dialect(COMMA, 2), &[0, 1], Some(0));
    assert_eq!(dripped, read(text, COMMA, 2));
}

#[test]
fn a_line_without_end_does_not_fill_the_memory() {
    let endless = io::repeat(b'1');
    let error = read_columns(b"1\n".chain(endless), &dialect(COMMA, 1), &[0], None).unwrap_err();
    assert_eq!(error, TextError::TooLong { line: 2 });
}

#[test]
fn damaged_compression_is_reported() {
    let lines: Vec<String> = (0..10_000).map(|i| format!("{i},{}\n", i * 7919 % 10_007)).collect();
    let mut compressed = gzip(lines.concat().as_bytes());
    let cut = &compressed[..compressed.len() / 2];
    let read = |bytes: &[u8]| read_columns(MultiGzDecoder::new(bytes), &dialect(COMMA, 2), &[0, 1], None);
    assert!(matches!(read(cut), Err(TextError::Truncated { line }) if line > 1000));
    assert!(matches!(read(&compressed[..compressed.len() - 1]), Err(TextError::Truncated { line: 10_000 })));
    let crc = compressed.len() - 8;
    compressed[crc] ^= 1;
    assert!(matches!(read(&compressed), Err(TextError::Damaged { line: 10_000 })));
}

#[test]
fn a_missing_file() {
    assert!(matches!(open(Path::new("/nowhere/at/all"), u64::MAX), Err(TextError::Io(_))));
}

#[test]
fn rows_of_one_kind() {
    let text = "Gyro,0,1.5\nAccel,7\n\"Gyro\" ,1,2.5\n\nGyros,9,9\n Gyro,2,3.5,\nAccel,8\nGyro,3,4.5";
    let of = |column, text: &str| Some(Tag { column, text: text.into() });
    let dialect = Dialect { tag: of(0, "Gyro"), ..dialect(COMMA, 3) };
    let table = read_columns(text.as_bytes(), &dialect, &[1, 2], Some(1)).unwrap();
    assert_eq!(table.columns, [vec![0.0, 1.0, 2.0, 3.0], vec![1.5, 2.5, 3.5, 4.5]]);
    assert_eq!((table.rows, table.first_line, table.open_end), (4, 1, true));
    let ragged = read_columns(
        &b"a 1 2\nb 1\na 1\n"[..],
        &Dialect { delimiter: Delimiter::Whitespace, tag: of(0, "a"), ..dialect },
        &[1],
        None,
    );
    assert_eq!(ragged, Err(TextError::Ragged { line: 3, row: 1, got: 2, expected: 3 }));
}

/// Random numbers (splitmix64).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }

    fn of<'t>(&mut self, words: &[&'t str]) -> &'t str {
        words[self.below(words.len())]
    }
}

const NUMBERS: [&str; 12] = [
    "0",
    "1",
    "-2",
    "0.25",
    "-0.0070883998931492112",
    "1e-5",
    "+4E3",
    "1403636579758555393",
    ".5",
    "5.",
    "1e300",
    "007",
];
const ODD: [&str; 12] = [
    "\"1.5\"",
    " 2 ",
    "2 ",
    " 3",
    "",
    "nan",
    "word",
    "1.2.3",
    "\"a,b\"",
    "1e400",
    "9223372036854775808",
    "\"1",
];
const OTHER_LINES: [&str; 8] = ["", "# c", "  % d", " ", "\t", "//", "end of log", ",,"];

/// A mostly plain table, and its dialect.
fn table(random: &mut Random, faults: bool) -> (Vec<u8>, Dialect, Vec<usize>, Option<usize>) {
    let (delimiter, between) = [
        (Delimiter::Byte(b','), ","),
        (Delimiter::Byte(b','), ", "),
        (Delimiter::Byte(b';'), ";"),
        (Delimiter::Byte(b'\t'), "\t"),
        (Delimiter::Whitespace, " "),
        (Delimiter::Whitespace, " \t "),
        (Delimiter::Byte(b':'), ":"),
    ][random.below(7)];
    let columns = 1 + random.below(4);
    let skip_lines = random.below(3);
    let end = random.of(&["\n", "\n", "\r\n", " \n", "\t\r\n"]);
    let trailing = random.below(4) == 0;
    let mut text = String::new();
    if random.below(4) == 0 {
        text += "\u{feff}";
    }
    for _ in 0..skip_lines {
        text += random.of(&["a,b", "", "# header", "1,2"]);
        text += "\n";
    }
    let integers = random.below(2) == 0;
    for _ in 0..random.below(30) {
        if random.below(8) == 0 {
            text += random.of(&OTHER_LINES[..if faults { 8 } else { 6 }]);
            text += end;
        }
        for column in 0..columns + usize::from(faults && random.below(60) == 0) {
            if column > 0 {
                text += between;
            }
            text += match random.below(40) {
                0 if faults => random.of(&ODD),
                1 => random.of(&ODD[..4]),
                _ if integers && column == 0 => random.of(&["1", "-2", "1403636579758555393", "+7"]),
                _ => random.of(&NUMBERS),
            };
        }
        if trailing {
            text += between;
        }
        text += if random.below(10) == 0 { "\n" } else { end };
    }
    if random.below(3) == 0 {
        text.truncate(text.trim_end().len());
    }
    let mut wanted: Vec<usize> = (0..columns).filter(|_| random.below(4) > 0).collect();
    if random.below(2) == 0 {
        wanted.reverse();
    }
    let exact = (random.below(3) > 0).then(|| random.below(columns));
    let comment = vec![b"#".to_vec(), b"%".to_vec(), b"//".to_vec()];
    (
        text.into_bytes(),
        Dialect {
            delimiter,
            comment,
            skip_lines,
            columns,
            dates: None,
            arrow: false,
            most: u64::MAX,
            tag: None,
        },
        wanted,
        exact,
    )
}

/// Bits of the columns, which distinguish signed zeros; integers, rows, first line.
type Bits = (Vec<Vec<u64>>, Option<Vec<i64>>, usize, usize, Remarks);

fn bits(result: Result<Table, TextError>) -> Result<Bits, TextError> {
    result.map(|t| {
        let columns = t.columns.iter().map(|c| c.iter().map(|x| x.to_bits()).collect()).collect();
        (columns, t.integers, t.rows, t.first_line, t.remarks)
    })
}

/// Pieces and parts have a few bytes, so that borders fall everywhere. The result is the same for any number of threads.
#[test]
fn pieces_parts_and_threads_do_not_matter() {
    let mut random = Random(20_080_101);
    let (mut tables, mut refused) = (0, 0);
    let pools: Vec<_> =
        (1..4).map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap()).collect();
    for round in 0..6000 {
        let (text, dialect, wanted, exact) = table(&mut random, round % 2 == 0);
        let layout = Layout::new(&dialect, &wanted, exact);
        let longest = 20 + random.below(60);
        let expected = bits(read_stream(Drip(&text), &layout, longest, longest));
        let part = 1 + random.below(longest);
        let got = bits(pools[round % 3].install(|| read_stream(&text[..], &layout, longest, part)));
        let context = || format!("{:?} {dialect:?} {wanted:?} {exact:?}", String::from_utf8_lossy(&text));
        assert_eq!(got, expected, "{longest} {part} {}", context());
        *if expected.is_ok() { &mut tables } else { &mut refused } += 1;
    }
    assert!(tables > 2000 && refused > 2000, "{tables} tables, {refused} refused");
}

#[test]
fn the_first_fault_of_a_large_text() {
    let lines: Vec<String> = (0..200_000).map(|i| format!("{i},{}", f64::from(i) / 3.0)).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    for faults in [&[150_000, 70_000, 190_000][..], &[199_999]] {
        let mut lines = lines.clone();
        for &at in faults {
            lines[at] = format!("{at},word");
        }
        let row = faults.iter().min().copied().unwrap();
        let expected = TextError::NotANumber { line: row + 1, row, column: 1, text: "word".into() };
        assert_eq!(pool.install(|| read(&lines.join("\n"), COMMA, 2)), Err(expected));
    }
}

/// A disk that fails after a few rows.
struct Broken(usize);

impl Read for Broken {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.0 = self.0.checked_sub(1).ok_or_else(|| io::Error::other("the disk is gone"))?;
        b"1\n".as_slice().read(out)
    }
}

#[test]
fn a_disk_that_fails() {
    let error = read_columns(Broken(9), &dialect(COMMA, 1), &[0], None).unwrap_err();
    assert_eq!(error, TextError::Io("the disk is gone".into()));
}
