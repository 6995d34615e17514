"""The likelihood of records with missing samples: coverage, bias, false parts, time.

``python -m studies.gaps`` writes docs/study/gaps.md; ``--parts 2`` stops after half of the records of every cell.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, lfilter

from sigmatau._native.likelihood import ChannelFit, summarize, summarize_masked
from sigmatau.noise.terms import NOISE
from studies.likelihood import LETTERS, _above, _below, _holds, _origin, _row
from studies.mixtures import SHORT, Mixture
from studies.runner import run
from studies.samples import simulated

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Row = dict[str, Any]

N = 2**15
RECORDS = 400
PARTS = 8
MIXTURES: dict[str, Mixture] = {
    **{name: SHORT[name] for name in ("N", "N B", "N K", "N B K", "Q N", "Q N B", "Q K")},
    # Most of the power is at low frequencies, which a mask spreads over all others.
    "N K strong": Mixture(N, 1.0, {"random_walk": 1.0, "rate_random_walk": 0.1}),
    "B": SHORT["B"],
    "K": SHORT["K"],
}

# Filters of the samples, and masks with which they are simulated.
FILTERS: dict[str, tuple[Floats, Floats]] = {
    "Butterworth, order 2, 0.16 of the rate": butter(2, 0.32),
    "mean of 8": (np.ones(8) / 8, np.ones(1)),
}
BEHIND, SETTLING = "N B K", 1000  # mixture behind the filters, and samples that are left out until a filter has settled
FILTERED_MASKS = ("none", "5 % at random", "5 % in blocks", "4 gaps of 5 %")

SHORTEST, LONGEST = 20, 2000  # lengths of blocks of missing samples, log-uniform
MASKS: dict[str, tuple[str, float]] = {
    "none": ("random", 0.0),
    "5 % at random": ("random", 0.05),
    "20 % at random": ("random", 0.2),
    "50 % at random": ("random", 0.5),
    "5 % in blocks": ("blocks", 0.05),
    "20 % in blocks": ("blocks", 0.2),
    "50 % in blocks": ("blocks", 0.5),
    "every second": ("second", 0.5),
    "1 gap of 10 %": ("gaps", 1),
    "4 gaps of 5 %": ("gaps", 4),
    "10 gaps of 5 %": ("gaps", 10),
    "8 single samples": ("singles", 8),
}


def missing(kind: str, size: float, n: int, rng: np.random.Generator) -> Mask:
    """Mask of missing samples."""
    is_missing = np.zeros(n, dtype=bool)
    if kind == "random":
        return np.asarray(rng.random(n) < size)
    if kind == "second":
        is_missing[1::2] = True
    elif kind == "singles":
        is_missing[rng.choice(n, int(size), replace=False)] = True
    elif kind == "gaps":
        length = int((0.1 if size == 1 else 0.05) * n)
        for _ in range(int(size)):
            start = int(rng.integers(0, n - length))
            is_missing[start : start + length] = True
    else:
        while is_missing.mean() < size:
            length = int(math.exp(rng.uniform(math.log(SHORTEST), math.log(LONGEST))))
            start = int(rng.integers(0, n - length))
            is_missing[start : start + length] = True
    return is_missing


def analysed(y: Floats, absent: Mask, tau0: float) -> ChannelFit:
    """Fit one record like `sigmatau.fitting.likelihood`."""
    if not absent.any():
        return summarize([y], samples=len(y), tau0=tau0).fit()
    first, last = int(np.argmin(absent)), len(absent) - int(np.argmin(absent[::-1]))
    span = slice(first, last)

    def pieces() -> Iterator[Floats]:
        yield y[span]

    return summarize_masked(pieces, present=~absent[span], tau0=tau0).fit()


def records(seed: int, name: str, mask: str) -> list[Row]:
    """Statements on a part of the records of a mixture."""
    return _rows_of(seed, MIXTURES[name], MASKS[mask], None)


def filtered_records(seed: int, name: str, mask: str) -> list[Row]:
    """Statements on a part of the records of a mixture behind a filter."""
    return _rows_of(seed, MIXTURES[BEHIND], MASKS[mask], FILTERS[name])


def _rows_of(seed: int, mixture: Mixture, mask: tuple[str, float], behind: tuple[Floats, Floats] | None) -> list[Row]:
    rng, tau0, (kind, size) = np.random.default_rng(seed), 1 / mixture.rate, mask
    rows = []
    for _ in range(RECORDS // PARTS):
        longer = N if behind is None else N + SETTLING
        y = simulated(longer, tau0, dict(mixture.truth), seed=int(rng.integers(1 << 62)))
        if behind is not None:
            y = np.ascontiguousarray(lfilter(*behind, y)[SETTLING:])
        absent = missing(kind, size, N, rng)
        started = time.process_time()
        row = _row(analysed(y, absent, tau0))
        rows.append({**row, "seconds": time.process_time() - started})
    return rows


def truth_of(name: str, mask: str) -> dict[str, float]:
    """True coefficients. Without neighbouring samples, the random walk includes quantization noise: N² + 2 Q²/τ₀."""
    mixture = MIXTURES[name]
    truth = dict(mixture.truth)
    if mask == "every second" and "quantization" in truth:
        steps = truth.pop("quantization")
        truth["random_walk"] = math.sqrt(truth.get("random_walk", 0.0) ** 2 + 2 * steps**2 * mixture.rate)
    return truth


def main(parts: int = PARTS) -> None:
    """Run the study and write docs/study/gaps.md."""
    cells = {
        f"{name}, {mask} {k}": (records, (name, mask)) for k in range(parts) for mask in MASKS for name in MIXTURES
    }
    cells |= {
        f"{name}, {mask} {k}": (filtered_records, (name, mask))
        for k in range(parts)
        for mask in FILTERED_MASKS
        for name in FILTERS
    }
    results = run("gaps", cells, settings=repr((N, RECORDS, PARTS, MIXTURES, MASKS, FILTERS)))
    Path("docs/study/gaps.md").write_text(page(results), encoding="utf-8")


def page(results: Mapping[str, list[Row]]) -> str:
    """Page of the study, for the finished cells."""
    failures: list[str] = []
    pooled: dict[str, list[bool]] = {}
    by_mask: dict[str, list[bool]] = {}
    count = len(_rows(results, "N", "none"))
    lines = [_HEAD.format(origin=_origin(), n=N, records=count, planned=RECORDS)]
    false = [_FALSE]
    for mask in MASKS:
        for name in MIXTURES:
            rows = _rows(results, name, mask)
            if not rows:
                continue
            truth, cell = truth_of(name, mask), f"- {name}, {mask}"
            for term, value in truth.items():
                line, cover = _line_of_term(rows, term, value)
                pooled.setdefault(LETTERS[term], []).extend(cover)
                by_mask.setdefault(mask, []).extend(cover)
                failures += _uncovered(cell, term, cover)
                lines.append(f"| {mask} | {name} | {line}")
            shares = _false_parts(rows, truth)
            for label, share_false in shares.items():
                limit = 0.05 if label in LETTERS.values() or label == "R" else 0.02
                if share_false is not None and _above(share_false, limit, len(rows)):
                    failures.append(f"{cell}: false {label} in {100 * share_false:.1f} %")
            texts = ["" if share_false is None else f"{100 * share_false:.1f}" for share_false in shares.values()]
            seconds = 1000 * float(np.median([row["seconds"] for row in rows]))
            false.append(f"| {mask} | {name} | {' | '.join(texts)} | {seconds:.0f} |")
    lines += ["", _COVERAGE]
    for label, cover in [*by_mask.items(), *pooled.items(), ("all", [c for covers in pooled.values() for c in covers])]:
        share, error = float(np.mean(cover)), math.sqrt(0.95 * 0.05 / len(cover))
        lines.append(f"| {label} | {len(cover)} | {100 * share:.2f} ± {100 * error:.2f} |")
        if (label == "all" or label in pooled) and not 0.94 - 3 * error <= share <= 0.97 + 3 * error:
            failures.append(f"- {label}: {100 * share:.2f} % covered in all")
    behind = len(_rows(results, "mean of 8", "4 gaps of 5 %"))
    lines.append(_FILTERED.format(origin=_origin(), terms=BEHIND, settling=SETTLING, records=behind))
    for mask in FILTERED_MASKS:
        for name in FILTERS:
            if rows := _rows(results, name, mask):
                for term, value in MIXTURES[BEHIND].truth.items():
                    line, cover = _line_of_term(rows, term, value)
                    failures += _uncovered(f"- {name}, {mask}", term, cover)
                    lines.append(
                        f"| {mask} | {name} | {line} {100 * np.mean([row['filter'] > 0 for row in rows]):.0f} |"
                    )
    lines += [*false, "", "## Gates", "", *(failures or ["All gates are met."]), "", _NOTES]
    return "\n".join(lines) + "\n"


def _line_of_term(rows: list[Row], term: str, value: float) -> tuple[str, list[bool]]:
    """Columns of a term with the true value, and whether its intervals contain that value."""
    stated = [row["terms"].get(term) for row in rows]
    cover = [_holds(s, value) for s in stated]
    available = [s for s in stated if s is not None]
    squares = np.array([s[1] ** 2 for s in available]) / value**2
    half = np.median([(s[3] - s[2]) / 2 if s[3] is not None else math.inf for s in available]) / value
    text = f"{LETTERS[term]} | {len(rows)} | {100 * np.mean([s[0] for s in available]):.0f} |"
    text += f" {100 * (squares.mean() - 1) / 2:+.2g} | {50 * squares.std(ddof=1):.3g} | {100 * half:.3g} |"
    return f"{text} {100 * np.mean(cover):.1f} |", cover


def _uncovered(cell: str, term: str, cover: list[bool]) -> list[str]:
    share = float(np.mean(cover))
    return [f"{cell}: {LETTERS[term]} covered in {100 * share:.1f} %"] if _below(share, 0.92, len(cover)) else []


def _rows(results: Mapping[str, list[Row]], name: str, mask: str) -> list[Row]:
    return [row for k in range(PARTS) for row in results.get(f"{name}, {mask} {k}", ())]


def _false_parts(rows: list[Row], truth: Mapping[str, float]) -> dict[str, float | None]:
    """Shares of records with false parts; None for a term that is present."""

    def share(flags: Iterator[bool]) -> float:
        return float(np.mean(list(flags)))

    result: dict[str, float | None] = {
        LETTERS[term]: None if term in truth else share(bool(row["terms"].get(term, [False])[0]) for row in rows)
        for term in NOISE
    }
    result["R"] = share(bool(row["ramp"][2]) for row in rows)
    result["process"] = share(bool(row["processes"]) for row in rows)
    result["filter"] = share(row["filter"] > 0 for row in rows)
    result["line"] = share(row["lines"] > 0 for row in rows)
    result["warm-up"] = share(bool(row["warm_up"]) for row in rows)
    result["band cut"] = share(bool(row["cut"]) for row in rows)
    result["widened"] = share(bool(row["widened"]) for row in rows)
    return result


_HEAD = """# Records with missing samples

Made by `make study` (studies/gaps.py); {origin}. Simulated records of {n} samples, 1 Hz; the mixtures are those of
[the likelihood's study](likelihood.md), whose letters are used. Each record has a new mask, drawn with it; the seeds are
derived from the names of the cells. Blocks have 20 to 2000 samples, log-uniform; gaps may overlap. The analysis has its
defaults: it selects terms, processes, filters and lines for each record. With every second sample missing, quantization
noise and random walk have the same density, and the random walk stands for both: N² + 2Q²/τ₀. "N K strong" has K = 0.1
N/sample; of N K, this is 0.003.

There are {records} records in a cell; `python -m studies.gaps` goes on to {planned}.

Gates, each with 3 standard errors of the simulation: coverage of the 95 % intervals and limits of all records of a term
94 to 97 %, in each row at least 92 %; an absent term is observed in at most 5 %; a process, a filter, a line or a warm-up is
added, the top of the band is left out, or intervals are widened, in at most 2 % each.

"Found" is the share of records that show the term, "bias" and "sd" are those of the squared coefficient, halved, "half
width" the median of (high − low)/2; all in per cent of the true coefficient.

| missing | mixture | term | records | found | bias | sd | half width | covered |
|---|---|---|---|---|---|---|---|---|"""

_NOTES = """False Q is too frequent in "N K strong" with one gap. In 300 other records each, Q was observed in 8 % with one
gap of 10 %, and in 7 % without missing samples. Both sets together have 9.2 ± 1.3 % with the gap and 6.2 ± 1.1
% without: part of the excess is that of complete records; an effect of the gap is neither shown nor excluded.

Coverage is above 95 %, and the half widths exceed 1.96 sd, because intervals include other explanations that are
nearly as likely, such as a filter ([intervals](../theory/likelihood.md)).

Until the matrix of a mask had the exact sum of white noise, N was half a per cent too large behind a mean of 8 samples where
samples were missing in blocks or gaps, and B was covered in 84 to 91 % ([cause](../theory/likelihood.md#missing-samples)).
Until a negative density was excluded as a model (commit 70e1d1d9), B was covered in 37 of 50 records behind a mean of 8 with
three to five gaps, and the half width of N was 2 to 10 times larger behind any filter.

Before differences took the place of samples in the segments (commit e2b5887; 40 other records a cell), K alone
was covered in 55 to 92 % of the records with missing samples, K of "N K strong" with every second sample
missing in 50 %, and B alone with 50 % missing at random in 72 %."""

_COVERAGE = """## Coverage

| records of | intervals | covered [%] |
|---|---|---|"""

_FILTERED = """
## Behind a filter

The terms {terms} behind a filter of the samples, without the first {settling} samples; columns as above, and the share of
records with a filter in the model [%]. There are {records} records in a cell; {origin}. The gate of coverage is 92 % in each
row.

| missing | filter | term | records | found | bias | sd | half width | covered | filter seen |
|---|---|---|---|---|---|---|---|---|---|"""

_FALSE = """
## Parts that are not there

Shares of the records [%], and the median processor time of the passes and the analysis together [ms].

| missing | mixture | Q | N | B | K | R | process | filter | line | warm-up | band cut | widened | time |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"""

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", type=int, default=PARTS, help=f"parts of the records, of {PARTS}")
    main(**vars(parser.parse_args()))
