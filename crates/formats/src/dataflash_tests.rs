use std::io::Cursor;

use super::*;

fn definition(id: u8, name: &str, letters: &str, labels: &str) -> Vec<u8> {
    let mut body = vec![0; 86];
    body[0] = id;
    body[1] = (HEADER + letters.chars().map(|c| width(c).unwrap()).sum::<usize>()) as u8;
    body[2..2 + name.len()].copy_from_slice(name.as_bytes());
    body[6..6 + letters.len()].copy_from_slice(letters.as_bytes());
    body[22..22 + labels.len()].copy_from_slice(labels.as_bytes());
    message(FMT, &body)
}

fn message(id: u8, body: &[u8]) -> Vec<u8> {
    [&MARKS[..], &[id], body].concat()
}

fn log(rows: u8) -> Vec<u8> {
    let mut bytes = definition(FMT, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
    bytes.extend(definition(7, "ACC", "QBB", "TimeUS,I,X"));
    for row in 0..rows {
        bytes.extend(message(7, &[row, 0, 0, 0, 0, 0, 0, 0, row % 2, 100 + row]));
    }
    bytes
}

fn column(bytes: &[u8], instance: u8) -> (DataFlashScan, Vec<u8>) {
    let scan = scan_dataflash(Cursor::new(bytes)).unwrap();
    let Some(kind) = scan.kinds.iter().find(|kind| kind.name == "ACC") else {
        return (scan, Vec::new());
    };
    let rows = kind.rows.iter().find(|r| r.0 == instance).map_or(0, |r| r.1);
    let wanted = DataFlashRows { id: 7, instance: Some((8, instance)), size: 10, rows, end: scan.end };
    let columns = dataflash_columns(Cursor::new(bytes), &wanted, &[(9, 1)]).unwrap();
    (scan, columns[0].clone())
}

#[test]
fn instances() {
    let (scan, x) = column(&log(5), 1);
    assert_eq!((scan.broken, scan.messages), (None, 7));
    assert_eq!(x, [101, 103]);
    assert_eq!(scan.kinds[1].rows, [(0, 3), (1, 2)]);
}

#[test]
fn every_cut_within_a_message_is_reported() {
    let bytes = log(6);
    for length in 1..bytes.len() {
        let (scan, x) = column(&bytes[..length], 0);
        let rows = length.saturating_sub(2 * FMT_LENGTH) / 13;
        assert_eq!(x.len(), rows.div_ceil(2), "{length}");
        let between = length == FMT_LENGTH || length >= 2 * FMT_LENGTH && (length - 2 * FMT_LENGTH) % 13 == 0;
        assert_eq!(scan.broken.is_none(), between, "{length}");
    }
}

#[test]
fn the_message_before_damage_is_dropped() {
    let mut bytes = log(9);
    let at = bytes.len() - 4 * 13;
    for byte in &mut bytes[at - 6..at + 20] {
        *byte ^= 0xff;
    }
    let (scan, x) = column(&bytes, 0);
    assert_eq!(x, [100, 102]);
    assert_eq!(scan.end as usize, at - 13);
    assert!(
        matches!(scan.broken, Some(Break::Damaged { at: place, .. }) if place as usize == at),
        "{scan:?}"
    );
}

#[test]
fn a_changed_byte_is_data_or_reported() {
    let bytes = log(6);
    for at in 0..bytes.len() {
        for mask in [0x01, 0x20, 0x80, 0xff] {
            let mut bytes = bytes.clone();
            bytes[at] ^= mask;
            let scan = scan_dataflash(Cursor::new(&bytes)).unwrap();
            for kind in &scan.kinds {
                for &(number, rows) in kind.rows.iter().filter(|_| kind.size > 0) {
                    let instance = kind.instance.map(|offset| (offset, number));
                    let wanted =
                        DataFlashRows { id: kind.id, instance, size: kind.size, rows, end: scan.end };
                    dataflash_columns(Cursor::new(&bytes), &wanted, &[(0, kind.size)]).unwrap();
                }
            }
        }
    }
}

#[test]
fn filler_after_the_last_message_is_not_damage() {
    for byte in [0, 0xff] {
        let bytes = [log(6), vec![byte; 1000]].concat();
        let (scan, x) = column(&bytes, 1);
        assert_eq!((scan.broken, scan.filler, scan.end), (None, Some(byte), log(6).len() as u64));
        assert_eq!(x, [101, 103, 105]);
        let other = [bytes, vec![7]].concat();
        assert!(scan_dataflash(Cursor::new(&other)).unwrap().broken.is_some());
    }
}
