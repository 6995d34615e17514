//! Sentences with checksums.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sigmatau_formats::read_sentences;

fuzz_target!(|data: &[u8]| {
    for (name, fields) in [(&b"VNYMR"[..], 12), (b"VNIMU", 11)] {
        if let Ok(found) = read_sentences(data, name, fields, &[0, fields - 1], u64::MAX) {
            let lines = data.iter().filter(|&&byte| byte == b'\n').count() + 1;
            assert!(found.columns[0].len() <= lines);
            assert_eq!(found.columns[0].len(), found.columns[1].len());
        }
    }
});
