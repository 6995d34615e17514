"""Records simulated in memory."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.unobserved import Unobserved, unobserved_texts
from sigmatau.record.record import Provenance, Record, make_stream, stream_name
from sigmatau.record.sampling import RateSource
from sigmatau.record.streams import CHUNK, InputKind, Stream
from sigmatau.record.thermometers import CELSIUS
from sigmatau.simulation.imperfections import Imperfections
from sigmatau.simulation.rows import Channel, Flicker, SimulationJob, Stamps, job


def simulate(
    model: NoiseModel,
    *,
    duration: float,
    rate: float,
    rng: int | np.random.Generator,
    imperfections: Imperfections | None = None,
    flicker: Flicker = "exact",
    unobserved: Unobserved = "absent",
) -> Record:
    """A record with the model's noise, by exact generators.

    Every term is the sampled process whose Allan variance `NoiseModel.avar` returns: quantization as differences of
    white phase, the random walk as white noise (with a bandwidth, as sampled states of its filter), bias instability
    as discrete flicker noise by circulant embedding of its first differences (Davies and Harte), the rate random walk
    as a sampled walk, the ramp as a line, Gauss-Markov processes as stationary recursions, sinusoids with a random
    phase.

    Parameters
    ----------
    model : NoiseModel
        Noise of the channels.
    duration : float
        Length of the record. [s]
    rate : float
        Sampling rate. [Hz]
    rng : int or numpy.random.Generator
        Seed, or a generator from which a seed is drawn. The same seed gives the same record. The noise of a channel does not
        depend on other channels and terms of the model, except on correlated channels.
    imperfections : Imperfections, optional
        Imperfections of a real log. Default: none.
    flicker : {"exact", "poles"}
        Generator of bias instability: exact, or the poles of `simulate_to`, which gives the same samples as that function.
    unobserved : {"absent", "mean", "upper-limit"}
        How the record includes terms that the fit of the model did not observe: not at all; with the mean of their
        variance if every coefficient up to the upper limit is equally probable; or at the limit.
        `Provenance.conversions` of the record states it.

    Returns
    -------
    Record
        Rates in SI, one stream for the gyros, one for the accelerometers, one for each other signal and the temperature;
        each channel of shape (n,), NaN where rows are lost. The record has no jitter: samples are on their grid.

    Raises
    ------
    OptionError
        For a rate or duration that is not positive, fewer than 4 samples, or imperfections that do not fit.

    See Also
    --------
    simulate_to : simulates into a file of any length.

    References
    ----------
    R. B. Davies and D. S. Harte, "Tests for Hurst effect", Biometrika 74(1), 1987, :doi:`10.1093/biomet/74.1.95`.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4, "bias_instability": 1e-5}})
    >>> st.simulate(model, duration=600, rate=100, rng=1)
    Record of 1 stream
      gyro: gyro_x [rad/s], 60000 samples at 100 Hz (600 s)
    """
    task = job(
        model,
        duration=duration,
        rate=rate,
        rng=rng,
        imperfections=imperfections,
        flicker=flicker,
        unobserved=unobserved,
    )
    wrong = task.imperfections
    present = _rows_present(task)
    by_stream: dict[str, dict[str, Floats]] = {}
    for name in model.channels:
        by_stream.setdefault(stream_name(name), {})[name] = _column(task, name, present)
    if wrong.temperature is not None:
        by_stream["temperature"] = {"temperature": _marked(wrong.temperature.shown(task.times(0, task.rows)), present)}

    def stream(name: str, columns: dict[str, Floats], unit: str, kind: InputKind) -> Stream:
        return make_stream(
            name,
            columns,
            rate=rate,
            unit={name: unit},
            kind=kind,
            grid_source=RateSource(kind="simulated"),
            jitter=wrong.jitter or None,
            finite=present is None,
        )

    streams = [
        stream(name, columns, CELSIUS, "rate")
        if name == "temperature" and wrong.temperature is not None
        else stream(name, columns, task.unit(next(iter(columns))), wrong.output)
        for name, columns in by_stream.items()
    ]
    return Record(
        streams=tuple(streams),
        provenance=Provenance(
            format="simulation",
            rows=task.rows,
            conversions=(f"simulated with seed {task.seed}", *unobserved_texts(model, unobserved)),
        ),
    )


def _rows_present(task: SimulationJob) -> NDArray[np.bool_] | None:
    """Rows that are not lost; None for all rows."""
    stamps = Stamps(task)
    pieces = [stamps.next(min(CHUNK, task.rows - start))[1] for start in range(0, task.rows, CHUNK)]
    return np.concatenate([p for p in pieces if p is not None]) if pieces[0] is not None else None


def _column(task: SimulationJob, name: str, present: NDArray[np.bool_] | None) -> Floats:
    channel = Channel(task, name)
    column = np.empty(task.rows)
    filled = 0
    for start in range(0, task.n, CHUNK):
        piece = channel.next(min(CHUNK, task.n - start))
        column[filled : filled + len(piece)] = piece
        filled += len(piece)
    return _marked(column, present)


def _marked(column: Floats, present: NDArray[np.bool_] | None) -> Floats:
    """A read-only column with NaN in lost rows."""
    if present is not None:
        column[~present] = np.nan
    column.setflags(write=False)
    return column
