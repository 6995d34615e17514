"""analyze(): the whole way from a record to its coefficients, walked once."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from sigmatau._version import __version__
from sigmatau.allan import Counting, Curves, Overlap, TauGrid, allan
from sigmatau.errors import DataError
from sigmatau.readoff import ReadOff, read_off
from sigmatau.record import Provenance, Record
from sigmatau.results import Finding, Printed, seconds
from sigmatau.streams import Stream
from sigmatau.terms import TERMS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Analysis", "analyze"]

SCHEMA = 1
"""Version of the JSON form; a JSON Schema of it is in sigmatau/schema."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Analysis(Printed):
    """What a record shows.

    Attributes
    ----------
    source : Provenance
    findings : tuple of Finding
        What is wrong with the record, or should be known, before a number is trusted.
    curves : Curves
        Allan deviation by channel; channels that could not be analysed are absent and have a finding.
    read_off : mapping of str to ReadOff
        Coefficients by the paper's method, by channel.
    grids : mapping of str to str
        Samples, rate and length of each channel, in words.
    """

    source: Provenance
    findings: tuple[Finding, ...]
    curves: Curves
    read_off: Mapping[str, ReadOff]
    grids: Mapping[str, str]

    def to_dict(self) -> dict[str, Any]:
        """The stable JSON form, schema 1: plain values, no NaN."""
        return {
            "schema": SCHEMA,
            "sigmatau": __version__,
            "source": self.source.to_dict(),
            "findings": [finding.to_dict() for finding in self.findings],
            "channels": {
                channel: {
                    "quantity": curve.quantity,
                    "sample_rate_hz": 1 / curve.tau0,
                    "samples": curve.n,
                    "curve": curve.to_dict(),
                    "read_off": self.read_off[channel].to_dict(),
                }
                for channel, curve in self.curves.items()
            },
        }

    def plot(self) -> Figure:
        """Draw the curves of all channels with error bands and the lines that were read; one panel a stream."""
        from sigmatau.plot.curves import draw_analysis

        return draw_analysis(self.curves, self.read_off)

    def summary(self) -> str:
        """The grids and the table of coefficients, as the command line prints them."""
        return "\n".join([*self.grids.values(), "", table(self.read_off)])

    def __repr__(self) -> str:
        return "\n".join([self.summary(), *map(str, self.findings)])


def analyze(
    record: Record,
    *,
    taus: TauGrid | ArrayLike = "half",
    overlap: Overlap = "full",
    counting: Counting = "standard",
    threads: int | None = None,
) -> Analysis:
    """Analyse a static record: Allan curves of every channel and the coefficients that show.

    Parameters
    ----------
    record : Record
        From `sigmatau.read` or `Record.from_arrays`.
    taus, overlap, counting, threads
        See `sigmatau.allan`.

    Returns
    -------
    Analysis

    Raises
    ------
    DataError
        If a sample is missing, the record is too short, or no channel is left.
    OptionError
        For times or grids that cannot be.

    Notes
    -----
    A channel that never changes is left out with a finding; the others are analysed.
    """
    if not isinstance(record, Record):
        raise TypeError(f"`record` must be a Record, see sigmatau.read, not a {type(record).__name__}")
    findings: list[Finding] = list(record.findings)
    curves = {}
    for stream in record.streams:
        found = allan(Record(streams=(stream,)), taus=taus, overlap=overlap, counting=counting, threads=threads)
        for channel, curve in found.items():
            if curve.adev.max() > _rounding(stream, channel):
                curves[channel] = curve
            else:
                findings.append(_constant(stream, channel))
    if not curves:
        raise DataError("no channel is left to analyse: " + "; ".join(f"{f.channel}: {f.message}" for f in findings))
    return Analysis(
        source=record.provenance,
        findings=tuple(findings),
        curves=Curves(curves),
        read_off={channel: read_off(curve) for channel, curve in curves.items()},
        grids={stream.name: _grid_text(stream) for stream in record.streams},
    )


_LEGEND = (
    "Read off as in El-Sheimy, Hou & Niu (2008). ± is their eq. (26) at the longest τ of each region: a rule of thumb,",
    "no confidence interval, and blind to the bias where terms meet. A term not listed has no stretch of its slope here.",
)


def table(read_off: Mapping[str, ReadOff]) -> str:
    """The coefficients as aligned text, channel by channel, in the paper's form and the field's units."""
    rows: list[tuple[str, str, str, str]] = []
    notes: dict[str, str] = {}
    for channel, result in read_off.items():
        if not result and not result.refused:
            rows.append((channel, "no region of any term", "", ""))
        first = channel
        for name, c in result.items():
            texts = result.texts(name)
            region = f"τ {seconds(c.tau_min)} … {seconds(c.tau_max)} s"
            for k, (value, unit) in enumerate(texts):
                label = TERMS[name].label(result.quantity) if k == 0 else "  ="
                rows.append((first, label, f"{value} {unit}", region if k == 0 else ""))
                first = ""
            if TERMS[name].look_alikes:
                notes.setdefault(TERMS[name].look_alikes, TERMS[name].label(result.quantity))
        for refusal in result.refused:
            label = f"no {TERMS[refusal.term].label(result.quantity)}"
            rows.append(
                (first, label, "", f"τ {seconds(refusal.tau_min)} … {seconds(refusal.tau_max)} s: {refusal.reason}")
            )
            first = ""
    widths = [max((len(row[k]) for row in rows), default=0) for k in range(3)]
    lines = ["  ".join((*(c.ljust(w) for c, w in zip(row, widths, strict=False)), row[3])).rstrip() for row in rows]
    lines += ["", *_LEGEND]
    lines += [f"{term.capitalize()}: the same slope is made by {others}." for others, term in notes.items()]
    return "\n".join(lines)


def _rounding(stream: Stream, channel: str) -> float:
    """A deviation that rounding alone may leave of a channel that never changes, or only grows evenly."""
    k = stream.channels.index(channel)
    raw, t = stream.samples.raw[k], stream.samples.transforms[k]
    largest = max(abs(float(raw[0])), abs(float(raw[-1]))) * abs(t.scale * t.factor)
    if t.kind != "rate":
        largest /= stream.grid.tau0
    return 4 * sys.float_info.epsilon * largest


def _constant(stream: Stream, channel: str) -> Finding:
    value = stream.samples.read(stream.channels.index(channel), 0, 1)[0]
    return Finding(
        code="constant_channel",
        severity="error",
        channel=channel,
        message=f"every one of {stream.grid.n} samples is {value:.6g} {stream.unit}",
        effect="not analysed; check the wiring, the resolution or the column",
    )


def _grid_text(stream: Stream) -> str:
    grid = stream.grid
    length = f"{grid.duration / 3600:.4g} h" if grid.duration >= 3600 else f"{grid.duration:.4g} s"
    return (
        f"{stream.name}: {len(stream.channels)} channel{'s' if len(stream.channels) > 1 else ''},"
        f" {grid.n} samples at {grid.rate:.6g} Hz ({grid.source}), {length}"
    )
