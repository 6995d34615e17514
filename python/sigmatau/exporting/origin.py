"""The head of an exported file: log, analysis, verdict on each channel, and findings that concern its numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import PurePath
from typing import Any

from sigmatau._version import __version__
from sigmatau.findings.wording.fit import beside_text, verdict_text
from sigmatau.findings.wording.phrases import axes_text
from sigmatau.record.record import stream_name
from sigmatau.results import duration_text

_MOST = 8  # kinds of findings in a head


def head_of(content: Mapping[str, Any], channels: Iterable[str]) -> tuple[str, ...]:
    """The lines of the head for a result of `analyze`, about some of its channels.

    Parameters
    ----------
    content : mapping
        Of ``to_dict`` or its JSON.
    channels : iterable of str
        Those that have a model.
    """
    found = {name: content["channels"][name] for name in channels}
    one = next(iter(found.values()))
    source = content.get("source") or {}
    topics = source.get("topics") or ()
    words = [
        f"from {PurePath(source.get('path') or 'samples in memory').name}",
        *(f"topic {topic}" for topic in topics[:2]),
        f"{duration_text(one['samples'] / one['sample_rate_hz'])} at {one['sample_rate_hz']:.4g} Hz",
        f"analysed by sigmatau {content.get('sigmatau', __version__)}",
    ]
    by_verdict: dict[str, list[str]] = {}
    for name, channel in found.items():
        fit = channel["fit"]
        terms = fit["terms"]
        beside = beside_text(
            response=bool(fit.get("filter")),
            lines=len(terms.get("sinusoid", ())),
            processes=len(terms.get("gauss_markov", ())),
            resonances=len(terms.get("resonance", ())),
            warm_up=bool(fit.get("warm_up")),
        )
        by_verdict.setdefault(verdict_text(fit["verdict"], beside), []).append(name)
    lines = [", ".join(words), *(f"{axes_text(names)}: {text}" for text, names in by_verdict.items())]
    kinds: dict[str, list[Mapping[str, Any]]] = {}
    for finding in content.get("findings", ()):
        concerned = finding.get("channels") or ()
        touches = not concerned or any(name in found and stream_name(name) in ("gyro", "accel") for name in concerned)
        if finding.get("severity", "info") != "info" and touches:
            kinds.setdefault(finding["code"], []).append(finding)
    return (*lines, *trust_of(found), *map(_line, list(kinds.values())[:_MOST]))


def trust_of(channels: Mapping[str, Any]) -> list[str]:
    """``trust: gyro good, accel_x poor``: a sensor whose axes are alike in one; none of a result without it."""
    sensors: dict[str, dict[str, str]] = {}
    for name, channel in channels.items():
        if "trust" in channel:
            sensors.setdefault(stream_name(name), {})[name] = channel["trust"]
    parts = (
        {sensor: next(iter(own.values()))} if len(set(own.values())) == 1 else own for sensor, own in sensors.items()
    )
    told = [f"{name} {word}" for part in parts for name, word in part.items()]
    return [f"trust: {', '.join(told)}"] if told else []


def _line(alike: list[Mapping[str, Any]]) -> str:
    """Findings of a kind in a line: the largest, and the axes of the others."""
    worst = max(alike, key=lambda one: abs(one.get("size") or 0.0))
    named = list(worst.get("channels") or ())
    others = list(dict.fromkeys(name for one in alike for name in one.get("channels") or () if name not in named))
    about = f"{axes_text(named)}: " if named else ""
    return f"{worst['severity']}: {about}{worst.get('message', worst['code'])}" + (
        f"; also {axes_text(others)}" if others else ""
    )


def topic_of(content: Mapping[str, Any]) -> dict[str, str]:
    """The ROS topic of the record as the name ``topic`` of a target; empty for no topic, or several."""
    topics: list[str] = (content.get("source") or {}).get("topics") or []
    return {"topic": topics[0]} if len(topics) == 1 and str(topics[0]).startswith("/") else {}
