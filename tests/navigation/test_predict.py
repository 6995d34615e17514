"""Predicted navigation errors: closed forms, sums over all samples, and what others' derivations give."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest

from known import seed_of
from sigmatau import DataError, NoiseModel, OptionError, simulate
from sigmatau.model.channel import ChannelModel
from sigmatau.model.parameters import Covariance
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid
from sigmatau.navigation.error_covariance import EARTH_RADIUS
from sigmatau.navigation.predict import predict
from sigmatau.units import STANDARD_GRAVITY

RATE = 100.0
TIMES = np.array([0.5, 10.0, 60.0])
T = 20.0

gyro = lambda terms, **more: NoiseModel(channels={"gyro_z": ChannelModel(terms=terms, **more)})  # noqa: E731


def angle(model, **options):
    return predict(model, after=TIMES, rate=RATE, **options)["heading"]


class TestAngle:
    """Of one gyro, whose angle is the integral of its noise; exact for samples where no reason is given."""

    def test_random_walk(self):
        n = {"random_walk": 1e-4}
        np.testing.assert_allclose(angle(gyro(n)).rms, 1e-4 * np.sqrt(TIMES), rtol=1e-12)
        calibrated = angle(gyro(n), calibration=T)
        np.testing.assert_allclose(calibrated.rms, 1e-4 * np.sqrt(TIMES + TIMES**2 / T), rtol=1e-12)

    def test_quantization(self):
        q = {"quantization": 1e-5}
        np.testing.assert_allclose(angle(gyro(q)).rms, 1e-5 * math.sqrt(2), rtol=1e-9)  # a sum of differences
        share = TIMES / T
        expected = 1e-5 * np.sqrt(1 + (1 + share) ** 2 + share**2)  # e(t) − (1 + t/T)·e(0) + t/T·e(−T)
        np.testing.assert_allclose(angle(gyro(q), calibration=T).rms, expected, rtol=1e-9)

    def test_rate_random_walk(self):
        """K²t³/3, of a walk in steps K²(t³/3 − t²·dt/2 + t·dt²/6) as the first sample is 0."""
        k, dt = 1e-5, 1 / RATE
        found = angle(gyro({"rate_random_walk": k})).std
        np.testing.assert_allclose(found**2, k**2 * (TIMES**3 / 3 - TIMES**2 * dt / 2 + TIMES * dt**2 / 6), rtol=1e-11)
        assert found[-1] == pytest.approx(k * math.sqrt(60.0**3 / 3), rel=1.5 * dt / 60)

    def test_flicker_from_zero(self):
        """(B²t²/π)·∫(2u − 3 + 4e⁻ᵘ − e⁻²ᵘ)u⁻³du = (2·ln2/π)·B²t², over poles of every time; dt/t of it is missing."""
        found = predict(gyro({"bias_instability": 1e-4}), after=[1.0, 10.0, 100.0], rate=RATE, flicker_error=1e-3)
        expected = 1e-4 * math.sqrt(2 * math.log(2) / math.pi) * found.after
        np.testing.assert_allclose(found["heading"].rms / expected, 1.0, atol=0.01)

    def test_flicker_of_records_that_are_simulated(self):
        """Their first sample is 0: E[(Σ(y_k − y_0))²] from the autocovariance of the phase, 4 to 8 times as much."""
        found = predict(gyro({"bias_instability": 1e-4}), after=[1.0, 10.0, 100.0], rate=RATE, flicker_error=1e-3)
        n = np.array([100.0, 1000.0, 10000.0])
        variances = []
        for steps in n:
            at, weights = np.array([0.0, 1.0, steps]), np.array([steps - 1, -steps, 1.0])
            variances.append(1e-8 * weights @ phase_of_flicker(np.abs(at[:, None] - at)) @ weights)
        ratios = np.sqrt(variances) / found["heading"].rms
        np.testing.assert_allclose(found.flicker_in_records, ratios[[0, 2]], rtol=5e-3)
        assert "2.1 to 2.8 times as large" in " ".join(repr(found).split())
        rng = np.random.default_rng(seed_of("predict flicker of records"))
        model = gyro({"bias_instability": 1e-4})
        angles = [
            simulate(model, duration=10.0, rate=RATE, rng=rng).streams[0].column("gyro_z").sum() for _ in range(300)
        ]
        rms = np.sqrt(np.mean(np.square(angles))) / RATE
        assert rms / found["heading"].rms[1] == pytest.approx(ratios[1], rel=3 / np.sqrt(2 * 300))
        assert predict(model, after=10.0, calibration=10.0, rate=RATE).flicker_in_records is None
        assert predict(gyro({"random_walk": 1e-4}), after=10.0, rate=RATE).flicker_in_records is None

    @pytest.mark.parametrize("error", [0.01, 1e-3])
    def test_flicker_after_a_calibration(self, error):
        """The contrast of three phases by the generalised autocovariance of flicker noise, exact for samples."""
        found = angle(gyro({"bias_instability": 1e-4}), calibration=T, flicker_error=error)
        variances = [contrast(t, phase_of_flicker) * 1e-8 for t in TIMES]
        np.testing.assert_allclose(found.rms, np.sqrt(variances), rtol=1.5 * error)
        # 1.5: contrasts other than the Allan variance, which the poles were fitted to.

    def test_all_linear_terms_after_a_calibration(self):
        """The same contrast of the other terms' generalised autocovariances."""
        dt = 1 / RATE
        for term, phase in {
            "quantization": lambda lag: np.where(lag == 0, 1.0, 0.0),
            "random_walk": lambda lag: -dt * lag / 2,
            "rate_random_walk": lambda lag: dt**3 * (lag**3 - lag) / 12,
        }.items():
            found = angle(gyro({term: 1e-4}), calibration=T)
            expected = [1e-4 * math.sqrt(contrast(t, phase)) for t in TIMES]
            np.testing.assert_allclose(found.rms, expected, rtol=1e-9)

    def test_ramp(self):
        """A mean, with its sign: R·t²/2, and the R·T/2 that the calibration takes for a bias."""
        found = angle(gyro({"rate_ramp": -2e-6, "random_walk": 1e-4}))
        np.testing.assert_allclose(found.mean, -1e-6 * TIMES**2, rtol=1e-12)
        np.testing.assert_allclose(found.rms**2, found.std**2 + found.mean**2, rtol=1e-12)
        np.testing.assert_allclose(found.shares["gyro_z", "rate_ramp"], found.mean**2 / found.rms**2, rtol=1e-12)
        calibrated = angle(gyro({"rate_ramp": -2e-6}), calibration=T)
        np.testing.assert_allclose(calibrated.mean, -1e-6 * (TIMES**2 + T * TIMES), rtol=1e-12)
        assert not calibrated.std.any()

    def test_turn_on_bias(self):
        found = angle(gyro({"random_walk": 1e-4}), turn_on={"gyro_z": 1e-3})
        np.testing.assert_allclose(found.rms**2, 1e-8 * TIMES + 1e-6 * TIMES**2, rtol=1e-12)


def contrast(t, phase):
    """Variance of x(t) − x(0) − (t/T)·(x(0) − x(−T)) from a generalised autocovariance of the phase, lags in samples."""
    weights = np.array([t / T, -1 - t / T, 1.0])
    at = np.rint(np.array([-T, 0.0, t]) * RATE)
    return float(weights @ phase(np.abs(at[:, None] - at)) @ weights)


def phase_of_flicker(lag):
    from scipy.special import digamma

    odd = (digamma(np.maximum(lag, 1) - 0.5) + np.euler_gamma + 2 * math.log(2)) / 2  # Σ 1/(2j − 1) to lag − 1
    j = -(4 * lag**2 - 1) / 2 * odd + 2 * lag * (lag - 1) - (lag - 1) ** 2 / 2
    return -(RATE**-2) / (2 * math.pi) * np.where(lag < 2, 0.0, j)


class TestHorizontal:
    def test_white_noise_on_a_flat_earth(self):
        """Velocity g·N·√(t³/3), position g·N·√(t⁵/20) of the gyro; N·√t, N·√(t³/3) of the accelerometer; steps: O(dt/t)."""
        model = NoiseModel(channels={"gyro_y": {"random_walk": 1e-4}, "accel_x": {"random_walk": 1e-3}})
        found = predict(model, after=[100.0], rate=RATE, earth="flat")
        t = 100.0
        of_gyro = {
            "velocity_x": STANDARD_GRAVITY * 1e-4 * math.sqrt(t**3 / 3),
            "position_x": STANDARD_GRAVITY * 1e-4 * math.sqrt(t**5 / 20),
        }
        of_accel = {"velocity_x": 1e-3 * math.sqrt(t), "position_x": 1e-3 * math.sqrt(t**3 / 3)}
        for name in of_gyro:
            error = found[name]
            for channel, expected in (("gyro_y", of_gyro[name]), ("accel_x", of_accel[name])):
                got = error.rms * np.sqrt(error.shares[channel, "random_walk"])
                assert got == pytest.approx(expected, rel=1e-6)
            assert sum(error.shares.values()) == pytest.approx(1.0, abs=1e-12)
        assert found["pitch"].rms == pytest.approx(1e-4 * math.sqrt(t), rel=1e-12)

    def test_schuler(self):
        """A constant bias of a level accelerometer makes b·R/g·(1 − cos ωt) of position, of the gyro R·ε·(t − sin ωt/ω)."""
        hours = np.array([600.0, 2532.0, 5064.0])
        model = NoiseModel(channels={"gyro_x": {"random_walk": 1e-12}, "accel_y": {"random_walk": 1e-12}})
        omega = math.sqrt(STANDARD_GRAVITY / EARTH_RADIUS)
        found = predict(model, after=hours, rate=1.0, turn_on={"accel_y": 1e-3})["position_y"]
        np.testing.assert_allclose(found.rms, 1e-3 / omega**2 * (1 - np.cos(omega * hours)), rtol=1e-6, atol=1e-3)
        found = predict(model, after=hours, rate=1.0, turn_on={"gyro_x": 1e-7})["position_y"]
        np.testing.assert_allclose(found.rms, 1e-7 * EARTH_RADIUS * (hours - np.sin(omega * hours) / omega), rtol=1e-6)

    def test_levelling_takes_a_constant_accelerometer_bias_and_leaves_the_walk(self):
        """N after a calibration: velocity N·√(t + t²/T), as of the angle of a gyro; the accelerometer alone."""
        model = NoiseModel(channels={"accel_x": {"random_walk": 1e-3}})
        found = predict(model, after=TIMES, calibration=T, rate=RATE)
        assert list(found) == ["velocity_x", "position_x"]
        np.testing.assert_allclose(found["velocity_x"].rms, 1e-3 * np.sqrt(TIMES + TIMES**2 / T), rtol=1e-12)
        np.testing.assert_allclose(
            found["position_x"].rms, 1e-3 * np.sqrt(TIMES**3 / 3 + TIMES**4 / (4 * T)), rtol=1e-3
        )

    def test_height_is_unstable(self):
        """A bias upwards grows with cosh(√(2g/R)·t)."""
        model = NoiseModel(channels={"accel_z": {"random_walk": 1e-12}})
        t = np.array([60.0, 1000.0])
        omega = math.sqrt(2 * STANDARD_GRAVITY / EARTH_RADIUS)
        found = predict(model, after=t, rate=1.0, turn_on={"accel_z": 1e-3})
        np.testing.assert_allclose(found["position_z"].rms, 1e-3 / omega**2 * (np.cosh(omega * t) - 1), rtol=1e-9)
        flat = predict(model, after=t, rate=1.0, turn_on={"accel_z": 1e-3}, earth="flat")
        np.testing.assert_allclose(flat["position_z"].rms, 1e-3 * t**2 / 2, rtol=1e-9)


class TestAgainstSums:
    """All terms at once against weights of every sample and their dense covariance: another way to the same number."""

    RATE, T, AFTER = 10.0, 12.0, 15.0

    def covariance(self, model, total):
        """Of the samples, up to a constant, which the weights cancel: from variances of differences."""
        lag = np.abs(np.subtract.outer(np.arange(total), np.arange(total))).astype(float)
        dt, terms = 1 / self.RATE, model.terms
        c = np.zeros((total, total))
        c += terms.get("random_walk", 0.0) ** 2 / dt * (lag == 0)
        c += (terms.get("quantization", 0.0) / dt) ** 2 * (2.0 * (lag == 0) - (lag == 1))
        c -= terms.get("rate_random_walk", 0.0) ** 2 * dt * lag / 2
        from scipy.special import digamma

        odd = np.where(lag > 0, (digamma(lag + 0.5) + np.euler_gamma + 2 * math.log(2)) / 2, 0.0)
        c -= 2 / math.pi * terms.get("bias_instability", 0.0) ** 2 * odd
        for gm in model.gauss_markov:
            c += gm.sigma**2 * np.exp(-lag * dt / gm.time)
        for line in model.sinusoid:
            c += line.amplitude**2 / 2 * np.cos(2 * math.pi * line.frequency * lag * dt)
        return c

    def weights(self, calibration, after, kind):
        """Of each sample in the position (velocity) error; Taylor's half-step in the position."""
        dt = 1 / self.RATE
        k = np.arange(after)
        ahead = dt * np.ones(after) if kind == "velocity" else dt**2 * (after - k - 0.5)
        return np.concatenate((np.full(calibration, -ahead.sum() / calibration), ahead))

    @pytest.mark.parametrize("kind", ["velocity", "position"])
    def test_every_term(self, kind):
        model = ChannelModel(
            terms={"quantization": 3e-4, "random_walk": 1e-3, "bias_instability": 5e-4, "rate_random_walk": 2e-4},
            gauss_markov=(GaussMarkov(sigma=1e-3, time=3.0),),
            sinusoid=(Sinusoid(amplitude=2e-3, frequency=0.13),),
            quantity="acceleration",
            unit="m/s^2",
        )
        found = predict(
            NoiseModel(channels={"accel_x": model}),
            after=[self.AFTER],
            calibration=self.T,
            rate=self.RATE,
            flicker_error=1e-3,
        )[f"{kind}_x"]
        average, ahead = round(self.T * self.RATE), round(self.AFTER * self.RATE)
        w = self.weights(average, ahead, kind)
        for name, part in model.parts().items():
            expected = w @ self.covariance(part, average + ahead) @ w
            got = float(found.rms[0] ** 2 * found.shares["accel_x", name][0])
            assert got == pytest.approx(expected, rel=5e-3 if name == "bias_instability" else 1e-8), name

    def test_bandwidth(self):
        """Over times far beyond its corner, filtered white noise counts with its density at zero, what folds back too."""
        wide = ChannelModel(terms={"random_walk": 1e-3}, bandwidth=LowPass(order=2, corner=20.0))
        found = predict(NoiseModel(channels={"gyro_z": wide}), after=[1000.0], rate=RATE)["heading"]
        density = float(wide.psd(1e-6, tau0=1 / RATE)[0])
        assert found.rms[0] == pytest.approx(math.sqrt(1000.0 * density), rel=1e-4)  # the filter's time over t


@pytest.mark.parametrize(("gyro_across", "axis", "sign"), [("gyro_y", "x", 1.0), ("gyro_x", "y", -1.0)])
def test_correlation_between_a_gyro_and_the_accelerometer_across_it(gyro_across, axis, sign):
    """Of noise that is the same in both, the velocity is that of a(t) ± g·∫ω; −1 takes away what +1 adds."""
    n_g, n_a, t = 1e-4, 1e-2, 10.0
    accel = f"accel_{axis}"
    terms = {gyro_across: {"random_walk": n_g}, accel: {"random_walk": n_a}}
    variances = []
    for rho in (-1.0, 0.0, 1.0):
        model = NoiseModel(channels=terms, correlation={"random_walk": {(accel, gyro_across): rho}} if rho else None)
        found = predict(model, after=[t], rate=RATE, earth="flat")[f"velocity_{axis}"]
        variances.append(found.rms[0] ** 2)
        assert sum(found.shares.values()) == pytest.approx(1.0, abs=1e-12)
    cross = sign * STANDARD_GRAVITY * n_g * n_a * t**2  # 2·∫ n_a·g·n_g·s ds
    assert variances[2] - variances[1] == pytest.approx(cross, rel=1e-3)
    assert variances[1] - variances[0] == pytest.approx(cross, rel=1e-3)


def test_interval_is_that_of_the_coefficients():
    """One term of which the error is known to 5 %: so is the angle; two: by their covariance."""
    terms = {"random_walk": 1e-4, "rate_random_walk": 1e-5}
    covariance = np.diag([(5e-6) ** 2, 0.0])
    model = gyro(terms, covariance=Covariance.of(tuple(terms), covariance))
    found = angle(model, level=0.6826894921370859)  # one standard deviation
    share = found.shares["gyro_z", "random_walk"]
    np.testing.assert_allclose(np.log(found.high / found.rms), 0.05 * share, rtol=1e-9)
    np.testing.assert_allclose(found.low * found.high, found.rms**2, rtol=1e-12)
    assert angle(gyro(terms)).low is None
    partly = gyro({**terms, "quantization": 1e-5}, covariance=Covariance.of(tuple(terms), covariance))
    assert predict(partly, after=1.0, rate=RATE).as_known == (("gyro_z", "quantization"),)


def test_interval_without_covariance():
    """A ramp, which a fit gives with its interval but outside the covariance: 10 % of it is 10 % of its angle."""
    limits = {"rate_ramp": (-2e-6 * (1 + 0.1 * 1.959963984540054), -2e-6 * (1 - 0.1 * 1.959963984540054))}
    found = predict(gyro({"rate_ramp": -2e-6}, intervals=limits), after=60.0, rate=RATE)
    error = found["heading"]
    np.testing.assert_allclose(np.log(error.high / error.rms), 1.959963984540054 * 0.1, rtol=1e-9)
    assert found.as_known == ()
    terms = {"random_walk": 1e-4, "rate_ramp": -2e-6}
    both = gyro(terms, intervals=limits, covariance=Covariance.of(["random_walk"], [[(5e-6) ** 2]]))
    error = predict(both, after=60.0, rate=RATE)["heading"]
    noise, ramp = (float(error.shares["gyro_z", term][0]) for term in terms)
    expected = 1.959963984540054 * math.hypot(0.05 * noise, 0.1 * ramp)
    assert math.log(error.high[0] / error.rms[0]) == pytest.approx(expected, rel=1e-9)


class TestNotSeen:
    def test_terms_at_their_limits(self):
        """By the closed forms: N²t + K²t³/3 of steps, and the ramp's R·t²/2; the last adds to the mean's size."""
        limits = {"rate_random_walk": 1e-5, "rate_ramp": 1e-7, "quantization": 0.0}
        model = gyro({"random_walk": 1e-4}, limits=limits, duration=7200.0)
        found = predict(model, after=TIMES, rate=RATE, level=0.5)
        assert "at its 95 % limit" in repr(found)
        error = found["heading"]
        np.testing.assert_allclose(error.rms, 1e-4 * np.sqrt(TIMES), rtol=1e-12)
        dt = 1 / RATE
        walk = 1e-10 * (TIMES**3 / 3 - TIMES**2 * dt / 2 + TIMES * dt**2 / 6)
        expected = np.sqrt(1e-8 * TIMES + walk + (0.5e-7 * TIMES**2) ** 2)
        np.testing.assert_allclose(error.at_most, expected, rtol=1e-9)
        assert found.not_seen == (("gyro_z", "rate_random_walk"), ("gyro_z", "rate_ramp"))
        text = repr(found)
        assert f"at most {math.degrees(expected[-1]):.3g}" in text
        assert "Not observed in the record, and 0 in the rms: gyro_z rate random walk, rate ramp." in " ".join(
            text.split()
        )
        assert found.to_dict()["errors"]["heading"]["at_most"] == error.at_most.tolist()

    def test_upper_end_and_sign_of_a_ramp(self):
        """What was seen counts with the upper end of its interval, and two ramps with their sizes added."""
        covariance = Covariance.of(["rate_ramp"], [[1e-14]])
        seen = {"gyro_z": ChannelModel(terms={"rate_ramp": -2e-6}, covariance=covariance, limits={"random_walk": 1e-4})}
        error = predict(NoiseModel(channels=seen), after=60.0, rate=RATE)["heading"]
        np.testing.assert_allclose(error.high, error.at_most, rtol=1e-12)
        (bare,) = (replace(channel, limits={}) for channel in seen.values())
        without = predict(NoiseModel(channels={"gyro_z": bare}), after=60.0, rate=RATE)["heading"]
        np.testing.assert_allclose(error.high**2, without.high**2 + 1e-8 * 60, rtol=1e-12)
        np.testing.assert_allclose(error.low, without.low, rtol=1e-12)
        tilted = NoiseModel(
            channels={
                "gyro_y": ChannelModel(terms={"rate_ramp": -2e-6}),
                "accel_x": ChannelModel(
                    terms={"random_walk": 1e-3}, limits={"rate_ramp": 1e-5}, quantity="acceleration", unit="m/s^2"
                ),
            }
        )
        error = predict(tilted, after=60.0, rate=RATE, earth="flat")["velocity_x"]
        more = 0.5e-5 * 60.0**2
        expected = error.rms**2 + 2 * np.abs(error.mean) * more + more**2
        np.testing.assert_allclose(error.at_most**2, expected, rtol=1e-9)

    def test_terms_that_cannot_be_told_apart(self):
        """In the model, with limits and no intervals: from neither of them to both at their limits."""
        terms = {"random_walk": 1e-4, "bias_instability": 1e-6, "rate_random_walk": 1e-6}
        limits = {"bias_instability": 2e-5, "rate_random_walk": 1e-5}
        well = {"intervals": {"random_walk": (0.9e-4, 1.1e-4)}, "limits": limits}
        sure = Covariance.of(["random_walk"], [[0.0]])
        found = predict(gyro(terms, covariance=sure, **well), after=TIMES, rate=RATE, calibration=T)
        error, one = found["heading"], angle(gyro({"random_walk": 1e-4}), calibration=T).rms
        most = angle(gyro({"random_walk": 1e-4, **limits}), calibration=T).rms
        np.testing.assert_allclose(error.low, one, rtol=1e-9)
        np.testing.assert_allclose(error.high, most, rtol=1e-9)
        np.testing.assert_allclose(error.at_most, most, rtol=1e-9)
        assert found.undecided == (("gyro_z", "bias_instability"), ("gyro_z", "rate_random_walk"))
        assert found.as_known == found.not_seen == ()
        assert "the rms contains the best fit: gyro_z bias instability, gyro_z rate random walk." in " ".join(
            repr(found).split()
        )
        assert "at its 95 % limit" in repr(found)
        assert found.to_dict()["undecided"][0] == ["gyro_z", "bias_instability"]
        # With their covariance the interval is that of the sum, here of B alone, and at most is as before.
        covariance = np.diag([0.0, 1e-14, 0.0])
        error = angle(gyro(terms, covariance=Covariance.of(tuple(terms), covariance), **well), calibration=T)
        share = error.shares["gyro_z", "bias_instability"]
        np.testing.assert_allclose(np.log(error.high / error.rms), 1.959963984540054 * 0.1 * share, rtol=1e-9)
        np.testing.assert_allclose(error.at_most, most, rtol=1e-9)

    def test_ramp_that_cannot_be_told_from_a_walk(self):
        """Of unknown sign: at most with its limit's R·t²/2, whatever the fit has."""
        limits = {"rate_ramp": 1e-6, "rate_random_walk": 1e-5}
        model = gyro({"random_walk": 1e-4, "rate_ramp": -1e-7, "rate_random_walk": 1e-7}, limits=limits)
        error = angle(model)
        most = angle(gyro({"random_walk": 1e-4, **limits})).rms
        np.testing.assert_allclose(error.low, angle(gyro({"random_walk": 1e-4})).rms, rtol=1e-9)
        np.testing.assert_allclose(error.high, most, rtol=1e-9)
        np.testing.assert_allclose(error.at_most, most, rtol=1e-9)

    def test_nothing_is_said_without_limits(self):
        found = predict(gyro({"random_walk": 1e-4}), after=60.0, rate=RATE)
        assert found["heading"].at_most is None
        assert "at most" not in repr(found)


def test_tilt_that_is_left_out():
    """gyro_x is not across accel_x: the row says so, and the row of an accelerometer with its gyro does not."""
    channels = {name: {"random_walk": 1e-4} for name in ("gyro_x", "accel_x", "accel_y", "accel_z")}
    found = predict(NoiseModel(channels=channels), after=60.0, rate=RATE)
    rows = {name: " ".join(repr(error).split()) for name, error in found.items()}
    for name in ("velocity_x", "position_x"):
        assert rows[name].endswith("tilt left out: no gyro_y")
        assert found.to_dict()["errors"][name]["tilt_without"] == "gyro_y"
    for name in ("roll", "velocity_y", "position_y", "velocity_z", "position_z"):
        assert "tilt" not in rows[name]


def test_beyond_the_record_and_beyond_the_equations():
    """exp(√(2g/R)·t) of a height after a day is no position; 3 h of a record of 2 h are not measured."""
    channels = {
        "accel_z": ChannelModel(terms={"random_walk": 1e-4}, quantity="acceleration", unit="m/s^2", duration=7200.0)
    }
    found = predict(NoiseModel(channels=channels), after=[60.0, 86400.0], rate=1.0)
    assert max(map(len, repr(found).splitlines())) <= 80
    text = " ".join(repr(found).split())
    minute, day = (row[-1] for row in found["velocity_z"].rows(duration=found.duration))
    assert "beyond the record" not in minute
    assert "beyond the record of 2 h, too large for these equations" in day
    assert "Beyond the 2 h of the record, the noise was not measured" in text
    assert "its error grows e-fold every 9.5 min" in text
    assert "Too large for the equations" in text
    heading = predict(gyro({"random_walk": 1e-2}), after=86400.0, rate=1.0)
    assert heading["heading"].rms[0] > 0.2
    assert "too large" not in repr(heading).lower()
    assert "Beyond" not in repr(heading)


def test_parts_are_called_as_in_an_analysis_and_negative_shares_are_shown():
    terms = {"gyro_y": {"random_walk": 1e-4}, "accel_x": {"random_walk": 1e-2, "rate_random_walk": 1e-3}}
    model = NoiseModel(channels=terms, correlation={"random_walk": {("gyro_y", "accel_x"): -0.9}})
    row = predict(model, after=10.0, rate=RATE)["velocity_x"].rows()[0][-1]
    for words in ("gyro_y angle random walk", "accel_x velocity random walk", "accel_x acceleration random walk"):
        assert words in row
    assert "gyro_y with accel_x random walk -" in row
    assert sum(int(part) for part in re.findall(r"(-?\d+) %", row)) == pytest.approx(100, abs=2)


def test_figure_has_dots_at_the_times_asked_for_and_limits_dashed():
    model = gyro({"random_walk": 1e-4}, limits={"rate_random_walk": 1e-6})
    found = predict(model, after=[1.0, 10.0, 60.0], rate=RATE)
    (ax,) = found.plot(marked=[9.0]).axes
    assert ax.lines[0].get_markevery() == [1]
    np.testing.assert_allclose(ax.lines[1].get_ydata(), np.degrees(found["heading"].at_most))
    (ax,) = predict(model, after=[60.0], rate=RATE).plot().axes
    low, high = ax.get_xlim()
    assert high >= 10 * low


def test_what_is_printed_and_written():
    model = NoiseModel(
        channels={name: {"random_walk": 1e-4, "bias_instability": 1e-5} for name in ("gyro_x", "gyro_z", "accel_y")}
    )
    found = predict(model, after=[60, 600], calibration=300, rate=RATE)
    assert list(found) == ["heading", "roll", "velocity_y", "position_y"]
    text = repr(found)
    assert "heading     60 s " in text
    assert "10 min" in text
    assert "The mean rates of the 5 min before the start are subtracted" in text
    assert "turn_on" in repr(predict(model, after=60, rate=RATE))
    assert "turn-on: gyro_x 206 deg/h, accel_y 1 mg (" in repr(
        predict(model, after=60, rate=RATE, turn_on={"gyro_x": 1e-3, "accel_y": 9.80665e-3})
    )
    content = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert content["errors"]["roll"]["unit"] == "rad"
    assert set(content["errors"]["velocity_y"]["shares"]) == {"gyro_x", "accel_y"}
    assert len(found.plot().axes) == 3
    with pytest.raises(KeyError, match="predicted: heading"):
        found["pitch"]


def test_model_of_one_channel_is_refused():
    with pytest.raises(OptionError, match=r"`model` must be a NoiseModel.*not ChannelModel"):
        predict(ChannelModel(terms={"random_walk": 1.0}), after=1.0, rate=RATE)


def test_signals_that_are_no_sensors():
    volts = ChannelModel(terms={"random_walk": 1.0}, quantity="signal", unit="V")
    with pytest.raises(DataError, match="gyros"):
        predict(NoiseModel(channels={"x": volts}), after=1.0, rate=RATE)
    with pytest.raises(OptionError, match="x is neither a gyro nor an accelerometer"):
        predict(NoiseModel(channels={"x": volts}), after=1.0, rate=RATE, turn_on={"x": 1.0})
    lone = NoiseModel(channels={"gyro_a": {"random_walk": 1e-4}, "accel_up": {"random_walk": 1e-4}})
    assert list(predict(lone, after=1.0, rate=RATE)) == ["angle_a", "velocity_up", "position_up"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"after": 0.0}, "`after`"),
        ({"after": [1.0, math.nan]}, "`after`"),
        ({"after": []}, "`after`"),
        ({"after": 1.0, "rate": 0.0}, "`rate`"),
        ({"after": 1.0, "calibration": 0.0}, "`calibration`"),
        ({"after": 1.0, "earth": "hollow"}, "hollow"),
        ({"after": 1.0, "turn_on": {"gyro_q": 1.0}}, "no channel 'gyro_q'"),
        ({"after": 1.0, "turn_on": {"gyro_z": -1.0}}, "standard deviation"),
        ({"after": 1.0, "turn_on": {"gyro_z": 1.0}, "calibration": 1.0}, "one of the two"),
        ({"after": 1.0, "level": 1.0}, "`level`"),
        ({"after": "a"}, "`after` must be one or more times in s, not 'a'"),
        ({"after": 1.0, "rate": "a"}, "`rate` must be a positive number of hertz, not 'a'"),
        ({"after": 1.0, "rate": True}, "`rate` must be a positive number of hertz, not True"),
        ({"after": 1.0, "calibration": "a"}, "`calibration` must"),
        ({"after": 1.0, "turn_on": ["gyro_z"]}, "`turn_on` must be a mapping"),
    ],
)
def test_wrong_options(options, words):
    with pytest.raises(OptionError, match=words):
        predict(gyro({"random_walk": 1.0}), **{"rate": RATE, **options})
