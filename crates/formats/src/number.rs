//! The plain decimal number: digits, a point, digits, an exponent. Anything else is left to the slow way.

// A call costs as much as the work of one of these, which is done for every number.
#![allow(clippy::inline_always)]

/// Bytes that may be looked at beyond the end of a number. \[bytes\]
pub(crate) const PAD: usize = 32;

/// Digits of the longest integer that always fits 64 bits.
const DIGITS: usize = 19;

/// Powers of ten that a double holds exactly.
const EXACT: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

const TENS: [u64; 9] = [1, 10, 100, 1000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// For k = 0 … 37 the first 64 bits of 10^−k, the rest cut off, and the power of two that they count in.
const INVERSES: [(u64, i32); 38] = inverses();

/// A number as it is written.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Written {
    negative: bool,
    /// All the digits as one integer; wrapped around if they are too many.
    mantissa: u64,
    /// Whether they are not too many.
    fits: bool,
    exponent: i32,
    /// Whether there is neither a point nor an exponent.
    whole: bool,
    /// Where it ends.
    pub(crate) end: usize,
}

/// The value and the end of a plain number that begins with one digit, the point and 16 to 23 digits, as doubles below ten
/// are written in full; nothing if there is none, or its value is not found in a quick way.
///
/// There must be [`PAD`] bytes after the number, whatever they are.
#[inline(always)]
pub(crate) fn long_fraction(text: &[u8], start: usize) -> Option<(f64, usize)> {
    let (negative, at) = sign(text, start);
    let window: &[u8; 26] = text[at..].first_chunk()?;
    let first = window[0].wrapping_sub(b'0');
    let (one, two, three) = (ascii(window, 2), ascii(window, 10), ascii(window, 18));
    let count = digits_in(three);
    if first > 9 || window[1] != b'.' || others(one) | others(two) != 0 || count == 8 {
        return None;
    }
    let end = at + 18 + count;
    // Zeros before the first digit that counts, up to eight of them.
    let zeros = if first == 0 { (one.trailing_zeros() / 8) as usize } else { 0 };
    let sixteen = (u64::from(first) * TENS[8] + value_of(one)) * TENS[8] + value_of(two);
    let mantissa = sixteen.wrapping_mul(TENS[count]).wrapping_add(value_of(low(three, count)));
    let fits = count + 16 + usize::from(first > 0) - zeros <= DIGITS;
    if !fits || mantissa == 0 || text[end] | 0x20 == b'e' {
        return None;
    }
    Some((signed(quotient(mantissa, 16 + count)?, negative), end))
}

/// The value and the end of a plain number of up to seven digits and, after a point, up to fifteen more, as loggers write
/// them; nothing if there is none, or its value is not found in a quick way.
///
/// There must be [`PAD`] bytes after the number, whatever they are.
#[inline(always)]
pub(crate) fn short_number(text: &[u8], start: usize) -> Option<(f64, usize)> {
    let (negative, at) = sign(text, start);
    let head = ascii(text, at);
    let before = digits_in(head);
    if before == 0 || before == 8 {
        return None;
    }
    let whole = value_of(low(head, before));
    let point = at + before;
    if text[point] != b'.' {
        return (text[point] | 0x20 != b'e').then(|| (signed(whole as f64, negative), point));
    }
    let one = ascii(text, point + 1);
    let count = digits_in(one);
    let (size, end) = if count < 8 {
        let mantissa = whole * TENS[count] + value_of(low(one, count));
        // Fourteen digits: one rounding of two exact numbers.
        (mantissa as f64 / EXACT[count], point + 1 + count)
    } else {
        let two = ascii(text, point + 9);
        let more = digits_in(two);
        let eight = whole * TENS[8] + value_of(one);
        if more == 8 || eight == 0 || before + 8 + more > DIGITS {
            return None;
        }
        (quotient(eight * TENS[more] + value_of(low(two, more)), 8 + more)?, point + 9 + more)
    };
    (count > 0 && text[end] | 0x20 != b'e').then(|| (signed(size, negative), end))
}

/// Reads the plain number that begins at `start`; nothing if there is none.
///
/// There must be [`PAD`] bytes after the number, whatever they are.
pub(crate) fn scan(text: &[u8], start: usize) -> Option<Written> {
    let (negative, mut at) = sign(text, start);
    let (mut mantissa, mut digits) = (u64::from(text[at].wrapping_sub(b'0')), 1);
    if text[at + 1] == b'.' && mantissa < 10 {
        at += 1;
    } else {
        (mantissa, digits) = (0, 0);
        run(text, &mut at, &mut mantissa, &mut digits);
        if digits == 0 {
            return None;
        }
    }
    let mut exponent = 0;
    let mut whole = true;
    if text[at] == b'.' {
        at += 1;
        // Zeros before the first digit that counts, up to eight of them.
        let zeros = if mantissa == 0 {
            digits = 0;
            (ascii(text, at).trailing_zeros() / 8) as usize
        } else {
            0
        };
        let point = at;
        run(text, &mut at, &mut mantissa, &mut digits);
        if at == point {
            return None;
        }
        exponent = -((at - point) as i32);
        digits = digits.saturating_sub(zeros);
        whole = false;
    }
    if text[at] | 0x20 == b'e' {
        at += 1;
        let down = text[at] == b'-';
        at += usize::from(matches!(text[at], b'-' | b'+'));
        let (mut power, mut digits) = (0, 0);
        run(text, &mut at, &mut power, &mut digits);
        if !(1..=4).contains(&digits) {
            return None;
        }
        let power = power as i32;
        exponent += if down { -power } else { power };
        whole = false;
    }
    Some(Written { negative, mantissa, fits: digits <= DIGITS, exponent, whole, end: at })
}

impl Written {
    /// The nearest double, if it is found in a quick way.
    pub(crate) fn nearest(self) -> Option<f64> {
        if !self.fits {
            return None;
        }
        let size = if self.mantissa == 0 || self.exponent == 0 {
            self.mantissa as f64
        } else if self.exponent < 0 {
            quotient(self.mantissa, self.exponent.unsigned_abs() as usize)?
        } else if self.mantissa <= 1 << 53 {
            // One rounding of two exact numbers.
            self.mantissa as f64 * EXACT.get(self.exponent as usize)?
        } else {
            return None;
        };
        Some(signed(size, self.negative))
    }

    /// The integer, if it is written as one and fits.
    pub(crate) fn integer(self) -> Option<i64> {
        let size = i64::try_from(self.mantissa).ok()?;
        (self.fits && self.whole).then_some(if self.negative { -size } else { size })
    }
}

/// Whether there is a minus, and where the digits begin.
#[inline(always)]
fn sign(text: &[u8], start: usize) -> (bool, usize) {
    let first = text[start];
    (first == b'-', start + usize::from(matches!(first, b'-' | b'+')))
}

/// Without a branch, which noise about zero would have guessed wrong every other time.
#[inline(always)]
fn signed(size: f64, negative: bool) -> f64 {
    f64::from_bits(size.to_bits() | (u64::from(negative) << 63))
}

/// The double nearest to m / 10^k, for m > 0 and k > 0, if it can be told.
///
/// 10^−k never ends in binary, so that the true product lies above that of m and the bits that are kept of 10^−k, and by
/// less than one unit of its upper word. Where that unit could carry into the bit that rounds, nothing is told; elsewhere
/// the true product is no tie, and the bit alone decides.
#[inline(always)]
fn quotient(m: u64, k: usize) -> Option<f64> {
    let &(inverse, power) = INVERSES.get(k)?;
    let shift = m.leading_zeros();
    let upper = ((u128::from(m << shift) * u128::from(inverse)) >> 64) as u64;
    // The upper word has 63 or 64 bits: 53 of the result, one that rounds, and the rest.
    let cut = 9 + (upper >> 63) as u32;
    let rest = (1_u64 << cut) - 1;
    if upper & rest == rest {
        let both_exact = m <= 1 << 53 && k < EXACT.len();
        return both_exact.then(|| m as f64 / EXACT[k]);
    }
    let rounded = ((upper >> cut) + 1) >> 1;
    let scale = power + 64 + cut as i32 + 1 - shift as i32;
    // As a signed integer, which takes one instruction.
    Some(rounded as i64 as f64 * f64::from_bits(((1023 + scale) as u64) << 52))
}

/// Takes digits up to the first byte that is none.
#[inline(always)]
fn run(text: &[u8], at: &mut usize, mantissa: &mut u64, digits: &mut usize) {
    let begin = *at;
    loop {
        let eight = ascii(text, *at);
        let count = digits_in(eight);
        if count == 8 {
            *mantissa = mantissa.wrapping_mul(TENS[8]).wrapping_add(value_of(eight));
            *at += 8;
            continue;
        }
        *mantissa = mantissa.wrapping_mul(TENS[count]).wrapping_add(value_of(low(eight, count)));
        *at += count;
        break;
    }
    *digits += *at - begin;
}

/// Marks the bytes that are no digits; those after the first may be wrong.
#[inline(always)]
fn others(eight: u64) -> u64 {
    (eight.wrapping_add(0x7676_7676_7676_7676) | eight) & 0x8080_8080_8080_8080
}

/// Digits before the first byte that is none.
#[inline(always)]
fn digits_in(eight: u64) -> usize {
    (others(eight).trailing_zeros() / 8) as usize
}

/// The first `count` digits, fewer than eight, at the upper end with zeros before them.
#[inline(always)]
fn low(eight: u64, count: usize) -> u64 {
    // In two steps, because there may be none.
    (eight << (56 - 8 * count)) << 8
}

/// Eight bytes as one number, the first one lowest, a digit as its value.
#[inline(always)]
fn ascii(text: &[u8], at: usize) -> u64 {
    let mut eight = [0; 8];
    eight.copy_from_slice(&text[at..at + 8]);
    u64::from_le_bytes(eight) ^ 0x3030_3030_3030_3030
}

/// The number that eight digits make: pairs first, then the four pairs in two multiplications.
#[inline(always)]
fn value_of(eight: u64) -> u64 {
    const PAIRS: u64 = 0x0000_00ff_0000_00ff;
    let pairs = eight.wrapping_mul(10).wrapping_add(eight >> 8);
    let odd = (pairs & PAIRS).wrapping_mul(100 + (1_000_000 << 32));
    let even = ((pairs >> 16) & PAIRS).wrapping_mul(1 + (10_000 << 32));
    odd.wrapping_add(even) >> 32
}

const fn inverses() -> [(u64, i32); 38] {
    let mut table = [(0, 0); 38];
    let mut divisor = 1_u128;
    let mut k = 0;
    while k < table.len() {
        // Long division of a power of two.
        let (mut rest, mut power) = (1_u128, 0);
        while rest < divisor {
            rest <<= 1;
            power -= 1;
        }
        let mut bits = 0_u64;
        let mut i = 0;
        while i < 64 {
            bits <<= 1;
            if rest >= divisor {
                rest -= divisor;
                bits |= 1;
            }
            rest <<= 1;
            i += 1;
        }
        table[k] = (bits, power - 63);
        divisor *= 10;
        k += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quick(text: &str) -> Option<(Option<f64>, Option<i64>, usize)> {
        let padded = [text.as_bytes(), &[b','; PAD]].concat();
        let found = scan(&padded, 0).map(|written| (written.nearest(), written.integer(), written.end));
        if let Some(long) = long_fraction(&padded, 0) {
            assert_eq!(found, Some((Some(long.0), None, long.1)), "{text}");
        }
        if let Some((value, end)) = short_number(&padded, 0) {
            let (nearest, _, expected_end) = found.expect(text);
            assert_eq!((value.to_bits(), end), (nearest.unwrap_or(value).to_bits(), expected_end), "{text}");
            assert_eq!(value.to_bits(), text[..end].parse::<f64>().unwrap().to_bits(), "{text}");
        }
        found
    }

    /// Random digits (splitmix64, seed fixed): as the standard library reads them, to the bit.
    #[test]
    fn the_nearest_double() {
        let mut state = 1_u64;
        let mut next = move || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            z ^ (z >> 31)
        };
        let (mut told, mut all) = (0, 0);
        for _ in 0..400_000 {
            let mut digits = (next() >> (next() % 64)).to_string();
            digits.truncate(1 + (next() % 20) as usize);
            let before = (next() % (digits.len() as u64 + 1)) as usize;
            let (whole, part) = digits.split_at(before);
            let sign = ["", "-", "+"][(next() % 3) as usize];
            let zeros = "0".repeat((next() % 9) as usize);
            let power = (next() % 60) as i32 - 30;
            let tail = if next() % 2 == 0 { String::new() } else { format!("e{power}") };
            let text = match (whole, part) {
                (_, "") => format!("{sign}{whole}{tail}"),
                ("", _) => format!("{sign}0.{zeros}{part}{tail}"),
                _ => format!("{sign}{whole}.{part}{tail}"),
            };
            let (value, _, end) = quick(&text).unwrap();
            assert_eq!(end, text.len(), "{text}");
            all += 1;
            if let Some(value) = value {
                told += 1;
                let expected: f64 = text.parse().unwrap();
                assert_eq!(value.to_bits(), expected.to_bits(), "{text}");
            }
        }
        assert!(told > all * 3 / 4, "{told} of {all}");
    }

    /// Numbers half-way between two doubles, and one unit of the last digit beside them: the worst there is.
    #[test]
    fn ties() {
        for k in 1..=20_u32 {
            // An odd number of 54 bits over 2^k is a tie; it has k digits after the point.
            for odd in [(1_u64 << 53) + 1, (1 << 54) - 1, (1 << 53) + 12_345_679] {
                let Some(scaled) = u128::from(odd).checked_mul(5_u128.pow(k)) else { continue };
                for near in [scaled - 1, scaled, scaled + 1] {
                    let digits = format!("{near:0>width$}", width = k as usize + 1);
                    let (whole, part) = digits.split_at(digits.len() - k as usize);
                    let text = format!("{whole}.{part}");
                    if let Some(value) = quick(&text).unwrap().0 {
                        assert_eq!(value.to_bits(), text.parse::<f64>().unwrap().to_bits(), "{text}");
                    }
                }
            }
        }
    }

    #[test]
    fn integers_and_ends() {
        assert_eq!(quick("9223372036854775807").unwrap().1, Some(i64::MAX));
        assert_eq!(quick("9223372036854775808").unwrap().1, None);
        assert_eq!(quick("-0042").unwrap(), (Some(-42.0), Some(-42), 5));
        assert_eq!(quick("2.0").unwrap(), (Some(2.0), None, 3));
        assert_eq!(quick("-0.0").unwrap().0.map(f64::to_bits), Some((-0.0_f64).to_bits()));
        assert_eq!(quick("1.5x").unwrap(), (Some(1.5), None, 3));
        // Too many digits are left to the slow way, leading zeros do not count.
        assert_eq!(quick("12345678901234567890").unwrap().0, None);
        assert_eq!(quick("0.00001234567890123456789").unwrap().0, Some(1.234_567_890_123_456_8e-5));
        for none in ["", "-", "+-1", ".", ".5", "5.", "e5", "1e", "1e+", "1e00005", "nan", "\"1\"", "#"] {
            assert!(quick(none).is_none(), "{none}");
        }
    }
}
