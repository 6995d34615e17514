"""Write log layouts as files: ``python tests/layouts/generator.py FOLDER``.

Each layout follows the manual or the public headers of a product, a data set or a library, which it names; none was
derived from the tables of this program. ``LAYOUTS`` is the corpus; ``recording.Layout`` describes the correct result for
each.
"""

import sys
from pathlib import Path

import flights
import instruments
import laboratory
import robots
import sketches
import wearables
from recording import Layout

MODULES = (instruments, wearables, flights, robots, sketches, laboratory)
LAYOUTS: tuple[Layout, ...] = tuple(
    value for module in MODULES for value in vars(module).values() if isinstance(value, Layout)
)


def write_corpus(folder: Path) -> dict[str, Path]:
    """Write every layout into a folder with its name, because several programs give their files the same name."""
    paths = {}
    for described in LAYOUTS:
        place = folder / described.name
        place.mkdir(parents=True, exist_ok=True)
        paths[described.name] = described.save(place)
    return paths


if __name__ == "__main__":
    for name, path in write_corpus(Path(sys.argv[1])).items():
        print(f"{name:32} {path.stat().st_size:8} {path}")
