"""The JSON form of an analysis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from sigmatau._version import SCHEMA
from sigmatau.options import stated
from sigmatau.results import plain_value

if TYPE_CHECKING:
    from sigmatau.analysis.result import Analysis
    from sigmatau.fitting.joint_fit import JointChannel


def to_dict(self: Analysis) -> dict[str, Any]:
    """The stable JSON form, schema 2: plain values, no NaN."""
    return with_joint(self, {})


def with_joint(self: Analysis, joint: Mapping[str, JointChannel]) -> dict[str, Any]:
    """The JSON form with the joint fits of channels."""
    return {
        "schema": SCHEMA,
        "sigmatau": self.version,
        "source": self.source.to_dict(),
        **({"options": options} if (options := stated_options(self)) else {}),
        **({"notes": dict(self.notes)} if self.notes else {}),
        **({} if self.rest is None else {"rest": self.rest.to_dict()}),
        "findings": [finding.to_dict() for finding in self.findings],
        "channels": {
            channel: {
                "quantity": curve.quantity,
                "sample_rate_hz": 1 / curve.tau0,
                "samples": curve.n,
                **(self.masks[channel].to_dict() if channel in self.masks else {}),
                **({"mean": self.means[channel].to_dict()} if channel in self.means else {}),
                "curve": curve.to_dict(),
                "read_off": self.read_off[channel].to_dict() if channel in self.read_off else {},
                **({"refused_lines": refused} if (refused := _refused_lines(self, channel)) else {}),
                **({"fit": fit.to_dict(), "trust": fit.trust} if (fit := self.fits.get(channel)) is not None else {}),
                **({"joint": joint[channel].to_dict()} if channel in joint else {}),
                **({"mean_stability": plain_value(means)} if (means := self.mean_stability.get(channel)) else {}),
                **({"stability": self.stability[channel].to_dict()} if channel in self.stability else {}),
            }
            for channel, curve in self.curves.items()
        },
    }


def _refused_lines(analysis: Analysis, channel: str) -> list[dict[str, Any]]:
    """Refused lines in given ranges."""
    refused = analysis.read_off[channel].refused if channel in analysis.read_off else ()
    return [refusal.to_dict() for refusal in refused if refusal.by_hand]


def to_json(self: Analysis) -> str:
    """The JSON form as text, as ``sigmatau analyze --json`` writes it."""
    import json

    return json.dumps(self.to_dict(), indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def stated_options(analysis: Analysis) -> dict[str, Any]:
    """Options that determine the result: the same log with the same options is the same run."""
    parts = {"reading": dict(analysis.source.options), "analysis": stated(analysis.options)}
    return {part: options for part, options in parts.items() if options}
