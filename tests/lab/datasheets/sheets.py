"""Datasheets, units and verdicts in one line each, for their tests."""

import math

from sigmatau import NoiseModel, compare_with
from sigmatau.lab.datasheets.sheet import Datasheet
from sigmatau.model.channel import ChannelModel

N = 0.005
Z95 = 1.6448536269514722


def sheet(sensor="gyro", **claims):
    return Datasheet.from_dict({"name": "N", "maker": "M", "source": "S", sensor: claims})


def walk(maximum=None, typical=None):
    values = {"maximum": maximum, "typical": typical}
    return {key: f"{value!r} rad/sqrt(s)" for key, value in values.items() if value is not None}


def channel(value=N, error=0.1, term="random_walk", **more):
    """A coefficient with the interval of a relative error of `error`, in logarithms."""
    reach = math.exp(1.959963984540054 * error)
    return ChannelModel(terms={term: value}, intervals={term: (value / reach, value * reach)}, level=0.95, **more)


def judge(model, claims, **options):
    verdict = compare_with(NoiseModel(channels={"gyro_x": model}), sheet(**claims), **options)
    (judged,) = verdict.judged
    return judged
