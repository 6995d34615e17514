"""Intervals of clicked figures, with the default of the page for the clicking error: a pixel of the screen."""

import json
import math

import numpy as np
import pytest

pytest.importorskip("matplotlib")
pytest.importorskip("starlette")

from clicked_figures import ENDS, LIMITS, covered, truths

import sigmatau as st
from drawn_curves import DEGREES_PER_HOUR, TRUTH, deviation
from known import seed_of
from sigmatau.app.clicking import clicked_curves

LEVEL = 0.95
STAGE = 900  # width of the picture on screen [pixels]
SHARPNESS = 0.5  # smallest default [pixels]
LEVELLED = 1.25  # of the default of a picture that was turned


def places(tau, deg_per_h, width, turn):
    """Places in a picture whose axes take 80 % of its width and height, turned by an angle."""
    height = 0.75 * width
    shares = [
        np.log(np.divide(value, low)) / math.log(high / low)
        for value, (low, high) in ((tau, LIMITS["xlim"]), (deg_per_h, LIMITS["ylim"]))
    ]
    x, y = width * (0.8 * shares[0] - 0.4), height * (0.4 - 0.8 * shares[1])
    c, s = math.cos(turn), math.sin(turn)
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def fitted(case, *, turn=0.0, record=False):
    """Whether the intervals of a clicked figure have the true values, by coefficient."""
    rng = np.random.default_rng(seed_of(case))
    width, options = rng.uniform(350, 2000), {}
    if record:
        model = st.NoiseModel(channels={"gyro_x": TRUTH})
        curve = st.allan(st.simulate(model, duration=3000, rate=20, rng=seed_of(f"{case} record")))["gyro_x"]
        tau, adev, options = curve.tau[:-2], curve.adev[:-2], {"rate": 20, "hours": 3000 / 3600}
    else:
        tau = np.geomspace(0.01, 2900, rng.integers(12, 50))
        adev = deviation(tau)
    zoom = min(STAGE / width, 3)
    turn = turn and rng.uniform(-turn, turn)

    def clicked(tau, deg_per_h):
        place = places(tau, deg_per_h, width, turn)
        return place + rng.standard_normal(place.shape) / zoom

    points = clicked(tau, DEGREES_PER_HOUR * adev)
    corners = {"x1": (0.01, 1), "x2": (1e4, 1), "y1": (0.01, 1), "y2": (0.01, 1e3)}
    ticks = {key: clicked(*corner) for key, corner in corners.items()}
    error = max(SHARPNESS, 1 / zoom)
    if turn:
        # As `levelTurn` of the page: the ticks of each axis are made level and upright.
        (a, b), (c, d) = ticks["x2"] - ticks["x1"], ticks["y2"] - ticks["y1"]
        weights = np.array([a * a + b * b, c * c + d * d])
        level = -weights @ [math.atan2(b, a), math.atan2(c, -d)] / weights.sum()
        matrix = np.array([[math.cos(level), math.sin(level)], [-math.sin(level), math.cos(level)]])
        points, ticks, error = points @ matrix, {key: place @ matrix for key, place in ticks.items()}, LEVELLED * error
    body = {
        "curves": [{"name": "", "points": points.tolist()}],
        "x_axis": [[ticks[key][0], ENDS[key]] for key in ("x1", "x2")],
        "y_axis": [[ticks[key][1], ENDS[key]] for key in ("y1", "y2")],
        "unit": "deg/h",
        "point_error": float(f"{error:.2g}"),
        **options,
    }
    (channel,) = json.loads(clicked_curves(clicks=body, progress=lambda stage: None))["channels"]
    return covered(channel["table"]["rows"]), channel["off"]


def share(name, runs, **options):
    """Share of the figures whose intervals have the true value, by coefficient, and share of the figures with a mark."""
    results = [fitted(f"{name} {k}", **options) for k in range(runs)]
    usable = [each for each, _ in results if each]
    counts = {label: sum(each[label] for each in usable) / runs for label in truths()}
    return counts, sum(bool(off) for _, off in results) / runs


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "options"), [("clicked page", {}), ("clicked record", {"record": True}), ("clicked photo", {"turn": 0.05})]
)
def test_intervals_of_clicked_figures_hold(name, options):
    """Without a stated length the intervals are those of the shortest possible record, which are too wide."""
    runs = 200
    shares, marked = share(name, runs, **options)
    margin = 3 * math.sqrt(LEVEL * (1 - LEVEL) / runs)
    assert min(shares.values()) > LEVEL - margin, shares
    assert marked < 0.05
