//! ArduPilot flight logs: scans the log and checks its fields.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sigmatau_formats::scan_dataflash;
use std::io::Cursor;

fuzz_target!(|data: &[u8]| {
    let Ok(scan) = scan_dataflash(Cursor::new(data)) else { return };
    assert!(scan.end <= data.len() as u64);
    for kind in &scan.kinds {
        assert!(kind.fields.iter().all(|(_, _, offset)| *offset <= kind.size));
    }
});
