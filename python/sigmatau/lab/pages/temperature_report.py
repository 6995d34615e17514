"""`temperature_report`: a temperature calibration, or units at several temperatures, as a page that opens offline."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from sigmatau import __version__
from sigmatau.errors import OptionError
from sigmatau.io.atomic import atomic
from sigmatau.lab.pages.lot_content import moment_text
from sigmatau.lab.pages.temperature_pdf import autopilot_files, document
from sigmatau.lab.temperature.figures import bias_svg, deviations_svg
from sigmatau.lab.temperature.matrix import TemperatureMatrix
from sigmatau.lab.temperature.matrix_figures import table_svg
from sigmatau.lab.temperature.result import ChannelCalibration, TemperatureCalibration
from sigmatau.lab.temperature.text import headline, heads, mean_unit, rows, summary_lines
from sigmatau.reporting.html import Section, asset, done, frame, scrolled, section
from sigmatau.reporting.markup import Markup, element, joined, name, raised
from sigmatau.results import printable

_ENDINGS = (".html", ".pdf")
_SCRIPTS = ("page", "numbers", "plot", "theme")
_WIDTH, _HEIGHT = 110.0, 62.0  # size of a figure [mm]


def temperature_report(
    result: TemperatureCalibration | TemperatureMatrix,
    path: str | Path,
    *,
    matrix: TemperatureMatrix | None = None,
    command: str | None = None,
    date: datetime | None = None,
) -> None:
    """Write a page: figures, tables with intervals, and parameters of autopilots.

    Parameters
    ----------
    result : TemperatureCalibration or TemperatureMatrix
        One sensor, or several units.
    path : str or Path
        ``.html``: a page that opens offline. ``.pdf``: to print; needs ``pip install 'sigmatau[pdf]'``.
    matrix : TemperatureMatrix, optional
        Coefficients of the runs of a calibration, as a section of its page.
    command : str, optional
        Command that made the page, to be printed in it.
    date : datetime, optional
        Date of the page. Default: now.

    Raises
    ------
    OptionError
        For another extension.
    DataError
        If the file cannot be written.
    ImportError
        For a PDF without typst.

    See Also
    --------
    calibrate_temperature, temperature_matrix : make the results.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> rate = st.simulate(model, duration=3600, rate=2, rng=1).streams[0].column("gyro_x")
    >>> log = st.Record.from_arrays(rate=2, gyro_x=rate, temperature=np.linspace(0, 50, 7200))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     st.temperature_report(st.calibrate_temperature(log), f"{folder}/temperature.html")
    """
    file = Path(path)
    if file.suffix.lower() not in _ENDINGS:
        raise OptionError(f"{{option}} {file.name!r}: the name must end in {' or '.join(_ENDINGS)}", option="path")
    date = datetime.now(tz=UTC) if date is None else date
    moment = moment_text(date)
    sections: list[Section] = []
    if isinstance(result, TemperatureCalibration):
        title = printable(result.unit_name or Path(result.source).name or "Record")
        about = headline(result)
        sections += [section("summary", "Summary", _summary(result))]
        sections += [
            section(f"channel-{k}", printable(channel.channel), _channel(channel))
            for k, channel in enumerate(result.values())
        ]
        sections += [section("files", "Parameters of autopilots", _files(result))]
        matrices = [] if matrix is None else [matrix]
    else:
        title, matrices = f"{len(result.units)} units", [result]
        about = f"{len(result.units)} units at {', '.join(f'{t:.3g}' for t in result.temperatures)} °C"
    facts = [("Command", command or ""), ("Date", moment), ("Version", f"sigmatau {__version__}")]
    facts = [(key, printable(text)) for key, text in facts if text]
    if file.suffix.lower() == ".pdf":
        calibration = result if isinstance(result, TemperatureCalibration) else None
        legend = "" if calibration is None else _legend(calibration)
        made = document(calibration, matrices, title=title, headline=about, legend=legend, done=facts, date=date)
        with atomic(file) as temporary:
            temporary.write_bytes(made)
        return
    for each in matrices:
        sections += [
            section(
                f"table-{k}" if k or sections else "summary",
                f"{table.title.capitalize()} [{table.unit}]",
                *_table(each, k),
            )
            for k, table in enumerate(each.tables())
        ]
    sections.append(section("done", "What was done", done(facts)))
    header = element(
        "header",
        element("p", "Temperature report", class_="kind"),
        element("h1", name(title)),
        element("p", element("span", name(printable(about))), class_="headline"),
        element("button", "Dark", type="button", id="theme", class_="quiet", hidden=True),
    )
    page = frame(
        title=f"{title} – temperature",
        made_by=f"sigmatau {__version__}",
        date=moment,
        header=header,
        sections=sections,
        charts={},
        styles=asset("report.css") + asset("temperature.css", __package__),
        scripts=[asset(f"{module}.js") for module in _SCRIPTS],
    )
    with atomic(file) as temporary:
        temporary.write_text(page, encoding="utf-8")


def _summary(result: TemperatureCalibration) -> Markup:
    channels = [
        element(
            "article",
            element("h3", name(printable(channel.channel))),
            (element("p", raised(f"{line[0].upper()}{line[1:]}.")) for line in summary_lines(channel)),
        )
        for channel in result.values()
    ]
    remarks = [element("p", f"{remark[0].upper()}{remark[1:]}.") for remark in result.remarks]
    about = _legend(result)
    return joined(element("div", channels, class_="calibrations"), remarks, element("p", about, class_="legend"))


def _legend(result: TemperatureCalibration) -> str:
    """What the intervals contain, and what not."""
    return (
        f"Intervals contain the true value with a probability of {100 * result.level:g} %. They account for random walk,"
        " bias instability and rate random walk. A mean is the bias of this log plus gravity or the rate of the earth. Its"
        " interval does not include the change of the bias from one power-up to the next."
    )


def _channel(channel: ChannelCalibration) -> Markup:
    unit, _ = mean_unit(channel)
    figures = [
        _figure(
            f"Mean [{unit}]. Line: polynomial with its interval. ▲ rising, ▼ falling",
            bias_svg(channel, width=_WIDTH, height=_HEIGHT),
        )
    ]
    if drawn := deviations_svg(channel, width=_WIDTH, height=_HEIGHT):
        figures.append(_figure(f"Allan deviation [{unit}]. Orange: as recorded. Blue: compensated", drawn))
    head = element("thead", element("tr", (element("th", raised(text), scope="col") for text in heads(channel))))
    body = element("tbody", (element("tr", (element("td", raised(text)) for text in row)) for row in rows(channel)))
    return joined(element("div", figures, class_="drawn"), scrolled(element("table", head, body)))


def _figure(caption: str, svg: str) -> Markup:
    return element("figure", element("p", raised(caption), class_="about"), Markup(svg))


def _table(matrix: TemperatureMatrix, number: int) -> Iterable[Markup]:
    table = list(matrix.tables())[number]
    yield element("p", "Largest of the axes. Thick line: median of the units.", class_="about")
    yield element(
        "div",
        _figure(f"{table.title} [{table.unit}]", table_svg(matrix, table, width=_WIDTH, height=_HEIGHT)),
        class_="drawn",
    )
    heads_ = ["Unit", *(f"{t:.3g} °C" for t in matrix.temperatures)]
    head = element("thead", element("tr", (element("th", text, scope="col") for text in heads_)))
    body = (
        element("tr", element("th", name(printable(unit)), scope="row"), (element("td", cell) for cell in cells))
        for unit, cells in table.rows
    )
    yield scrolled(element("table", head, element("tbody", body)))


def _files(result: TemperatureCalibration) -> Markup:
    parts = [
        element("details", element("summary", target), element("pre", text, tabindex="0"))
        if is_file
        else element("p", f"{target}: {text}", class_="none")
        for target, text, is_file in autopilot_files(result)
    ]
    return element("div", parts, class_="files")
