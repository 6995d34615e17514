"""Every format cut off, and with a changed page: nothing is shorter or wrong without a word."""

import pytest
from benches.formats import damage_outcomes
from benches.logs import KINDS

NEEDS = {
    "MCAP, zstd": "rosbags",
    "ROS 2 db3": "rosbags",
    "ROS 1 bag, lz4": "rosbags",
    "HDF5, fletcher32": "h5py",
    "Parquet, page checksums": "pyarrow",
    "Arrow file": "pyarrow",
    "LabVIEW TDMS": "nptdms",
}


@pytest.mark.parametrize("name", KINDS)
def test_damage_is_said(name, tmp_path):
    if name in NEEDS:
        pytest.importorskip(NEEDS[name], reason="it writes the log")
    kind = KINDS[name]
    for what, left in damage_outcomes(kind, tmp_path, n=3000, flips=4).items():
        if what.startswith("cut"):
            assert left.code in (1, 4), what
            assert left.right, what
        else:
            # Without a checksum numbers may have become other numbers: that cannot show. A page of an index, or of what
            # stands behind the data, may be read without loss.
            assert left.code in (0, 1, 2, 4), what
            assert left.right or not kind.checked, what
            assert left.rows == 3000 or left.code, what
        assert left.rows <= 3000
        assert (left.finding != "") == (left.code != 0), what
