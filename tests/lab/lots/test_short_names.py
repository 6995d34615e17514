"""Labels of runs and units: without what all names share, on the forest plot and on the page of a lot."""

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from sigmatau.lab.lots.short_names import common_prefix, short_names
from sigmatau.lab.pages.lot_html import chart_data


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["day 1", "day 2"], ["day 1", "day 2"]),
        (["2026-11-24_imu_SN0041", "2026-11-24_imu_SN0042"], ["SN0041", "SN0042"]),
        (["production_run_17_A", "production_run_17_B", "production_run_17"], ["17_A", "17_B", "17"]),
        (["a_very_long_name_of_a_run", "another_name_that_is_long"], ["…ong_name_of_a_run", "…name_that_is_long"]),
        (["one_long_name_of_a_single_run"], ["…e_of_a_single_run"]),
        (["no separator: abcdefghijk1", "no separator: abcdefghijk2"], ["abcdefghijk1", "abcdefghijk2"]),
    ],
)
def test_names(names, expected):
    assert short_names(names) == expected
    assert all(name.startswith(common_prefix(names)) for name in names)


@pytest.fixture(scope="module")
def results():
    rng = np.random.default_rng(seed_of("short names"))
    records = (st.Record.from_arrays(rate=10, gyro=rng.standard_normal((6000, 3)) * 1e-3) for _ in range(3))
    return {f"2026-11-24_imu_SN004{k}": st.analyze(record) for k, record in enumerate(records)}


def test_labels_of_the_forest_plot(results):
    figure = st.compare_runs(list(results.values()), names=list(results), units=["A"] * 3).plot()
    labels = {label.get_text() for label in figure.axes[0].get_yticklabels()}
    assert labels == {"SN0040", "SN0041", "SN0042"}


def test_names_on_the_page_of_a_lot(results, tmp_path):
    lot = st.judge_lot(results)
    assert chart_data(lot)["units"] == ["SN0040", "SN0041", "SN0042"]
    st.lot_report(lot, tmp_path / "lot.html")
    text = (tmp_path / "lot.html").read_text(encoding="utf-8")
    assert "Names begin with <bdi>2026-11-24_imu_</bdi>." in text
