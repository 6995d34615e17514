//! Serialised messages: faults found by mutated input.

use sigmatau_formats::ros::Program;

/// Found by the fuzz target `messages`: a sequence of elements without bytes, with the largest possible count.
#[test]
fn a_sequence_of_nothing_takes_no_time() {
    let steps = [("[", -1, -1), ("log_time", 1, 0), ("]", 0, -1), ("u1", 1, 1)]
        .map(|(word, count, column)| (word.to_owned(), count, column));
    let program = Program::compile(&steps, true, &[0, 1], None).unwrap();
    let mut columns = program.columns();
    let message = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 42];
    assert!(program.decode(&message, &[message.len()], &[7], &mut columns));
    assert_eq!(columns.floats, [[7.0], [42.0]]);
}
