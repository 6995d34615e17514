"""Ranges of averaging times for the lines of the read-off, by channel and term."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from sigmatau.errors import OptionError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.read_off import ReadOff, read_off, read_off_with_fit
from sigmatau.fitting.read_off_lines import Span, as_span
from sigmatau.noise.synonyms import unknown_term
from sigmatau.noise.terms import TERMS
from sigmatau.record.record import stream_name

_FORMS = "want TERM, or CHANNEL.TERM or SENSOR.TERM: gyro_x.random_walk, accel.rate_ramp"


class ReadOffAt:
    """Given ranges: ``{"random_walk": (1, 10), "gyro_x.quantization": (0.01, 2)}``.

    A range of a channel takes precedence over one of its sensor, and that over one of all channels.
    """

    def __init__(self, stated: Mapping[str, object] | None, *, force: bool = False) -> None:
        self._spans: dict[tuple[str, str], Span] = {}
        self._force = force
        if stated is not None and not isinstance(stated, Mapping):
            raise OptionError(
                f"{{option}} must be ranges of averaging times by term, in s, e.g. {{'random_walk': (1, 10)}},"
                f" not {stated!r}",
                option="read_off_at",
            )
        for key, span in (stated or {}).items():
            place, _, term = str(key).rpartition(".")
            if term not in TERMS:
                raise _error(str(key), f": {unknown_term(term)}; {_FORMS}")
            try:
                self._spans[place, term] = as_span(span)
            except OptionError as error:
                raise error.named("read_off_at", str(key)) from None

    def check(self, channels: Iterable[str]) -> None:
        """Raise `OptionError` if a range names an unknown channel or sensor."""
        names = list(channels)
        for place, term in self._spans:
            if place not in ("", *names, *map(stream_name, names)):
                raise _error(f"{place}.{term}", f": no channel or sensor {place!r}; channels: {', '.join(names)}")

    def read(self, curve: DeviationCurve, fitted: NoiseFit | None) -> ReadOff:
        """Read off the curve of a channel, with its fit if there is one. Raises `OptionError` for a range outside the
        curve.
        """
        places = ("", stream_name(curve.channel), curve.channel)
        by_term = {
            term: (place, span)
            for own_place in places
            for (place, term), span in self._spans.items()
            if place == own_place
        }
        spans: dict[str, Any] = {term: span for term, (_, span) in by_term.items()}
        try:
            if fitted is None:
                return read_off(curve, **spans, force=self._force)
            return read_off_with_fit(curve, fitted, spans, force=self._force)
        except OptionError as error:
            place = by_term[error.option or ""][0]
            raise error.named("read_off_at", f"{place}.{error.option}" if place else str(error.option)) from None


def _error(key: str, message: str) -> OptionError:
    return OptionError(f"{{option}} {key}{message}", option="read_off_at")
