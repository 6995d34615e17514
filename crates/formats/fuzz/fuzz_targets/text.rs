//! Text tables: the first bytes choose the dialect. Single columns must equal those of the whole table.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sigmatau_formats::date::Order;
use sigmatau_formats::{Delimiter, Dialect, Encoding, Writing, read_columns, read_written};

fuzz_target!(|data: &[u8]| {
    let [choice, columns, text @ ..] = data else { return };
    let delimiter = match choice & 3 {
        0 => Delimiter::Byte(b','),
        1 => Delimiter::Byte(b';'),
        2 => Delimiter::Byte(b'\t'),
        _ => Delimiter::Whitespace,
    };
    let columns = usize::from(columns % 8) + 1;
    let dialect = Dialect {
        delimiter,
        comment: vec![b"#".to_vec(), b"//".to_vec()],
        skip_lines: usize::from(choice >> 6),
        columns,
        dates: (choice & 8 != 0).then_some(Order::DayFirst),
        arrow: choice & 16 != 0 && columns > 1,
        most: u64::MAX,
        tag: None,
    };
    let wanted: Vec<usize> = (0..columns).step_by(2).collect();
    let exact = (choice & 4 != 0).then_some(0);
    let encoding = match choice >> 4 & 3 {
        1 => Encoding::Utf16Le,
        2 => Encoding::Utf16Be,
        _ => Encoding::Ascii,
    };
    let writing = Writing { encoding, decimal_comma: choice & 8 != 0, lines: None };
    if let Ok(table) = read_written(text, writing, &dialect, &wanted, exact) {
        let lines = text.iter().filter(|&&byte| byte == b'\n').count() + 1;
        assert!(encoding != Encoding::Ascii || table.rows <= lines);
        assert!(table.columns.iter().all(|column| column.iter().all(|value| !value.is_infinite())));
    }
    if let Ok(all) = read_columns(text, &dialect, &(0..columns).collect::<Vec<_>>(), None) {
        for (k, column) in all.columns.iter().enumerate() {
            let one = read_columns(text, &dialect, &[k], None).expect("the whole table could be read");
            let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&one.columns[0]), bits(column));
        }
    }
});
