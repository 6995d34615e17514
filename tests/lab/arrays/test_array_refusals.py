"""What is not an array is refused, and the message names the sensor."""

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from sigmatau.errors import NotAtRestError
from sigmatau.lab.arrays.channels import complete_rows


def noise(name, count=3, n=6000, size=1e-3):
    return size * np.random.default_rng(seed_of(name)).standard_normal((count, n))


def array(samples, *, rate=20.0, sensor="gyro", **options):
    columns = {f"{sensor}_{k}": values for k, values in enumerate(samples)}
    return st.analyze_array(st.Record.from_arrays(rate=rate, **columns), **options)


def test_dead_sensor():
    x = noise("dead")
    x[1] = 0.25
    with pytest.raises(st.DataError, match="gyro_1 never changes"):
        array(x)


def test_duplicated_column():
    x = noise("copy")
    x[2] = x[0]
    with pytest.raises(st.DataError, match="gyro_0 and gyro_2 are identical"):
        array(x)


def test_duplicated_column_with_another_scale():
    x = noise("scaled copy")
    x[2] = 1.5 * x[0]
    with pytest.raises(st.DataError, match="gyro_0 and gyro_2 are one signal"):
        array(x)


def test_duplicated_column_with_a_common_disturbance():
    x = noise("common copy")
    x[2] = x[0] + 0.5
    with pytest.raises(st.DataError, match="gyro_0 and gyro_2 are one signal"):
        array(x, common=True)


def test_opposite_sign():
    """Sensors that see a common vibration with opposite signs."""
    x = noise("opposite") + 0.01 * np.random.default_rng(seed_of("vibration")).standard_normal(6000)
    x[1] *= -1
    with pytest.raises(st.OptionError, match=r"opposite signs.*`invert` gyro_1"):
        array(x)
    inverted = array(x, invert=["gyro_1"])
    assert all(each.value > 0.9 for each in inverted.correlations["random_walk"].values())


def test_axes_of_one_sensor():
    record = st.Record.from_arrays(rate=20, **dict(zip(("gyro_x", "gyro_y", "gyro_z"), noise("axes"), strict=True)))
    with pytest.raises(st.OptionError, match="gyro_x, gyro_y, gyro_z are the axes of one sensor"):
        st.analyze_array(record)


@pytest.mark.parametrize("name", ["gyro_1", "accel_x", "gyro_x\n", ""])
def test_name_of_the_virtual_sensor(name):
    with pytest.raises(st.OptionError, match="must be a new channel of gyro"):
        array(noise("name"), name=name)


def test_opposite_gravity():
    x = noise("gravity")
    x += np.array([[9.81], [-9.79], [9.8]])
    with pytest.raises(st.DataError, match=r"gravity with opposite signs, 9\.81 and -9\.79"):
        array(x, sensor="accel")


def test_moving_record():
    x = noise("moving", n=20_000) + 0.2 * np.sin(np.arange(20_000) / 300) * (np.arange(20_000) % 7000 > 3500)
    with pytest.raises(NotAtRestError, match="An array needs a record at rest"):
        array(x)


def test_different_rates():
    logs = [st.Record.from_arrays(rate=rate, gyro_x=noise(f"rate {rate}", 1)[0]) for rate in (20.0, 20.01)]
    with pytest.raises(st.DataError, match=r"different rates, 20 and 20\.01 Hz"):
        st.analyze_array(logs)


def test_different_quantities():
    record = st.Record.from_arrays(rate=20, gyro_x=noise("gyro", 1)[0], accel_x=noise("accel", 1)[0])
    with pytest.raises(st.DataError, match="an array has one quantity"):
        st.analyze_array(record, axes=["gyro_x", "accel_x"])
    with pytest.raises(st.OptionError, match="name the sensors of one axis"):
        st.analyze_array(record)


def test_too_few_sensors():
    with pytest.raises(st.OptionError, match="at least two sensors"):
        array(noise("single", 1))
    with pytest.raises(st.OptionError, match="`common` needs three sensors"):
        array(noise("pair", 2), common=True)


def test_target_that_is_not_observed():
    with pytest.raises(st.OptionError, match="`target` rate_random_walk: no sensor shows it; observed: random_walk"):
        array(noise("white"), target="rate_random_walk")


def test_several_logs_are_one_array():
    x = noise("logs", 3)
    logs = [st.Record.from_arrays(rate=20, gyro_x=each) for each in x]
    several = st.analyze_array(logs)
    assert several.names == ("gyro_x_1", "gyro_x_2", "gyro_x_3")
    assert several.virtual.channel == "gyro_x"
    single = array(x)
    assert several.virtual.weights.vector == pytest.approx(single.virtual.weights.vector, rel=1e-9)


def test_spikes_are_filled():
    """Rows that an analysis leaves out are filled for all channels, and change N by their share at most."""
    x = noise("spikes", 2, n=20_000)
    spiked = x.copy()
    spiked[0, 5000], spiked[1, 9000:9003] = 1.0, np.nan
    clean, filled = array(x), array(spiked)
    assert filled.filled >= 4
    for name in clean.names:
        expected = clean.coefficients["random_walk"][name].value
        assert filled.coefficients["random_walk"][name].value == pytest.approx(expected, rel=0.002)


def test_long_gaps_leave_the_longest_stretch():
    x = noise("gap", 2, n=10_000)
    lost = np.zeros(10_000, dtype=bool)
    lost[2000:5000] = True
    samples, count = complete_rows(x, lost)
    assert samples.shape == (2, 5000)
    assert count == 0
    assert (samples == x[:, 5000:]).all()


def test_filled_rows_keep_the_covariance():
    rng = np.random.default_rng(seed_of("filled"))
    x = rng.standard_normal((2, 50_000))
    x[1] = 0.8 * x[0] + 0.6 * x[1]
    lost = np.zeros(50_000, dtype=bool)
    lost[rng.choice(50_000, 500, replace=False)] = True
    samples, count = complete_rows(np.where(lost, np.nan, x), lost)
    assert count == 500
    assert np.cov(samples) == pytest.approx(np.cov(x), abs=0.005)  # a hundredth of the rows, with other noise


def test_misfit_is_stated_and_widens():
    """A line that no fit of a channel can find, because it is in the correlation alone, is a misfit."""
    rng = np.random.default_rng(seed_of("misfit"))
    n = 40_000
    spectrum = np.fft.rfft(rng.standard_normal((2, n)), axis=1)
    half = spectrum.shape[1] // 2
    spectrum[1, half:] = 0.8 * spectrum[0, half:] + 0.6 * spectrum[1, half:]  # correlated in the upper half of the band
    x = 1e-3 * np.fft.irfft(spectrum, n, axis=1)
    result = array(x)
    assert result.goodness.is_misfit
    assert result.goodness.widening > 2
    assert "the model does not fit" in repr(result)
    assert not result.virtual.model["gyro_virtual"].adequate


def test_weights_that_are_determined_too_weakly():
    """A slow noise that is just visible has no weights; the rest of the analysis stands."""
    n = 6000
    x = noise("weak", 5, n=n)
    x += 1e-5 * np.cumsum(np.random.default_rng(seed_of("weak walk")).standard_normal((5, n)), axis=1)
    result = array(x, target="rate_random_walk")
    assert result.virtual is None
    assert "too weakly for weights" in result.no_weights
    assert "no virtual sensor: the record determines" in repr(result)
    assert result.coefficients["random_walk"]["gyro_0"].observed
    with pytest.raises(st.DataError, match="there is no virtual sensor"):
        _ = result.fused_record


def pair_of_logs(folder, *, start, shift=0, late=0.0):
    """Two logs of one clock with correlated noise; the second begins `shift` samples later, with stamps `late` [s]."""
    x = noise("pair of logs", 2, n=8000)
    x[1] = 0.9 * x[0] + 0.4 * x[1]
    records = []
    for k, first in enumerate((0, shift)):
        path = folder / f"sensor{k}.csv"
        time = start + k * late + np.arange(first, 8000) / 50
        np.savetxt(
            path, np.c_[time, x[k, first:]], delimiter=",", header="t [s],gyro_x [rad/s]", comments="", fmt="%.9f"
        )
        records.append(st.read(path))
    return records


@pytest.mark.parametrize("start", [0.0, 1.7e9])
@pytest.mark.parametrize("shift", [0, 3, 100])
def test_logs_that_start_at_different_samples(tmp_path, start, shift):
    """Stamps that count from 1970 lose their whole seconds when they are read; logs are still aligned."""
    result = st.analyze_array(pair_of_logs(tmp_path, start=start, shift=shift))
    assert result.samples == 8000 - shift
    correlation = result.correlations["random_walk"]["gyro_x_1", "gyro_x_2"]
    assert correlation.value == pytest.approx(0.9 / np.hypot(0.9, 0.4), abs=0.01)


def test_logs_that_are_half_a_sample_apart(tmp_path):
    with pytest.raises(st.DataError, match=r"not synchronous: they are 0\.50 samples apart"):
        st.analyze_array(pair_of_logs(tmp_path, start=0.0, late=0.01))
