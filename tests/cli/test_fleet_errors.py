"""What `sigmatau fleet` prints about logs that failed."""

from sigmatau.cli.fleet import _grouped


def test_equal_failures_are_one_line():
    lines = [
        "a.csv: row 7 has 3 fields",
        "b.csv: is empty",
        "c.csv: row 12 has 2 fields",
        "d.csv: row 9 has 4 fields",
        "e",
    ]
    assert _grouped(lines) == [
        "a.csv: row 7 has 3 fields; the same for 2 more logs",
        "b.csv: is empty",
        "e",
    ]
