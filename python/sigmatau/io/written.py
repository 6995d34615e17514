"""Recognition of files that sigmatau wrote, which are not logs."""

from __future__ import annotations

import re
from pathlib import Path

_HEAD, _TAIL = 4096, 16384  # bytes at the beginning and at the end that may name the program; a PDF names it at the end

# Signatures of JSON, text and exports, figures, reports, coefficients and curves of --csv, tables and JUnit XML of a
# lot, and arrays of a state space.
# They are at the beginning: a search of each place would take ten times longer, for each log of a fleet.
_WRITTEN = re.compile(
    rb'\{\s*(?:"(?:schema|lot)": \d+,\s*)?"sigmatau": "'
    rb"|(?:[^\n]{0,200}\n){0,2}[^\n]{0,200}written by sigmatau \d"
    rb'|\{\s*"value0": \{[^}]*\},\s*"about": \[\s*"[^"]*written by sigmatau \d'
    rb"|\x89PNG.*Software\0sigmatau \d"
    rb"|%PDF.*/Creator \(sigmatau \d"
    rb'|<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><meta name="generator" content="sigmatau \d'
    rb"|channel,(?:term,(?:observed,)?value,|tau_s,adev,)[a-z_,]*\n"
    rb"|unit,state,reason,[a-z_,]*\n"
    rb'|<\?xml [^\n]*\n<testsuites name="sigmatau'
    rb"|PK\x03\x04.{26}[a-z_]+\.F\.npy",
    re.DOTALL,
)
_FIGURE = re.compile(rb"<svg.*<dc:title>sigmatau \d", re.DOTALL)  # after a declaration


def is_result(path: Path) -> bool:
    """Whether a file is a result of sigmatau, by its content; a simulated log or a pipe is not."""
    if not path.is_file():
        return False
    try:
        with path.open("rb") as stream:
            head = stream.read(_HEAD)
            if head.startswith(b"%PDF"):
                stream.seek(max(path.stat().st_size - _TAIL, 0))
                head += stream.read()
    except OSError:
        return False
    return _WRITTEN.match(head) is not None or (b"<svg" in head and _FIGURE.search(head) is not None)
