"""The targets: those of the table in `templates`, and modules for the others.

A short YAML is one entry of `templates._TEMPLATES`, which is then listed. Any other file is a module with its `Target`,
named in `_OTHERS`.
"""

from __future__ import annotations

from difflib import get_close_matches
from importlib import import_module

from sigmatau.errors import OptionError
from sigmatau.exporting.target import Target
from sigmatau.exporting.targets import templates

_OTHERS = {
    "gtsam": "gtsam.TARGET",
    "model": "model.TARGET",
    "basalt": "basalt.TARGET",
    "px4": "autopilots.PX4",
    "ardupilot": "autopilots.ARDUPILOT",
    "kf-gins": "kf_gins.TARGET",
    "gnss-ins-sim": "simulators.GNSS_INS_SIM",
    "matlab": "matlab.TARGET",
    "gazebo": "simulators.GAZEBO",
    "ros": "ros.TARGET",
    "state-space": "state_space.TARGET",
    "ieee952": "ieee952.TARGET",
}  # module and attribute; imported when it is asked for

NAMES = (*templates.TARGETS, *_OTHERS)  # Names of the targets, as they are typed

_SAME = {
    "vins-mono": "vins",
    "vins-fusion": "vins",
    "asl": "euroc",
    "okvis": "okvis2",
    "isaac-ros": "cuvslam",
    "isaac-ros-visual-slam": "cuvslam",
    "robot-localization": "ros",
    "ekf2": "px4",
    "ekf3": "ardupilot",
}  # other names of the same program


def target(name: str) -> Target:
    """A target by its name, in any case, or by that of its program; raises `OptionError` that lists them."""
    if not isinstance(name, str):
        raise OptionError(
            f"{{option}} must be the name of a target, not {name!r}; targets: {', '.join(NAMES)}", option="to"
        )
    known = _known(name)
    if known in templates.TARGETS:
        return templates.TARGETS[known]
    if known not in _OTHERS:
        close = get_close_matches(known, NAMES, n=1)
        meant = f", perhaps {close[0]}" if close else ""
        raise OptionError(f"unknown target {name!r}{meant}; targets: {', '.join(NAMES)}", option="to")
    module, attribute = _OTHERS[known].split(".")
    found: Target = getattr(import_module(f"{__name__}.{module}"), attribute)
    return found


def _known(name: str) -> str:
    """The name of a target, for its own name or another one of its program; in lower case, if there is none."""
    typed = name.lower().replace("_", "-")
    joined = {known.replace("-", ""): known for known in NAMES}
    return _SAME.get(typed) or joined.get(typed.replace("-", ""), typed)
