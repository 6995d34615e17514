"""Two channels together: identities, and the laws of coherence, gain and phase; see known.seed_of for the seeds."""

import functools
import itertools
import json
import math

import numpy as np
import pytest

import known
import sigmatau as st
from sigmatau import DataError, OptionError, RecordTooShortError
from sigmatau.spectrum import coherence as law
from sigmatau.spectrum.cross import cross_spectrum
from sigmatau.spectrum.estimate import psd

RATE = 100.0
RECORDS = 40  # set before any of them was drawn, and left


def record(x, y, rate=RATE):
    return st.Record.from_arrays(rate=rate, gyro_x=x, gyro_y=y)


def pair(seed, n=20_000):
    return np.random.default_rng(known.seed_of(seed)).standard_normal((2, n))


@pytest.mark.parametrize("method", ["welch", "multitaper"])
class TestIdentities:
    def test_densities_are_those_of_psd(self, method):
        x, y = pair("cross densities")
        both, alone = cross_spectrum(record(x, y), "gyro_x", "gyro_y", method=method), psd(record(x, y), method=method)
        np.testing.assert_allclose(both.density_a, alone["gyro_x"].density, rtol=1e-12)
        np.testing.assert_allclose(both.density_b, alone["gyro_y"].density, rtol=1e-12)
        np.testing.assert_array_equal(both.frequency, alone["gyro_x"].frequency)
        np.testing.assert_array_equal(both.dof, alone["gyro_x"].dof)

    def test_a_channel_and_its_multiple(self, method):
        x, _ = pair("multiple")
        found = cross_spectrum(record(x, -2.5 * x), "gyro_x", "gyro_y", method=method)
        assert found.coherence == pytest.approx(1.0, abs=1e-12)
        assert found.transfer == pytest.approx(-2.5, rel=1e-12)
        assert np.abs(found.phase) == pytest.approx(math.pi, abs=1e-9)

    def test_the_other_way_round(self, method):
        x, y = pair("round")
        y = y + x
        there = cross_spectrum(record(x, y), "gyro_x", "gyro_y", method=method)
        back = cross_spectrum(record(x, y), "gyro_y", "gyro_x", method=method)
        np.testing.assert_allclose(back.cross, there.cross.conj(), rtol=1e-12)
        np.testing.assert_allclose(back.coherence, there.coherence, rtol=1e-12)

    def test_a_delay(self, method):
        """b is a two samples later: its phase falls by 2π·f·2τ₀."""
        x, _ = pair("delay")
        found = cross_spectrum(record(x[2:], x[:-2]), "gyro_x", "gyro_y", method=method, f_max=20.0)
        inside = (found.frequency > 1) & (found.frequency < 20)
        expected = -2 * np.pi * found.frequency[inside] * 2 / RATE
        # What enters at one end of a segment and leaves at the other is two samples of hundreds.
        assert np.angle(np.exp(1j * (found.phase[inside] - expected))).std() < 0.02


@functools.cache
def related(method):
    """b = 0.8·a one sample later, and noise of its own as large: γ² = 0.64/1.64; and a third channel of its own."""
    rng = np.random.default_rng(known.seed_of(f"related {method}"))
    found = []
    for _ in range(RECORDS):
        x, own, other = rng.standard_normal((3, 4096))
        y = 0.8 * np.roll(x, 1) + own
        r = st.Record.from_arrays(rate=RATE, gyro_x=x, gyro_y=y, gyro_z=other)
        found.append([cross_spectrum(r, "gyro_x", name, method=method, f_max=50.0) for name in ("gyro_y", "gyro_z")])
    return found


def share(values):
    return np.mean(values), np.std(values, ddof=1) / math.sqrt(len(values))


@pytest.mark.parametrize("per_octave", [None, 3])
@pytest.mark.parametrize("method", ["welch", "multitaper"])
class TestLaws:
    """95 % means 95 %, within three standard errors, away from the ends of the band."""

    def spectra(self, method, per_octave, k):
        for row in related(method):
            shown = row[k] if per_octave is None else row[k].binned(per_octave=per_octave)
            there = (shown.frequency > 2 * row[k].resolution) & (shown.frequency < 45)
            # Neighbours of many tapers are alike: every fourth says as much, in a quarter of the time.
            yield shown, np.flatnonzero(there)[:: 4 if (method, per_octave) == ("multitaper", None) else 1]

    def test_intervals(self, method, per_octave):
        # In bands the turning phase lessens the coherence, and every interval is wider than need be.
        least_only = per_octave is not None
        held = {"coherence": [], "gain": [], "phase": []}
        for shown, there in itertools.islice(self.spectra(method, per_octave, 0), 16):
            # The interval holds the true coherence where the measured one is between two quantiles of its law.
            p = law.probability_below(shown.coherence[there], 0.64 / 1.64, shown.dof[there] / 2)
            held["coherence"].append(np.mean(np.abs(p - 0.5) <= 0.475))
            low, high = shown.gain_interval()
            held["gain"].append(np.mean(((low <= 0.8) & (high >= 0.8))[there]))
            # In a bin the phase is that at its mean frequency, because it turns evenly.
            turned = -2 * np.pi * shown.frequency / RATE
            low, high = shown.phase_interval()
            off = np.angle(np.exp(1j * (turned - shown.phase)))
            held["phase"].append(np.mean((np.abs(off) <= (high - low) / 2)[there]))
        for what, values in held.items():
            mean, error = share(values)
            if not least_only:
                assert mean == pytest.approx(0.95, abs=3 * error), what
            elif what == "phase":
                assert mean > 0.95 - 3 * error

    def test_an_interval_holds_what_its_law_allows(self, method, per_octave):
        """Of one record; `test_intervals` takes the law, because the ends take a hundred times as long."""
        shown, there = next(self.spectra(method, per_octave, 0))
        low, high = shown.coherence_interval()
        p = law.probability_below(shown.coherence[there], 0.64 / 1.64, shown.dof[there] / 2)
        sure = np.abs(np.abs(p - 0.5) - 0.475) > 1e-3  # the ends are interpolated
        held = (low <= 0.64 / 1.64) & (high >= 0.64 / 1.64)
        np.testing.assert_array_equal(held[there][sure], (np.abs(p - 0.5) <= 0.475)[sure])

    def test_chance(self, method, per_octave):
        """Independent channels are above the level in 5 %."""
        above = [
            np.mean((shown.coherence > shown.significance())[there])
            for shown, there in self.spectra(method, per_octave, 1)
        ]
        mean, error = share(above)
        assert mean == pytest.approx(0.05, abs=3 * error)


class TestLawOfTheCoherence:
    @pytest.mark.parametrize(("n", "true"), [(3, 0.0), (3, 0.5), (20, 0.1), (20, 0.95), (300, 0.0), (300, 0.5)])
    def test_of_pairs_drawn(self, n, true):
        """Kolmogorov's distance of 100 coherences of n complex normal pairs from their law."""
        rng = np.random.default_rng(known.seed_of(f"coherence of {n} pairs, {true}"))
        count = 100
        draw = rng.standard_normal((4, count, n))
        a, own = draw[0] + 1j * draw[1], draw[2] + 1j * draw[3]
        b = math.sqrt(true) * a + math.sqrt(1 - true) * own
        measured = np.abs((a.conj() * b).sum(1)) ** 2 / ((np.abs(a) ** 2).sum(1) * (np.abs(b) ** 2).sum(1))
        p = np.sort(law.probability_below(measured, true, float(n)))
        distance = np.abs(p - (np.arange(count) + 0.5) / count).max()
        assert distance < 1.95 / math.sqrt(count)  # exceeded in 0.1 %
        low, high = law.interval(measured, np.full(count, float(n)))
        assert np.mean((low <= true) & (true <= high)) >= 0.95 - 3 * math.sqrt(0.95 * 0.05 / count)

    def test_without_coherence(self):
        """Beta(1, n − 1), in closed form."""
        assert law.significance(11.0) == pytest.approx(1 - 0.05**0.1, rel=1e-12)
        assert law.probability_below(0.2, 0.0, 11.0) == pytest.approx(1 - 0.8**10, rel=1e-9)
        assert law.significance(1.0) == 1.0

    def test_many_alike_are_interpolated(self):
        measured = np.linspace(0, 0.99, 500)
        low, high = law.interval(measured, np.full(500, 30.0))
        some = slice(None, None, 83)
        exact = law.interval(measured[some], np.full(len(measured[some]), 30.0))
        np.testing.assert_allclose(low[some], exact[0], atol=1e-3)
        np.testing.assert_allclose(high[some], exact[1], atol=1e-3)


class TestSamples:
    @pytest.mark.parametrize("method", ["welch", "multitaper"])
    def test_missing_samples_of_either(self, method):
        x, y = pair("missing of either")
        y = y + x
        x[5000] = np.nan
        y[12_000] = np.nan
        found = cross_spectrum(record(x, y), "gyro_x", "gyro_y", method=method)
        assert np.isfinite(found.cross).all()
        assert found.coherence.mean() == pytest.approx(0.5, abs=0.1)

    def test_channels_of_two_streams(self):
        x, y = pair("two streams")
        r = st.Record.from_arrays(rate=RATE, gyro_x=x, accel_x=y + x)
        found = cross_spectrum(r, "gyro_x", "accel_x")
        assert (found.unit_a, found.unit_b) == ("rad/s", "m/s^2")

    def test_channels_that_are_not_sampled_together(self):
        x, y = pair("not together")
        one, other = (
            st.Record.from_arrays(rate=RATE, gyro_x=x).streams[0],
            st.Record.from_arrays(rate=RATE, accel_x=y[:-1]).streams[0],
        )
        with pytest.raises(DataError, match="not sampled together: 20000 samples"):
            cross_spectrum(st.Record(streams=(one, other)), "gyro_x", "accel_x")

    def test_refusals(self):
        r = record(*pair("refusals", n=1000))
        with pytest.raises(OptionError, match="both 'gyro_x'"):
            cross_spectrum(r, "gyro_x", "gyro_x")
        with pytest.raises(OptionError, match="method"):
            cross_spectrum(r, "gyro_x", "gyro_y", method="fft")
        with pytest.raises(RecordTooShortError, match="coherence 1"):
            cross_spectrum(r, "gyro_x", "gyro_y", segment=10.0)
        with pytest.raises(RecordTooShortError, match="coherence 1"):
            cross_spectrum(r, "gyro_x", "gyro_y", method="multitaper", tapers=1)
        with pytest.raises(KeyError, match="gyro_q"):
            cross_spectrum(r, "gyro_x", "gyro_q")
        with pytest.raises(DataError, match="gyro_q"):
            cross_spectrum(r.streams[0], "gyro_q", "gyro_y")
        with pytest.raises(OptionError, match="level"):
            cross_spectrum(r, "gyro_x", "gyro_y").gain_interval(level=95)


def test_to_dict_print_and_plot():
    x, y = pair("cross dict")
    y = y + x
    y[:] = np.where(np.abs(y) > 9, 0, y)
    found = cross_spectrum(record(x, y), "gyro_x", "gyro_y").binned()
    plain = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert plain["sided"] == "two"
    lengths = {len(v) for v in plain.values() if isinstance(v, list)}
    assert lengths == {len(found.frequency)}
    assert "*" in repr(found)
    assert "coherence" in repr(found)
    upper, lower = found.plot().axes
    assert "coherence" in upper.get_ylabel()
    assert "phase of gyro_y" in lower.get_ylabel()
    with pytest.raises(ValueError, match="read-only"):
        found.cross[0] = 0
