"""Internal low-pass filters and aliasing: planted, found, measured, and what they are said to do against what they do."""

import json
import math

import numpy as np
import pytest
from sigmatau.quality.spectrum.low_pass import aliasing, low_pass, low_passes
from sigmatau.quality.spectrum.pair_spectrum import by_pairs
from studies.bandwidth import filtered_white

import known
import sigmatau as st
from sigmatau.errors import OptionError
from sigmatau.noise.terms import aliasing_inflation
from sigmatau.quality.spectrum import filter_models


def stream_of(y, rate):
    return st.Record.from_arrays(rate=rate, gyro_x=y).streams[0]


def planted(order, rate, corner, n=2**19):
    rng = np.random.default_rng(known.seed_of(f"filter {order} {rate} {corner}"))
    return filtered_white(n, rate=rate, bandwidth=corner, order=order, rng=rng)


def measured_share(y, rate, sizes=(256, 362, 512)):
    """σ at one sample over what the random walk makes there, the random walk from the cluster sizes that are given."""
    curve = st.allan(st.Record.from_arrays(rate=rate, gyro_x=y), taus=np.array([1, *sizes]) / rate)["gyro_x"]
    walk = np.sqrt(curve.avar * curve.tau)
    return walk[0] / walk[1:].mean()


ANALOG = [shape for shape in filter_models.SHAPES if not filter_models.digital(shape)]
DIGITAL = {"digital1": 1, "digital2": 2, "digital4": 4}


class TestShapes:
    @pytest.mark.parametrize("shape", ANALOG)
    @pytest.mark.parametrize("corner", [2.0, 30.0, 60.0])
    def test_folded_white_is_the_sum_of_images(self, shape, corner):
        f = np.array([0.1, 5.0, 20.0, 49.0])
        k = np.arange(-20_000, 20_001) * 100.0
        images = [filter_models.response(shape, corner, x + k).sum() for x in f]
        # The images that are left out fall as 1/k² for a first order: 1.5e-5 at 60 Hz.
        assert filter_models.folded_white(shape, corner, f, 0.01) == pytest.approx(images, rel=3e-5)

    @pytest.mark.parametrize("shape", filter_models.SHAPES)
    def test_corner_is_at_half_the_power(self, shape):
        assert filter_models.response(shape, 30.0, 30.0, tau0=0.01) == pytest.approx(0.5, rel=1e-6)
        assert filter_models.response(shape, 30.0, 0.0, tau0=0.01) == 1.0

    @pytest.mark.parametrize("shape", DIGITAL)
    @pytest.mark.parametrize("corner", [2.0, 30.0, 45.0])
    def test_digital_ones_are_those_of_scipy(self, shape, corner):
        from scipy.signal import butter, freqz

        f = np.array([0.1, 5.0, 20.0, 49.0])
        expected = np.abs(freqz(*butter(DIGITAL[shape], corner, fs=100.0), worN=f, fs=100.0)[1]) ** 2
        assert filter_models.folded_white(shape, corner, f, 0.01) == pytest.approx(expected, rel=1e-6, abs=1e-12)

    @pytest.mark.parametrize("shape", DIGITAL)
    def test_variance_of_digital_ones(self, shape):
        """Eq. (11) for samples, 4·∫S·sin⁴(πmf)/(m·sin πf)²df, as a sum over a fine grid, against the autocovariance."""
        f = (np.arange(200_000) + 0.5) / 400_000
        for m in (1, 7):
            gain = np.sin(np.pi * m * f) ** 4 / (m * np.sin(np.pi * f)) ** 2
            expected = 4 * np.mean(filter_models.response(shape, 0.07, f) * gain) / 2 * m
            assert filter_models.relative_avar(shape, 0.07, m, 1.0)[0] == pytest.approx(expected, rel=1e-6)

    @pytest.mark.parametrize(("shape", "name"), [("first_order", "σ = 0.05"), ("butterworth2", "N = 0.005")])
    def test_known_variances(self, shape, name):
        """Ten digits of the theory, at 30 Hz and 0.01 s; the first order by its own variance σ², N² = 2σ²τ_f."""
        m = np.array(known.SIZES[:4])
        n2 = 0.005**2 if shape == "butterworth2" else 2 * 0.05**2 / (2 * math.pi * 30)
        plateau = n2 * filter_models.folded_white(shape, 30.0, 0.0, 0.01)[0]
        found = filter_models.relative_avar(shape, 30.0, m, 0.01) * plateau / (m * 0.01)
        assert found == pytest.approx(known.FILTERS[shape, name][:4], rel=2e-9)

    @pytest.mark.parametrize("shape", filter_models.SHAPES)
    def test_right_from(self, shape):
        """Within 2 % in variance from there on, and not an octave before."""
        tau = filter_models.right_from(shape, 30.0, 0.002)
        m = round(tau / 0.002)
        assert filter_models.relative_avar(shape, 30.0, [m, 2 * m], 0.002) == pytest.approx([0.98, 0.99], abs=0.001)


@pytest.mark.parametrize(
    ("order", "rate", "corner"),
    [(1, 200.0, 30.0), (2, 200.0, 30.0), (1, 100.0, 30.0), (2, 200.0, 5.0), (1, 400.0, 10.0)],
)
def test_corner_order_and_effect(order, rate, corner):
    y = planted(order, rate, corner)
    stream = stream_of(y, rate)
    fitted = low_passes(stream)["gyro_x"]
    assert fitted.shape == {1: "first_order", 2: "butterworth2"}[order]
    assert fitted.corner == pytest.approx(corner, abs=4 * fitted.error + 0.003 * corner)
    (finding,) = low_pass(stream)
    assert finding.code == "low_pass_filter"
    assert finding.severity == "warning"
    assert finding.size == fitted.corner
    # The random walk from some 2^19/256 clusters has an error of 1.3 %.
    share = (
        measured_share(y, rate)
        if corner > 20
        else math.sqrt(filter_models.relative_avar(fitted.shape, corner, 1, 1 / rate)[0])
    )
    assert dict(finding.factors)["random_walk"] == pytest.approx(share, rel=0.04)
    json.dumps(finding.to_dict(), allow_nan=False)


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize("corner", [2.0, 5.0, 20.0, 40.0])
def test_digital_filters(order, corner):
    """Corner and order of scipy.signal.butter at 100 Hz; of five records' 95 % intervals at most two miss (p = 0.1 %).

    Of 100 records of 2^18 samples a case, 91 to 100 % of the intervals held.
    """
    from scipy.signal import butter, lfilter

    rng = np.random.default_rng(known.seed_of(f"digital {order} {corner}"))
    held = 0
    for _ in range(5):
        stream = stream_of(lfilter(*butter(order, corner, fs=100.0), rng.standard_normal(102_000))[2000:], 100.0)
        fitted = low_passes(stream)["gyro_x"]
        assert f"digital{order}" in (fitted.shape, *fitted.alike)
        held += abs(fitted.corner - corner) <= 1.96 * fitted.error
    assert held >= 3  # fewer have a chance of 1e-3
    expected = math.sqrt(filter_models.relative_avar(f"digital{order}", corner, 1, 0.01)[0])
    assert fitted.sigma_one_sample == pytest.approx(expected, rel=0.1)


def test_a_steep_digital_filter_is_not_interpolation():
    from scipy.signal import butter, lfilter

    from sigmatau.quality.spectrum.upsampling import upsampled

    rng = np.random.default_rng(known.seed_of("steep"))
    for corner in (2.0, 30.0):
        y = lfilter(*butter(4, corner, fs=100.0), rng.standard_normal(2**17))[1000:]
        assert upsampled(stream_of(y, 100.0)) == []


def test_the_example_of_the_field():
    """A MEMS gyro at 200 Hz behind 30 Hz: 0.52 … 0.96 of the random walk at 5 … 100 ms."""
    relative = np.sqrt(filter_models.relative_avar("first_order", 30.0, [1, 20], 1 / 200))
    assert relative == pytest.approx([0.52, 0.96], abs=0.006)
    (finding,) = low_pass(stream_of(planted(1, 200.0, 30.0), 200.0))
    assert finding.details.sigma_one_sample == pytest.approx(0.52, abs=0.006)


@pytest.mark.parametrize(
    ("truth", "kept"),
    [
        ({"bias_instability": 0.3}, True),
        ({"rate_random_walk": 0.05}, True),
        ({"quantization": 2e-3}, True),
    ],
)
def test_beside_other_noise(truth, kept):
    rate, n = 200.0, 2**19
    model = st.NoiseModel(channels={"gyro_x": truth})
    name = f"beside {next(iter(truth))}"
    other = st.simulate(model, duration=n / rate, rate=rate, rng=known.seed_of(name)).streams[0].column("gyro_x")
    fitted = low_passes(stream_of(planted(1, rate, 30.0) + other, rate))["gyro_x"]
    assert ("first_order" in (fitted.shape, *fitted.alike)) is kept
    assert fitted.corner == pytest.approx(30, rel=0.12)


def test_running_mean():
    white = np.random.default_rng(known.seed_of("running mean")).standard_normal(2**18)
    y = np.convolve(white, np.ones(4) / 4, "valid")
    fitted = low_passes(stream_of(y, 200.0))["gyro_x"]
    assert fitted.shape == "mean"
    assert fitted.corner == pytest.approx(0.44294647 * 200 / 4, rel=0.005)
    assert fitted.sigma_one_sample == pytest.approx(
        0.25, rel=0.02
    )  # AVAR(1) is 1/16 of that of white noise: only the ends differ


def test_beside_a_line_and_a_resonance():
    from scipy.signal import iirpeak, lfilter

    rng = np.random.default_rng(known.seed_of("filter and resonance"))
    y = planted(1, 200.0, 30.0)
    y += 3 * np.sin(2 * np.pi * 41.3 * np.arange(len(y)) / 200.0)
    y += 20 * lfilter(*iirpeak(55.0, 30.0, fs=200.0), rng.standard_normal(len(y)))
    assert low_passes(stream_of(y, 200.0))["gyro_x"].corner == pytest.approx(30, rel=0.1)


def test_gaps():
    """A few lost samples: segments without them are enough."""
    y = planted(1, 200.0, 30.0)
    y[:: len(y) // 20] = np.nan
    assert low_passes(stream_of(y, 200.0))["gyro_x"].corner == pytest.approx(30, rel=0.03)


def lossy(y, share, name):
    """At random, a sample here and there."""
    return np.where(np.random.default_rng(known.seed_of(name)).random(len(y)) < share, np.nan, y)


@pytest.mark.parametrize(("order", "corner"), [(1, 30.0), (2, 20.0), (2, 10.0)])
@pytest.mark.parametrize("share", [0.003, 0.05])
def test_filters_are_seen_through_random_losses(order, corner, share):
    """No stretch of 64 samples is whole at 5 %, none of 4096 at 0.3 %: as without losses, corner, order and folded noise."""
    y = planted(order, 100.0, corner, n=2**18)
    stream = stream_of(lossy(y, share, f"losses {order} {corner} {share}"), 100.0)
    fits = low_passes(stream)
    found = fits["gyro_x"]
    assert found.shape == ("first_order" if order == 1 else "butterworth2")
    # The corner's own error, and 1 % for the filter that is planted, which is simulated at a finite rate.
    assert found.corner == pytest.approx(corner, abs=3 * found.error + 0.01 * corner)
    assert found.sigma_one_sample == pytest.approx(measured_share(y, 100.0), rel=0.03)
    assert [f.code for f in aliasing(stream, fits=fits)] == (["aliasing"] if order == 1 else [])


def test_the_density_by_pairs():
    """Against the closed form through 10 % losses, band by band, beside a walk of a hundred times the samples' spread."""
    name = "density by pairs"
    rng = np.random.default_rng(known.seed_of(name))
    y = planted(2, 100.0, 20.0, n=2**18) + np.cumsum(0.1 * rng.standard_normal(2**18))
    found = by_pairs(lossy(y, 0.1, name), stream_of(y, 100.0), "gyro_x")
    for low, high in ((8.0, 16.0), (16.0, 32.0), (32.0, 49.0)):
        band = (found.frequency >= low) & (found.frequency < high)
        ratio = found.density[band] / filter_models.folded_white("butterworth2", 20.0, found.frequency[band], 0.01)
        # Neighbours under a Hann taper are correlated by 4/9 and 1/36.
        error = math.sqrt(2 * np.mean(1 / found.dof[band]) * (1 + 2 * (4 / 9 + 1 / 36)) / band.sum())
        assert np.mean(ratio) == pytest.approx(1, abs=3 * error)
        # As sure as it says: the bins' own scatter, of which some hundred are free.
        assert np.std(ratio) == pytest.approx(math.sqrt(2 * np.mean(1 / found.dof[band])), rel=0.3)


def test_no_filter_in_clean_records_with_losses():
    """1e-6 a channel, as without losses: in 60 channels of clean mixtures not one."""
    from test_lines import clean_records

    for k, stream in enumerate(clean_records("false alarms with losses", 30)):
        columns = [lossy(stream.column(c), (0.003, 0.05, 0.2)[k % 3], f"clean losses {k} {c}") for c in stream.channels]
        rate = stream.grid.rate
        torn = st.Record.from_arrays(rate=rate, **dict(zip(stream.channels, columns, strict=True))).streams[0]
        assert low_pass(torn) == []


def test_coloured_noise_is_no_filter():
    """A Gauss-Markov process beside as much white noise has the spectrum of a filter and a floor."""
    rng = np.random.default_rng(known.seed_of("coloured"))
    y = filtered_white(2**18, rate=100.0, bandwidth=3.0, order=1, rng=rng) + 15 * rng.standard_normal(2**18)
    assert low_pass(stream_of(y, 100.0)) == []
    assert low_pass(stream_of(np.ones(10_000), 100.0)) == []
    assert low_pass(stream_of(rng.standard_normal(200), 100.0)) == []


class TestAliasing:
    def test_seen_in_the_spectrum(self):
        """First order, 30 Hz at 100 Hz: 1.131, which `factors` says within what the corner leaves open."""
        stream = stream_of(planted(1, 100.0, 30.0), 100.0)
        (finding,) = aliasing(stream)
        assert finding.severity == "warning"
        assert dict(finding.factors)["random_walk"] == pytest.approx(1.131, abs=0.01)
        assert not finding.details.stated
        assert aliasing(stream, fits={}) == []

    def test_not_where_sampling_is_fast(self):
        assert aliasing(stream_of(planted(1, 400.0, 10.0), 400.0)) == []

    def test_not_where_other_filters_do_the_same(self):
        """At 50 Hz a first-order filter of 30 Hz has a spectrum that is flat to 10 %: it does not tell what is folded in."""
        assert aliasing(stream_of(planted(1, 50.0, 30.0), 50.0)) == []

    @pytest.mark.parametrize(("rate", "severity"), [(10.0, "warning"), (100.0, "warning"), (500.0, "info")])
    def test_stated(self, rate, severity):
        stream = stream_of(np.random.default_rng(known.seed_of("stated")).standard_normal(1000), rate)
        (finding,) = aliasing(stream, bandwidth=(30.0, None))
        first, second = (aliasing_inflation(rate=rate, bandwidth=30.0, order=order) for order in (1, 2))
        assert finding.severity == severity
        assert finding.channels == ("gyro_x",)
        assert finding.details.stated
        assert dict(finding.factors)["random_walk"] == first
        assert finding.details.second_order == second
        (finding,) = aliasing(stream, bandwidth=(30.0, 2))
        assert dict(finding.factors)["random_walk"] == second
        assert finding.severity == ("warning" if second > 1.05 else "info")

    def test_remedy_is_a_rate_that_helps(self):
        stream = stream_of(np.arange(100.0), 50.0)
        (finding,) = aliasing(stream, bandwidth=(30.0, 1))
        rate = finding.details.rate_needed
        assert aliasing_inflation(rate=rate, bandwidth=30.0) == pytest.approx(1.02, abs=1e-3)

    @pytest.mark.parametrize("wrong", [(0.0, None), (math.nan, 1), (30.0, 0), (30.0, 9), (1e9, 1)])
    def test_wrong_bandwidth(self, wrong):
        with pytest.raises(OptionError, match=r"bandwidth|order"):
            aliasing(stream_of(np.arange(100.0), 50.0), bandwidth=wrong)


def test_false_alarms():
    """The threshold leaves 1e-6 a channel: in 80 channels of clean mixtures not one."""
    from test_lines import clean_records

    for stream in clean_records("false alarms of filters", 40):
        assert low_pass(stream) == []


def test_adis(field_data):
    """All gyros are filtered: 0.79 of the random walk at one sample; z has a resonance as well."""
    record = st.read(field_data / "adis16405_static.csv.gz", rate=100)
    stream = record.stream_of("gyro_x")
    fitted = low_passes(stream)
    assert set(fitted) == {"gyro_x", "gyro_y", "gyro_z"}
    for channel in ("gyro_x", "gyro_y"):
        y = np.array(stream.column(channel))
        # From 0.32 to 0.64 s the filter is over and the flicker noise not yet 2 % of the deviation.
        assert fitted[channel].sigma_one_sample == pytest.approx(measured_share(y, 100.0, (32, 45, 64)), rel=0.03)
        assert {"mean", "bartlett"} & {fitted[channel].shape, *fitted[channel].alike}
    assert {f.channel for f in low_pass(stream, fits=fitted)} == set(fitted)


def counts(name, cut, *, level=0.0):
    """Counts of an angle that wanders at random, behind a second-order filter at 10 Hz or none; 100 Hz."""
    white = np.random.default_rng(known.seed_of(name)).normal(size=60_000) * 1e-7
    if cut:
        from scipy.signal import butter, lfilter

        white = lfilter(*butter(2, 10 / 50), white)
    step = 2e-7 if cut else 5e-7
    angle = np.cumsum(white + level)
    return st.Record.from_arrays(
        rate=100.0, gyro_x=np.diff(np.round(angle / step) * step, prepend=0), input="increments"
    )


def test_rounding_of_counts_is_no_filter():
    """White noise and quantization, which rises towards half the sampling rate, fall nowhere."""
    for k in range(12):
        assert low_pass(counts(f"counts {k}", cut=False).streams[0]) == []


def test_a_filter_under_quantization_makes_no_deviation_larger():
    """It is found by its fall below the random walk; what makes σ at one sample larger is said to be another."""
    for k in range(4):
        (finding,) = low_pass(counts(f"filtered counts {k}", cut=True, level=1.3e-7).streams[0])
        assert finding.size == pytest.approx(10, rel=0.1)
        assert dict(finding.factors)["random_walk"] > 1
        assert finding.details.sigma_one_sample > 1
