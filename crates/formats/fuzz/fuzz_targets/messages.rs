//! Serialised messages: both the definition and the message are made from the input.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sigmatau_formats::ros::Program;

const WORDS: [&str; 12] = ["u1", "i2", "u4", "i8", "f4", "f8", "time", "string", "[", "]", "log_time", "?"];

fuzz_target!(|data: &[u8]| {
    let [count, flags, rest @ ..] = data else { return };
    let count = usize::from(count % 16).min(rest.len() / 2);
    let (definition, body) = rest.split_at(2 * count);
    let steps: Vec<(String, i64, i64)> = definition
        .chunks(2)
        .enumerate()
        .map(|(k, pair)| {
            let word = WORDS[usize::from(pair[0]) % WORDS.len()].to_owned();
            (word, i64::from(pair[1] as i8), k as i64 * 4 - 4)
        })
        .collect();
    let wanted: Vec<usize> = (0..32).step_by(3).collect();
    let Ok(program) = Program::compile(&steps, flags & 1 == 0, &wanted, (flags & 2 != 0).then_some(0)) else {
        return;
    };
    let mut columns = program.columns();
    let ends: Vec<usize> = (0..=3).map(|k| k * body.len() / 3).skip(1).collect();
    program.decode(body, &ends, &[1, 2, 3], &mut columns);
});
