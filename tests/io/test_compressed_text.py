"""Every format of text is read compressed by gzip and within a zip archive as it is read plain."""

import gzip
import json
import zipfile

import numpy as np
import pytest

import known
from container_damage import flipped
from sigmatau.errors import DataError
from sigmatau.io.read import read

N = 4000  # rows, so that every text is larger than the head that the layout is detected from
RNG = np.random.default_rng(known.seed_of("compressed text"))
GYRO = RNG.normal(0, 0.05, (N, 3)).round(9)
ACCEL = (RNG.normal(0, 0.01, (N, 3)) + np.array([0, 0, 9.81])).round(9)
UNIT = {"gyro": "deg/s", "accel": "m/s^2", "time": "s"}
NAMES = ("gx", "gy", "gz", "ax", "ay", "az")


def _named_rows():
    for k, values in enumerate(np.hstack([GYRO, ACCEL]).tolist()):
        yield {"time": k / 100, **dict(zip(NAMES, values, strict=True))}


def _lvm():
    tags = "LabVIEW Measurement\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n***End_of_Header***\t\n\n"
    units = "\t".join(["deg/s"] * 3 + ["m/s^2"] * 3)
    tags += f"Channels\t6\nY_Unit_Label\t{units}\nX_Dimension{chr(9)}Time\n***End_of_Header***\n"
    rows = "\n".join("\t".join(repr(v) for v in row.values()) for row in _named_rows())
    return tags + "\t".join(["X_Value", *NAMES, "Comment"]) + "\n" + rows + "\n"


TEXTS = {
    "log.csv": lambda: (
        "\n".join([",".join(["time", *NAMES]), *(",".join(map(repr, r.values())) for r in _named_rows())]) + "\n"
    ),
    "log.lvm": _lvm,
    "log.jsonl": lambda: "\n".join(map(json.dumps, _named_rows())) + "\n",
    "log.json": lambda: json.dumps(list(_named_rows())),
    "log.txt": lambda: "\n".join(" ".join(f"{n}:{v!r}" for n, v in r.items()) for r in _named_rows()) + "\n",
}


@pytest.mark.parametrize("packed", ["gz", "zip"])
@pytest.mark.parametrize("name", TEXTS)
def test_text_is_read_alike_when_compressed(tmp_path, name, packed):
    data = TEXTS[name]().encode()
    assert len(data) > 1 << 18
    plain = tmp_path / name
    plain.write_bytes(data)
    path = tmp_path / f"{name}.{packed}"
    if packed == "gz":
        path.write_bytes(gzip.compress(data))
    else:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(name, data)
    expected, record = read(plain, unit=UNIT), read(path, unit=UNIT)
    assert record.channels == expected.channels
    for channel in expected.channels:
        stream = record.stream_of(channel)
        assert stream.grid.rate == pytest.approx(100)
        np.testing.assert_array_equal(stream.column(channel), expected.stream_of(channel).column(channel))
    assert record.findings == expected.findings


@pytest.mark.parametrize("name", [name for name in TEXTS if name != "log.json"])
def test_a_truncated_stream_is_read_up_to_its_end(tmp_path, name):
    data = gzip.compress(TEXTS[name]().encode())
    path = tmp_path / f"{name}.gz"
    path.write_bytes(data[: len(data) // 2])
    record = read(path, unit=UNIT)
    length = len(record.streams[0].column("gyro_x"))
    assert N // 4 < length < 3 * N // 4
    np.testing.assert_allclose(record.stream_of("gyro_x").column("gyro_x"), np.radians(GYRO[:length, 0]))
    damage = [finding for finding in record.findings if finding.code == "damaged"]
    assert [finding.severity for finding in damage] == ["error"] * len(damage)
    assert any(finding.details.what == "gzip stream" for finding in damage)


@pytest.mark.parametrize("name", TEXTS)
def test_damaged_compressed_data_are_not_passed_over(tmp_path, name):
    data = gzip.compress(TEXTS[name]().encode())
    path = tmp_path / f"{name}.gz"
    for place in range(len(data) // 3, len(data), len(data) // 4):
        path.write_bytes(flipped(data, place))
        try:
            record = read(path, unit=UNIT)
        except DataError:
            continue
        assert any(finding.severity == "error" for finding in record.findings)
        values = record.stream_of("gyro_x").column("gyro_x")
        np.testing.assert_allclose(values, np.radians(GYRO[: len(values), 0]))


@pytest.mark.parametrize("name", TEXTS)
def test_a_bomb_is_refused(tmp_path, name):
    path = tmp_path / f"{name}.gz"
    path.write_bytes(gzip.compress(TEXTS[name]().encode() + b"\n" * (1 << 26), 1))
    with pytest.raises(DataError, match="expands from"):
        read(path, unit=UNIT)
