use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use crate::remarks::Remarks;
use crate::table::{Delimiter, Dialect};
use crate::text::{LONGEST, read_columns, read_file, read_stream};

struct Bytes<'a>(&'a [u8]);

impl Source for Bytes<'_> {
    fn read_at(&self, out: &mut [u8], at: u64) -> io::Result<usize> {
        let rest = &self.0[(at as usize).min(self.0.len())..];
        // Never all that is asked for.
        let got = rest.len().min(out.len()).min(5);
        out[..got].copy_from_slice(&rest[..got]);
        Ok(got)
    }

    fn length(&self) -> u64 {
        self.0.len() as u64
    }
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

/// A table, plain for the most part, and the dialect to read it by.
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

/// Bits of the columns, so that zeros with a sign are told apart; integers, rows, first line.
type Bits = (Vec<Vec<u64>>, Option<Vec<i64>>, usize, usize, Remarks);

fn bits(result: Result<Table, TextError>) -> Result<Bits, TextError> {
    result.map(|t| {
        let columns = t.columns.iter().map(|c| c.iter().map(|x| x.to_bits()).collect()).collect();
        (columns, t.integers, t.rows, t.first_line, t.remarks)
    })
}

/// Pieces of a few bytes, so that every border falls everywhere: one after the other, on several threads, and without
/// the quick way, all is the same.
#[test]
fn pieces_threads_and_ways_do_not_matter() {
    let mut random = Random(20_080_101);
    let (mut tables, mut refused) = (0, 0);
    for round in 0..6000 {
        let (text, dialect, wanted, exact) = table(&mut random, round % 2 == 0);
        let layout = Layout::new(&dialect, &wanted, exact);
        let longest = 20 + random.below(60);
        let mut slow = Layout::new(&dialect, &wanted, exact);
        slow.quick = false;
        let expected = bits(read_stream(&text[..], &slow, longest));
        let context = || format!("{:?} {dialect:?} {wanted:?} {exact:?}", String::from_utf8_lossy(&text));
        assert_eq!(bits(read_stream(&text[..], &layout, longest)), expected, "{}", context());
        let sizes = Sizes { piece: 1 + random.below(longest), longest };
        let threads = 1 + round % 3;
        let got = bits(read(&Bytes(&text), &layout, sizes, threads));
        assert_eq!(got, expected, "{sizes:?} {threads} {}", context());
        *if expected.is_ok() { &mut tables } else { &mut refused } += 1;
    }
    assert!(tables > 2000 && refused > 2000, "{tables} tables, {refused} refused");
}

fn temporary(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("sigmatau-pieces-{}-{name}", std::process::id()))
}

fn dialect(columns: usize) -> Dialect {
    Dialect {
        delimiter: Delimiter::Byte(b','),
        comment: vec![b"#".to_vec()],
        skip_lines: 1,
        columns,
        dates: None,
        arrow: false,
        most: u64::MAX,
        tag: None,
    }
}

#[test]
fn a_large_file_and_its_first_fault() {
    let mut lines = vec!["t,x".to_string()];
    lines.extend((0..200_000).map(|i| format!("{i},{}", f64::from(i) / 3.0)));
    let path = temporary("large");
    let read = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| read_file(&path, &dialect(2), &[1, 0], Some(0)))
    };
    for faults in [&[][..], &[150_000, 70_000, 190_000], &[199_999]] {
        let mut lines = lines.clone();
        for &at in faults {
            lines[at] = format!("{at},word");
        }
        let text = lines.join("\n");
        std::fs::write(&path, &text).unwrap();
        let expected = read_columns(text.as_bytes(), &dialect(2), &[1, 0], Some(0));
        if let Some(line) = faults.iter().min() {
            let (line, row) = (line + 1, line - 1);
            assert_eq!(expected, Err(TextError::NotANumber { line, row, column: 1, text: "word".into() }));
        }
        for threads in [1, 2, 3, 8] {
            assert_eq!(read(threads), expected, "{threads}");
        }
    }
    std::fs::remove_file(&path).unwrap();
}

/// A file of which the logger cuts off the end, or to which it adds, while it is read.
struct Changing<'a> {
    text: &'a [u8],
    lengths: (usize, usize),
    reads: AtomicUsize,
}

impl Source for Changing<'_> {
    fn read_at(&self, out: &mut [u8], at: u64) -> io::Result<usize> {
        let early = self.reads.fetch_add(1, Ordering::Relaxed) < 40;
        let length = if early { self.lengths.0 } else { self.lengths.1 };
        Bytes(&self.text[..length]).read_at(out, at)
    }

    fn length(&self) -> u64 {
        self.lengths.0 as u64
    }
}

/// What is read is always a beginning of what was there, whole rows but for the last.
#[test]
fn a_file_that_changes_while_it_is_read() {
    let text = (1000..3000).map(|i| format!("{i}\n")).collect::<Vec<_>>().concat();
    let dialect = Dialect { skip_lines: 0, ..dialect(1) };
    let layout = Layout::new(&dialect, &[0], None);
    for lengths in [(10_000, 4000), (4000, 10_000), (10_000, 0), (10_000, 4003)] {
        for threads in [1, 2, 3] {
            let source = Changing { text: text.as_bytes(), lengths, reads: AtomicUsize::new(0) };
            let table = read(&source, &layout, Sizes { piece: 64, longest: 128 }, threads).unwrap();
            let values: Vec<usize> = table.columns[0].iter().map(|&x| x as usize).collect();
            let (last, rows) = values.split_last().unwrap();
            assert!(rows.iter().enumerate().all(|(i, &x)| x == 1000 + i), "{lengths:?}");
            let whole = 1000 + rows.len();
            assert!([1, 10, 100, 1000].iter().any(|cut| *last == whole / cut), "{last}");
        }
    }
}

struct Broken;

impl Source for Broken {
    fn read_at(&self, out: &mut [u8], at: u64) -> io::Result<usize> {
        if at >= 1 << 16 {
            return Err(io::Error::other("the disk is gone"));
        }
        out.chunks_mut(2).for_each(|pair| pair.copy_from_slice(&b"1\n"[..pair.len()]));
        Ok(out.len())
    }

    fn length(&self) -> u64 {
        1 << 17
    }
}

#[test]
fn a_disk_that_fails() {
    let dialect = dialect(1);
    let layout = Layout::new(&dialect, &[0], None);
    let error = read(&Broken, &layout, Sizes { piece: 1 << 12, longest: 1 << 13 }, 2).unwrap_err();
    assert_eq!(error, TextError::Io("the disk is gone".into()));
}

#[test]
fn a_line_without_end_in_a_large_file() {
    let path = temporary("endless");
    let text = format!("t\n{}{}", "1\n".repeat(400_000), "2".repeat(3 * LONGEST));
    std::fs::write(&path, &text).unwrap();
    let expected = read_columns(text.as_bytes(), &dialect(1), &[0], None);
    assert_eq!(expected, Err(TextError::TooLong { line: 400_002 }));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert_eq!(pool.install(|| read_file(&path, &dialect(1), &[0], None)), expected);
    std::fs::remove_file(&path).unwrap();
}
