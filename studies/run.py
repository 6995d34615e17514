"""Run every study: ``make study``. Each writes its page in docs/study/; what is done is kept in .study/."""

from __future__ import annotations

from studies import read_off


def main() -> None:
    """Run all studies."""
    read_off.main()


if __name__ == "__main__":
    main()
