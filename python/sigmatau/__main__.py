"""``python -m sigmatau``."""

from sigmatau.cli import main

raise SystemExit(main())
