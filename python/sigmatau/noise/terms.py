"""The table of noise terms: names, slopes, read-off points, units and expected variances.

The names are those of the field (IEEE Std 952, 1293). The letters are not public, because the paper's Q for the random
walk is the N of the standards. The formulas are in the Rust core.

References
----------
.. [1] N. El-Sheimy, H. Hou, X. Niu, "Analysis and modeling of inertial sensors using Allan variance,"
   IEEE Trans. Instrum. Meas., vol. 57, no. 1, 2008, :doi:`10.1109/TIM.2007.908635`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native import kernels
from sigmatau._native.arguments import whole_sizes
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.noise.shown import SHOWN, ShownUnit, asked_unit, check_units, prefixed_unit, shown_unit
from sigmatau.units import find

BIAS_LEVEL = math.sqrt(2 * math.log(2) / math.pi)
"""Height of the flicker plateau over the bias instability, √(2 ln 2/π) = 0.664 (eq. 19 for T much longer than 1/f₀)."""


@frozen
class Term:
    """One noise term.

    Attributes
    ----------
    name : str
        Key in results and model files.
    symbols : tuple of str
        The letters in IEEE Std 952 and in the paper.
    slope : float
        Slope of its σ(τ) in a log-log plot. [1]
    read_at : float or None
        The τ at which a line of that slope equals the coefficient; None for the plateau. [s]
    level : float
        σ(read_at) over the coefficient. [1]
    labels : mapping
        Names for a gyro, an accelerometer and any other signal.
    short_name : str
        Short name for narrow tables.
    times : str
        Suffix of its unit, after the unit of the rate: ``"*sqrt(s)"``.
    si_units : mapping
        SI unit of its coefficient on a gyro and an accelerometer.
    usual_units : mapping
        Units in which it is printed for a gyro and an accelerometer, the most common first.
    synonyms : str
        Other names, from the glossary, in lower case and separated by commas.
    look_alikes : str
        Other processes with the same slope, which an Allan variance cannot distinguish; empty if there are none.
    is_noise : bool
        False for the ramp, which is the same in each record.
    has_system : bool
        Whether linear systems can represent it: state spaces, ARMA processes, and the true noise for which
        a filter is judged. They refuse a model with any other term.
    """

    name: str
    symbols: tuple[str, str]
    slope: float
    read_at: float | None
    level: float
    labels: Mapping[str, str]
    short_name: str
    times: str
    si_units: Mapping[str, str]
    usual_units: Mapping[str, tuple[str, ...]]
    synonyms: str
    look_alikes: str = ""
    is_noise: bool = True
    has_system: bool = False

    @property
    def interval_power(self) -> int:
        """The p of coefficient² ∝ τ₀^(2 − p), for the same samples at another interval τ₀: twice the slope, plus 2."""
        return round(2 * self.slope + 2)

    def deviation(self, tau: ArrayLike) -> NDArray[np.float64]:
        """Value of its line: σ(τ) for the coefficient 1 at averaging times much longer than the sample interval.

        Parameters
        ----------
        tau : array_like, shape (n_tau,)
            Averaging times. [s]

        Returns
        -------
        ndarray, shape (n_tau,)
            [unit of the rate over that of the coefficient]
        """
        return self.level * (np.asarray(tau, dtype=float) / (self.read_at or 1.0)) ** self.slope

    def label(self, quantity: str) -> str:
        """Name on this kind of sensor, e.g. ``"angle random walk"``.

        Parameters
        ----------
        quantity : str
            ``"angular_rate"``, ``"acceleration"`` or ``"signal"``.

        Returns
        -------
        str
        """
        return self.labels.get(quantity, self.labels["signal"])


TERMS: Mapping[str, Term] = {
    term.name: term
    for term in (
        Term(
            name="quantization",
            symbols=("Q", "Qz"),
            slope=-1.0,
            read_at=math.sqrt(3),
            level=1.0,
            labels={"signal": "quantization"},
            short_name="quantization",
            times="*s",
            si_units={"angular_rate": "rad", "acceleration": "m/s"},
            usual_units={"angular_rate": ("arcsec",), "acceleration": ("m/s",)},
            synonyms="quantisation, quantization noise, angle white noise, white phase noise",
            look_alikes="flicker or white noise of the angle (velocity) itself",
            has_system=True,
        ),
        Term(
            name="random_walk",
            symbols=("N", "Q"),
            slope=-0.5,
            read_at=1.0,
            level=1.0,
            labels={
                "angular_rate": "angle random walk",
                "acceleration": "velocity random walk",
                "signal": "random walk",
            },
            short_name="random walk",
            times="*sqrt(s)",
            si_units={"angular_rate": "rad/sqrt(s)", "acceleration": "m/s/sqrt(s)"},
            usual_units={"angular_rate": ("deg/sqrt(h)",), "acceleration": ("m/s/sqrt(h)",)},
            synonyms=(
                "n, arw, vrw, angle random walk, angular random walk, velocity random walk, white, white noise,"
                " noise density, rate noise density, acceleration noise density, noise spectral density, nsd,"
                " gyroscope noise density, accelerometer noise density, white frequency noise"
            ),
            has_system=True,
        ),
        Term(
            name="bias_instability",
            symbols=("B", "B"),
            slope=0.0,
            read_at=None,
            level=BIAS_LEVEL,
            labels={"signal": "bias instability"},
            short_name="bias instab.",
            times="",
            si_units={"angular_rate": "rad/s", "acceleration": "m/s^2"},
            usual_units={"angular_rate": ("deg/h",), "acceleration": ("m/s/h", "ug")},
            synonyms=(
                "b, bi, bias stability, in run bias stability, in run bias instability, flicker, flicker noise, 1/f noise,"
                " pink noise, flicker frequency noise, allan deviation floor"
            ),
            look_alikes="a valley between a random walk and a rate random walk, or a Gauss-Markov hump",
            has_system=True,
        ),
        Term(
            name="rate_random_walk",
            symbols=("K", "K"),
            slope=0.5,
            read_at=3.0,
            level=1.0,
            labels={"acceleration": "acceleration random walk", "signal": "rate random walk"},
            short_name="rate walk",
            times="/sqrt(s)",
            si_units={"angular_rate": "rad/s/sqrt(s)", "acceleration": "m/s^2/sqrt(s)"},
            usual_units={"angular_rate": ("deg/h/sqrt(h)",), "acceleration": ("m/s/h^(3/2)",)},
            synonyms=(
                "k, rrw, acceleration random walk, bias random walk, random walk frequency noise, gyroscope random walk,"
                " accelerometer random walk"
            ),
            look_alikes="a Gauss-Markov process with a long correlation time",
            has_system=True,
        ),
        Term(
            name="rate_ramp",
            symbols=("R", "R"),
            slope=1.0,
            read_at=math.sqrt(2),
            level=1.0,
            labels={"acceleration": "acceleration ramp", "signal": "rate ramp"},
            short_name="ramp",
            times="/s",
            si_units={"angular_rate": "rad/s^2", "acceleration": "m/s^3"},
            usual_units={"angular_rate": ("deg/h^2",), "acceleration": ("m/s/h^2",)},
            synonyms="r, ramp, acceleration ramp, linear drift, drift rate ramp, frequency drift",
            look_alikes="flicker acceleration noise (PSD ~ 1/f³), or a slow change of temperature",
            is_noise=False,
            has_system=True,
        ),
    )
}
"""The noise terms by their key in results and model files, in the order of their slopes."""

NOISE = tuple(name for name, term in TERMS.items() if term.is_noise)
"""Terms in whose squared coefficients the Allan variance is linear: all but the ramp."""
SLOW = tuple(name for name, term in TERMS.items() if term.slope >= 0)
"""Terms whose deviation does not decrease with the averaging time."""
RANKED = tuple(sorted(TERMS, key=lambda name: (abs(TERMS[name].slope) > 1 / 2, TERMS[name].slope)))
"""The terms by importance for users; the steep ones last."""
# quantities whose coefficients have listed units; those of other signals consist of the unit of the signal and of s
_INERTIAL = ("angular_rate", "acceleration")


def refuse_without_system(terms: Iterable[str]) -> None:
    """Raise `DataError` for a term that linear systems cannot represent: without the term, they would have too little
    noise.
    """
    lacking = [name for name in terms if not TERMS[name].has_system]
    if lacking:
        raise DataError(f"no linear system has the noise of {' and '.join(lacking)}; leave it out of the model")


def coefficient_unit(term: str, quantity: str, unit: str) -> str:
    """SI unit of a coefficient: ``"rad/sqrt(s)"`` for the random walk of a gyro.

    For a signal in any other unit U: U*s, U*sqrt(s), U, U/sqrt(s), U/s.
    """
    if quantity in _INERTIAL:
        return TERMS[term].si_units[quantity]
    times = TERMS[term].times
    if unit == "1":
        return times[1:] if times.startswith("*") else f"1{times}"
    return f"({unit}){times}" if "/" in unit and times.startswith("*") else f"{unit}{times}"


def coefficient_units(quantity: str, unit: str) -> dict[str, str]:
    """SI units of the coefficients of all terms, see `coefficient_unit`."""
    return {term: coefficient_unit(term, quantity, unit) for term in TERMS}


def display_units(
    term: str, quantity: str, unit: str, values: Iterable[float | None] = ()
) -> tuple[tuple[str, float], ...]:
    """Usual units of a coefficient: ``(text, one such unit in SI)``, the most common first; or that of `show_in`.

    The unit of another signal has the prefix that the `values` need, which are printed in this unit.
    """
    if SHOWN.get() and (asked := asked_unit(*_asked_for(term, quantity, unit))) is not None:
        return (asked,)
    if quantity in _INERTIAL:
        units = (find(symbol) for symbol in TERMS[term].usual_units[quantity])
        return tuple((u.text, u.factor) for u in units)
    if (prefixed := prefixed_unit(unit, TERMS[term].times, values)) is not None:
        return ((prefixed.text, prefixed.factor),)
    return ((coefficient_unit(term, quantity, unit).replace("sqrt(s)", "√s").replace("*", "·"), 1.0),)


def asked_rate_unit(quantity: str, unit: str, values: Iterable[float | None] = ()) -> tuple[str, float] | None:
    """The unit of `show_in` for deviations of rates or of their integrals, and its size in `unit`; None without one.

    The unit of another signal has the prefix that the `values` need, see `display_units`.
    """
    if quantity in _INERTIAL:
        return asked_unit(unit, unit, None)
    rate_unit, _, is_integral = unit.partition("·")
    tail = "*s" if is_integral == "s" else ""
    shown = shown_unit(unit, rate_unit, tail) or prefixed_unit(rate_unit, tail, values)
    return None if shown is None else (shown.text, shown.factor)


def asked_density(quantity: str, unit: str, values: Iterable[float | None] = ()) -> ShownUnit | None:
    """The unit of `show_in` for the root of a density, which is that of the random walk; None without one.

    The unit of another signal has the prefix that the `values` need, see `display_units`.
    """
    si, rate_unit, tail = _asked_for("random_walk", quantity, unit)
    asked = shown_unit(si, rate_unit, tail)
    return asked if asked is not None or tail is None else prefixed_unit(rate_unit, tail, values)


def _asked_for(term: str, quantity: str, unit: str) -> tuple[str, str, str | None]:
    """Arguments of `asked_unit` for a coefficient: its SI unit, the unit of the channel, and the suffix after the unit
    of a signal.
    """
    return coefficient_unit(term, quantity, unit), unit, None if quantity in _INERTIAL else TERMS[term].times


def check_shown(channels: Mapping[str, tuple[str, str]], terms: Iterable[str] = tuple(TERMS)) -> None:
    """Refuse a unit of `show_in` that fits no coefficient of some channels.

    Parameters
    ----------
    channels : mapping of str to (str, str)
        Quantity and unit by channel.
    terms : iterable of str
        Coefficients that are printed; the unit of deviations is that of bias instability. Default: all.

    Raises
    ------
    OptionError
        Names the unit, and units that fit.
    """
    names = tuple(terms)
    check_units(
        {
            channel: [_asked_for(term, quantity, unit) for term in names]
            for channel, (quantity, unit) in channels.items()
        }
    )


def avar(
    term: str,
    coefficient: float,
    *,
    m: ArrayLike,
    tau0: float,
    cutoff: float | None = None,
    averaged: bool = False,
) -> NDArray[np.float64]:
    """Expected Allan variance of one term, exact for sampled data.

    Parameters
    ----------
    term : str
        A key of `TERMS`.
    coefficient : float
        Coefficient in SI; see `coefficient_unit`.
    m : array_like of int, shape (n_tau,)
        Cluster sizes in samples.
    tau0 : float
        Sample interval. [s]
    cutoff : float, optional
        Bias instability only: the cut-off f₀ of eq. (18), for the continuous-time form, eq. (19). Default: the exact
        variance of discrete flicker noise, which only sampling cuts off. [Hz]
    averaged : bool
        Rate random walk only: a continuous walk averaged over each sample, K²τ/3 for every m (eq. 21). Default: the walk
        sampled at the samples' times, K²τ₀(2m²+1)/(6m), which tends to eq. (21).

    Returns
    -------
    ndarray, shape (n_tau,)
        Variance. [unit of the rate, squared]

    Raises
    ------
    ValueError
        For an unknown term, a size below 1, a tau0 or cut-off that is not positive.

    See Also
    --------
    psd : the density of the same term.

    References
    ----------
    Eqs. (15), (17), (19), (21) and (23) of [1]_; for flicker N. J. Kasdin, Proc. IEEE 83 (1995),
    :doi:`10.1109/5.381848`.

    .. [1] :doi:`10.1109/TIM.2007.908635`

    Examples
    --------
    >>> avar("random_walk", 1e-4, m=[1, 100], tau0=0.01)
    array([1.e-06, 1.e-08])
    """
    sizes = whole_sizes(m)
    if term not in TERMS:
        raise ValueError(f"unknown term {term!r}; terms: {', '.join(TERMS)}")
    if not (math.isfinite(tau0) and tau0 > 0):
        raise ValueError(f"`tau0` must be a positive number of seconds, not {tau0!r}")
    if cutoff is not None and not (math.isfinite(cutoff) and cutoff > 0):
        raise ValueError(f"`cutoff` must be a positive number of hertz, not {cutoff!r}")
    if not math.isfinite(coefficient):
        raise ValueError(f"the coefficient must be a finite number, not {coefficient!r}")
    if sizes.size and sizes.min() < 1:
        raise ValueError(f"`m` must be at least 1 sample, got {sizes.min()}")
    return kernels.term_avar(term, float(coefficient), sizes, float(tau0), cutoff=cutoff, averaged=averaged)


def psd(term: str, coefficient: float, f: ArrayLike, *, tau0: float | None = None) -> NDArray[np.float64]:
    """Two-sided power spectral density of one term's rate.

    Parameters
    ----------
    term : str
        A key of `TERMS`.
    coefficient : float
        Coefficient in SI; see `coefficient_unit`.
    f : array_like, shape (n_f,)
        Frequencies, positive. [Hz]
    tau0 : float, optional
        Sample interval: gives the exact spectrum of the sampled process, below 1/(2·tau0). Required for quantization
        noise, whose density depends on it. Default: the continuous forms of the paper. [s]

    Returns
    -------
    ndarray, shape (n_f,)
        [(unit of the rate)²/Hz, two-sided]

    Raises
    ------
    ValueError
        For an unknown term, or quantization without `tau0`.

    See Also
    --------
    avar : the Allan variance of the same term.

    Notes
    -----
    A ramp is deterministic and has no PSD. Eq. (24) is a conventional substitute for drawing; its Allan variance by eq.
    (11) diverges and is not eq. (23).

    References
    ----------
    Eqs. (14), (16), (18), (20) and (24) of [1]_.

    .. [1] :doi:`10.1109/TIM.2007.908635`

    Examples
    --------
    >>> psd("rate_random_walk", 1e-6, [0.1])
    array([2.53302959e-12])
    """
    if term not in TERMS:
        raise ValueError(f"unknown term {term!r}; terms: {', '.join(TERMS)}")
    return kernels.term_psd(term, float(coefficient), np.atleast_1d(np.asarray(f, dtype=float)), tau0)


def aliasing_inflation(*, rate: float, bandwidth: float, order: int = 1) -> float:
    """Factor by which sampling without an anti-alias filter increases the random walk of a sensor.

    A Butterworth filter with this bandwidth limits the white noise of the sensor. Sampling folds the noise that the
    filter passes at multiples of the sampling rate onto low frequencies.

    Parameters
    ----------
    rate : float
        Sampling rate. [Hz]
    bandwidth : float
        Frequency of -3 dB. [Hz]
    order : int
        1 (an RC filter) … 9.

    Returns
    -------
    float
        N_eff/N, 1 or more.

    Raises
    ------
    ValueError
        For a rate or bandwidth that is not positive, an order outside 1 … 9.

    Notes
    -----
    N_eff²/N² = Σ_k |H(k·rate)|² = Re Σ_j a_j·coth(a_j)/order, with a_j = -p_j/(2·rate) over its poles p_j;
    for order 1 it is x·coth(x), with x = π·bandwidth/rate. See :doc:`/study/bandwidth` for Fig. 12 of [1]_.

    References
    ----------
    .. [1] :doi:`10.1109/TIM.2007.908635`

    Examples
    --------
    >>> round(aliasing_inflation(rate=100, bandwidth=30), 3)
    1.131
    """
    for name, value in (("rate", rate), ("bandwidth", bandwidth)):
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"`{name}` must be a positive number of hertz, not {value!r}")
    if order not in range(1, 10):
        raise ValueError(f"`order` must be 1 to 9, not {order!r}")
    x = math.pi * bandwidth / rate
    # Half a sample interval times the poles, from the residues −p_j/(2n) of |H|².
    angles = np.pi * (2 * np.arange(order) + order + 1) / (2 * order)
    a = -x * np.exp(1j * angles)
    decay = np.exp(-2 * a)
    return math.sqrt(float((a / order * (1 + decay) / (1 - decay)).real.sum()))
