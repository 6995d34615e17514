"""Run every study: ``make study``. Each writes its page in docs/study/; finished cells are stored in .study/."""

from __future__ import annotations

from studies import (
    adis16405,
    arrays,
    bandwidth,
    bandwidth_instrument,
    coarse,
    consistent,
    coverage,
    datasheets,
    disturbances,
    disturbed,
    efficiency,
    false_alarms,
    gaps,
    interleaved,
    intervals,
    joint,
    likelihood,
    lots,
    matern,
    mean_stability,
    oracle,
    other_noise,
    paper_claims,
    paper_read_off,
    planning,
    prediction,
    processes,
    read_off,
    real_records,
    repeatability,
    rest,
    robustness,
    round_trip,
    selection,
    stability,
    temperature,
    tune,
)

STUDIES = (
    read_off,
    paper_read_off,
    planning,
    intervals,
    robustness,
    likelihood,
    mean_stability,
    oracle,
    other_noise,
    coarse,
    efficiency,
    coverage,
    processes,
    matern,
    datasheets,
    gaps,
    joint,
    bandwidth,
    bandwidth_instrument,
    round_trip,
    stability,
    selection,
    false_alarms,
    rest,
    interleaved,
    disturbances,
    disturbed,
    prediction,
    consistent,
    tune,
    adis16405,
    real_records,
    repeatability,
    lots,
    temperature,
    arrays,
    paper_claims,
)


def main() -> None:
    """Run all studies."""
    for study in STUDIES:
        study.main()


if __name__ == "__main__":
    main()
