//! Bags of ROS 1: contents, and the messages of all channels.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sigmatau_formats::ros::{self, LogKind, Program};
use std::io::Write;

fuzz_target!(|data: &[u8]| {
    let path = std::env::temp_dir().join(format!("sigmatau-fuzz-bag-{}", std::process::id()));
    let mut file = std::fs::File::create(&path).expect("a temporary file");
    file.write_all(data).expect("room for it");
    drop(file);
    let steps = [
        ("log_time".to_owned(), 1, 0),
        ("u4".to_owned(), 2, 1),
        ("string".to_owned(), 1, -1),
        ("f8".to_owned(), 9, 3),
    ];
    if let Ok(contents) = ros::contents(&path, LogKind::Bag) {
        let ids: Vec<u32> = contents.channels.iter().map(|channel| channel.id).collect();
        let cdr = LogKind::Bag == LogKind::Mcap;
        let program = Program::compile(&steps, cdr, &[0, 1, 3, 11], Some(0)).expect("the steps are right");
        let _ = ros::messages(&path, LogKind::Bag, &ids, &program);
    }
});
