"""One module a target, each with its ``TARGET``; to add one, write such a module and name it in `_MODULES`."""

from __future__ import annotations

from importlib import import_module

from sigmatau.errors import OptionError
from sigmatau.exporting.target import Target

__all__ = ["NAMES", "target"]

_MODULES = {
    "kalibr": "kalibr",
    "openvins": "openvins",
    "euroc": "euroc",
    "gtsam": "gtsam",
    "lio-sam": "lio_sam",
    "vins": "vins",
    "orb-slam3": "orb_slam3",
    "fast-lio": "fast_lio",
    "model": "model",
    "px4": "px4",
    "ardupilot": "ardupilot",
    "kf-gins": "kf_gins",
    "gnss-ins-sim": "gnss_ins_sim",
    "matlab": "matlab",
    "gazebo": "gazebo",
    "ros": "ros",
    "state-space": "state_space",
    "ieee952": "ieee952",
}

NAMES = tuple(_MODULES)
"""Names of the targets, as they are typed."""


def target(name: str) -> Target:
    """A target by its name, in capitals or not; raises `OptionError` that lists them."""
    if not isinstance(name, str):
        raise OptionError(
            f"{{option}} must be the name of a target, not {name!r}; targets: {', '.join(NAMES)}", option="to"
        )
    if name.lower() not in _MODULES:
        raise OptionError(f"unknown target {name!r}; targets: {', '.join(NAMES)}", option="to")
    found: Target = import_module(f"{__name__}.{_MODULES[name.lower()]}").TARGET
    return found
