"""Dates of logs, from their names and notes."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from datetime import datetime
from pathlib import PurePath

DATE_NOTES = ("recorded", "start", "time", "date")
"""Notes of `analyze` that state the beginning of a record."""

_DATE = re.compile(r"(?<!\d)(20\d\d)([-_]?)(\d\d)\2(\d\d)(?:[T_ -]?(\d\d)([:_-]?)(\d\d)(?:\6(\d\d))?)?(?!\d)")


def iso_date(text: str) -> datetime | None:
    """A date in ISO 8601; None for other text."""
    try:
        return datetime.fromisoformat(text.strip())
    except ValueError:
        return None


def date_in_name(log: str) -> datetime | None:
    """The first date in the name of a log, otherwise in its path: 2026-05-01 or 20260501_120000."""
    for part in (PurePath(log).name, log):
        for match in _DATE.finditer(part):
            year, _, month, day, hour, _, minute, second = match.groups()
            # 4512 in 20260501_4512 is a serial number, not a time.
            for h, m, s in ((hour, minute, second), (0, 0, 0)):
                with suppress(ValueError):
                    return datetime(int(year), int(month), int(day), int(h or 0), int(m or 0), int(s or 0))  # noqa: DTZ001  UTC
    return None


def without_days(name: str) -> str:
    """Replace the dates in a name by spaces, so that the 07 in 2026-05-07 is not taken for a serial number."""
    return _DATE.sub(lambda date: " " * (date.end(4) - date.start()) + name[date.end(4) : date.end()], name)


def day_of_log(notes: Mapping[str, str], log: str) -> str:
    """The day of a record, ``"2026-05-07"``, from its notes, otherwise from its name; empty if neither has a date."""
    stated = {key.strip().lower(): text for key, text in notes.items()}
    for key in DATE_NOTES:
        if date := iso_date(stated.get(key, "")):
            return f"{date:%Y-%m-%d}"
    date = date_in_name(PurePath(log).name)
    return "" if date is None else f"{date:%Y-%m-%d}"
