//! Sums of rows times factors, several elements side by side.

use pulp::Simd;

/// Adds the rows times their factors to `out`. Each element is summed in the order of the rows, so that the bits are the
/// same on every machine.
#[inline(always)]
#[allow(clippy::inline_always)] // Inlined into a function that is compiled for these vectors.
pub(crate) fn add_rows<'a, S: Simd>(
    simd: S,
    out: &mut [f64],
    rows: &(impl Iterator<Item = (f64, &'a [f64])> + Clone),
) {
    let (head, tail) = S::as_mut_simd_f64s(out);
    let mut start = 0;
    while start + 4 <= head.len() {
        add_tile::<S, 4>(simd, &mut head[start..start + 4], start, rows.clone());
        start += 4;
    }
    if start + 2 <= head.len() {
        add_tile::<S, 2>(simd, &mut head[start..start + 2], start, rows.clone());
        start += 2;
    }
    if start < head.len() {
        add_tile::<S, 1>(simd, &mut head[start..=start], start, rows.clone());
    }
    let first = head.len() * S::F64_LANES;
    for (k, x) in tail.iter_mut().enumerate() {
        rows.clone().for_each(|(factor, row)| *x += factor * row[first + k]);
    }
}

/// [`add_rows`] for the `T` vectors from index `start`, whose sums stay in registers.
#[inline(always)]
#[allow(clippy::inline_always)] // As above.
fn add_tile<'a, S: Simd, const T: usize>(
    simd: S,
    out: &mut [S::f64s],
    start: usize,
    rows: impl Iterator<Item = (f64, &'a [f64])>,
) {
    let mut sums = [simd.splat_f64s(0.0); T];
    sums.copy_from_slice(out);
    let (from, to) = (start * S::F64_LANES, (start + T) * S::F64_LANES);
    for (factor, row) in rows {
        let factor = simd.splat_f64s(factor);
        for (sum, value) in sums.iter_mut().zip(S::as_simd_f64s(&row[from..to]).0) {
            *sum = simd.add_f64s(*sum, simd.mul_f64s(factor, *value));
        }
    }
    out.copy_from_slice(&sums);
}
