"""Lines: planted, found, measured, and what they are said to do against what they do."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from sigmatau.quality.spectrum.lines import find_lines, lines, lines_in_fits

import known
import sigmatau as st
from sigmatau._native import kernels
from sigmatau.findings.kinds.disturbances import Spikes
from sigmatau.findings.kinds.spectrum import Mains
from sigmatau.noise.terms import avar
from sigmatau.quality.curve_checks import fit_findings

RATE, N = 100.0, 2**18
T = np.arange(N) / RATE
MEMS = {"random_walk": 5e-3, "bias_instability": 2e-3}


def noise(name, **coefficients):
    model = st.NoiseModel(channels={"gyro_x": coefficients or MEMS})
    record = st.simulate(model, duration=N / RATE, rate=RATE, rng=known.seed_of(name))
    return np.array(record.streams[0].column("gyro_x"))


def stream_of(y, rate=RATE):
    return st.Record.from_arrays(rate=rate, gyro_x=y).streams[0]


def only_line(y, rate=RATE):
    (line,) = find_lines(stream_of(y, rate))["gyro_x"]
    return line


@pytest.mark.parametrize("frequency", [0.37, 7.3, 23.30012, 49.1])
def test_frequency_and_amplitude(frequency):
    """Within four standard errors of the law for a sinusoid in white noise: sd(f) = √(6 S/(A²π²T³))·√2 … with Hann's taper
    1.35 times that, sd(A) = √(2·S·1.5/T), S two-sided; the refined frequency is good to 2 % of a bin beside."""
    amplitude, length = 3e-3, N / RATE
    y = noise(f"line {frequency}", random_walk=5e-3) + amplitude * np.sin(2 * np.pi * frequency * T + 1)
    line = only_line(y)
    density = 5e-3**2
    sd = math.sqrt(12 * density / (math.pi**2 * amplitude**2 * length**3))
    assert line.frequency == pytest.approx(frequency, abs=4 * 1.35 * sd + 0.02 / length)
    # Of the power in nine bins the noise's own share is taken off, with an error of its own of 3·S/T.
    assert line.amplitude == pytest.approx(amplitude, abs=4 * math.sqrt(3 * density / length) + 0.01 * amplitude)
    assert line.width == 0
    assert not line.harmonics


def test_unsteady_line():
    """Its frequency drifts by 0.04 Hz in the record, as a fan's does: over 105 bins."""
    frequency = np.linspace(0.53, 0.57, N)
    amplitude = 5e-3
    clean = noise("unsteady noise", random_walk=5e-3)
    line = only_line(clean + amplitude * np.sin(2 * np.pi * np.cumsum(frequency) / RATE))
    assert line.frequency == pytest.approx(0.55, abs=0.005)
    assert 0.01 < line.width < 0.03  # Hann's taper takes the ends off: 80 % of its power is in 0.4 of the record
    assert line.amplitude == pytest.approx(amplitude, rel=0.15)


def test_resonance():
    """Noise in a band of 1.5 Hz, 40 times as dense as what is beside."""
    from scipy.signal import iirpeak, lfilter

    numerator, denominator = iirpeak(20.0, 20.0 / 1.5, fs=RATE)
    white = np.random.default_rng(known.seed_of("resonance")).standard_normal(N)
    line = only_line(noise("resonance noise", random_walk=1.0) + 60 * lfilter(numerator, denominator, white))
    assert line.frequency == pytest.approx(20, abs=0.5)
    assert 0.7 < line.width < 4


def test_harmonics_are_grouped():
    base = 0.5625
    y = noise("harmonics")
    for order, amplitude in ((1, 8e-3), (3, 4e-3), (5, 3e-3)):
        y += amplitude * np.sin(2 * np.pi * order * base * T + order)
    line = only_line(y)
    assert line.frequency == pytest.approx(base, abs=1e-4)
    assert [each.frequency for each in line.harmonics] == pytest.approx([3 * base, 5 * base], abs=1e-3)
    (finding,) = lines(stream_of(y))
    assert finding.details.lines == (line,)


def test_harmonics_are_folded():
    y = noise("folded", random_walk=5e-3) + 4e-3 * np.sin(2 * np.pi * 21.7 * T) + 2e-3 * np.sin(2 * np.pi * 65.1 * T)
    line = only_line(y)
    assert line.frequency == pytest.approx(21.7, abs=1e-3)
    assert [each.frequency for each in line.harmonics] == pytest.approx([34.9], abs=1e-3)


@pytest.mark.parametrize(
    ("rate", "mains", "seen", "named"),
    [
        (200.0, 50.0, 50.0, Mains(frequency=50.0, multiple=1, folded=False)),
        (80.0, 50.0, 30.0, Mains(frequency=50.0, multiple=1, folded=True)),
        (100.0, 60.0, 40.0, Mains(frequency=60.0, multiple=1, folded=True)),
        (95.0, 100.0, 5.0, Mains(frequency=50.0, multiple=2, folded=True)),
    ],
)
def test_mains_are_named(rate, mains, seen, named):
    rng = np.random.default_rng(known.seed_of(f"mains {rate} {mains}"))
    t = np.arange(100_000) / rate
    line = only_line(rng.standard_normal(len(t)) + 0.3 * np.sin(2 * np.pi * (mains + 0.01) * t), rate)
    assert line.frequency == pytest.approx(seen, abs=0.02)
    assert line.mains == named


def test_no_mains_for_any_other_line():
    assert only_line(noise("no mains", random_walk=5e-3) + 4e-3 * np.sin(2 * np.pi * 23.3 * T)).mains is None


def test_effect_on_the_deviation():
    """The stated factor on σ(τ), against the same noise without the line: the variances at one τ differ by the line's."""
    clean = noise("effect")
    y = clean + 1e-2 * np.sin(2 * np.pi * 0.563 * T)
    (finding,) = lines(stream_of(y))
    assert finding.severity == "warning"
    assert finding.code == "spectral_line"
    assert finding.size == pytest.approx(1e-2, rel=0.05)
    tau, stated = finding.details.tau, finding.details.factor
    adev = [st.allan(st.Record.from_arrays(rate=RATE, gyro_x=x), taus=[tau])["gyro_x"].adev[0] for x in (y, clean)]
    # Noise and line are independent only on average: their product adds 1/√edf of twice the root of both variances.
    assert stated == pytest.approx(adev[0] / adev[1], rel=0.02)


def test_effect_of_an_unsteady_line():
    """The same where the line is a band; its ends, which Hann's taper hides, make it 15 % in amplitude uncertain."""
    clean = noise("effect unsteady", random_walk=5e-3)
    y = clean + 1e-2 * np.sin(2 * np.pi * np.cumsum(np.linspace(0.53, 0.57, N)) / RATE)
    (finding,) = lines(stream_of(y))
    assert find_lines(stream_of(y))["gyro_x"][0].width > 0
    tau, stated = finding.details.tau, finding.details.factor
    adev = [st.allan(st.Record.from_arrays(rate=RATE, gyro_x=x), taus=[tau])["gyro_x"].adev[0] for x in (y, clean)]
    assert adev[0] / adev[1] > 1.3
    assert stated == pytest.approx(adev[0] / adev[1], rel=0.1)


def fit_of(y, **options):
    return st.fit(st.allan(st.Record.from_arrays(rate=RATE, gyro_x=y))["gyro_x"], **options)


@pytest.mark.parametrize(
    ("frequency", "amplitude", "sweep"),
    [
        (0.563, 1e-2, 0.0),
        (0.563, 1e-1, 0.0),
        (0.05, 6e-3, 0.0),
        (3.1, 2e-2, 0.0),
        (0.55, 5e-2, 0.03),
        (7.0, 5e-2, 0.03),
    ],
)
def test_changes_are_those_of_the_fit_that_is_printed(frequency, amplitude, sweep):
    """Against the same noise without the line, fitted from the same averaging time on; whatever the fit made of the line."""
    clean = noise(f"changes {frequency} {amplitude}")
    y = clean + amplitude * np.sin(2 * np.pi * np.cumsum(frequency * np.linspace(1 - sweep, 1 + sweep, N)) / RATE)
    stream = stream_of(y)
    found = lines(stream)
    assert all(not finding.factors for finding in found)
    printed = fit_of(y)
    (finding,) = lines_in_fits(stream, {"gyro_x": printed}, found)
    without = fit_of(clean, tau_min=printed.tau_min)
    changes = dict(finding.factors)
    for term in ("random_walk", "bias_instability"):
        true = printed[term].value / without[term].value
        # Of a sweeping line, whose ends the taper hides, the power is known to 3 %; 5 % is the least that is said.
        assert changes.get(term, 1.0) == pytest.approx(true, rel=0.06), term
        assert term in changes or abs(true - 1) < 0.1
    assert finding.fit_effect.tau_min_s == finding.fit_effect.compared_from_s == printed.tau_min
    assert finding.fit_effect.without == ("spectral_line",)


def test_changes_are_there_at_all():
    """A fit that was told to begin at one sample takes the line in; `analyze` says what its own fit made of it."""
    clean = noise("changes at all")
    stream = stream_of(clean + 0.1 * np.sin(2 * np.pi * 0.563 * T))
    fits = {"gyro_x": fit_of(stream.column("gyro_x"), tau_min=1 / RATE)}
    (finding,) = lines_in_fits(stream, fits, lines(stream))
    true = fits["gyro_x"]["bias_instability"].value / fit_of(clean, tau_min=1 / RATE)["bias_instability"].value
    assert abs(true - 1) > 0.05
    assert dict(finding.factors)["bias_instability"] == pytest.approx(true, rel=0.02)
    whole = st.analyze(st.Record(streams=(stream,)))
    (said,) = lines_in_fits(stream, whole.fits, lines(stream))
    (of_analysis,) = (f for f in whole.findings if f.code == "spectral_line")
    assert (of_analysis.factors, of_analysis.fit_effect) == (said.factors, said.fit_effect)
    other = replace(finding, details=object.__new__(Spikes))
    assert lines_in_fits(stream, fits, [other]) == [other]
    assert lines_in_fits(stream, {}, [finding]) == [finding]


@pytest.mark.parametrize("frequency", [0.01, 0.02, 0.04])
@pytest.mark.parametrize(
    "terms",
    [
        {"random_walk": 1e-4},
        {"random_walk": 1e-4, "bias_instability": 3e-5},
        {"random_walk": 1e-4, "rate_random_walk": 1e-5},
    ],
)
def test_slow_lines(frequency, terms):
    """In 2 h at 100 Hz, of an amplitude that doubles the Allan variance where it does most: sin⁴(x)/x² = 0.525, x = 1.17."""
    name = f"slow {frequency} {sorted(terms)}"
    model = st.NoiseModel(channels={"gyro_x": terms})
    clean = st.simulate(model, duration=7200, rate=RATE, rng=known.seed_of(name)).streams[0].column("gyro_x")
    m = round(1.1656 / (math.pi * frequency) * RATE)
    variance = sum(avar(term, value, m=m, tau0=1 / RATE)[0] for term, value in terms.items())
    amplitude = math.sqrt(variance / 0.525)
    y = clean + amplitude * np.sin(2 * np.pi * frequency * np.arange(len(clean)) / RATE)
    line = only_line(y)
    assert line.frequency == pytest.approx(frequency, abs=0.5 / 7200)
    # Of a density 0.85·f·T times that of the noise, 61 and more: amplitude to 1/√61 or so, thrice.
    assert line.amplitude == pytest.approx(amplitude, rel=0.4)
    assert find_lines(stream_of(np.array(clean)))["gyro_x"] == ()


@pytest.mark.parametrize("cycles", [5, 6, 8, 12, 18, 30])
@pytest.mark.parametrize("terms", [{"random_walk": 1e-4}, {"random_walk": 1e-4, "rate_random_walk": 1e-6}])
def test_few_cycles_that_tower_over_the_noise(cycles, terms):
    """In 10 min at 100 Hz; of amplitude A the density in a bin is A²·T/6 over that of the noise, 2400 N²/(1 Hz) and more."""
    name = f"cycles {cycles} {sorted(terms)}"
    model = st.NoiseModel(channels={"gyro_x": terms})
    clean = np.array(st.simulate(model, duration=600, rate=RATE, rng=known.seed_of(name)).streams[0].column("gyro_x"))
    t = np.arange(len(clean)) / RATE
    line = only_line(clean + 5e-4 * np.sin(2 * np.pi * cycles / 600 * t + 1))
    assert line.frequency == pytest.approx(cycles / 600, abs=0.5 / 600)
    assert line.amplitude == pytest.approx(5e-4, rel=0.15)
    assert find_lines(stream_of(clean))["gyro_x"] == ()


def test_slow_noise_has_no_lines():
    """1e-4 a channel by design, in the lowest bins of walks and mixtures: in 400 none, or once in 25 runs one."""
    rng = np.random.default_rng(known.seed_of("slow noise"))
    found = 0
    for k in range(400):
        white, walk = rng.standard_normal(8192), np.cumsum(rng.standard_normal(8192))
        found += bool(find_lines(stream_of(white + walk * 10 ** rng.uniform(-4, 1) * (k % 4 > 0)))["gyro_x"])
    assert found <= 1


def test_a_sinusoid_in_the_model_is_told():
    """Twelve cycles in 10 min that double the variance at their times."""
    model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    clean = st.simulate(model, duration=600, rate=RATE, rng=known.seed_of("sixth term")).streams[0].column("gyro_x")
    y = clean + 1e-4 * np.sin(2 * np.pi * 0.02 * np.arange(len(clean)) / RATE + 1)
    fitted = fit_of(y)
    assert fitted.sinusoid
    (told,) = (f for f in fit_findings(fitted) if f.code == "sinusoid_fitted")
    assert told.size == pytest.approx(1e-4, rel=0.15)
    assert told.details.frequency == pytest.approx(0.02, rel=0.05)
    assert not any(f.code == "sinusoid_fitted" for f in fit_findings(fit_of(np.array(clean))))


def ringing(seed):
    rng = np.random.default_rng(seed)
    y = 5e-4 * rng.standard_normal(N)
    t = np.arange(300) / RATE
    for start in rng.integers(0, N - 300, 8):
        y[start : start + 300] += 0.5 * rng.normal() * np.exp(-t / 0.4) * np.sin(2 * np.pi * 9 * t)
    return y


def test_knocks_are_no_lines():
    """A mount rings at 9 Hz after each of eight knocks; a line that is there at rest is still found beside them."""
    y = ringing(known.seed_of("knocks"))
    assert find_lines(stream_of(y))["gyro_x"] == ()
    line = only_line(y + 3e-5 * np.sin(2 * np.pi * 23.3 * T))
    assert line.frequency == pytest.approx(23.3, abs=0.01)
    (finding,) = lines(stream_of(y + 3e-5 * np.sin(2 * np.pi * 23.3 * T)))
    assert finding.details.between_motion


def test_rounding_has_no_lines():
    """A ramp alone leaves its last digits."""
    assert lines(stream_of(1e-9 * np.arange(N))) == []


def test_with_gaps():
    """5 % of the samples lost: the line is still there, and its amplitude too."""
    y = noise("gaps", random_walk=5e-3) + 4e-3 * np.sin(2 * np.pi * 7.3 * T)
    y[np.random.default_rng(known.seed_of("lost")).random(N) < 0.05] = np.nan
    line = only_line(y)
    assert line.frequency == pytest.approx(7.3, abs=1e-3)
    # Scaled to the power of a whole record, a line comes out √0.95 as large.
    assert line.amplitude == pytest.approx(4e-3, rel=0.08)
    assert lines(stream_of(y))


def test_slopes_roll_offs_and_steps_are_no_lines():
    """Steep spectra, a null in the middle of one, a knock, a warm-up: nothing to do with a line."""
    from scipy.signal import butter, lfilter

    rng = np.random.default_rng(known.seed_of("no lines"))
    white = rng.standard_normal(N)
    cases = {
        "walk": np.cumsum(white),
        "twice": np.cumsum(np.cumsum(white)) * 1e-3,
        "eighth order": lfilter(*butter(8, 5, fs=RATE), white) + 1e-3 * rng.standard_normal(N),
        "running mean": np.convolve(white, np.ones(7) / 7, "same") + 1e-3 * rng.standard_normal(N),
        "knock": white + 50 * np.exp(-np.maximum(T - 800, 0) / 2) * (T > 800),
        "warm-up": white + 100 * np.exp(-T / 600),
    }
    for name, y in cases.items():
        assert find_lines(stream_of(y))["gyro_x"] == (), name


def test_constant_and_short():
    assert lines(stream_of(np.ones(10_000))) == []
    assert lines(stream_of(np.random.default_rng(known.seed_of("short")).standard_normal(100))) == []
    y = np.full(1000, np.nan)
    y[:100] = 1.0
    assert lines(stream_of(y)) == []


def test_dict():
    y = noise("dict") + 4e-3 * np.sin(2 * np.pi * 7.3 * T)
    (finding,) = lines(stream_of(y))
    (line,) = json.loads(json.dumps(finding.to_dict(), allow_nan=False))["details"]["lines"]
    assert line["frequency"] == pytest.approx(7.3, abs=1e-3)


def test_column_is_that_of_a_sinusoid():
    """Sanity of the oracle that the effect leans on: THEORY's closed form."""
    m = np.array([10, 50])
    direct = 1e-6 * np.sin(np.pi * 0.37 * m / RATE) ** 4 / (m**2 * np.sin(np.pi * 0.37 / RATE) ** 2)
    assert kernels.sinusoid_avar(1e-3, 0.37, m, 1 / RATE) == pytest.approx(direct, rel=1e-12)


def test_false_alarms():
    """2e-4 a channel by design: in 200 channels of clean mixtures none, or once in 25 runs one (and never two)."""
    found = 0
    for rates in clean_records("false alarms of lines", 100):
        found += len(lines(rates))
    assert found <= 1


def clean_records(name, count):
    """Mixtures whose corner times lie anywhere, 10 to 400 Hz, 10 to 40 min; two channels a record."""
    rng = np.random.default_rng(known.seed_of(name))
    for _ in range(count):
        rate = float(np.exp(rng.uniform(np.log(10), np.log(400))))
        truth = {"random_walk": 1e-3}
        for term, exponent in (("bias_instability", 0.5), ("rate_random_walk", 1.0), ("rate_ramp", 1.5)):
            if rng.random() < 0.5:
                truth[term] = 1e-3 / (10 ** rng.uniform(-1, 3)) ** exponent
        if rng.random() < 0.5:
            truth["quantization"] = 1e-3 * math.sqrt(10 ** rng.uniform(-2.5, 1))
        if len(truth) > 2 and rng.random() < 0.3:
            del truth["random_walk"]
        model = st.NoiseModel(channels={"gyro_x": truth, "gyro_y": truth})
        duration = min(600 * 4 ** rng.random(), max(2**17 / rate, 600))
        yield st.simulate(model, duration=duration, rate=rate, rng=rng).streams[0]


def test_adis(field_data):
    """The accelerometers carry a line at 0.53 … 0.57 Hz with a third harmonic, 0.5 … 0.9 mg; the gyros none there."""
    record = st.read(field_data / "adis16405_static.csv.gz", rate=100)
    gyro, accel = (record.stream_of(channel) for channel in ("gyro_x", "accel_x"))
    for channel, found in find_lines(accel).items():
        (line,) = (each for each in found if 0.53 <= each.frequency <= 0.57)
        assert 0.5e-3 <= line.amplitude / 9.80665 <= 1.0e-3, channel
        assert any(abs(each.frequency - 3 * line.frequency) < 0.01 for each in line.harmonics), channel
    assert {f.channel for f in lines(accel) if f.severity == "warning"} == {"accel_x", "accel_y", "accel_z"}
    for found in find_lines(gyro).values():
        assert not any(0.5 <= each.frequency <= 0.6 for each in found)


@pytest.mark.parametrize("length", [N, N - 1, 3**11])
def test_a_line_at_half_the_sampling_rate(length):
    """Every second sample is off: ±A by turns has the power A², and makes 2A² of the variance at one sample."""
    amplitude = 0.02
    clean = noise(f"by turns {length}", random_walk=5e-3)[:length]
    y = clean + amplitude * (-1.0) ** np.arange(length)
    line = only_line(y)
    assert line.frequency == pytest.approx(RATE / 2, rel=1e-12)
    # 1.35·√(S/T), of white noise in one bin and not in two, as above; four of them.
    assert line.amplitude == pytest.approx(amplitude, abs=4 * 1.35 * 5e-3 / math.sqrt(length / RATE))
    (finding,) = lines(stream_of(y))
    stated = finding.details.factor
    true = float(np.std(np.diff(y)) / np.std(np.diff(clean)))
    assert stated == pytest.approx(true, abs=0.01)
    assert true == pytest.approx(math.sqrt(1 + 2 * amplitude**2 / (5e-3**2 * RATE)), rel=0.01)
    # It is taken out of the samples as it was put in.
    record = st.Record.from_arrays(rate=RATE, gyro_x=y)
    fitted = st.fit(st.allan(record)["gyro_x"], tau_min=0.01)
    (told,) = lines_in_fits(record.streams[0], {"gyro_x": fitted}, [finding])
    factor = dict(told.factors).get("random_walk", 1.0)
    without = st.fit(st.allan(st.Record.from_arrays(rate=RATE, gyro_x=clean))["gyro_x"], tau_min=0.01)
    if fitted["random_walk"].value:
        ratio = fitted["random_walk"].value / without["random_walk"].value
        assert factor == pytest.approx(ratio if abs(ratio - 1) > 0.05 else 1.0, rel=0.02)


@pytest.mark.parametrize("bins", [1, 2, 3, 6])
def test_a_line_next_to_half_the_sampling_rate(bins):
    """Its skirt is folded back upon it."""
    amplitude, length = 0.02, N / RATE
    frequency = RATE / 2 - bins / length
    y = noise(f"next to half {bins}", random_walk=5e-3) + amplitude * np.sin(2 * np.pi * frequency * T + 1)
    line = only_line(y)
    assert line.frequency == pytest.approx(frequency, abs=0.5 / length)
    # Where the skirts of line and image overlap they add by their phase: of a neighbour at one bin, by some per cent.
    assert line.amplitude == pytest.approx(amplitude, rel=0.05 if bins > 1 else 0.35)
