"""Modified, Hadamard, total, time, Theo1, MTIE, TIE rms: known answers, slow twins, identities, laws, statistics."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import known
from sigmatau import Record, allan, deviation
from sigmatau.errors import OptionError
from sigmatau.estimators.deviation_kinds import KINDS


def record(y, rate=1.0):
    return Record.from_arrays(rate=rate, y=y)


def values(given, kind, **options):
    """The deviations of every channel, and `allan` as one of their kinds."""
    if kind == "allan":
        return [array for curve in allan(given, **options).values() for array in (curve.adev, curve.ramp)]
    return [curve.deviation for curve in deviation(given, kind=kind, **options).values()]


def dev(y, kind, m, **options):
    factor = KINDS[kind].tau_per_m
    curve = deviation(record(y), kind=kind, taus=[factor * size for size in m], **options)["y"]
    assert curve.m.tolist() == sorted(m)
    return dict(zip(curve.m.tolist(), curve.deviation, strict=True))


def printed(value, like):
    """To as many digits as the other was printed with."""
    digits = len(f"{like:.10g}".replace(".", "").lstrip("0"))
    return value == pytest.approx(like, rel=0.51 * 10.0 ** (1 - max(digits, 6)))


def phase_of(y):
    return np.concatenate(([0.0], np.cumsum(y)))


def reflected(sequence, m):
    """Mean squared second difference of the means of each 3m points, without their slope and between mirror images."""
    squares = []
    half = 3 * m // 2
    for k in range(len(sequence) - 3 * m + 1):
        part = sequence[k : k + 3 * m]
        slope = (part[-half:].mean() - part[:half].mean()) / (3 * m - half)
        part = part - slope * np.arange(3 * m)
        whole = np.concatenate((part[::-1], part, part[::-1]))
        means = [whole[i : i + m].mean() for i in range(8 * m)]
        squares.append(np.mean([(means[i] - 2 * means[i + m] + means[i + 2 * m]) ** 2 for i in range(6 * m)]))
    return np.mean(squares), len(squares)


# Slow twins, on the phase and with loops, from the definitions of NIST SP 1065.
def twin(kind, y, m):
    x = phase_of(y)
    points = len(x)
    if kind in ("modified", "time"):
        terms = [
            sum(x[i + 2 * m] - 2 * x[i + m] + x[i] for i in range(j, j + m)) / m for j in range(points - 3 * m + 1)
        ]
        value = math.sqrt(np.mean(np.square(terms)) / 2) / m
        return value * (m / math.sqrt(3) if kind == "time" else 1), len(terms)
    if kind == "parabolic":
        # Slopes of lines fitted to adjacent clusters; for one sample, the Allan variance.
        if m == 1:
            return math.sqrt(np.mean(np.diff(y) ** 2) / 2), points - 2
        slopes = [np.polynomial.polynomial.polyfit(np.arange(m), x[k : k + m], 1)[1] for k in range(points - m + 1)]
        terms = [slopes[k + m] - slopes[k] for k in range(points - 2 * m)]
        # The slopes have the factor 12/(m³ − m); the definition has 12/m³.
        return math.sqrt(np.mean(np.square(terms)) / 2) * (1 - 1 / m**2), len(terms)
    if kind in ("modified_total", "time_total"):
        value, terms = reflected(x, m)
        value = math.sqrt(value / 2) / m
        return value * (m / math.sqrt(3) if kind == "time_total" else 1), terms
    if kind == "hadamard_total" and m > 1:
        value, terms = reflected(y, m)
        return math.sqrt(value / 6), terms
    if kind.startswith("hadamard"):
        means = [np.mean(y[k : k + m]) for k in range(len(y) - m + 1)]
        terms = [means[k + 2 * m] - 2 * means[k + m] + means[k] for k in range(len(y) - 3 * m + 1)]
        return math.sqrt(np.mean(np.square(terms)) / 6), len(terms)
    if kind == "total":
        # Of frequencies: the record between its mirror images.
        mirrored = np.concatenate((y[::-1], y, y[::-1]))
        n = len(y)
        terms = [np.mean(mirrored[n + i : n + i + m]) - np.mean(mirrored[n + i - m : n + i]) for i in range(1, n)]
        return math.sqrt(np.mean(np.square(terms)) / 2), len(terms)
    if kind == "theo1":
        total = 0.0
        for i in range(points - m):
            for delta in range(m // 2):
                step = (x[i] - x[i - delta + m // 2]) + (x[i + m] - x[i + delta + m // 2])
                total += step**2 / (m // 2 - delta)
        return math.sqrt(total / (0.75 * (points - m))) / m, (points - m) * m // 2
    moves = [x[k : k + m + 1] for k in range(points - m)]
    if kind == "mtie":
        return max(np.ptp(window) for window in moves), len(moves)
    return math.sqrt(np.mean([(window[-1] - window[0]) ** 2 for window in moves])), len(moves)


# NIST SP 1065, table 31, seven digits: m = 1, 10, 100 (time in the unit of tau0).
NBS14 = {
    "modified": (2.922319e-1, 6.172376e-2, 2.170921e-2),
    "hadamard": (2.943883e-1, 9.581083e-2, 3.237638e-2),
    "total": (2.922319e-1, 9.134743e-2, 3.406530e-2),
    "time": (1.687202e-1, 3.563623e-1, 1.253382e0),
}

# Files of Stable32's results, their column of deviations, and the estimator; five digits.
TABLES = {
    "mdev": ("modified", "full", 5),
    "mdev_octave": ("modified", "full", 5),
    "hdev": ("hadamard", "none", 5),
    "hdev_octave": ("hadamard", "none", 5),
    "ohdev": ("hadamard", "full", 5),
    "ohdev_octave": ("hadamard", "full", 5),
    "totdev_octave": ("total", "full", 5),
    "tdev": ("time", "full", 5),
    "tdev_octave": ("time", "full", 5),
    "mtie": ("mtie", "full", 3),
    "tierms": ("tie_rms", "full", 3),
    "theo1_alpha0": ("theo1", "full", 5),
    "theo1_alpha0_decade": ("theo1", "full", 5),
}


class TestKnownAnswers:
    @pytest.mark.parametrize("kind", NBS14)
    def test_nbs14(self, kind):
        got = dev(known.nbs14(), kind, [1, 10, 100])
        for m, value in zip((1, 10, 100), NBS14[kind], strict=True):
            assert got[m] == pytest.approx(value, rel=0.51e-6), m

    def test_nbs14_disjoint_hadamard(self):
        got = dev(known.nbs14(), "hadamard", [1, 10, 100], overlap="none")
        for m, value in zip((1, 10, 100), (2.943883e-1, 1.052754e-1, 3.910860e-2), strict=True):
            assert got[m] == pytest.approx(value, rel=0.51e-6)

    def test_nbs14_theo1(self):
        """Without removal of the bias; five digits."""
        got = dev(known.nbs14(), "theo1", [10, 100, 1000])
        for m, value in zip((10, 100, 1000), (0.10757, 0.031789, 0.0050524), strict=True):
            assert got[m] == pytest.approx(value, rel=0.5e-4)

    @pytest.mark.parametrize(
        ("kind", "values"),
        [
            ("modified", (91.22945, 74.78849)),
            ("hadamard", (70.80607, 85.61487)),
            ("total", (91.22945, 93.90379)),
            ("time", (52.67135, 86.35831)),
        ],
    )
    def test_nine_points(self, kind, values):
        """NIST SP 1065, table 30."""
        got = dev(known.NINE_POINTS, kind, [1, 2])
        assert [got[1], got[2]] == pytest.approx(values, rel=0.6e-6)

    @pytest.mark.parametrize("name", TABLES)
    def test_phase_dat(self, field_data, name):
        kind, overlap, column = TABLES[name]
        phase = np.loadtxt(field_data / "phasedat" / "PHASE.DAT")
        with (field_data / "phasedat" / f"phase_dat_{name}.txt").open(encoding="utf-8") as file:
            table = np.array([line.split() for line in file if line.strip() and line.split()[0].isdigit()], dtype=float)
        options = {} if kind != "hadamard" else {"overlap": overlap}
        curve = deviation(
            Record.from_arrays(rate=1, phase=phase, unit={"phase": "s"}, input="accumulated"),
            kind=kind,
            taus=table[:, 1],
            **options,
        )["phase"]
        assert curve.m.tolist() == table[:, 0].astype(int).tolist()
        assert curve.deviation == pytest.approx(table[:, column], rel=1.1e-4)  # half a unit of five digits and theirs
        assert curve.n_terms == pytest.approx(table[:, 2], rel=1e-3)
        assert curve.unit == ("s" if KINDS[kind].has_phase_unit else "1")


class TestAgainstTwins:
    @pytest.mark.parametrize("n", [10, 11, 50, 130])
    @pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("theobr", "theoh")])
    def test_every_size(self, kind, n):
        rng = np.random.default_rng(known.seed_of(f"twin {kind} {n}"))
        y = 3.0 + np.cumsum(rng.standard_normal(n))
        y = np.round(y * 1024) / 1024  # sums of the twin are exact
        lasts = {
            "modified": (n + 1) // 3,
            "time": (n + 1) // 3,
            "hadamard": n // 3,
            "total": n - 1,
            "parabolic": n // 2,
        }
        last = lasts.get(kind, lasts.get(kind.removesuffix("_total"), n))
        sizes = range(10, last + 1, 2) if kind == "theo1" else range(1, last + 1)
        factor = KINDS[kind].tau_per_m
        curve = deviation(record(y), kind=kind, taus=[factor * m for m in sizes])["y"]
        assert curve.m.tolist() == list(sizes)
        for m, value, terms in zip(curve.m, curve.deviation, curve.n_terms, strict=True):
            expected, count = twin(kind, y, int(m))
            assert terms == count
            assert value == pytest.approx(expected, rel=1e-11, abs=1e-13)

    def test_allantools(self):
        import allantools

        rng = np.random.default_rng(known.seed_of("allantools"))
        x = np.concatenate(([0.0], np.cumsum(rng.standard_normal(5000))))
        sizes = [1, 2, 5, 16, 100, 1000]
        peers = {
            "modified": allantools.mdev, "hadamard": allantools.ohdev, "total": allantools.totdev,
            "time": allantools.tdev, "mtie": allantools.mtie, "tie_rms": allantools.tierms,
            "parabolic": allantools.pdev,
        }  # fmt: skip
        for kind, peer in peers.items():
            tau, expected, _, _ = peer(x, rate=1.0, data_type="phase", taus=sizes)
            got = dev(np.diff(x), kind, [round(t) for t in tau])
            assert list(got.values()) == pytest.approx(expected, rel=1e-9), kind

    def test_allantools_total(self):
        """Theirs takes N·m steps of Python for each size."""
        import allantools

        x = np.concatenate(([0.0], np.cumsum(np.random.default_rng(known.seed_of("total")).standard_normal(300))))
        peers = {
            "modified_total": allantools.mtotdev, "hadamard_total": allantools.htotdev, "time_total": allantools.ttotdev,
        }  # fmt: skip
        for kind, peer in peers.items():
            tau, expected, _, _ = peer(x, rate=1.0, data_type="phase", taus=[1, 2, 7, 30, 80])
            got = dev(np.diff(x), kind, [round(t) for t in tau])
            assert list(got.values()) == pytest.approx(expected, rel=1e-12), kind

    def test_theobr_and_theoh(self):
        """SP 1065, section 5.2.16: the mean of Allan over Theo1 at τ = 9, 12 … to a tenth of the record."""
        n = 400
        y = np.random.default_rng(known.seed_of("theobr")).standard_normal(n)
        allan_variance = allan(record(y), taus=np.arange(1, 41))["y"].adev ** 2
        ratios = [
            allan_variance[8 + 3 * i] / twin("theo1", y, 12 + 4 * i)[0] ** 2 for i in range(int(40.1 / 3 - 3) + 1)
        ]
        assert len(ratios) == 11
        sizes = np.array([10, 60, 400])
        got = deviation(record(y), kind="theobr", taus=0.75 * sizes)["y"]
        expected = [math.sqrt(np.mean(ratios)) * twin("theo1", y, m)[0] for m in sizes]
        assert got.deviation == pytest.approx(expected, rel=1e-12)
        hybrid = deviation(record(y), kind="theoh", taus="all")["y"]
        assert hybrid.m.tolist() == [*range(1, 41), *range(54, 401, 2)]
        assert hybrid.tau.tolist() == [*range(1, 41), *np.arange(40.5, 301, 1.5)]
        assert hybrid.deviation[:40] ** 2 == pytest.approx(allan_variance, rel=1e-13)
        assert hybrid.deviation[-1] == got.deviation[-1]

    def test_theobr_is_limited(self):
        with pytest.raises(OptionError, match="the limit is 50000 samples"):
            deviation(record(np.zeros(50_001)), kind="theoh")


class TestIdentities:
    def test_modified_of_one_sample_is_allan(self):
        y = np.random.default_rng(known.seed_of("modified of one")).standard_normal(20_000)
        expected = allan(record(y), taus=[1])["y"].adev[0]
        for kind in ("modified", "total"):
            assert dev(y, kind, [1])[1] == pytest.approx(expected, rel=1e-14)

    @pytest.mark.parametrize("overlap", ["full", "none"])
    def test_a_ramp_is_invisible_to_hadamard(self, overlap):
        y = 0.5 + 0.25 * np.arange(3000)
        assert max(dev(y, "hadamard", [1, 7, 100, 1000], overlap=overlap).values()) < 1e-9

    def test_a_ramp_in_parabolic(self):
        """R·τ/√2 for long clusters: 1 − 1/m² of it, from the factor 12/m³ of the definition."""
        got = dev(0.25 * np.arange(3000), "parabolic", [1, 2, 7, 100, 1000])
        for m, value in got.items():
            assert value == pytest.approx(0.25 * m / math.sqrt(2) * (1 - 1 / m**2 if m > 1 else 1), rel=1e-12)

    @pytest.mark.parametrize("kind", ["modified_total", "hadamard_total"])
    def test_a_slope_is_invisible_to_the_reflected_kinds(self, kind):
        """Of the phase for the modified total deviation, of the rate for the Hadamard total deviation."""
        y = np.full(900, 0.5) if kind == "modified_total" else 0.5 + 0.25 * np.arange(900)
        assert max(dev(y, kind, [2, 7, 100, 300]).values()) < 1e-9

    def test_a_ramp_in_modified(self):
        """R·τ/√2, as in the Allan deviation."""
        got = dev(0.25 * np.arange(3000), "modified", [1, 7, 100, 1000])
        assert all(value == pytest.approx(0.25 * m / math.sqrt(2), rel=1e-12) for m, value in got.items())

    def test_a_constant_rate_in_tie(self):
        """MTIE and TIE rms are the angle that it makes; nothing else sees it."""
        rate = 50.0
        gyro = Record.from_arrays(rate=rate, gyro_x=np.full(500, 0.125))
        for kind in KINDS:
            curve = deviation(gyro, kind=kind)["gyro_x"]
            expected = 0.125 * curve.tau if kind in ("mtie", "tie_rms") else 0 * curve.tau
            assert curve.deviation == pytest.approx(expected, rel=1e-12, abs=1e-15)
            assert curve.unit == ("rad" if KINDS[kind].has_phase_unit else "rad/s")

    def test_units_of_velocity(self):
        accel = Record.from_arrays(
            rate=100, accel_x=np.random.default_rng(1).standard_normal(1000), unit={"accel": "g"}
        )
        modified = deviation(accel, kind="modified")["accel_x"]
        time = deviation(accel, kind="time")["accel_x"]
        assert (modified.unit, time.unit) == ("m/s^2", "m/s")
        assert time.deviation == pytest.approx(time.tau / math.sqrt(3) * modified.deviation, rel=1e-15)

    def test_mtie_grows(self):
        y = np.random.default_rng(known.seed_of("mtie grows")).standard_normal(3000)
        curve = deviation(record(y), kind="mtie", taus="eighth")["y"]
        # Each is rounded at the height of the phase.
        assert (np.diff(curve.deviation) >= -1e-13 * curve.deviation[1:]).all()
        assert (curve.deviation >= deviation(record(y), kind="tie_rms", taus="eighth")["y"].deviation).all()

    @pytest.mark.parametrize("kind", ["theo1", "modified", "theobr", "theoh", "modified_total"])
    def test_progress(self, kind):
        record = Record.from_arrays(rate=1.0, a=np.sin(np.arange(200.0)), gyro=np.sin(np.ones((100, 3)) + np.arange(3)))
        parts = []
        deviation(record, kind=kind, progress=parts.append)
        assert parts == sorted(parts)
        assert 0 < parts[0] < 1
        assert parts[-1] == 1

        def stop(part):
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            deviation(record, kind=kind, progress=stop)

    @pytest.mark.parametrize(
        ("kind", "n"), [("allan", 100_000), ("every allan", 20_000), *((k, 40_000) for k in KINDS)]
    )
    def test_threads_do_not_show(self, kind, n):
        y = np.random.default_rng(known.seed_of("threads")).standard_normal((n, 3))
        if kind in ("modified_total", "hadamard_total", "time_total", "theobr", "theoh"):
            y = y[:3000]
        taus = {"theo1": [7.5, 75.0], "every allan": "all"}.get(kind, "octave")
        one, *others = (
            values(Record.from_arrays(rate=1, gyro=y), kind.removeprefix("every "), taus=taus, threads=threads)
            for threads in (1, 2, 3, None)
        )
        assert all(np.array_equal(a, b) for other in others for a, b in zip(one, other, strict=True))


finite = st.floats(-1e6, 1e6, allow_nan=False, width=32)
kinds = st.sampled_from(["allan", *sorted(set(KINDS) - {"theobr", "theoh"})])


class TestLaws:
    @settings(max_examples=80, deadline=None)
    @given(st.lists(finite, min_size=10, max_size=120), st.integers(-8, 8), kinds)
    def test_scale_and_sign(self, y, power, kind):
        factor = -(2.0**power)
        a, b = (values(record(np.array(y) * f), kind)[0] for f in (1.0, factor))
        assert b == pytest.approx(a * abs(factor), rel=1e-14, abs=0)

    @settings(max_examples=80, deadline=None)
    @given(st.lists(finite, min_size=10, max_size=120), kinds.filter(lambda kind: kind != "parabolic"))
    def test_time_reversal(self, y, kind):
        """The parabolic deviation, as published, leaves out the last term: N + 1 − 2m of N + 2 − 2m."""
        a, b = (values(record(np.array(v)), kind)[0] for v in (y, y[::-1]))
        assert b == pytest.approx(a, rel=1e-9, abs=1e-11 * np.abs(y).max())

    @settings(max_examples=60, deadline=None)
    @given(
        st.lists(finite, min_size=10, max_size=120),
        st.floats(-1e3, 1e3),
        st.sampled_from(["modified", "hadamard", "total", "theo1"]),
    )
    def test_a_constant_rate_does_not_show(self, y, offset, kind):
        y = np.array(y)
        a, b = (deviation(record(v), kind=kind)["y"].deviation for v in (y, y + offset))
        assert b == pytest.approx(a, rel=1e-7, abs=1e-9 * (np.abs(y).max() + abs(offset)))
