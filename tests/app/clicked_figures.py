"""Pictures of figures with known axes, and clicks on them."""

import io

import numpy as np
from PIL import Image

from drawn_curves import DEGREES_PER_HOUR, TRUTH, deviation, figure, times

UNITS = {"random_walk": DEGREES_PER_HOUR / 60, "bias_instability": DEGREES_PER_HOUR, "rate_random_walk": 1.0}
LIMITS = {"xlim": (0.01, 1e4), "ylim": (1, 1e3)}  # ends of the axes, which have labels
ENDS = {"x1": 0.01, "x2": 1e4, "y1": 1.0, "y2": 1e3}


class Picture:
    """A picture of 640 by 480 pixels with the curve of `TRUTH`, as a file, and places in it."""

    def __init__(self, path, *, turn=0.0, tau=None, adev=None, size=(640, 480), **settings):
        tau = times() if tau is None else tau
        adev = deviation(tau) if adev is None else adev
        drawing, axes = figure(size=(6.4, 4.8))
        axes.plot(tau, DEGREES_PER_HOUR * adev)
        axes.set(**LIMITS)
        drawing.canvas.draw()
        self.path, self.turn, self.size = path, np.radians(turn), size
        self._transform = axes.transData
        self.tau, self.adev = tau, adev
        if path.suffix in (".svg", ".pdf"):
            drawing.savefig(path)
            return
        data = io.BytesIO()
        drawing.savefig(data, dpi=100)
        image = Image.open(data).convert("RGB").resize(size)
        image.rotate(-turn, fillcolor="white", resample=Image.Resampling.BICUBIC).save(path, **settings)

    def place(self, tau, deg_per_h):
        """Place of a point of the figure. [pixels]"""
        width, height = self.size
        x, y = self._transform.transform((tau, deg_per_h))
        dx, dy = x * width / 640 - width / 2, height / 2 - y * height / 480
        c, s = np.cos(self.turn), np.sin(self.turn)
        return width / 2 + c * dx - s * dy, height / 2 + s * dx + c * dy

    def ticks(self):
        """Places of the ends of the axes by the name of the tick."""
        x, y = LIMITS["xlim"], LIMITS["ylim"]
        corners = {"x1": (x[0], y[0]), "x2": (x[1], y[0]), "y1": (x[0], y[0]), "y2": (x[0], y[1])}
        return {key: self.place(*corner) for key, corner in corners.items()}

    def points(self, count=24):
        """Places along the curve."""
        tau = np.geomspace(self.tau[0], self.tau[-1], count)
        value = np.exp(np.interp(np.log(tau), np.log(self.tau), np.log(self.adev)))
        return [self.place(*point) for point in zip(tau, DEGREES_PER_HOUR * value, strict=True)]


def request(picture, *, error=1.0, rng=None, count=24, **changes):
    """A request for the curve of a picture without turn, with errors of all clicks."""
    noise = np.zeros(2) if rng is None else error

    def clicked(place):
        return np.asarray(place) + (0 if rng is None else noise * rng.standard_normal(2))

    ticks = {key: clicked(place) for key, place in picture.ticks().items()}
    return {
        "curves": [{"name": "", "points": [clicked(place).tolist() for place in picture.points(count)]}],
        "x_axis": [[ticks[key][0], str(ENDS[key])] for key in ("x1", "x2")],
        "y_axis": [[ticks[key][1], str(ENDS[key])] for key in ("y1", "y2")],
        "linear": None,
        "unit": "deg/h",
        "content": "deviation",
        "point_error": error,
        "rate": None,
        "hours": None,
    } | changes


def truths():
    """The coefficients of `TRUTH` in deg/√h, deg/h and deg/h/√h."""
    return {
        "angle random walk": np.degrees(TRUTH["random_walk"]) * 60,
        "bias instability": np.degrees(TRUTH["bias_instability"]) * 3600,
        "rate random walk": np.degrees(TRUTH["rate_random_walk"]) * 3600 * 60,
    }


def covered(rows):
    """Whether each interval or limit of a table of coefficients has the true value, by label."""
    result = {}
    for label, value, interval, _ in rows:
        if label in truths():
            bounds = (np.nan, np.nan)  # a value without an interval
            if interval.startswith("["):
                bounds = tuple(map(float, interval.strip("[]").split(", ")))
            elif value.startswith("below "):
                bounds = (0.0, float(value.split()[-1]))
            result[label] = bool(bounds[0] <= truths()[label] <= bounds[1])
    return result
