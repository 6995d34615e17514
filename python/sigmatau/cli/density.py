"""``sigmatau density``: Allan deviations and noise model of a measured density."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter

from sigmatau._version import __version__
from sigmatau.cli.declared import InMain, InMethod, InOutput, MayBeMinus, Quiet, Show, Texts
from sigmatau.cli.options import ENDINGS, check_output, check_outputs, say, write_result
from sigmatau.digits import significant
from sigmatau.errors import DataError, OptionError
from sigmatau.fitting.density_neighbours import independent_step
from sigmatau.fitting.psd_fit import QUANTITIES, PsdFit, fit_psd
from sigmatau.io.atomic import atomic
from sigmatau.io.read.density_table import MeasuredDensity, read_density
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.psd_avar import AvarFromPsd, avar_from_psd
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import check_shown, display_units
from sigmatau.record.record import stream_name
from sigmatau.results import csv_text
from sigmatau.typed.pairs import averaging_times, key_values

_CHANNELS = {"rad/s": "gyro", "m/s^2": "accel"}
_OPTIONS = {"tau0": "rate", "tau": "taus"}


def density_command(
    table: Path,
    /,
    *,
    columns: Annotated[list[str] | None, Texts, InMain] = None,
    unit: Annotated[str | None, InMain] = None,
    sided: Annotated[Literal["one", "two"] | None, InMain] = None,
    averages: Annotated[float | None, InMain] = None,
    rate: Annotated[float | None, InMethod] = None,
    taus: Annotated[str | None, InMethod] = None,
    channel: Annotated[str | None, InOutput] = None,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"]), InMain] = None,
    csv: Annotated[Path | None, InOutput] = None,
    json: Annotated[Path | None, MayBeMinus, InMain] = None,
    show: Show = None,
    quiet: Quiet = False,
) -> int:
    """Turn a measured power spectral density into Allan deviations and a noise model.

    Parameters
    ----------
    table
        Table of frequency and density, such as CSV with a header: frequency [Hz],psd one-sided [(deg/s)^2/Hz].
    columns
        The columns by name or number: frequency=f,density=3. Default: recognised by their names.
    unit
        Unit of the density, "(deg/s)^2/Hz", or of its root: mdps/rtHz, ug/rtHz, nT/rtHz. Default: that of the header.
    sided
        Whether the density is one- or two-sided. Default: as the header states.
    averages
        Number of averaged independent spectra, for the coefficients and their intervals. Default: none; then only
        deviations are computed.
    rate
        Sampling rate in Hz, if the density is that of samples: discrete time is then exact, and quantization noise is
        fitted. Default: continuous time.
    taus
        Averaging times, in seconds or with units: 0.1,1,10min. Default: two per octave that the frequencies allow.
    channel
        Name of the channel in the model: gyro_x. Default: gyro or accel by the unit, or the name of the column.
    output
        Write the model file (.toml) for export, simulate, plan and predict.
    csv
        Write the Allan deviations as CSV in SI units.
    json
        Write the result as JSON, in SI; - writes it to standard output instead of the tables.
    quiet
        Print only errors on standard error.
    """
    set_shown(show)
    check_output(output, ENDINGS["model"], "output")
    check_outputs([table], output=output, csv=csv, json=json)
    if output is not None and averages is None:
        raise OptionError(
            "--output needs --averages, the number of averaged spectra, for the intervals", option="averages"
        )
    for option, number in (("averages", averages), ("rate", rate)):
        if number is not None and not 0 < number < float("inf"):
            raise OptionError(f"--{option} {number:g}: must be a positive number", option=option)
    times = None if taus is None else averaging_times(taus)
    if isinstance(times, str):
        raise OptionError(f"--taus {taus}: give times, e.g. 0.1,1,10min", option="taus")
    measured = read_density(
        table, columns=key_values(columns or [], "columns", "frequency=f") or None, unit=unit, sided=sided
    )
    quantity = QUANTITIES.get(measured.unit, "signal")
    name = channel or _CHANNELS.get(measured.unit) or measured.name.replace(" ", "_") or "signal"
    _check_name(name, quantity)
    printed = ["bias_instability"] if averages is None else ["bias_instability", "random_walk", "rate_random_walk"]
    check_shown({name: (quantity, measured.unit)}, printed)
    if measured.without_zero:
        say("info: the density at frequency 0 is left out", quiet=quiet)
    tau0 = None if rate is None else 1 / rate
    try:
        curve = avar_from_psd(measured.frequency, measured.density, times, sided=measured.sided, tau0=tau0)
        fit = None if averages is None else _fitted(measured, averages, tau0, quiet=quiet)
    except OptionError as error:
        raise error.named(_OPTIONS.get(error.option or "", error.option or "")) from None
    except DataError as error:
        raise error.about(str(table)) from None
    if csv is not None:
        with atomic(csv) as temporary:
            temporary.write_text(csv_text(_columns(curve)), encoding="utf-8")
    if output is not None and fit is not None:
        NoiseModel(channels={name: fit.model}).write(output)
    if fit is not None and not fit.is_adequate:
        say(f"warning: {name}: the terms do not describe this density. Leave out lines and filters", quiet=quiet)
    if fit is None:
        say("coefficients and a model file: --averages, the number of averaged spectra", quiet=quiet)
    text = "\n\n".join([_table(name, curve, measured, quantity), *([] if fit is None else [f"{name}: {fit!r}"])])
    write_result(text, _content(name, measured, curve, fit), json)
    return 0


def _check_name(name: str, quantity: str) -> None:
    """Raise `OptionError` for a channel of a sensor that does not have this unit."""
    wanted = {"gyro": "angular_rate", "accel": "acceleration"}.get(stream_name(name), "signal")
    if wanted != quantity:
        raise OptionError(
            f"--channel {name}: the unit does not fit this sensor: it is that of {quantity}", option="channel"
        )


def _fitted(measured: MeasuredDensity, averages: float, tau0: float | None, *, quiet: bool) -> PsdFit:
    """Fit the noise terms to independent densities."""
    step = independent_step(measured.density)
    if step > 1:
        which = {2: "second", 3: "third"}.get(step, f"{step}th")
        say(
            f"info: neighbouring densities are correlated, as after a window: coefficients use every {which} one",
            quiet=quiet,
        )
    return fit_psd(
        measured.frequency[::step],
        measured.density[::step],
        dof=2 * averages,
        sided=measured.sided,
        unit=measured.unit,
        tau0=tau0,
    )


def _table(name: str, curve: AvarFromPsd, measured: MeasuredDensity, quantity: str) -> str:
    middle = float(np.median(curve.adev)) if len(curve.tau) else 0.0
    text, factor = display_units("bias_instability", quantity, measured.unit, [middle])[-1]
    band = f"from {curve.f_min:.4g} to {curve.f_max:.4g} Hz"
    head = f"{name}: Allan deviation [{text}] of a {measured.sided}-sided density {band}"
    lines = [head, f"  {'τ [s]':>10}  {'σ':>11}  at most, with noise outside the band"]
    for tau, adev, limit in zip(curve.tau.tolist(), curve.adev / factor, curve.adev_at_most / factor, strict=True):
        lines.append(f"  {tau:10.4g}  {significant(adev, 4, zeros=True):>11}  {significant(limit, 4, zeros=True):>11}")
    return "\n".join([*lines, f"  outside: {curve.outside}"])


def _columns(curve: AvarFromPsd) -> dict[str, list[Any]]:
    return {"tau_s": curve.tau.tolist(), "adev": curve.adev.tolist(), "adev_at_most": curve.adev_at_most.tolist()}


def _content(name: str, measured: MeasuredDensity, curve: AvarFromPsd, fit: PsdFit | None) -> dict[str, Any]:
    content = {"sigmatau": __version__, "channel": name, "unit": measured.unit, "sided": measured.sided}
    return {**content, "allan": curve.to_dict(), "fit": None if fit is None else fit.to_dict()}
