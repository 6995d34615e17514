"""The same log as text with names, as JSON, and as an Excel workbook, in the published layouts."""

from __future__ import annotations

import datetime as dt
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

CHANNELS = tuple(f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz")
UNITS = ("rad/s",) * 3 + ("m/s^2",) * 3

Values = NDArray[np.float64]
Stamps = NDArray[np.int64]


def lvm(folder: Path, stamps: Stamps, values: Values) -> Path:
    """Write a LabVIEW measurement file: its header, the header of a segment, and the rows."""
    step = float(stamps[1] - stamps[0]) * 1e-9
    tags = {
        "Channels": ["6"],
        "Samples": [str(len(stamps))] * 6,
        "Date": ["2023/11/14"] * 6,
        "Time": ["22:13:20"] * 6,
        "Y_Unit_Label": list(UNITS),
        "X_Dimension": ["Time"] * 6,
        "X0": ["0.0000000000000000E+0"] * 6,
        "Delta_X": [f"{step:.6f}"] * 6,
    }
    lines = ["LabVIEW Measurement", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab", "Decimal_Separator\t."]
    lines += ["Multi_Headings\tYes", "X_Columns\tOne", "Time_Pref\tRelative", "***End_of_Header***\t", ""]
    lines += ["\t".join([tag, *numbers]) for tag, numbers in tags.items()]
    lines += ["***End_of_Header***", "\t".join(["X_Value", *CHANNELS, "Comment"])]
    times = ((stamps - stamps[0]) * 1e-9).tolist()
    lines += [f"{t:.6f}\t" + "\t".join(map(repr, row)) + "\t" for t, row in zip(times, values.tolist(), strict=True)]
    path = folder / "log.lvm"
    path.write_text("\r\n".join([*lines, ""]), newline="")
    return path


def keyed(folder: Path, stamps: Stamps, values: Values) -> Path:
    """Write lines of names and values."""
    names = ("time_ns", *CHANNELS)
    rows = zip(stamps.tolist(), *(values[:, k].tolist() for k in range(6)), strict=True)
    path = folder / "serial.txt"
    lines = (" ".join(f"{name}:{value!r}" for name, value in zip(names, row, strict=True)) for row in rows)
    path.write_text("\n".join([*lines, ""]))
    return path


def json_lines(folder: Path, stamps: Stamps, values: Values) -> Path:
    """Write an object for each row."""
    path = folder / "log.jsonl"
    with path.open("w") as stream:
        for stamp, row in zip(stamps.tolist(), values.tolist(), strict=True):
            stream.write(json.dumps({"time_ns": stamp, "gyro": row[:3], "accel": row[3:]}) + "\n")
    return path


def echo(folder: Path, stamps: Stamps, values: Values) -> Path:
    """Write ``sensor_msgs/Imu`` as printed by ``ros2 topic echo``."""
    path = folder / "imu.yaml"
    matrix = "\n- 0.0" * 9
    with path.open("w") as stream:
        for stamp, row in zip(stamps.tolist(), values.tolist(), strict=True):
            gyro, accel = (
                "".join(f"\n  {a}: {x!r}" for a, x in zip("xyz", v, strict=True)) for v in (row[:3], row[3:])
            )
            stream.write(
                f"header:\n  stamp:\n    sec: {stamp // 10**9}\n    nanosec: {stamp % 10**9}\n  frame_id: imu\n"
                f"orientation:\n  x: 0.0\n  y: 0.0\n  z: 0.0\n  w: 1.0\norientation_covariance:{matrix}\n"
                f"angular_velocity:{gyro}\nangular_velocity_covariance:{matrix}\n"
                f"linear_acceleration:{accel}\nlinear_acceleration_covariance:{matrix}\n---\n"
            )
    return path


def csv_echo(folder: Path, stamps: Stamps, values: Values) -> Path:
    """Write ``sensor_msgs/Imu`` as printed by ``ros2 topic echo --csv``."""
    path = folder / "imu.csv"
    zeros = ",".join(["0.0"] * 9)
    with path.open("w") as stream:
        for stamp, row in zip(stamps.tolist(), values.tolist(), strict=True):
            gyro, accel = (",".join(map(repr, part)) for part in (row[:3], row[3:]))
            stream.write(
                f"{stamp // 10**9},{stamp % 10**9},imu,0.0,0.0,0.0,1.0,{zeros},{gyro},{zeros},{accel},{zeros}\n"
            )
    return path


_PARTS = {
    "[Content_Types].xml": '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default'
    ' Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="xml"'
    ' ContentType="application/xml"/><Override PartName="/xl/workbook.xml" ContentType="application/vnd.openxmlformats-'
    'officedocument.spreadsheetml.sheet.main+xml"/></Types>',
    "xl/styles.xml": '<styleSheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><cellXfs count="2">'
    '<xf numFmtId="0"/><xf numFmtId="22" applyNumberFormat="1"/></cellXfs></styleSheet>',
    "_rels/.rels": '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship'
    ' Id="rId1" Type="http://schemas.openxmlformats.org/officeDocument/2006/relationships/officeDocument"'
    ' Target="xl/workbook.xml"/></Relationships>',
}
_MAIN = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
_REL = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"


def workbook(path: Path, sheets: dict[str, list[list[Any]]]) -> Path:
    """A workbook of ECMA-376 with the rows of each sheet: numbers, words, dates, and None for an empty
    cell.
    """
    named = "".join(f'<sheet name="{name}" sheetId="{k}" r:id="rId{k}"/>' for k, name in enumerate(sheets, 1))
    links = "".join(
        f'<Relationship Id="rId{k}" Type="{_REL}/worksheet" Target="worksheets/sheet{k}.xml"/>'
        for k in range(1, len(sheets) + 1)
    )
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, content in _PARTS.items():
            archive.writestr(name, content)
        archive.writestr("xl/workbook.xml", f'<workbook {_MAIN} xmlns:r="{_REL}"><sheets>{named}</sheets></workbook>')
        archive.writestr(
            "xl/_rels/workbook.xml.rels",
            f'<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">{links}</Relationships>',
        )
        for k, rows in enumerate(sheets.values(), 1):
            body = "".join(f"<row>{''.join(map(_cell, row))}</row>" for row in rows)
            archive.writestr(
                f"xl/worksheets/sheet{k}.xml", f"<worksheet {_MAIN}><sheetData>{body}</sheetData></worksheet>"
            )
    return path


def _cell(value: object) -> str:
    if value is None:
        return "<c/>"
    if isinstance(value, dt.datetime):
        days = (value - dt.datetime(1899, 12, 30)) / dt.timedelta(days=1)  # noqa: DTZ001  as Excel counts
        return f'<c s="1"><v>{days!r}</v></c>'
    if isinstance(value, str):
        return f'<c t="inlineStr"><is><t>{value}</t></is></c>'
    return f"<c><v>{value!r}</v></c>"


def xlsx(folder: Path, stamps: Stamps, values: Values) -> Path:
    """A workbook with one sheet."""
    header = ["time [s]", *(f"{c} [{u}]" for c, u in zip(CHANNELS, UNITS, strict=True))]
    times = ((stamps - stamps[0]) * 1e-9).tolist()
    rows = [[t, *row] for t, row in zip(times, values.tolist(), strict=True)]
    return workbook(folder / "log.xlsx", {"imu": [header, *rows]})
