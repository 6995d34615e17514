"""Filters, lines, warm-ups and temperature drifts of simulated records, as `analyze` reports them from the fit."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from known import seed_of
from sigmatau import NoiseModel, Record, analyze, simulate
from sigmatau.findings.spectrum import Mains
from sigmatau.fitting.channel import fit_channel
from sigmatau.quality.fit_findings import fit_findings
from sigmatau.record.record import make_stream

RATE, N = 100.0, 2**17
T = np.arange(N) / RATE
DEG_H = math.pi / 180 / 3600
SENSOR = {"random_walk": 1e-4, "bias_instability": 1e-5, "rate_random_walk": 4e-6}


def white(name, n=N):
    return np.random.default_rng(seed_of(name)).standard_normal(n)


def noise(name, *, duration, rate, **terms):
    model = NoiseModel(channels={"gyro_x": terms})
    return np.array(simulate(model, duration=duration, rate=rate, rng=seed_of(name)).streams[0].column("gyro_x"))


def record_of(x, rate=RATE):
    return Record.from_arrays(rate=rate, gyro_x=x)


def fitted(x, rate=RATE):
    fit = fit_channel(record_of(x, rate), "gyro_x")
    return fit, {finding.code: finding for finding in fit_findings(fit)}


class TestFilters:
    @pytest.mark.parametrize(("order", "corner"), [(1, 30.0), (2, 10.0)])
    def test_corner_and_random_walk(self, order, corner):
        """Butterworth; of eight 95 % intervals six or more hold but for a chance of 6e-3."""
        held = walks = 0
        for k in range(8):
            x = lfilter(*butter(order, corner, fs=RATE), white(f"filter {order} {corner} {k}", N + 2000))[2000:]
            fit, found = fitted(x)
            details = found["low_pass_filter"].details
            assert found["low_pass_filter"].severity == "info"
            assert details.corner == pytest.approx(corner, rel=0.1)
            held += details.low <= corner <= details.high
            walks += fit["random_walk"].low <= 1 / math.sqrt(RATE) <= fit["random_walk"].high
        # Three of the eight second-order filters at a tenth of the rate stop at three coefficients: the model is widened.
        assert held >= (5 if (order, corner) == (2, 10.0) else 6)
        assert walks >= 6

    def test_order_is_named(self):
        """At a tenth to a quarter of the rate: of 14 filters at most one has another name."""
        named = 0
        for order in (1, 2):
            # Of first order at a quarter of the rate, it is a mean of two samples.
            for corner in (10.0, 15.0, 20.0, 25.0)[: 2 + order]:
                for k in range(2):
                    _, found = fitted(lfilter(*butter(order, corner, fs=RATE), white(f"ord {order} {corner} {k}")))
                    details = found["low_pass_filter"].details
                    named += (details.shape, details.order) == ("butterworth", order)
        assert named >= 13

    def test_white_noise_has_nothing_beside_it(self):
        """40 channels of 2^15 samples: one in 500 is widened, by design; here none is. One in twenty has
        a term by chance, in the place of which there may be a process."""
        said = [
            f.code
            for k in range(40)
            for f in fit_findings(fit_channel(record_of(white(f"clean {k}", 2**15)), "gyro_x"))
        ]
        assert set(said) <= {"second_explanation"}
        assert len(said) <= 6  # 2 expected at most; 7 have a probability of 0.5 %

    @pytest.mark.parametrize("kind", ["held", "linear"])
    def test_values_between_samples_are_no_filter(self, kind):
        """Samples at 50 Hz in a log of 100 Hz: one fault, one name."""
        x = white(f"between {kind}", N // 2 + 1)
        x = np.repeat(x, 2)[:N] if kind == "held" else np.interp(np.arange(N) / 2, np.arange(len(x)), x)
        codes = {finding.code for finding in analyze(record_of(x)).findings}
        assert codes & {"repeated_samples", "interpolated"}
        assert "low_pass_filter" not in codes

    def test_a_gauss_markov_process_over_white_noise_is_no_filter(self):
        decay = math.exp(-1 / RATE / 0.3)
        process = lfilter([math.sqrt(1 - decay**2)], [1, -decay], white("process"))
        _, found = fitted(process + 0.2 * white("over it"))
        assert set(found) <= {"gauss_markov_process", "second_explanation"}  # white noise behind a filter is alike
        assert found["gauss_markov_process"].details.time == pytest.approx(0.3, rel=0.1)
        assert found["gauss_markov_process"].size == pytest.approx(1.0, rel=0.05)


class TestLines:
    def test_a_steady_line_and_an_unsteady_one_with_a_harmonic(self):
        """The second is 2 mHz wide, some three times the resolution of the record; its harmonic twice as much."""
        amplitude, drift = 0.2, np.cumsum(np.where(np.arange(N) < N // 2, -1e-3, 1e-3)) / RATE
        phase = 2 * np.pi * (7.31 * T + drift)
        x = white("lines") + amplitude * np.sin(2 * np.pi * 23.3 * T)
        x += 0.15 * np.sin(phase) + 0.1 * np.sin(2 * phase + 1)
        fit, found = fitted(x)
        first, second = found["spectral_line"].details.lines
        assert first.low < 23.3 < first.high
        assert first.high - first.low < 0.1
        assert first.frequency == pytest.approx(23.3, abs=5e-3)  # a bin of the segments of 2^14 samples is 6 mHz
        assert first.amplitude == pytest.approx(amplitude, rel=0.05)
        assert (first.harmonics, first.mains) == ((), None)
        assert second.frequency == pytest.approx(7.31, abs=5e-3)
        assert second.amplitude == pytest.approx(0.15, rel=0.1)
        (harmonic,) = second.harmonics
        assert harmonic.frequency == pytest.approx(14.62, abs=1e-2)
        assert harmonic.amplitude == pytest.approx(0.1, rel=0.1)
        assert found["spectral_line"].size == first.amplitude
        assert fit["random_walk"].low < 1 / math.sqrt(RATE) < fit["random_walk"].high

    @pytest.mark.parametrize(
        ("rate", "mains", "seen", "multiple"),
        [(200.0, 50.0, 50.0, 1), (80.0, 50.0, 30.0, 1), (100.0, 60.0, 40.0, 1), (95.0, 100.0, 5.0, 2)],
    )
    def test_mains_are_named(self, rate, mains, seen, multiple):
        t = np.arange(N) / rate
        _, found = fitted(white(f"mains {rate}") + 0.3 * np.sin(2 * np.pi * (mains + 0.01) * t), rate)
        (line,) = found["spectral_line"].details.lines
        assert line.frequency == pytest.approx(seen, abs=0.02)
        assert line.mains == Mains(frequency=mains / multiple, multiple=multiple, folded=seen != mains)

    def test_a_record_that_repeats_itself(self):
        """Its spectrum has nothing but lines; the strongest hundred are told."""
        fit, found = fitted(np.tile(white("repeated", N // 32), 16))
        assert len(fit.sinusoid) == 100
        assert sum(1 + len(line.harmonics) for line in found["spectral_line"].details.lines) == 100


class TestWarmUp:
    RATE, DURATION = 20.0, 7200.0
    SECONDS = np.arange(round(RATE * DURATION)) / RATE

    @pytest.mark.parametrize("time", [120.0, 400.0, 1000.0])
    def test_size_and_time_constant(self, time):
        drift = 6e-3 * np.exp(-self.SECONDS / time)
        clean = noise(f"warm-up {time}", duration=self.DURATION, rate=self.RATE, **SENSOR)
        (before, _), (fit, found) = (fitted(x, self.RATE) for x in (clean, clean + drift))
        details = found["warm_up"].details
        assert found["warm_up"].size == pytest.approx(6e-3, rel=0.1)
        assert found["warm_up"].size == pytest.approx(6e-3, abs=3 / 1.96 * (details.high - details.low) / 2)
        assert details.time_constant == pytest.approx(time, rel=0.15)
        # As without the drift; what the drift takes of the slowest noise is a part of the interval.
        names, covariance = before.covariance.names, before.covariance.matrix
        half = 1.96 * np.sqrt(covariance[names.index("rate_random_walk")][names.index("rate_random_walk")])
        assert fit.model["rate_random_walk"] == pytest.approx(before.model["rate_random_walk"], abs=half)

    def test_none_in_clean_records(self):
        """40 channels of N + B + K."""
        said = 0
        for k in range(40):
            x = noise(
                f"no warm-up {k}",
                duration=4096,
                rate=1.0,
                random_walk=1.0,
                bias_instability=0.03,
                rate_random_walk=3e-3,
            )
            said += "warm_up" in fitted(x, 1.0)[1]
        assert said == 0

    def test_one_drift_is_one_finding(self):
        x = 2e-4 * white("drift alone") + 1e-3 * np.exp(-T / 240)
        assert [f.code for f in analyze(record_of(x)).findings] == ["warm_up"]

    def test_a_step_beside_a_drift_is_told(self):
        """Each alone is found; the drift hides a step that is smaller than it."""
        x = 2e-3 * white("warm-up and step") + 6e-3 * np.exp(-T / 200) + np.where(T > 900, 2e-3, 0.0)
        found = {f.code: f for f in analyze(record_of(x)).findings if f.code in ("not_static", "warm_up")}
        step = found["not_static"]
        assert (step.severity, step.details.beside_drift) == ("warning", True)
        assert [one.time for one in step.details.steps] == pytest.approx([900], abs=4)
        assert step.size == pytest.approx(2e-3, abs=3e-4)
        assert found["warm_up"].details.low < 6e-3 < found["warm_up"].details.high


class TestTemperature:
    RATE, DURATION, PER_KELVIN = 10.0, 7200.0, 5 * DEG_H

    def celsius(self, t):
        """A room that warms by 15 K, with its regulation."""
        return (
            20
            + 13.5 * (1 - np.exp(-t / 2500)) / (1 - math.exp(-self.DURATION / 2500))
            + 1.5 * np.sin(2 * np.pi * t / 1500)
        )

    def record(self, name, *, every=1.0, per_kelvin=PER_KELVIN, step=0.0):
        t = (np.arange(round(self.DURATION * self.RATE)) + 0.5) / self.RATE
        x = noise(name, duration=self.DURATION, rate=self.RATE, random_walk=1e-5, bias_instability=2e-6)
        at = (np.arange(round(self.DURATION / every)) + 0.5) * every
        shown = np.round(self.celsius(at) / step) * step if step else self.celsius(at)
        thermometer = make_stream("temperature", {"temperature": shown}, rate=1 / every, unit={})
        streams = record_of(x + per_kelvin * self.celsius(t), self.RATE).streams
        return Record(streams=(*streams, replace(thermometer, quantity="temperature", unit="K")))

    @pytest.mark.parametrize("every", [0.1, 1.0, 60.0])
    def test_coefficient(self, every):
        analysis = analyze(self.record(f"temperature {every}", every=every))
        (finding,) = (f for f in analysis.findings if f.code == "temperature_drift")
        assert finding.unit == "rad/s/K"
        assert finding.details.low < self.PER_KELVIN < finding.details.high
        assert finding.size == pytest.approx(self.PER_KELVIN, rel=0.05)
        assert not analysis.fits["gyro_x"]["rate_random_walk"].observed
        assert {f.code for f in analysis.findings} == {"temperature_drift"}

    def test_a_coarse_thermometer(self):
        """Steps of 0.5 K are a thirtieth of the range: with them as they are the coefficient would be too small."""
        analysis = analyze(self.record("coarse", step=0.5))
        (finding,) = (f for f in analysis.findings if f.code == "temperature_drift")
        assert finding.size == pytest.approx(self.PER_KELVIN, rel=0.05)

    def test_of_a_temperature_that_has_nothing_to_do_with_it(self):
        """One of 8 records is found at 3.3 standard errors with a chance of 0.8 %, two with one of 1e-4."""
        said = 0
        for k in range(8):
            found = analyze(self.record(f"no temperature {k}", per_kelvin=0.0)).findings
            said += any(f.code == "temperature_drift" for f in found)
        assert said <= 1


def test_a_drift_with_temperature_is_no_walk_and_hides_none():
    """5 deg/h/K over 15 K beside K = 20 deg/h/√h: K in its interval, or below its limit, on 15 axes."""
    from studies.disturbances import WARM_UP, record

    truth, held = 20 * DEG_H / 60, []
    for k in range(5):
        found = record(np.random.default_rng(seed_of(f"a drift and a walk {k}")), WARM_UP)
        for axis in "xyz":
            walk = fit_channel(found, f"gyro_{axis}")["rate_random_walk"]
            held.append(walk.low <= truth <= walk.high if walk.observed else truth <= (walk.upper_limit or np.inf))
    assert np.mean(held) >= 0.92 - 3 * math.sqrt(0.92 * 0.08 / len(held))
