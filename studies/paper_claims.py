"""Check of the sentence "close to the manufacturers' claim" of the paper: Tables II, IV and V against section III, by term.

``python -m studies.paper_claims`` writes docs/study/paper-claims.md.
"""

from __future__ import annotations

from dataclasses import replace
from importlib import resources
from pathlib import Path

from sigmatau.lab.datasheets.compare import compare_with
from sigmatau.lab.datasheets.sheet import datasheet
from sigmatau.lab.datasheets.verdict import Verdict
from sigmatau.model.noise_model import NoiseModel
from studies.paper.tables import TABLES

__all__ = ["PAGE", "measured", "page", "verdicts"]

PAGE = Path(__file__).resolve().parent.parent / "docs" / "study" / "paper-claims.md"

_ONE_SIGMA = 0.6826894921370859  # probability of ± one standard deviation of a normal variable


def measured(unit: str) -> NoiseModel:
    """Values measured in the paper, with their ± as one standard deviation."""
    text = resources.files("sigmatau.data").joinpath(f"{unit}.toml")
    with resources.as_file(text) as path:
        model = NoiseModel.read(path)
    channels = {}
    for name, channel in model.channels.items():
        intervals = {}
        for term, value in channel.items():
            printed, error = TABLES[unit][name, term]
            intervals[term] = (value * (1 - error / printed), value * (1 + error / printed))
        channels[name] = replace(channel, intervals=intervals, level=_ONE_SIGMA)
    return NoiseModel(channels=channels)


def verdicts() -> dict[str, Verdict]:
    """Compare each of the three units with the manufacturer's values in the paper."""
    titles = {"cimu": "Table II", "hg1700": "Table IV", "motionpak2": "Table V"}
    return {unit: compare_with(measured(unit), datasheet(unit), unit=titles[unit]) for unit in TABLES}


def page() -> str:
    """The page."""
    compared = verdicts()
    judged = [j for verdict in compared.values() for j in verdict.judged if j.readings[0].measured.value is not None]
    total = sum(len(table) for table in TABLES.values())
    counts = {status: sum(j.status == status for j in judged) for status in ("within", "undecided", "out")}
    with_maximum = [j for j in judged if j.claim.maximum is not None]
    typical = [j.readings[0].typical for j in judged if j.claim.maximum is None]
    farthest = max(abs(c.sigmas) for c in typical if c is not None and c.sigmas is not None)
    proven = sum(j.status == "within" for j in with_maximum)
    blocks = "\n\n".join(f"```text\n{verdict!r}\n```" for verdict in compared.values())
    return _TEXT.format(
        blocks=blocks,
        total=total,
        judged=len(judged),
        typical=len(typical),
        farthest=farthest,
        maximum=len(with_maximum),
        proven=proven,
        unproven=len(with_maximum) - proven,
        out=counts["out"],
    )


_TEXT = """# "Close to the manufacturers' claim"

The paper concludes that "most of the results from the Allan-variance analysis are close to the manufacturers' claim,
which prove that the method performed in this paper is valid". Section III of the paper states the claims; Tables II, IV
and V state the results. This page compares them with `compare_with`, with the paper's ± as one standard deviation.
`python -m studies.paper_claims` writes this page, and `tests/lab/datasheets/test_paper_claims.py` tests it.

{blocks}

Evidence for the conclusion:

- The three tables have {total} coefficients. For {judged} of them there is a claim: the angle random walks of two of the
  three units. For the MotionPak II, section III states biases and bandwidths, but not noise.
- {typical} claims are typical values ("about"). The measured values differ from them by at most {farthest:.1f} σ. The
  errors are a third of the values, so only a random walk below 0.6 or above 1.9 times the claim would differ
  significantly.
- {maximum} claims are maxima ("less than"). With 95 % confidence, {proven} of the coefficients meet them, {unproven} is
  below the maximum but not significantly, and {out} exceed it.
- The claims for the bias instability of the CIMU and for the noise of its accelerometers were not tested, because two
  hours are too short, as the paper says. Most of section III is about bias repeatability, scale factors and residual
  bias. These are not noise, and a record at rest does not show them.

The results do not contradict the claims, and {proven} of {judged} comparisons confirm one. However, a method with an
error of 30 % in the random walk would not have contradicted them either. The agreement is therefore not a proof of the
method. The accuracy of reading off a slope is measured with known noise in [read-off](read-off.md).
"""


def main() -> None:
    """Write docs/study/paper-claims.md."""
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
