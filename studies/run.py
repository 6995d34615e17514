"""Run every study: ``make study``. Each writes its page in docs/study/; what is done is kept in .study/."""

from __future__ import annotations

from studies import adis16405, coverage, efficiency, intervals, read_off, robustness, selection, stability


def main() -> None:
    """Run all studies."""
    for study in (read_off, intervals, robustness, efficiency, coverage, adis16405, stability, selection):
        study.main()


if __name__ == "__main__":
    main()
