"""Run every study: ``make study``. Each writes its page in docs/study/; what is done is kept in .study/."""

from __future__ import annotations

from studies import adis16405, bandwidth, coverage, efficiency, intervals, read_off, robustness


def main() -> None:
    """Run all studies."""
    for study in (read_off, intervals, robustness, efficiency, coverage, bandwidth, adis16405):
        study.main()


if __name__ == "__main__":
    main()
