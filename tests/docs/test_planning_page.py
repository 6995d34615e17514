"""The table of docs/how-to/planning.md is what `plan` computes for the sensors that the page shows."""

import re
import tomllib

import pytest

from conftest import ROOT
from sigmatau import NoiseModel
from sigmatau.fitting.planning import relative_error, smallest_detectable
from sigmatau.units import find

PAGE = (ROOT / "docs" / "how-to" / "planning.md").read_text(encoding="utf-8")
HOURS = (1 / 6, 1, 4, 24)
RATE = 100
UNITS = {"deg/h/√h": "deg/h/sqrt(h)", "µg": "ug", "m/s/h^{3/2}": "m/s/h^(3/2)"}


def cells():
    """Sensor, term, unit, hours and value of each cell."""
    sensor = ""
    for row in re.findall(r"^\| (?:`(\w+)` )?\| ([NBK]) (?:± %|\[(.+)\]) \| (.+) \|$", PAGE, flags=re.MULTILINE):
        sensor = row[0] or sensor
        for hours, value in zip(HOURS, row[3].split(" | "), strict=True):
            yield sensor, row[1], row[2], hours, value


@pytest.mark.parametrize("sensor", sorted({cell[0] for cell in cells()}))
def test_the_table(sensor):
    (grades,) = re.findall(r"^```toml\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE)
    channels = NoiseModel.from_dict(tomllib.loads(grades)).channels
    assert set(channels) == {cell[0] for cell in cells()}
    noise = dict(channels[sensor].terms)
    own = [cell for cell in cells() if cell[0] == sensor]
    assert len(own) == 12
    for _, letter, unit, hours, shown in own:
        n = round(3600 * hours * RATE)
        if letter == "N":
            found = 100 * relative_error(noise, "random_walk", noise["random_walk"], n=n, tau0=1 / RATE)
        else:
            term = {"B": "bias_instability", "K": "rate_random_walk"}[letter]
            found = smallest_detectable(noise, term, n=n, tau0=1 / RATE, power=0.9) / find(UNITS.get(unit, unit)).factor
        assert float(f"{found:.2g}") == float(shown), (letter, hours)
