//! The part that the targets for both kinds of logs share.

use sigmatau_formats::ros::{self, LogKind, Program};

/// Largest total size of the unpacked chunks. [bytes]
const MOST: u64 = 1 << 26;

/// Reads the contents, and decodes all channels by a definition that fits few of them.
pub fn read(data: &[u8], kind: LogKind) {
    let path = std::env::temp_dir().join(format!("sigmatau-fuzz-{}", std::process::id()));
    std::fs::write(&path, data).expect("room for a temporary file");
    let steps = [("log_time", 1, 0), ("u4", 2, 1), ("string", 1, -1), ("f8", 9, 3)]
        .map(|(word, count, column)| (word.to_owned(), count, column));
    if let Ok(contents) = ros::contents(&path, kind, MOST) {
        let ids: Vec<u32> = contents.channels.iter().map(|channel| channel.id).collect();
        let cdr = kind == LogKind::Mcap;
        let program = Program::compile(&steps, cdr, &[0, 1, 3, 11], Some(0)).expect("the steps are right");
        let _ = ros::messages(&path, kind, &ids, &program, MOST);
    }
}
