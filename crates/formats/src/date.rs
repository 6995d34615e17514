//! Dates of ISO 8601 into nanoseconds since 1970, as tables have them for stamps.

/// Nanoseconds since 1970 of a date and time: `2026-03-01 12:00:00.000`, with `T` between, `/` for `-` (as Excel writes it),
/// `Z` or an offset after it; without either as UTC. Seconds may be left out, and digits beyond the ninth are dropped.
///
/// Nothing if it is no such date, or beyond the years 1678 to 2261.
#[must_use]
pub fn nanoseconds(text: &[u8]) -> Option<i64> {
    let mut rest = text;
    let year = number(&mut rest, 4)?;
    let dash = one_of(&mut rest, b"-/")?;
    let month = number(&mut rest, 2)?;
    one_of(&mut rest, &[dash])?;
    let day = number(&mut rest, 2)?;
    one_of(&mut rest, b"Tt ")?;
    let hour = number(&mut rest, 2)?;
    one_of(&mut rest, b":")?;
    let minute = number(&mut rest, 2)?;
    let (mut second, mut nanos) = (0, 0);
    if one_of(&mut rest, b":").is_some() {
        second = number(&mut rest, 2)?;
        // Where decimals have commas, points and commas have been exchanged, or have not.
        if one_of(&mut rest, b".,").is_some() {
            nanos = fraction(&mut rest)?;
        }
    }
    let offset = offset(rest)?;
    let leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
    let days_of_month = match month {
        4 | 6 | 9 | 11 => 30,
        2 if leap => 29,
        2 => 28,
        1..=12 => 31,
        _ => return None,
    };
    // A leap second is 60, and the next second in a count that has none.
    if !(1..=days_of_month).contains(&day) || hour > 23 || minute > 59 || second > 60 {
        return None;
    }
    let seconds = days(year, month, day) * 86_400 + hour * 3600 + minute * 60 + second - offset;
    seconds.checked_mul(1_000_000_000)?.checked_add(nanos)
}

/// The same of a day alone, at midnight, and of a time alone, on the first day of 1970.
#[must_use]
pub fn part(text: &[u8]) -> Option<i64> {
    if text.get(2) == Some(&b':') {
        nanoseconds(&[b"1970-01-01 ", text].concat())
    } else {
        nanoseconds(&[text, b" 00:00"].concat())
    }
}

/// Days since 1970 of a day of the Gregorian calendar, counted in years that begin in March.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    year * 365 + year / 4 - year / 100 + year / 400 + day_of_year - 719_468
}

/// Exactly so many digits.
fn number(rest: &mut &[u8], digits: usize) -> Option<i64> {
    let (own, after) = rest.split_at_checked(digits)?;
    *rest = after;
    own.iter().try_fold(0, |sum, b| b.is_ascii_digit().then(|| sum * 10 + i64::from(b - b'0')))
}

/// One of these bytes, which is taken off.
fn one_of(rest: &mut &[u8], bytes: &[u8]) -> Option<u8> {
    let (&first, after) = rest.split_first()?;
    bytes.contains(&first).then(|| {
        *rest = after;
        first
    })
}

/// Digits after the point, in nanoseconds.
fn fraction(rest: &mut &[u8]) -> Option<i64> {
    let count = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    let (digits, after) = rest.split_at(count);
    *rest = after;
    let nanos = (0..9).fold(0, |sum, k| sum * 10 + digits.get(k).map_or(0, |b| i64::from(b - b'0')));
    (count > 0).then_some(nanos)
}

/// Seconds that a zone is ahead of UTC: nothing, `Z`, `+01:00`, `+0100` or `+01`.
fn offset(mut rest: &[u8]) -> Option<i64> {
    if one_of(&mut rest, b" ").is_some() && rest.is_empty() {
        return None;
    }
    if rest.is_empty() || rest.eq_ignore_ascii_case(b"z") || rest.eq_ignore_ascii_case(b"utc") {
        return Some(0);
    }
    let sign = one_of(&mut rest, b"+-")?;
    let hours = number(&mut rest, 2)?;
    let minutes = match rest {
        [] => 0,
        [b':', ..] => number(&mut &rest[1..], 2).filter(|_| rest.len() == 3)?,
        _ => number(&mut &*rest, 2).filter(|_| rest.len() == 2)?,
    };
    let ahead = hours * 3600 + minutes * 60;
    (hours < 24 && minutes < 60).then_some(if sign == b'-' { -ahead } else { ahead })
}

#[cfg(test)]
mod tests {
    use super::{nanoseconds, part};

    const NOON: i64 = 1_772_366_400_000_000_000; // date -u -d 2026-03-01T12:00:00 +%s

    #[test]
    fn a_day_and_a_time_apart() {
        let time = part(b"12:00:00.5").unwrap();
        assert_eq!(part(b"2026-03-01").unwrap() + time, NOON + 500_000_000);
        for wrong in ["", "12", "12:", "24:00:00", "2026-03-32", "2026-03-01 12:00", "12:00:00 12:00"] {
            assert_eq!(part(wrong.as_bytes()), None, "{wrong}");
        }
    }

    #[test]
    fn every_spelling() {
        for (text, expected) in [
            ("2026-03-01 12:00:00", NOON),
            ("2026-03-01T12:00:00.000", NOON),
            ("2026/03/01 12:00", NOON),
            ("2026-03-01t12:00:00,5z", NOON + 500_000_000),
            ("2026-03-01T12:00:00.123456789Z", NOON + 123_456_789),
            ("2026-03-01T12:00:00.1234567899", NOON + 123_456_789),
            ("2026-03-01 13:00:00+01:00", NOON),
            ("2026-03-01 06:30:00.0 -0530", NOON),
            ("2026-03-01 14:00+02", NOON),
            ("2026-03-01 12:00:00 UTC", NOON),
            ("1970-01-01T00:00:00Z", 0),
            ("1969-12-31T23:59:59.999999999Z", -1),
            ("2000-02-29 00:00:00", 951_782_400_000_000_000),
            ("2016-12-31 23:59:60", 1_483_228_800_000_000_000),
        ] {
            assert_eq!(nanoseconds(text.as_bytes()), Some(expected), "{text}");
        }
    }

    #[test]
    fn what_is_no_date() {
        for text in [
            "",
            "2026",
            "2026-03-01",
            "2026-03-01 ",
            "2026-03/01 12:00",
            "2026-13-01 12:00",
            "2025-02-29 12:00",
            "2026-03-00 12:00",
            "2026-03-01 24:00:00",
            "2026-03-01 12:60:00",
            "2026-03-01 12:00:61",
            "2026-03-01 12:00:00.",
            "2026-03-01 12:00:00 ",
            "2026-03-01 12:00:00x",
            "2026-03-01 12:00:00+1",
            "2026-03-01 12:00:00+01:0",
            "2026-03-01 12:00:00+01:000",
            "2026-03-01 12:00:00+25:00",
            "26-03-01 12:00:00",
            "01.03.2026 12:00:00",
            "9999-01-01 00:00:00",
            "12:00:00",
        ] {
            assert_eq!(nanoseconds(text.as_bytes()), None, "{text}");
        }
    }
}
