"""A small log of three channels, and the command line run on it."""

import functools
import json
from importlib import resources

import jsonschema
import numpy as np

from sigmatau.cli import main

HEADER = "gyro_x [deg/s],gyro_y [deg/s],accel_z [g]"


def table(rows=1200, header=HEADER):
    y = np.random.default_rng(9).standard_normal((rows, 3)) * (0.1, 0.1, 0.01)
    return "\n".join([header, *(",".join(f"{v:.6f}" for v in row) for row in y)]) + "\n"


def run(*argv, capsys):
    code = main([str(a) for a in argv])
    out, err = capsys.readouterr()
    return code, out, err


@functools.cache
def published():
    """Validator of the JSON schema, without the check of the schema itself, which takes a second."""
    text = resources.files("sigmatau").joinpath("schema/result-2.schema.json").read_text()
    return jsonschema.Draft202012Validator(json.loads(text))
