"""An axis beside disturbed ones of the same sensor is not trusted; axes of another sensor are."""

import numpy as np
from studies.motions import band

import sigmatau as st
from known import seed_of

RATE, N = 100.0, 12_000


def analysed(name, sizes):
    """Two sensors of three axes; vibration of 10 to 14 Hz of a size [m/s²] on each axis of the accelerometers."""
    rng = np.random.default_rng(seed_of(name))
    gyro = np.radians(0.06) * rng.standard_normal((N, 3))
    accel = 0.01 * rng.standard_normal((N, 3)) + [0.0, 0.0, 9.80665]
    accel += np.stack([size * band(rng, N, RATE, 10, 14) for size in sizes], axis=1)
    return st.analyze(st.Record.from_arrays(rate=RATE, gyro=gyro, accel=accel), at_rest=True)


def test_an_axis_beside_disturbed_ones_is_at_best_partial():
    found = analysed("two shaken", (0.1, 0.1, 0.0))
    (finding,) = (one for one in found.findings if one.code == "other_axes_disturbed")
    assert (finding.channels, finding.details.disturbed) == (("accel_z",), ("accel_x", "accel_y"))
    assert found["accel_z"].trust == "partial"
    assert {found[f"gyro_{axis}"].trust for axis in "xyz"} == {"good"}


def test_no_axis_is_disturbed():
    found = analysed("quiet", (0.0, 0.0, 0.0))
    assert "other_axes_disturbed" not in {one.code for one in found.findings}
    assert {fitted.trust for fitted in found.fits.values()} == {"good"}
