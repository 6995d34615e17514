"""Any name a channel may have: what a program reads of a file is that of a file with a plain name."""

import ast
import functools
import re
import xml.etree.ElementTree as ET

from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.model.noise_model import NoiseModel

TERMS = {"random_walk": 1e-4, "bias_instability": 1e-5, "rate_random_walk": 1e-6}

# What ends a comment somewhere, or looks like it, among any characters.
PIECES = st.sampled_from(["\n", "\r", "\x0b", "\x0c", "\x85", "\u2028", "\u2029", "\x00", "-->", "--", "%}", "...", "'",
                          '"', "#", ";", ": ", "]]>", "<x>", "&lt;", "\\n", "{", "\t", "\ud800", "\ufeff"])  # fmt: skip
NAMES = st.lists(st.one_of(PIECES, st.text(max_size=4)), max_size=8).map("".join)


def text(target, name):
    model = NoiseModel(channels={name: TERMS, "accel_x": TERMS})
    written = export(model, to=target, choices=Choices(filter_rate=1.0))
    written.encode()  # no half of a surrogate pair
    return written


def lines(written):
    """As editors and shells split them, at all that anyone takes for the end of a line."""
    return re.split(r"[\n\r\x0b\x0c\x1c-\x1e\x85\u2028\u2029]", written)


READERS = {
    "px4": lambda written: [line for line in lines(written) if not line.startswith("#")],
    "ardupilot": lambda written: [line for line in lines(written) if not line.startswith("#")],
    "kf-gins": lambda written: YAML(typ="safe").load(written),
    "ros": lambda written: YAML(typ="safe").load(written),
    "gnss-ins-sim": lambda written: ast.dump(ast.parse(written)),
    "matlab": lambda written: [re.match(r"((?:[^'%]|'[^']*')*)", line)[1] for line in lines(written)],
    "gazebo": lambda written: [
        (e.tag, (e.text or "").strip(), e.attrib) for e in ET.fromstring(written.encode()).iter()
    ],
}


@functools.cache
def plain(target):
    """What is read of a file with a plain name."""
    return READERS[target](text(target, "gyro_x"))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(ending=NAMES)
def test_a_name_changes_nothing_that_is_read(ending):
    for target, read in READERS.items():
        assert read(text(target, f"gyro_{ending}")) == plain(target), target
