//! Dates and times of day in tables, converted to nanoseconds.

/// Order of day and month in a date that ends in the year: `07/08/2026`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// 7 August.
    DayFirst,
    /// 8 July.
    MonthFirst,
}

/// Parts of a stamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// A day and a time of day.
    Date,
    /// Only a day, at midnight.
    Day,
    /// A time of day, on the first day of 1970.
    Clock,
    /// Only minutes and seconds, `51:26.3`, as spreadsheets save a time of day.
    Minutes,
}

/// A stamp read from text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stamp {
    /// Nanoseconds since 1970.
    pub nanos: i64,
    /// Parts in the text.
    pub form: Form,
    /// Whether the other order of day and month gives a different date, or no date.
    pub ordered: bool,
}

const NANOS: i64 = 1_000_000_000;
const DAY: i64 = 86_400;
const MONTHS: [&[u8]; 12] =
    [b"jan", b"feb", b"mar", b"apr", b"may", b"jun", b"jul", b"aug", b"sep", b"oct", b"nov", b"dec"];

/// Reads a stamp, from 1678 to 2261, in any of these forms:
///
/// - `2026-03-01 12:00:00.000`, also with `T` in the middle, `/` for `-` (from Excel), or `Z` or an offset at the end;
///   without them it is UTC. Digits beyond the ninth are dropped;
/// - days as `2026-3-1`, `01.03.2026`, `3/1/26` (in this `order`), `1-Mar-2026`, or with the day of the year, `2026-060`;
/// - times as `9:51:26.259`, `09:51:26:259` (milliseconds), `9:51:26,259`, `9:51:26.259 AM`, or `51:26.3` without a day;
/// - a day and a time with `T`, spaces, a comma, `-`, `_` or `:` (after a day of the year) in between, or only one of them.
#[must_use]
pub fn stamp(text: &[u8], order: Order) -> Option<Stamp> {
    let mut rest = text;
    let day = parse_day(&mut rest, order);
    let ordered = day.is_some_and(|(_, ordered)| ordered);
    let seconds = day.map_or(0, |(day, _)| day * DAY);
    if day.is_some() {
        if rest.is_empty() {
            return Some(Stamp { nanos: seconds.checked_mul(NANOS)?, form: Form::Day, ordered });
        }
        let comma = take_any(&mut rest, b",").is_some();
        if take_any(&mut rest, if comma { b" " } else { b"Tt _-:" }).is_none() && !comma {
            return None;
        }
        rest = rest.trim_ascii_start();
    }
    let (within, whole) = parse_clock(&mut rest, day.is_none())?;
    let nanos = seconds.checked_sub(offset(rest)?)?.checked_mul(NANOS)?.checked_add(within)?;
    let form = match (day, whole) {
        (Some(_), _) => Form::Date,
        (None, true) => Form::Clock,
        (None, false) => Form::Minutes,
    };
    Some(Stamp { nanos, form, ordered })
}

/// The day at the start of a text, counted from 1970, and whether the order of day and month matters.
fn parse_day(rest: &mut &[u8], order: Order) -> Option<(i64, bool)> {
    let mut after = *rest;
    let (first, digits) = whole_number(&mut after, 4)?;
    // In files with decimal commas, points and commas have been exchanged.
    let separator = take_any(&mut after, b"-/., :")?;
    let (day, ordered) = if digits == 4 {
        let mut rest = after;
        let (second, digits) = whole_number(&mut rest, 3)?;
        if digits == 3 {
            after = rest;
            let last = if is_leap(first) { 366 } else { 365 };
            ((1..=last).contains(&second).then(|| days(first, 1, 1) + second - 1)?, false)
        } else {
            take_any(&mut rest, &[separator]).filter(|&byte| byte != b' ' && byte != b':')?;
            let (third, _) = whole_number(&mut rest, 2)?;
            after = rest;
            (day_number(first, second, third)?, false)
        }
    } else {
        let named = month_name(&mut after);
        let (second, _) = match named {
            Some(month) => (month, 0),
            None if separator == b' ' || separator == b':' => return None,
            None => whole_number(&mut after, 2)?,
        };
        take_any(&mut after, &[separator])?;
        let (year, digits) = whole_number(&mut after, 4)?;
        let year = match digits {
            4 => year,
            2 => year + if year < 70 { 2000 } else { 1900 },
            _ => return None,
        };
        let (day, month) = match order {
            Order::MonthFirst if named.is_none() => (second, first),
            _ => (first, second),
        };
        (day_number(year, month, day)?, named.is_none())
    };
    *rest = after;
    Some((day, ordered))
}

/// Nanoseconds since midnight of the time of day at the start of a text, and whether it has an hour. A time without an hour
/// needs `minutes_alone` and decimals.
fn parse_clock(rest: &mut &[u8], minutes_alone: bool) -> Option<(i64, bool)> {
    let (first, _) = whole_number(rest, 2)?;
    take_any(rest, b":")?;
    let (second, _) = whole_number(rest, 2)?;
    let third = match take_any(rest, b":") {
        Some(_) => Some(whole_number(rest, 2)?.0),
        None => None,
    };
    let nanos = match (third, take_any(rest, b".,:")) {
        (_, None) => None,
        (Some(_), Some(b':')) => Some(thousandths(rest)?),
        (_, Some(b':')) => return None,
        _ => Some(fraction(rest)?),
    };
    let (hour, minute, seconds, whole) = match third {
        Some(seconds) => (first, second, seconds, true),
        None if minutes_alone && nanos.is_some() => (0, first, second, false),
        None if minutes_alone => return None,
        None => (first, second, 0, true),
    };
    let hour = if whole { half_day(rest, hour)? } else { hour };
    // A leap second is written as 60; it is counted as the next second.
    let valid = hour <= 23 && minute <= 59 && seconds <= 60;
    valid.then(|| ((hour * 3600 + minute * 60 + seconds) * NANOS + nanos.unwrap_or(0), whole))
}

/// Removes `AM` or `PM` and converts to 24 hours; without them, the hour itself.
fn half_day(rest: &mut &[u8], hour: i64) -> Option<i64> {
    let mut after = rest.trim_ascii_start();
    let Some(half) = take_any(&mut after, b"AaPp") else { return Some(hour) };
    let _ = take_any(&mut after, b".");
    take_any(&mut after, b"Mm")?;
    let _ = take_any(&mut after, b".");
    *rest = after;
    let afternoon = half.eq_ignore_ascii_case(&b'p');
    (1..=12).contains(&hour).then_some(hour % 12 + if afternoon { 12 } else { 0 })
}

/// Milliseconds of at most three digits, or microseconds of six, in nanoseconds.
fn thousandths(rest: &mut &[u8]) -> Option<i64> {
    match whole_number(rest, 6)? {
        (millis, 1..=3) => Some(millis * 1_000_000),
        (micros, 6) => Some(micros * 1000),
        _ => None,
    }
}

/// Removes the English name of a month, whole or its first three letters; the number of the month.
fn month_name(rest: &mut &[u8]) -> Option<i64> {
    let letters = rest.iter().take_while(|b| b.is_ascii_alphabetic()).count();
    let name = rest.get(..3).filter(|_| (3..=9).contains(&letters))?;
    let month = MONTHS.iter().position(|month| month.eq_ignore_ascii_case(name))?;
    *rest = &rest[letters..];
    Some(month as i64 + 1)
}

/// Reads up to `most` digits, at least one; their value and their number.
fn whole_number(rest: &mut &[u8], most: usize) -> Option<(i64, usize)> {
    let count = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    (1..=most).contains(&count).then(|| Some((number(rest, count)?, count)))?
}

/// Days since 1970 of a date; None if the month has no such day.
fn day_number(year: i64, month: i64, day: i64) -> Option<i64> {
    let days_of_month = match month {
        4 | 6 | 9 | 11 => 30,
        2 if is_leap(year) => 29,
        2 => 28,
        1..=12 => 31,
        _ => return None,
    };
    (1..=days_of_month).contains(&day).then(|| days(year, month, day))
}

fn is_leap(year: i64) -> bool {
    (year % 4 == 0 && year % 100 != 0) || year % 400 == 0
}

/// Days since 1970 of a day of the Gregorian calendar, counted in years that begin in March.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    year * 365 + year / 4 - year / 100 + year / 400 + day_of_year - 719_468
}

/// Reads an exact number of digits.
fn number(rest: &mut &[u8], digits: usize) -> Option<i64> {
    let (own, after) = rest.split_at_checked(digits)?;
    *rest = after;
    own.iter().try_fold(0, |sum, b| b.is_ascii_digit().then(|| sum * 10 + i64::from(b - b'0')))
}

/// Removes the next byte if it is one of `bytes`.
fn take_any(rest: &mut &[u8], bytes: &[u8]) -> Option<u8> {
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

/// Seconds that a zone is ahead of UTC: empty, `Z`, `+01:00`, `+0100` or `+01`.
fn offset(mut rest: &[u8]) -> Option<i64> {
    if take_any(&mut rest, b" ").is_some() && rest.is_empty() {
        return None;
    }
    if rest.is_empty() || rest.eq_ignore_ascii_case(b"z") || rest.eq_ignore_ascii_case(b"utc") {
        return Some(0);
    }
    let sign = take_any(&mut rest, b"+-")?;
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
    use super::{Form, Order, stamp};

    /// Nanoseconds since 1970 of a date and time that begins with the year.
    fn nanoseconds(text: &[u8]) -> Option<i64> {
        stamp(text, Order::DayFirst).filter(|s| s.form == Form::Date && !s.ordered).map(|s| s.nanos)
    }

    const NOON: i64 = 1_772_366_400_000_000_000; // date -u -d 2026-03-01T12:00:00 +%s

    const MORNING: i64 = 1_563_789_086_259_000_000; // date -u -d 2019-07-22T09:51:26.259 +%s%3N
    const MIDNIGHT: i64 = MORNING - CLOCK;
    const CLOCK: i64 = ((9 * 60 + 51) * 60 + 26) * 1_000_000_000 + 259_000_000;

    #[test]
    fn a_day_and_a_time_apart() {
        let read = |text: &str| stamp(text.as_bytes(), Order::DayFirst);
        let (day, time) = (read("2026-03-01").unwrap(), read("12:00:00.5").unwrap());
        assert_eq!(day.nanos + time.nanos, NOON + 500_000_000);
        assert_eq!((day.form, time.form), (Form::Day, Form::Clock));
        for wrong in ["", "12", "12:", "24:00:00", "2026-03-32", "2026-03-01 12", "12:00:00 12:00", "12:00"] {
            assert_eq!(read(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn every_clock() {
        for (text, form, expected) in [
            ("9:51:26.259", Form::Clock, CLOCK),
            ("09:51:26:259", Form::Clock, CLOCK),
            ("09:51:26,259", Form::Clock, CLOCK),
            ("09:51:26:259000", Form::Clock, CLOCK),
            ("9:51:26.259 AM", Form::Clock, CLOCK),
            ("9:51:26.259am", Form::Clock, CLOCK),
            ("9:51:26.259 p.m.", Form::Clock, CLOCK + 43_200_000_000_000),
            ("12:00:00 AM", Form::Clock, 0),
            ("12:00:00 PM", Form::Clock, 43_200_000_000_000),
            ("9:51:26:9", Form::Clock, CLOCK - 250_000_000),
            ("09:51:26.259+00:00", Form::Clock, CLOCK),
            ("51:26.259", Form::Minutes, CLOCK - 9 * 3_600_000_000_000),
            ("2019-07-22", Form::Day, MIDNIGHT),
            ("22.07.2019", Form::Day, MIDNIGHT),
            ("22,07,2019", Form::Day, MIDNIGHT),
            ("22/7/19", Form::Day, MIDNIGHT),
            ("22-Jul-2019", Form::Day, MIDNIGHT),
            ("22 July 2019", Form::Day, MIDNIGHT),
            ("2019-203", Form::Day, MIDNIGHT),
            ("2019-7-22 9:51:26.259", Form::Date, MORNING),
            ("22/07/2019 09:51:26.259", Form::Date, MORNING),
            ("22/07/2019, 9:51:26.259 AM", Form::Date, MORNING),
            ("22.07.2019T09:51:26.259Z", Form::Date, MORNING),
            ("22.07.2019 11:51:26.259 +02:00", Form::Date, MORNING),
            ("2019-07-22_09:51:26.259", Form::Date, MORNING),
            ("2019-07-22-09:51:26:259", Form::Date, MORNING),
            ("22-Jul-2019 09:51:26.259", Form::Date, MORNING),
            ("2019:203:09:51:26.259", Form::Date, MORNING),
            ("2019-203T09:51:26.259Z", Form::Date, MORNING),
        ] {
            let parsed = stamp(text.as_bytes(), Order::DayFirst);
            assert_eq!(parsed.map(|stamp| (stamp.form, stamp.nanos)), Some((form, expected)), "{text}");
        }
    }

    #[test]
    fn the_order_of_day_and_month() {
        let both = |text: &[u8]| [Order::DayFirst, Order::MonthFirst].map(|order| stamp(text, order));
        for (text, nanos) in [
            ("07/22/2019 09:51:26.259", [None, Some(MORNING)]),
            ("22/07/2019 09:51:26.259", [Some(MORNING), None]),
            ("03/01/2026 12:00:00", [Some(NOON - 57 * 86_400_000_000_000), Some(NOON)]),
        ] {
            let parsed = both(text.as_bytes());
            assert_eq!(parsed.map(|stamp| stamp.map(|s| s.nanos)), nanos, "{text}");
            assert!(parsed.iter().flatten().all(|stamp| stamp.ordered), "{text}");
        }
        for text in ["2026-03-01 12:00:00", "1-Mar-2026 12:00", "12:00:00"] {
            let parsed = both(text.as_bytes());
            assert_eq!(parsed[0], parsed[1], "{text}");
            assert!(!parsed[0].unwrap().ordered, "{text}");
        }
    }

    #[test]
    fn what_is_no_stamp() {
        for text in [
            "9",
            "9.5",
            "9:51",
            "9:51:26.",
            "9:51:61",
            "9:60:00",
            "123:00:00",
            "13:00:00 PM",
            "0:10:00 AM",
            "9:51:26 XM",
            "9:51:26:2599",
            "22/07",
            "22/07/2019 ",
            "22/07/2019 9",
            "22/13/2019",
            "29/02/2019",
            "22/07/2019x9:51:26",
            "22-Foo-2019",
            "22 07 2019",
            "2019-366",
            "2019-000",
            "1.2.3",
            "1,2,3",
            "60:00.5",
            "1e5",
            "-9:51:26",
            "99:99.5",
        ] {
            assert_eq!(stamp(text.as_bytes(), Order::DayFirst), None, "{text}");
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
