"""No quantile is written as a number: an interval has the level that was asked for."""

import io
import re
import tokenize
from pathlib import Path

import numpy as np
import pytest

from sigmatau._native.distributions import chi2_quantile_above, normal_quantile, student_quantile

ROOT = Path(__file__).parents[1]
LEVELS = (0.9, 0.95, 0.9545, 0.99, 0.9973, 0.999)
MIN_DIGITS = 3  # of a number that could be a quantile


def quantiles():
    """Quantiles of both sides and of one: of the normal, of χ² with 1 and 2 degrees and of the square of t with 7."""
    probability = np.array(LEVELS)
    normal = np.concatenate([normal_quantile(0.5 + 0.5 * probability), normal_quantile(probability)])
    chi2 = np.concatenate([chi2_quantile_above(k, 1 - probability) for k in (1, 2)])
    return np.concatenate([normal, normal**2, chi2, student_quantile(7, 0.5 + 0.5 * probability) ** 2])


QUANTILES = quantiles()


def is_quantile(text):
    """Whether a number is a quantile to all digits that are written."""
    digits = text.replace("_", "").removesuffix("f64").removesuffix("f32")
    if not re.fullmatch(r"\d+\.\d+", digits) or len(digits.replace(".", "").strip("0")) < MIN_DIGITS:
        return False
    half = 0.5 * 10.0 ** -len(digits.split(".")[1])
    return bool(np.any(np.abs(QUANTILES - float(digits)) <= half * (1 + 1e-9)))


def in_python(text):
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return [(t.start[0], t.string) for t in tokens if t.type == tokenize.NUMBER and is_quantile(t.string)]


def in_rust(text):
    """Those of a file without its tests, which compare with tables, and without comments."""
    code = re.split(r"#\[cfg\(test\)\]\n(?:#\[.*\n)*mod ", text)[0]
    return [
        (k, number)
        for k, line in enumerate(code.splitlines(), 1)
        for number in re.findall(r"(?<![\w.])\d[\d_]*\.\d[\d_]*(?:f64|f32)?", line.split("//")[0])
        if is_quantile(number)
    ]


def sources():
    yield from (path for path in sorted(ROOT.glob("python/**/*.py")))
    yield from (path for path in sorted(ROOT.glob("crates/*/src/**/*.rs")) if "tests" not in path.stem)


def test_no_quantile_is_a_number():
    found = []
    for path in sources():
        text = path.read_text()
        where = in_rust(text) if path.suffix == ".rs" else in_python(text)
        found += [f"{path.relative_to(ROOT)}:{line}: {number}" for line, number in where]
    assert not found, "compute it from the level: " + ", ".join(found)


@pytest.mark.parametrize(
    "number", ["1.96", "1.959964", "1.645", "2.576", "2.58", "3.84", "3.841", "5.591", "2.706", "5.99", "6.63", "1.28"]
)
def test_quantiles_are_refused(number):
    assert in_python(f"width = {number} * error\n") == [(1, number)]
    assert in_rust(f"let a = 0.5;\nlet width = {number} * error;\n") == [(2, number)]


def test_other_numbers_and_tables_pass():
    assert in_python("a = 1.9\nb = 2.5\nc = 3.14\nd = 1.95\n'1.96'  # 1.96\n") == []
    assert in_rust("let a = 1.4826; // 1.96\n#[cfg(test)]\nmod tests { const Z: f64 = 1.96; }\n") == []
