"""Noise models: from a file, a fit or by hand; what they predict, and records simulated from them."""

from sigmatau.model.arma import Arma, arma
from sigmatau.model.channel import ChannelModel
from sigmatau.model.file import value_in_si
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.predict import predict
from sigmatau.model.prediction import PredictedError, Prediction
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid
from sigmatau.model.simulation import Imperfections, Outage, Simulated, Temperature, WarmUp, simulate, simulate_to
from sigmatau.model.state_space import StateSpace, state_space
from sigmatau.model.transform import avar_from_psd
from sigmatau.model.verify import Verification, Verifications

__all__ = [
    "Arma",
    "ChannelModel",
    "GaussMarkov",
    "Imperfections",
    "LowPass",
    "NoiseModel",
    "Outage",
    "PredictedError",
    "Prediction",
    "Simulated",
    "Sinusoid",
    "StateSpace",
    "Temperature",
    "Verification",
    "Verifications",
    "WarmUp",
    "arma",
    "avar_from_psd",
    "predict",
    "simulate",
    "simulate_to",
    "state_space",
    "value_in_si",
]
