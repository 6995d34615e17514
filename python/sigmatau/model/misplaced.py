"""Words for who asks a model for what a function gives, or a function for a model of several channels."""

from __future__ import annotations

from collections.abc import Mapping

from sigmatau.errors import OptionError

__all__ = ["PointsToFunctions", "one_channel"]

_FUNCTIONS = ("state_space", "arma")


class PointsToFunctions:
    """A model whose missing methods are functions of the package."""

    __slots__ = ()

    def __getattr__(self, name: str) -> object:
        if name in _FUNCTIONS:
            one = 'model["gyro_x"]' if hasattr(type(self), "channels") else "model"
            raise AttributeError(f"{name} is a function of one channel: sigmatau.{name}({one}, dt=0.01)")
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")


def one_channel(model: object, *, kind: type, function: str) -> None:
    """Raise `OptionError` for a model of several channels, or what is no model at all."""
    if isinstance(model, kind):
        return
    channels = getattr(model, "channels", None)
    if isinstance(channels, Mapping) and channels:
        raise OptionError(
            f"{{option}} is one of {len(channels)} channel{'s' * (len(channels) > 1)}, and {function} takes a single one:"
            f" {function}(model[{next(iter(channels))!r}], …)",
            option="model",
        )
    raise OptionError(f"{{option}} must be a {kind.__name__}, not {type(model).__name__}", option="model")
