use std::io::Cursor;

use super::*;

fn message(kind: u8, payload: &[u8]) -> Vec<u8> {
    let mut bytes = (payload.len() as u16).to_le_bytes().to_vec();
    bytes.push(kind);
    bytes.extend_from_slice(payload);
    bytes
}

fn log(rows: u8) -> Vec<u8> {
    let mut bytes = [MAGIC, &[1], &[0; 8]].concat();
    bytes.extend(message(b'F', b"imu:uint64_t timestamp;uint8_t x;"));
    bytes.extend(message(b'A', b"\x00\x07\x00imu"));
    for row in 0..rows {
        bytes.extend(message(b'D', &[7, 0, row, 0, 0, 0, 0, 0, 0, 0, 100 + row]));
    }
    bytes
}

fn column(bytes: &[u8]) -> (UlogScan, Vec<u8>) {
    let scan = scan_ulog(Cursor::new(bytes)).unwrap();
    let columns = match scan.topics.first() {
        Some(topic) => ulog_columns(Cursor::new(bytes), scan.end, topic, &[(8, 1)]).unwrap(),
        None => vec![Vec::new()],
    };
    (scan, columns[0].clone())
}

#[test]
fn whole() {
    let (scan, x) = column(&log(5));
    assert_eq!((scan.broken, scan.messages, scan.topics[0].size), (None, 7, 9));
    assert_eq!(x, [100, 101, 102, 103, 104]);
}

#[test]
fn every_cut_within_a_message_is_reported() {
    let bytes = log(5);
    let first = bytes.len() - 5 * 14;
    for length in HEADER..bytes.len() {
        let (scan, x) = column(&bytes[..length]);
        let rows = length.saturating_sub(first) / 14;
        assert_eq!(x.len(), rows, "{length}");
        let between = length == HEADER || length == 52 || length >= first && (length - first) % 14 == 0;
        assert_eq!(scan.broken.is_none(), between, "{length}");
    }
}

#[test]
fn the_message_before_damage_is_dropped() {
    let mut bytes = log(9);
    let at = bytes.len() - 4 * 14;
    for byte in &mut bytes[at - 6..at + 20] {
        *byte ^= 0xff;
    }
    let (scan, x) = column(&bytes);
    assert_eq!(x, [100, 101, 102, 103]);
    assert_eq!(scan.end as usize, at - 14);
    assert!(
        matches!(scan.broken, Some(Break::Damaged { at: place, .. }) if place as usize == at),
        "{scan:?}"
    );
}

#[test]
fn messages_of_unknown_kinds_are_skipped() {
    let mut bytes = log(2);
    bytes.extend(message(b'Z', b"later"));
    bytes.extend(message(b'D', &[7, 0, 9, 0, 0, 0, 0, 0, 0, 0, 109]));
    let (scan, x) = column(&bytes);
    assert_eq!((x, scan.unknown, scan.broken), (vec![100, 101, 109], 1, None));
}

#[test]
fn appended_after_a_crash() {
    let mut flags = vec![0; 40];
    flags[8] = APPENDED;
    let mut bytes = [MAGIC, &[1], &[0; 8], &message(b'B', &flags)].concat();
    bytes.extend_from_slice(&log(2)[HEADER..]);
    bytes.extend_from_slice(&[11, 0, b'D', 7]); // unfinished
    let to = bytes.len() as u64;
    bytes[HEADER + 3 + 16..HEADER + 3 + 24].copy_from_slice(&to.to_le_bytes());
    bytes.extend(message(b'D', &[7, 0, 9, 0, 0, 0, 0, 0, 0, 0, 109]));
    let (scan, x) = column(&bytes);
    assert_eq!((x, scan.broken), (vec![100, 101, 109], None));
    assert_eq!(scan.unfinished, [(to - 4, to)]);
    let (scan, _) = column(&bytes[..to as usize]);
    assert_eq!(scan.broken, Some(Break::Cut { at: to - 4 }));
}

#[test]
fn a_changed_byte_is_data_or_reported() {
    let bytes = log(6);
    for at in 0..bytes.len() {
        for mask in [0x01, 0x20, 0x80, 0xff] {
            let mut bytes = bytes.clone();
            bytes[at] ^= mask;
            if let Ok(scan) = scan_ulog(Cursor::new(&bytes)) {
                for topic in &scan.topics {
                    if topic.size > 0 {
                        ulog_columns(Cursor::new(&bytes), scan.end, topic, &[(0, topic.size)]).unwrap();
                    }
                }
            }
        }
    }
}
