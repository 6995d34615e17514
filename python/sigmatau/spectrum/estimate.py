"""Estimates of power spectral densities; see `psd`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats
from sigmatau.errors import OptionError, RecordTooShortError
from sigmatau.record.record import Record, need_record
from sigmatau.record.streams import Stream
from sigmatau.results import seconds
from sigmatau.spectrum.result import Method, Spectra, Spectrum
from sigmatau.spectrum.tapers import good_length, hann, remove_trend, sine_correlation

# Welch's method uses evenly spaced segments of a record with more samples. The error of an average then depends on
# their number, and is 0.1 % for this one.
MAX_SAMPLES = 1 << 22
SHORTEST = 64  # Samples in the shortest segment that a spectrum is made of
# Longest default segment. [samples] A record of 1e6 samples has 480 of them: each of the 2048 bins has an error of 4.6 %.
_LONGEST_SEGMENT = 1 << 12
_MIN_SEGMENTS = 15
_BATCH_SAMPLES = 1 << 16  # number of samples that are transformed together, so that they stay in a core's cache
# Sum of the squared correlations of Hann-tapered segments that overlap by half, (1/6)², twice: Welch 1967.
_OVERLAP_CORRELATION = 2 / 36


def psd(
    record: Record | Stream,
    *,
    method: Method = "welch",
    segment: float | None = None,
    tapers: int = 8,
    f_max: float | None = None,
) -> Spectra:
    """Two-sided power spectral density of every channel of a record.

    Parameters
    ----------
    record : Record or Stream
        Static data. Welch's segments with a missing sample are omitted, and segments are shortened if too few are left; the
        multitaper estimate uses the longest run without a missing sample.
    method : {"welch", "multitaper"}
        Welch's average of Hann-tapered segments that overlap by half, each without its mean and the slope of the record
        [1]_; or the mean over sine tapers of the whole record without its mean and slope [2]_, for low frequencies.
    segment : float, optional
        Length of Welch's segments. Default: a power of two of samples, at most 4096, so that at least 15 fit in. [s]
    tapers : int
        Number of tapers of the multitaper estimate, which has 2·tapers degrees of freedom, fewer within a resolution of
        0 and of half the sampling rate; the resolution is (tapers + 1)/(2·record), to either side.
    f_max : float, optional
        Highest frequency of the multitaper estimate. Default: 4096 frequencies. [Hz]

    Returns
    -------
    Spectra
        A mapping from channel to `Spectrum`. [unit²/Hz, two-sided]

    Raises
    ------
    OptionError
        For an unknown method, fewer than 1 taper, or a segment that is longer than the record or under 8 samples.
    RecordTooShortError
        If no segment, of 64 samples by default, has all its samples.

    See Also
    --------
    cross_spectrum : coherence of two channels.
    transfer : the filter that shaped a spectrum.

    References
    ----------
    .. [1] P. D. Welch, :doi:`10.1109/TAU.1967.1161901`.
    .. [2] K. S. Riedel, A. Sidorenko, :doi:`10.1109/78.365298`, eqs. (8) and (9).

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> spectrum = st.psd(st.simulate(model, duration=600, rate=100, rng=1))["gyro_x"]
    >>> float(spectrum.density.mean().round(10))  # N²
    1e-08
    """
    need_record(record, stream=True)
    if method not in ("welch", "multitaper"):
        raise OptionError(f"{{option}} must be welch or multitaper, not {method!r}", option="method")
    streams = record.streams if isinstance(record, Record) else (record,)
    spectra: dict[str, Spectrum] = {}
    for stream in streams:
        size = segment_size(segment, stream) if method == "welch" else None
        for channel in stream.channels:
            y = np.ascontiguousarray(stream.column(channel))
            if method == "welch":
                spectra[channel] = welch(y, stream, channel, size=size)
            else:
                spectra[channel] = _multitaper(y, stream, channel, tapers=tapers, f_max=f_max)
    return Spectra(spectra)


def welch(y: Floats, stream: Stream, channel: str, *, size: int | None = None) -> Spectrum:
    """Welch's estimate of a channel from an array; see `psd`. `size` is the segment in samples."""
    n, tau0 = len(y), stream.grid.tau0
    length = size or default_size(n)
    while True:
        starts = segment_starts(y, length, gaps=stream.mask is not None)
        if len(starts) >= min(_MIN_SEGMENTS, 2 * n // length - 1) or size is not None or length < 2 * SHORTEST:
            break
        length //= 2
    if not len(starts):
        raise RecordTooShortError(
            f"{channel} has no {length} samples in a row, which a spectrum needs", need=length, got=n
        )
    density, taper_power = _average(y, starts, length, slope(y, gaps=stream.mask is not None))
    frequency, dofs = welch_grid(starts, length, tau0)
    return Spectrum(
        channel=channel,
        quantity=stream.quantity,
        unit=stream.unit,
        frequency=frequency,
        density=density[2:] * (tau0 / taper_power),
        dof=dofs,
        resolution=1.5 / (length * tau0),  # the noise bandwidth of Hann's taper
        segments=len(starts),
        n=n,
        tau0=tau0,
    )


def welch_grid(starts: NDArray[np.int64], length: int, tau0: float) -> tuple[Floats, Floats]:
    """Frequencies of Welch's estimate and the degrees of freedom at each, from the segments' beginnings."""
    overlapping = float(np.mean(np.diff(starts) < length)) if len(starts) > 1 else 0.0
    dof = 2 * len(starts) / (1 + _OVERLAP_CORRELATION * overlapping)
    # Removing the mean removes a sixth of white noise at the first frequency, and nothing at the others.
    frequency = np.arange(2, length // 2 + 1) / (length * tau0)
    dofs = np.full(len(frequency), dof)
    if length % 2 == 0:
        dofs[-1] /= 2  # the transform at half the sampling rate is real
    return frequency, dofs


def default_size(n: int) -> int:
    """Samples in a segment for a record of `n`: a power of two for which 15 segments fit, overlapping by half."""
    fits = max(2 * n // (_MIN_SEGMENTS + 1), SHORTEST)
    return min(1 << (fits.bit_length() - 1), _LONGEST_SEGMENT)


def segment_size(segment: float | None, stream: Stream) -> int | None:
    """Samples in a segment of a length in seconds; None for the default. Raises OptionError if no segment of this length
    fits.
    """
    if segment is None:
        return None
    is_number = isinstance(segment, Real) and not isinstance(segment, bool) and math.isfinite(segment)
    size = round(segment / stream.grid.tau0) if is_number else 0
    if not 8 <= size <= stream.grid.n:
        longest = seconds(stream.grid.duration)
        raise OptionError(
            f"{{option}} must be of {seconds(8 * stream.grid.tau0)} s (8 samples) to {longest} s (the record),"
            f" not {segment!r}",
            option="segment",
        )
    return size


def segment_starts(y: Floats, length: int, *, gaps: bool) -> NDArray[np.int64]:
    """Starts of the segments: half a length apart, no sample missing, evenly thinned beyond `MAX_SAMPLES`."""
    starts = np.arange(0, len(y) - length + 1, max(length // 2, 1))
    if gaps:
        missing = np.concatenate(([0], np.cumsum(np.isnan(y))))
        starts = starts[missing[starts + length] == missing[starts]]
    limit = 2 * MAX_SAMPLES // length
    if len(starts) > limit:
        starts = starts[np.linspace(0, len(starts) - 1, limit).astype(np.int64)]
    return starts


def slope(y: Floats, *, gaps: bool) -> float:
    """Slope of the whole record per sample: a ramp leaks into all frequencies, and a segment is too short to find it."""
    t = np.arange(len(y), dtype=np.float64)
    t -= (len(y) - 1) / 2
    if gaps:
        finite = np.isfinite(y)
        t, y = t[finite], y[finite]
        t -= t.mean()
    power = float(t @ t)
    return float(t @ y - t.sum() * y.mean()) / power if power > 0 else 0.0


def _average(y: Floats, starts: NDArray[np.int64], length: int, rise: float) -> tuple[Floats, float]:
    """Sum of the tapered segments' squared transforms over their number, and the taper's power."""
    taper = hann(length)
    ramp = rise * (np.arange(length) - (length - 1) / 2) * taper
    total = np.zeros(length // 2 + 1)
    for some in batches(starts, length):
        parts = transforms(y, some, taper, ramp).view(np.float64)
        squares = np.einsum("ij,ij->j", parts, parts)
        total += squares[::2] + squares[1::2]
    return total / len(starts), float(taper @ taper)


def batches(starts: NDArray[np.int64], length: int) -> list[NDArray[np.int64]]:
    """Starts of the segments, in groups that are transformed together."""
    batch = max(1, _BATCH_SAMPLES // length)
    return [starts[first : first + batch] for first in range(0, len(starts), batch)]


def transforms(y: Floats, starts: NDArray[np.int64], taper: Floats, ramp: Floats) -> NDArray[np.complex128]:
    """Transforms of segments, mean and ramp removed, tapered; shape (n_segments, n_f)."""
    rows = np.lib.stride_tricks.sliding_window_view(y, len(taper))[starts]
    rows -= rows.mean(axis=1, keepdims=True)
    rows *= taper
    rows -= ramp
    return np.fft.rfft(rows, axis=1)


def _multitaper(y: Floats, stream: Stream, channel: str, *, tapers: int, f_max: float | None) -> Spectrum:
    if stream.mask is not None:
        y = y[longest_run(y)]
    n, tau0 = len(y), stream.grid.tau0
    used = used_samples(n, tapers, channel)
    bins = tapered_bins(used, tau0, f_max)
    density: Floats = np.zeros(bins)
    for parts in tapered(y[:used], bins, tapers):
        density += np.abs(parts) ** 2
    density *= tau0 / tapers
    frequency, dof, resolution = tapered_grid(used, bins, tapers, tau0)
    return Spectrum(
        channel=channel,
        quantity=stream.quantity,
        unit=stream.unit,
        frequency=frequency,
        density=density,
        dof=dof,
        resolution=resolution,
        segments=tapers,
        n=stream.grid.n,
        tau0=tau0,
        method="multitaper",
    )


def used_samples(n: int, tapers: int, what: str) -> int:
    """Number of samples used of n, a few per mille fewer at most, for a fast transform."""
    if tapers < 1:
        raise OptionError(f"{{option}} must be at least 1, not {tapers!r}", option="tapers")
    need = max(SHORTEST, 4 * tapers)
    if n < need:
        raise RecordTooShortError(f"{what} has {n} samples in a row; a spectrum needs {need}", need=need, got=n)
    return good_length(n + 1) - 1


def tapered_bins(used: int, tau0: float, f_max: float | None) -> int:
    """Number of frequencies up to `f_max`; 4096 by default."""
    bins = min(4096, used // 2) if f_max is None else min(int(f_max * (used + 1) * tau0), used // 2)
    if bins < 1:
        raise OptionError(f"{{option}} is below the record's resolution, {1 / (used * tau0):.3g} Hz", option="f_max")
    return bins


def tapered_grid(used: int, bins: int, tapers: int, tau0: float) -> tuple[Floats, Floats, float]:
    """Frequencies of the multitaper estimate, the degrees of freedom at each, and its resolution."""
    k = np.arange(1, bins + 1)
    # Near 0 and half the sampling rate the tapered transforms of a real series resemble their conjugates.
    alike = sine_correlation(tapers, 2 * k) + sine_correlation(tapers, used + 1 - 2 * k)
    return k / ((used + 1) * tau0), 2 * tapers / (1 + alike), (tapers + 1) / (2 * (used + 1) * tau0)


def tapered(y: Floats, bins: int, tapers: int) -> Iterator[NDArray[np.complex128]]:
    """Transforms of samples without mean and slope under each sine taper, at `bins` frequencies. All follow from one
    transform of twice the length, which a sine taper shifts by half-bins in both directions.
    """
    used = len(y)
    transform = np.fft.rfft(np.concatenate(([0.0], remove_trend(y))), 2 * (used + 1))
    centres = 2 * np.arange(1, bins + 1)
    for k in range(1, tapers + 1):
        yield (_values(transform, centres - k, used) - _values(transform, centres + k, used)) / math.sqrt(
            2 * (used + 1)
        )


def _values(transform: NDArray[np.complex128], bins: NDArray[np.int64], used: int) -> NDArray[np.complex128]:
    """Transform of a real series at any bin; beyond its ends the transform is mirrored."""
    folded = np.abs(bins)
    over = folded > used + 1
    folded = np.where(over, 2 * (used + 1) - folded, folded)
    values = transform[folded]
    return np.where((bins < 0) ^ over, values.conj(), values)


def longest_run(y: Floats) -> slice:
    """The longest stretch without a NaN."""
    edges = np.concatenate(([-1], np.flatnonzero(np.isnan(y)), [len(y)]))
    k = int(np.argmax(np.diff(edges)))
    return slice(int(edges[k]) + 1, int(edges[k + 1]))
