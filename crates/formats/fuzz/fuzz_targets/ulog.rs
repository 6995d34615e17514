//! PX4 flight logs: the columns must have as many rows as the scan counted.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sigmatau_formats::{scan_ulog, ulog_columns};
use std::io::Cursor;

fuzz_target!(|data: &[u8]| {
    let Ok(scan) = scan_ulog(Cursor::new(data)) else { return };
    assert!(scan.end <= data.len() as u64);
    for topic in scan.topics.iter().take(8) {
        let fields = [(0, topic.size.min(8)), (topic.size / 2, topic.size - topic.size / 2)];
        if let Ok(columns) = ulog_columns(Cursor::new(data), scan.end, topic, &fields) {
            for ((_, length), column) in fields.iter().zip(columns) {
                assert_eq!(column.len(), length * topic.rows);
            }
        }
    }
});
