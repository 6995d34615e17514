"""Noise models: from a file, a fit or by hand; what they predict, and records simulated from them."""

from sigmatau.model.channel import ChannelModel
from sigmatau.model.file import value_in_si
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid
from sigmatau.model.simulation import Imperfections, Outage, Simulated, Temperature, WarmUp, simulate, simulate_to

__all__ = [
    "ChannelModel",
    "GaussMarkov",
    "Imperfections",
    "LowPass",
    "NoiseModel",
    "Outage",
    "Simulated",
    "Sinusoid",
    "Temperature",
    "WarmUp",
    "simulate",
    "simulate_to",
    "value_in_si",
]
