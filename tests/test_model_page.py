"""docs/how-to/model-file.md: its file is read, has every key, and its commands run."""

import re
import tomllib

import pytest

from conftest import ROOT
from sigmatau import DataError, NoiseModel
from sigmatau.model.file import _OTHER_KEYS
from sigmatau.noise.terms import NOISE, TERMS
from sigmatau.units import find

PAGE = (ROOT / "docs" / "how-to" / "model-file.md").read_text(encoding="utf-8")


def block(language):
    (found,) = re.findall(rf"^```{language}\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE)
    return found


def keys_of(table):
    """Of tables and of the tables within them."""
    for key, value in table.items():
        yield key
        for inner in value if isinstance(value, list) else [value]:
            if isinstance(inner, dict):
                yield from keys_of(inner)


ROWS = [[cell.strip() for cell in row.strip("|").split("|")] for row in PAGE.splitlines() if row.startswith("| `")]
LISTED = [row[0].strip("`") for row in ROWS]
PARTS = {"sigma", "time", "amplitude", "frequency", "width", "order", "corner", "rate", "smoothness"}


def test_the_file_has_every_key_and_the_table_lists_it():
    content = tomllib.loads(block("toml"))
    used = {key for channel in content["channels"].values() for key in keys_of(channel)}
    assert used == {*TERMS, *_OTHER_KEYS, *PARTS}
    assert set(LISTED) == used
    assert len(LISTED) == len(used)
    assert set(NOISE) == set(re.findall(r"`(\w+)`", PAGE.split("## Correlation")[1].split("which both")[0]))


def test_the_file_is_read_as_it_says():
    model = NoiseModel.from_dict(tomllib.loads(block("toml")))
    x = model.channels["gyro_x"]
    assert x["random_walk"] == pytest.approx(5e-3 * find("deg/s").factor / 2**0.5, rel=1e-14)
    assert x["rate_ramp"] < 0
    assert (len(x.gauss_markov), len(x.resonance), len(x.sinusoid)) == (1, 1, 1)
    assert x.alike_from.time == 3600.0
    assert x.turn_on.sigma == pytest.approx(200 * find("deg/h").factor, rel=1e-14)
    assert x.alternatives[0].gauss_markov[0].time == 80.0
    assert (x.bandwidth.order, x.bandwidth.corner, x.bandwidth.rate) == (1, 30.0, 100.0)
    assert model.channels["pressure_a"].unit == "Pa"
    assert model.correlation == {
        "random_walk": {("gyro_x", "gyro_y"): 0.3},
        "bias_instability": {("gyro_x", "gyro_y"): -0.2},
    }
    assert NoiseModel.from_dict(tomllib.loads(model.to_toml())) == model


@pytest.mark.parametrize("row", [row for row in ROWS if row[3]], ids=lambda row: row[0])
def test_the_units_of_the_table_are_taken(row):
    key = row[0].strip("`")
    parts = {
        "sigma": 'gauss_markov = [{{ sigma = "{}", time = "1 s" }}]',
        "time": 'gauss_markov = [{{ sigma = "{si}", time = "{}" }}]',
        "turn_on": 'random_walk = "{si}*1"\nturn_on = {{ sigma = "{}" }}',
        "amplitude": 'sinusoid = [{{ amplitude = "{}", frequency = "1 Hz" }}]',
        "frequency": 'sinusoid = [{{ amplitude = "{si}", frequency = "{}" }}]',
        "width": 'resonance = [{{ sigma = "{si}", frequency = "100 kHz", width = "{}" }}]',
        "rate": 'random_walk = "{si}*1"\nbandwidth = {{ order = 1, corner = "1 Hz", rate = "{}" }}',
        "corner": 'random_walk = "{si}*1"\nbandwidth = {{ order = 1, corner = "{}" }}',
    }
    for channel, si, walk, units in (
        ("gyro_x", "1 rad/s", "1 deg/sqrt(h)", row[3]),
        ("accel_x", "1 m/s^2", "1 m/s/sqrt(h)", row[4]),
    ):
        for unit in units.split(", "):
            form = parts.get(key, f'{key} = "{{}}"' + ('\nsided = "two"' if key == "noise_density" else ""))
            line = form.format(f"1 {unit}", si=si).replace(f"{si}*1", walk)
            assert NoiseModel.from_dict(tomllib.loads(f"[channels.{channel}]\n{line}"))
        with pytest.raises(DataError):
            NoiseModel.from_dict(tomllib.loads(f'[channels.{channel}]\n{key} = "1 kg"'))


@pytest.mark.parametrize(
    "spelling", re.findall(r"`([^`]+)`", PAGE.split("common spellings:")[1].split(". The error")[0])
)
def test_spellings(spelling):
    assert find(spelling)


def test_signals():
    text = '[channels.flow]\nunit = "m/s"\nrandom_walk = "1 (m/s)*sqrt(s)"\nquantization = "1 (m/s)*s"\n'
    text += 'bias_instability = "1 m/s"\nrate_random_walk = "1 m/s/sqrt(s)"\nrate_ramp = "1 m/s/s"'
    assert len(NoiseModel.from_dict(tomllib.loads(text)).channels["flow"]) == 5
