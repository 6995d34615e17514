"""How-to pages: their commands are ones that the targets take, and what they show is what is written."""

import re
import shlex

import pytest

from conftest import ROOT
from sigmatau.export import Choices, export, target
from sigmatau.model import NoiseModel, value_in_si

TARGETS = ("px4", "ardupilot", "kf-gins", "gnss-ins-sim", "matlab", "gazebo", "ros", "state-space", "ieee952")
SHOWN = ROOT / "python" / "sigmatau" / "data" / "motionpak2.toml"


def commands(page):
    text = (ROOT / "docs" / "how-to" / f"{page}.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```sh\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)
    return [shlex.split(line) for block in blocks for line in block.splitlines()], text


def run(argv, tmp_path):
    """What the command writes for the model of the page."""
    assert argv[:3] == ["sigmatau", "export", "model.toml"]
    options = {}
    for key, value in zip(argv[3::2], argv[4::2], strict=True):
        options.setdefault(key, []).append(value)
    (to,), (path,) = options.pop("--to"), options.pop("-o")
    choices = Choices(
        axes=options.pop("--axes", ["worst"])[0],
        walk=dict(text.split("=") for text in options.pop("--rate-random-walk", [])),
        names=dict(text.split("=") for text in options.pop("--name", [])),
        horizon=value_in_si(options.pop("--horizon")[0], "s", "horizon") if "--horizon" in options else None,
        **{key: float(options.pop(f"--{key}")[0]) for key in ("rate", "step") if f"--{key}" in options},
    )
    assert options == {}
    assert path.endswith((target(to).ending, *target(to).binary))
    return to, export(NoiseModel.read(SHOWN), to=to, path=tmp_path / path, choices=choices)


def code(line):
    """What a program reads of a line: without the comment."""
    return re.split(r"\s*(?:^|\s)[#%] ", line)[0]


@pytest.mark.parametrize("page", TARGETS)
def test_page(page, tmp_path):
    given, text = commands(page)
    written = [run(argv, tmp_path) for argv in given]
    assert {to for to, _ in written} == {page}
    assert "## Why the number differs" in text
    shown = re.findall(r"^```text\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)
    assert len(shown) == (page != "state-space")
    for block in shown:
        rest = iter([code(line) for line in written[0][1].splitlines()])
        for line in block.splitlines():
            assert code(line) in rest, f"{page}: {line}"  # in order; others may be between
