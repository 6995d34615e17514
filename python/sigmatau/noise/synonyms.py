"""Other names of the noise terms, for the errors about names that are no terms: those of docs/glossary.md."""

from __future__ import annotations

from collections.abc import Iterable

from sigmatau.noise.terms import TERMS

_OTHER_NAMES = {
    "quantization": "quantisation, quantization noise, angle white noise, white phase noise",
    "random_walk": (
        "n, arw, vrw, angle random walk, angular random walk, velocity random walk, white, white noise, noise density,"
        " rate noise density, acceleration noise density, noise spectral density, nsd, gyroscope noise density,"
        " accelerometer noise density, white frequency noise"
    ),
    "bias_instability": (
        "b, bi, bias stability, in run bias stability, in run bias instability, flicker, flicker noise, 1/f noise,"
        " pink noise, flicker frequency noise, allan deviation floor"
    ),
    "rate_random_walk": (
        "k, rrw, acceleration random walk, bias random walk, random walk frequency noise, gyroscope random walk,"
        " accelerometer random walk"
    ),
    "rate_ramp": "r, ramp, acceleration ramp, linear drift, drift rate ramp, frequency drift",
}
_MEANT = {name: term for term, names in _OTHER_NAMES.items() for name in names.split(", ")}
_MEANT["q"] = "quantization (IEEE 952) or random_walk (the paper)"


def unknown_term(name: object, terms: Iterable[str] = TERMS) -> str:
    """What to say of a name that is no term: the term that it means, or those that are known."""
    meant = _MEANT.get(str(name).lower().replace("_", " ").replace("-", " "))
    return f"unknown term {name!r}; " + (f"it is {meant} here" if meant else f"terms: {', '.join(terms)}")
