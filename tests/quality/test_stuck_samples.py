"""Samples that repeat, stick or lie at an end of the range; and noise, fine or coarse, that does none of this."""

import math

import numpy as np
import pytest
from clean_records import check_samples as check
from scipy.signal import butter, sosfilt

import sigmatau
from known import seed_of
from sigmatau import NoiseModel, Record, allan, fit, simulate
from sigmatau.quality.samples.dropouts import dropouts
from sigmatau.quality.samples.repeated_samples import repeated_samples, repeats, runs_of_equal
from sigmatau.quality.samples.saturation import _clipped_sd, saturation
from sigmatau.quality.samples.stuck_samples import stuck_samples

N = 60_000
GYRO = ("gyro_x", "gyro_y", "gyro_z")


def white(name, shape=(N, 3)):
    return np.random.default_rng(seed_of(name)).normal(size=shape)


def gyro(x, rate=100.0):
    return Record.from_arrays(rate=rate, gyro=x).streams[0]


class TestRepeated:
    @pytest.mark.parametrize("step", [0.0, 0.01, 0.5, 1.0])
    @pytest.mark.parametrize("times", [2, 3, 5])
    def test_each_sample_so_many_times(self, times, step):
        """Also where the step of the numbers makes a third of all neighbours equal by chance."""
        x = white(f"times {times}")
        x = np.round(x / step) * step if step else x
        (finding,) = repeated_samples(gyro(np.repeat(x[: N // times], times, axis=0)))
        assert finding.code == "repeated_samples"
        assert finding.severity == "warning"
        assert finding.size == pytest.approx(times, rel=0.02)
        assert (finding.details.shortest, finding.details.longest) == (times, times)
        assert finding.channels == GYRO
        assert finding.details.sensor_rate == pytest.approx(100 / finding.size)

    @pytest.mark.parametrize(("sensor", "log"), [(63, 200), (100, 140), (90, 100)])
    def test_sample_and_hold_of_any_ratio(self, sensor, log):
        x = white(f"hold {sensor}")[np.arange(N) * sensor // log]
        (finding,) = repeated_samples(gyro(x, rate=log))
        assert finding.size == pytest.approx(log / sensor, rel=0.01)

    def test_irregular_copies(self):
        rng = np.random.default_rng(seed_of("irregular"))
        x = white("irregular copies")[np.cumsum(rng.random(N) < 0.7) - 1]
        (finding,) = repeated_samples(gyro(x))
        assert finding.size == pytest.approx(1 / 0.7, rel=0.02)

    def test_one_channel(self):
        (finding,) = repeated_samples(Record.from_arrays(rate=100, gyro_x=np.repeat(white("one", 5000), 2)).streams[0])
        assert finding.channel == "gyro_x"
        assert finding.size == pytest.approx(2.0)

    def test_one_slow_axis_of_three(self):
        x = white("slow axis")
        x[:, 1] = np.repeat(x[: N // 2, 1], 2)
        (finding,) = repeated_samples(gyro(x))
        assert finding.channels == ("gyro_y",)

    @pytest.mark.parametrize("step", [0.1, 0.5, 1.0, 1.5, 2.0, 4.0])
    @pytest.mark.parametrize("drift", [0.0, 2.0])
    def test_coarse_steps_do_not_repeat(self, step, drift):
        """Neighbours are equal by chance, and more often when all axes drift to the middle of a step together."""
        x = white(f"coarse {step}") + np.linspace(0, drift * step, N)[:, None]
        assert repeated_samples(gyro(np.round(x / step) * step)) == []
        assert repeated_samples(gyro(np.round(x / step)[:, :1] * [[1, 0, 0]])) == []

    def test_a_stretch_that_sticks_is_no_repetition(self):
        x = white("stretch", N)
        x[1000:9000] = x[1000]
        assert repeats(Record.from_arrays(rate=100, signal=x).streams[0]) is None

    def test_sigma_at_one_sample(self):
        """1/k of that of white noise with the same σ at long τ."""
        x = np.repeat(white("sigma", (200_000, 3)), 4, axis=0)
        (finding,) = repeated_samples(gyro(x))
        curves = allan(Record.from_arrays(rate=100, gyro=x), taus=[0.01])
        # N of the samples before they were held: 1·√(4·0.01 s), so that white noise would have σ(0.01 s) = 2.
        ratio = np.mean([float(c.adev[0]) for c in curves.values()]) / 2
        assert finding.details.sigma_one_sample == pytest.approx(0.25, rel=0.02)
        # The mean square of 600,000 changes of white noise, 0.5 of it the standard error of σ.
        assert ratio == pytest.approx(0.25, rel=3 * 0.5 * math.sqrt(3 / 600_000))

    @pytest.mark.parametrize("high", [0.2, 0.5, 1.0])
    def test_clipping_is_no_repetition(self, high):
        """Neighbours are both at the end of the range in the square of the share that is; none is a copy."""
        x = white(f"clipped neighbours {high}")
        assert repeated_samples(gyro(np.clip(x, -high, high))) == []
        assert repeated_samples(gyro(np.clip(x, -9, high))) == []
        assert repeated_samples(gyro(np.clip(x[:, :1], -9, high) * [[1, 0, 0]])) == []

    def test_copies_are_found_in_what_is_clipped(self):
        x = np.repeat(np.clip(white("clipped copies"), -1, 1), 2, axis=0)
        (finding,) = repeated_samples(gyro(x))
        assert finding.size == pytest.approx(2, rel=0.02)

    @pytest.mark.parametrize("bias", [1e-3, 0.1])
    @pytest.mark.parametrize("sigma", [1e-5, 1e-4])
    def test_angles_in_single_precision_do_not_repeat(self, bias, sigma):
        """Their step doubles with the angle, on all axes at once; the differences of printed ones are equal but for dust."""
        rng = np.random.default_rng(seed_of(f"single precision {bias} {sigma}"))
        angle = np.cumsum(rng.normal(bias, sigma, (50_000, 3)), axis=0)
        single = angle.astype(np.float32)
        printed = np.diff(np.round(angle, 6), axis=0)
        told = []
        for array, kind in ((single, "accumulated"), (np.diff(single, axis=0), "increments"), (printed, "increments")):
            stream = Record.from_arrays(rate=100, gyro=array, input=kind, unit={"gyro": "rad"}).streams[0]
            told += [f.code for f in check(stream)]
        assert not {"repeated_samples", "saturation", "stuck_samples", "dropout"} & set(told)

    @pytest.mark.parametrize("stamps", [True, False])
    @pytest.mark.parametrize("times", [2, 4])
    def test_what_is_stated_of_the_coefficients(self, times, stamps):
        """By stamps of the rows the random walk is the sensor's own; by the sensor's rate for the rows it is √k of it."""
        rng = np.random.default_rng(seed_of(f"stated {times} {stamps}"))
        x = np.repeat(rng.normal(size=(100_000, 3)), times, axis=0)
        data = {f"w{axis}": x[:, k] for k, axis in enumerate("xyz")}
        options = {"rate": 100.0}
        unit = {"gyro": "rad/s"}
        if stamps:
            data["t"] = np.arange(len(x)) / (100.0 * times)
            options, unit = {"rate": 100.0 * times}, {"gyro": "rad/s", "time": "s"}  # typed as well, and confirmed
        record = sigmatau.from_frame(data, unit=unit, **options)
        (finding,) = repeated_samples(record.streams[0])
        stated = dict(finding.factors).get("random_walk", 1.0)
        assert stated == pytest.approx(1.0 if stamps else math.sqrt(times), rel=0.01)
        assert finding.details.rate_given == (not stamps)
        assert ("quantization" in dict(finding.factors)) == (not stamps)
        tau = 64 * times / record.streams[0].grid.rate
        # The sensor's own: 1 at 100 Hz.
        got = [float(c.adev[0]) * math.sqrt(tau / 0.01) for c in allan(record, taus=[tau]).values()]
        # Three axes of 1562 clusters; held samples that clusters share make less than 1 %.
        assert np.mean(got) == pytest.approx(stated, rel=3 / math.sqrt(2 * 3 * 1562) + 0.01)


def test_the_other_coefficients_of_duplicated_samples():
    """Times are stretched twice: quantization × 2, rate random walk × 0.71, ramp × 0.5; exact in the Allan variance."""
    for term, slope in (("quantization", -1.0), ("rate_random_walk", 0.5), ("rate_ramp", 1.0)):
        model = NoiseModel(channels={"gyro_x": {term: 1e-3}})
        x = (
            simulate(model, duration=400.0, rate=100.0, rng=seed_of(f"other {term}") % 2**60)
            .streams[0]
            .column("gyro_x")
        )
        x = x + 1e-5 * np.random.default_rng(seed_of(f"noise {term}")).normal(size=len(x))
        twice = Record.from_arrays(rate=100.0, gyro_x=np.repeat(x, 2))
        (finding,) = [f for f in check(twice.streams[0]) if f.code == "repeated_samples"]
        once = allan(Record.from_arrays(rate=100.0, gyro_x=x), taus=[5.12])["gyro_x"].adev[0]
        stretched = allan(twice, taus=[10.24])["gyro_x"].adev[0]
        # The same clusters, and those between: with quantization noise half of them begin within a sample.
        ratio = float(stretched / once) * 2**-slope
        assert ratio == pytest.approx(dict(finding.factors)[term], rel=0.3 if term == "quantization" else 0.01)


class TestDropout:
    @pytest.mark.parametrize("bias", [0.0, 8.0])
    def test_a_run_of_zeros(self, bias):
        x = white(f"dropout {bias}") + bias
        x[20_000:20_500, 1] = 0.0
        (finding,) = check(gyro(x / 100))
        assert (finding.code, finding.channel, finding.severity) == ("dropout", "gyro_y", "warning")
        assert finding.spans == ((200.0, 205.0),)
        assert (finding.details.samples, finding.details.runs) == (500, 1)
        assert (finding.details.start, finding.details.longest) == pytest.approx((200.0, 5.0))

    def test_axes_that_are_lost_at_different_times_are_one_finding(self):
        x = white("dropouts of two axes") + 3
        x[20_000:20_500, 1] = 0.0
        x[40_000:40_050, 2] = 0.0
        ((finding, _),) = dropouts(gyro(x))
        assert finding.channels == ("gyro_y", "gyro_z")
        assert finding.spans == ((200.0, 205.0),)
        assert finding.details.samples == 500

    def test_a_range_that_ends_at_zero_is_saturation(self):
        for level in (0.0, -1.0, -2.0):
            x = np.maximum(white(f"half {level}") + level, 0.0)
            assert dropouts(gyro(x)) == []
            assert [f.code for f, _ in saturation(gyro(x))] == ["saturation"]
            assert stuck_samples(gyro(x)) == []

    def test_coarse_numbers_that_stick_at_zero(self):
        x = np.round(white("coarse zero"))
        x[20_000:20_500, 1] = 0.0
        assert dropouts(gyro(x)) == []
        assert len(stuck_samples(gyro(x))) == 1


class TestStuck:
    @pytest.mark.parametrize("step", [0.0, 0.1, 1.0])
    def test_a_run_that_noise_does_not_make(self, step):
        x = white(f"run {step}")
        x = np.round(x / step) * step if step else x
        x[20_000:20_300, 1] = x[20_000, 1]
        ((finding, _),) = stuck_samples(gyro(x))
        assert finding.code == "stuck_samples"
        assert finding.channel == "gyro_y"
        assert finding.spans[0][0] == finding.details.start == pytest.approx(200.0, abs=0.05)
        assert finding.details.longest == pytest.approx(3.0, abs=0.05)

    def test_on_all_axes_it_is_one_finding(self):
        x = white("all axes")
        x[20_000:20_300] = x[20_000]
        ((finding, _),) = stuck_samples(gyro(x))
        assert finding.channels == GYRO
        assert finding.spans == ((200.0, 203.0),)

    @pytest.mark.parametrize("ratio", [0.05, 0.1, 0.2, 0.4, 0.7, 3.0])
    @pytest.mark.parametrize("phase", [0.0, 0.25, 0.5])
    def test_coarse_noise_does_not_stick(self, ratio, phase):
        """Not even at a tenth of a step in the middle of one, where it rests for ever; nor while it drifts through."""
        x = white(f"coarse {ratio} {phase}") * ratio + phase
        assert stuck_samples(gyro(np.round(x))) == []
        assert stuck_samples(gyro(np.round(x + np.linspace(0, 3, N)[:, None]))) == []

    @pytest.mark.parametrize("ratio", [0.35, 0.4, 0.5, 0.7])
    def test_coarse_quantization_noise_does_not_stick(self, ratio):
        """Its neighbours differ by more than those of white noise, so that it seems larger than it is."""
        x = np.diff(white(f"quantization {ratio}", (4 * N, 3)), axis=0) * ratio
        assert stuck_samples(gyro(np.round(x))) == []

    @pytest.mark.parametrize(("start", "stop"), [(20_000, 20_300), (N - 300, N), (20_000, 20_080)])
    def test_a_run_in_smooth_noise(self, start, stop):
        """Behind a filter numbers rest at their extremes; a stuck sensor jumps after it, or never moves again."""
        x = sosfilt(butter(2, 0.06, output="sos"), white("smooth"), axis=0)
        x = np.round(x / np.diff(x, axis=0).std()) + 50
        assert stuck_samples(gyro(x)) == []
        x[start:stop, 1] = x[start, 1]
        ((finding, _),) = stuck_samples(gyro(x))
        assert (finding.channel, finding.details.runs) == ("gyro_y", 1)
        assert finding.details.longest == pytest.approx((stop - start) / 100, abs=0.05)

    def test_a_run_among_held_samples(self):
        x = np.repeat(white("held", (N // 4, 3)), 4, axis=0)
        assert stuck_samples(gyro(x)) == []
        x[20_000:20_300] = x[20_000]
        assert len(stuck_samples(gyro(x))) == 1

    def test_runs_are_no_copies(self):
        """40 runs of 200 are 13 % of the record, and nothing else repeats."""
        x = white("no copies", N)
        for start in range(1000, N - 1000, 1450):
            x[start : start + 200] = x[start]
        found = check(Record.from_arrays(rate=100, gyro_x=x).streams[0])
        assert "stuck_samples" in [finding.code for finding in found]
        assert "repeated_samples" not in [finding.code for finding in found]

    def test_a_channel_that_never_changes_is_for_others_to_tell(self):
        assert stuck_samples(gyro(np.ones((1000, 3)))) == []

    def test_runs(self):
        first, lengths = runs_of_equal(np.array([1.0, 1, 2, 3, 3, 3, np.nan, np.nan, 4, 4]))
        assert (first.tolist(), lengths.tolist()) == ([0, 3, 8], [2, 3, 2])
        first, lengths = runs_of_equal(np.array([1.0, 1, 2, 3, 3, 3, 3, 5]), shortest=4)
        assert (first.tolist(), lengths.tolist()) == ([3], [4])


class TestSaturation:
    @pytest.mark.parametrize("step", [0.0, 0.05, 0.1])
    @pytest.mark.parametrize(("low", "high"), [(-2.0, 2.0), (-9.0, 1.5), (-1.0, 9.0)])
    def test_clipped_noise(self, low, high, step):
        """What clipping leaves of the standard deviation, in closed form and in the Allan variance."""
        x = white(f"clipped {low}", (4 * N, 1))[:, 0]
        x = np.round(x / step) * step if step else x
        if step:
            low, high = round(low / step) * step, round(high / step) * step
        y = np.clip(x, low, high)
        ((finding, _),) = saturation(Record.from_arrays(rate=100, signal=y).streams[0])
        assert finding.code == "saturation"
        assert finding.severity == "warning"
        assert finding.size == pytest.approx(np.mean((x <= low) | (x >= high)), rel=1e-12)
        curves = allan(Record.from_arrays(rate=100, a=x, b=y), taus=[0.04])
        measured = float(curves["b"].adev[0] / curves["a"].adev[0])
        # 0.4 % is a standard error of σ(0.04 s) by eq. (26), of which the ratio has a part; the step is known to 1 %.
        assert dict(finding.factors)["random_walk"] == pytest.approx(measured, rel=0.008)

    def test_closed_form(self):
        """Noise held at 0 from one side is half a Gaussian: variance 1/2 - 1/(2π)."""
        assert _clipped_sd(0.5, 0.0) == pytest.approx(math.sqrt(0.5 - 0.5 / math.pi), rel=1e-12)
        assert _clipped_sd(0.0, 0.0) == pytest.approx(1.0, rel=1e-12)
        assert _clipped_sd(0.5 - 1e-9, 0.5 - 1e-9) == pytest.approx(0.0, abs=1e-8)

    def test_a_knock_into_the_end_of_the_range(self):
        x = white("knock")
        x[7000:7040, 2] = 80.0
        ((finding, _),) = saturation(gyro(x))
        assert finding.channel == "gyro_z"
        assert finding.spans == (pytest.approx((70.0, 70.4)),)
        assert (finding.details.low, finding.details.high) == (None, 80.0)
        assert finding.factors == ()
        assert stuck_samples(gyro(x)) == []

    @pytest.mark.parametrize("ratio", [0.1, 0.3, 0.5, 0.7, 1.0, 2.0, 10.0, 100.0])
    @pytest.mark.parametrize("drift", [0.0, 3.0, 40.0])
    def test_tails_are_no_ends(self, ratio, drift):
        x = white(f"tails {ratio}") * ratio + np.linspace(0, drift, N)[:, None] + 0.37
        assert saturation(gyro(np.round(x))) == []
        x += np.cumsum(white(f"walk {ratio}"), axis=0) * 0.02 * ratio
        assert saturation(gyro(np.round(x))) == []
        assert saturation(gyro(np.repeat(np.round(x), 3, axis=0))) == []

    def test_short_tails_are_no_ends(self):
        rng = np.random.default_rng(seed_of("short tails"))
        for _ in range(400):
            assert saturation(gyro(np.round(rng.normal(size=(300, 3)) * 2.5))) == []

    @pytest.mark.parametrize("rest", [10.2, 10.5, 10.8])
    def test_a_coarse_channel_that_comes_to_rest(self, rest):
        """Its last two levels are visited in turn."""
        x = np.minimum(np.linspace(0, 20, N), rest)[:, None] + 0.3 * white("comes to rest")
        assert saturation(gyro(np.round(x))) == []


def test_duplicates_at_the_sensors_rate_change_a_fitted_random_walk_by_the_root_of_two():
    x = white("fitted", (100_000, 1))[:, 0]
    twice = Record.from_arrays(rate=100, gyro_x=np.repeat(x, 2))
    (finding,) = repeated_samples(twice.streams[0])
    once = fit(allan(Record.from_arrays(rate=100, gyro_x=x))["gyro_x"])["random_walk"]
    read = float(allan(twice, taus=[0.64])["gyro_x"].adev[0]) * 0.8
    assert dict(finding.factors)["random_walk"] == pytest.approx(math.sqrt(2), rel=1e-3)
    # σ at 32 true samples of 100,000: 1.3 % by eq. (26).
    assert read / once.value == pytest.approx(dict(finding.factors)["random_walk"], rel=3 * 0.0127)


def pulses(name, sigmas, mean, how):
    """Pulses of an angle, of so many standard deviations of an increment, scaled as logs do it; integers where not."""
    x = white(name) / sigmas + mean * np.array([1, -0.7, 0.4])
    count = np.diff(np.floor(np.cumsum(x, axis=0)), axis=0, prepend=0.0)
    size = 3.0638e-6
    if how == "printed":  # decimals of about half a pulse
        return np.round(count * size / 1.3e-6) * 1.3e-6
    if how == "compensated":  # scale factor and bias by temperature, once a second
        slow = np.repeat(np.cumsum(white(f"{name} slow", (N // 100, 3)), axis=0), 100, axis=0)
        return count * size * (1 + 1e-5 * slow) + 1e-4 * size * slow
    return count * size


PULSES = [(1.0, 0.0, "exact"), (1.0, 0.3, "printed"), (1.0, 3.2, "compensated")]
PULSES += [(2.0, 0.0, "printed"), (2.0, 0.3, "compensated"), (2.0, 3.2, "exact")]
PULSES += [(3.0, 0.0, "compensated"), (3.0, 0.3, "exact"), (3.0, 3.2, "printed")]


@pytest.mark.parametrize(("sigmas", "mean", "how"), PULSES)
def test_pulses_have_nothing_wrong_with_them(sigmas, mean, how):
    """Four of five equal the one before, many are zero, and few values occur: that is their rounding."""
    gyro = pulses(f"pulses {sigmas} {mean} {how}", sigmas, mean, how)
    (stream,) = Record.from_arrays(rate=100, input="increments", gyro=gyro).streams
    assert {f.code for f in check(stream)} <= {"coarse_resolution"}


def test_a_dropout_of_pulses_is_found():
    x = pulses("dropout of pulses", 2.0, 30.0, "exact")
    x[20_000:20_500] = 0.0
    x[40_000] = 0.0
    (stream,) = Record.from_arrays(rate=100, input="increments", gyro=x).streams
    ((_, mask),) = dropouts(stream)
    assert np.flatnonzero(mask.all(axis=1)).tolist() == [*range(20_000, 20_500), 40_000]
