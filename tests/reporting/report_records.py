"""Records for reports, and names that a page must show as text."""

from datetime import datetime

import numpy as np

import sigmatau as st

DATE = datetime(2026, 1, 2, 3, 4)  # noqa: DTZ001  of the page, not of an instant
NAMES = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
HOSTILE = {
    "script": "<script>document.title='run'</script>",
    "quotes": "\"'>&amp;</td>`${1}`",
    "emoji": "🛰️ é",
    "right to left": "‮evil‬ עברית",
    "ends": "]]></script><!--",
    "markup": '#import "x"; $ * _ [a] \\ @b',
}


def six_axes(hours=0.2, rate=100.0):
    model = st.NoiseModel(
        channels={name: {"random_walk": 1e-4 * (1 + k), "bias_instability": 5e-6} for k, name in enumerate(NAMES[:3])}
        | {name: {"random_walk": 1e-3, "rate_random_walk": 1e-4} for name in NAMES[3:]}
    )
    record = st.simulate(model, duration=hours * 3600, rate=rate, rng=np.random.default_rng(22))
    columns = {name: np.array(record.stream_of(name).column(name)) for name in NAMES}
    columns["gyro_x"][4321] += 1.0
    louder = slice(columns["gyro_x"].size * 3 // 4, None)
    columns["gyro_x"][louder] *= 1.3
    return st.Record.from_arrays(rate=rate, **columns)


def signals(names, n=4000):
    """White noise on channels of any name."""
    rng = np.random.default_rng(7)
    return st.Record.from_arrays(rate=50.0, **{name: rng.standard_normal(n) for name in names})
