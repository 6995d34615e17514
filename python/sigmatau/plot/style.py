"""New figures, which a notebook shows at the end of a cell, figures of given axes, and two styles."""

from __future__ import annotations

import contextlib
import functools
import importlib.util
import io
import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, cast, get_args

from sigmatau.errors import OptionError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Style = Literal["screen", "paper"]
Panels: TypeAlias = "Axes | Sequence[Axes] | None"

# A column of a two-column paper is 3.5 inches wide (IEEE), half the width of a panel on a screen. Legends are below the
# panels, where they hide no curve.
_PAPER = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.labelsize": 7,
    "axes.linewidth": 0.6,
    "legend.fontsize": 6,
    "xtick.labelsize": 6,
    "ytick.labelsize": 6,
    "lines.markersize": 2,
    "font.family": "serif",
    "mathtext.fontset": "stix",
    "savefig.dpi": 300,
}
_PAPER_WIDTH, _PAPER_HEIGHT = 0.5, 0.6  # sizes relative to those on a screen
_paper = False  # set by `styled`


def need_matplotlib() -> None:
    """Raise ImportError with the command to install matplotlib if it is missing."""
    if importlib.util.find_spec("matplotlib") is None:
        raise ImportError("drawing needs matplotlib: pip install 'sigmatau[plot]'")


@contextlib.contextmanager
def styled(style: str) -> Iterator[None]:
    """Draw in a style; raises `OptionError` for an unknown one."""
    global _paper
    if style not in get_args(Style):
        raise OptionError(f"{{option}} must be one of {', '.join(get_args(Style))}, not {style!r}", option="style")
    need_matplotlib()
    from matplotlib import rc_context

    with rc_context(_PAPER if style == "paper" else {}):  # type: ignore[arg-type]
        _paper = style == "paper"
        try:
            yield
        finally:
            _paper = False


@functools.cache
def _shown() -> type[Figure]:
    from matplotlib.figure import Figure

    class ShownFigure(Figure):
        """A figure outside pyplot, which a notebook shows by its picture."""

        def _repr_png_(self) -> bytes:
            out = io.BytesIO()
            self.savefig(out, format="png")
            return out.getvalue()

    return ShownFigure


def new_figure(width: float, height: float, **options: Any) -> Figure:  # noqa: ANN401
    """An empty figure; its size is in inches on a screen, and smaller in the style of a paper."""
    need_matplotlib()
    if _paper:
        width, height, options = _PAPER_WIDTH * width, _PAPER_HEIGHT * height, options | {"dpi": _PAPER["savefig.dpi"]}
    return _shown()(figsize=(width, height), layout="constrained", **options)


def small() -> int:
    """Size of small text, such as that of legends. [points]"""
    return 6 if _paper else 8


def across() -> int:
    """Largest number of panels with colour bars side by side."""
    return 2 if _paper else 3


def make_panels(ax: Any, count: int, *, columns: int, width: float, height: float) -> list[Axes]:  # noqa: ANN401  as below
    """Given axes, one per panel; or those of a new figure, at most `columns` side by side, each of a size in inches."""
    if (given_axes := check_panels(ax, count)) is not None:
        return given_axes
    columns = min(count, columns)
    rows = -(-count // columns)
    places = list(new_figure(width * columns, height * rows, dpi=120).subplots(rows, columns, squeeze=False).flat)
    for unused in places[count:]:
        unused.set_visible(False)
    return places[:count]


def two_panels(ax: Any) -> list[Axes]:  # noqa: ANN401  as below
    """Two given axes, or those of a new figure, one below the other with one horizontal axis."""
    return check_panels(ax, 2) or list(new_figure(7, 5).subplots(2, 1, sharex=True, height_ratios=(1.4, 1)))


def label_axes(ax: Axes, x: str, y: str) -> None:
    """Name both axes and draw a thin grid."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)


def legend(ax: Axes) -> None:
    """Add a legend."""
    if _paper:
        ax.legend(fontsize=small(), loc="upper center", bbox_to_anchor=(0.5, -0.2), frameon=False)
    else:
        ax.legend(fontsize=small(), loc="best")


def whole_decades(ax: Axes) -> None:
    """Set limits of at least a decade, with labels at powers of ten only, so that labels do not overlap."""
    from matplotlib.ticker import LogLocator, NullFormatter

    for axis, limits, put in ((ax.xaxis, ax.get_xlim(), ax.set_xlim), (ax.yaxis, ax.get_ylim(), ax.set_ylim)):
        low, high = sorted(limits)
        if high < 10 * low:
            put(10 ** math.floor(math.log10(low)), 10 ** math.ceil(math.log10(high)))
        axis.set_major_locator(LogLocator(numticks=7))
        axis.set_minor_formatter(NullFormatter())


def parent_figure(ax: Axes) -> Figure:
    """The figure of axes."""
    return cast("Figure", ax.get_figure(root=True))


def check_panels(ax: Any, count: int) -> list[Axes] | None:  # noqa: ANN401  one axes, several, or None
    """Given axes, one per panel; None if there are none. Raises `OptionError` for a wrong number."""
    if ax is None:
        return None
    several = getattr(ax, "flat", ax)
    panels = [ax] if hasattr(ax, "plot") else list(several) if isinstance(several, Iterable) else []
    if len(panels) != count or not all(hasattr(panel, "plot") for panel in panels):
        got = f"{ax!r:.80}" if not panels else len(panels)
        raise OptionError(f"{{option}} must be {count} axes, one a panel, not {got}", option="ax")
    return panels
