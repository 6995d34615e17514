"""Turn-on bias of a unit, from a comparison of its runs."""

from __future__ import annotations

from sigmatau import TurnOn
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.lots.comparison import RunComparison
from sigmatau.lab.lots.runs import MEAN


def measure_turn_on(comparison: RunComparison, *, unit: str | None = None) -> dict[str, TurnOn]:
    """Spread of the mean of each channel between the runs of a unit: its turn-on bias, if each run follows a power-up.

    The interval is that of a standard deviation of k independent normal values, by χ² with k - 1 degrees of freedom. The
    spread includes the drift of the bias within a run and, for an accelerometer, changes of its tilt.

    Parameters
    ----------
    comparison : RunComparison
        Comparison of the runs of each unit, ``by="unit"``.
    unit : str, optional
        Serial number of the unit. Default: the only one.

    Returns
    -------
    dict of str to TurnOn
        By channel.

    Raises
    ------
    OptionError
        If the runs are not grouped by unit, or the unit is missing or unknown.
    DataError
        If no channel has the means of two runs.

    See Also
    --------
    NoiseModel.with_turn_on : adds it to a model.
    random_effects : the estimate and its interval.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> days = []
    >>> for day, bias in enumerate([0.010, 0.012, 0.009]):
    ...     powered = st.Imperfections(level={"gyro_x": bias})
    ...     days.append(st.analyze(st.simulate(model, duration=600, rate=10, rng=day, imperfections=powered)))
    >>> spread = st.measure_turn_on(st.compare_runs(days))["gyro_x"]
    >>> f"{spread.sigma:.4f} rad/s, at most {spread.high:.4f}, from {spread.power_ups} power-ups"
    '0.0015 rad/s, at most 0.0096, from 3 power-ups'
    """
    if comparison.by != "unit":
        raise OptionError(
            f"a turn-on bias is that of the runs of a unit: {{option}} must be unit, not {comparison.by}", option="by"
        )
    chosen = comparison.groups[0] if unit is None and len(comparison.groups) == 1 else unit
    if chosen not in comparison.groups:
        listed = ", ".join(comparison.groups)
        asked = "choose {option}" if unit is None else f"there is no {unit!r}"
        raise OptionError(f"a turn-on bias is that of one unit, {asked}; units: {listed}", option="unit")
    spreads = {}
    for row, (group, channel, term) in enumerate(comparison):
        if group != chosen or term != MEAN:
            continue
        effects = comparison.row(row)
        if effects.tau is not None and effects.tau_high:
            spreads[channel] = TurnOn(
                sigma=effects.tau,
                low=effects.tau_low,
                high=effects.tau_high,
                level=comparison.level,
                power_ups=effects.k,
            )
    if not spreads:
        raise DataError("a turn-on bias needs the means of a channel in two runs of a unit")
    return spreads
