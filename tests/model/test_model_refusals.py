"""What models, processes, imperfections and their users refuse: in words, with the name of the argument."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import DataError, Imperfections, NoiseModel, OptionError, predict, simulate
from sigmatau.model.channel import ChannelModel
from sigmatau.model.file import value_in_si
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid
from sigmatau.simulation.imperfections import Outage, Temperature
from sigmatau.statespace.arma import arma
from sigmatau.statespace.state_space import state_space

WHITE = ChannelModel(terms={"random_walk": 1e-4})
MODEL = NoiseModel(channels={"gyro_x": WHITE})
PROCESS = GaussMarkov(sigma=1.0, time=2.0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            {"terms": {"random_walk": "1"}},
            "random_walk must be a positive number, not '1'; NoiseModel.from_dict takes values with units",
        ),
        ({"terms": {"random_walk": True}}, "random_walk must be a positive number, not True"),
        ({"terms": {"random_walk": np.array([1.0])}}, "random_walk must be a positive number"),
        ({"terms": 3.0}, "`terms` must be a mapping"),
        ({"terms": {"random_walk": 1.0}, "limits": 3.0}, "`limits` must be a mapping"),
        ({"terms": {"random_walk": 1e-300}}, "1e-100 to 1e.100 in SI, not 1e-300"),
        ({"terms": {"random_walk": 1e300}}, "1e-100 to 1e.100 in SI, not 1e.300"),
        ({"terms": {"rate_ramp": -1e300}}, "rate_ramp must be from"),
        ({"terms": {"random_walk": 10**400}}, "random_walk must be a positive number"),
        ({"gauss_markov": PROCESS}, r"`gauss_markov` must be a tuple of GaussMarkov, \(GaussMarkov"),
        ({"gauss_markov": (1.0,)}, "`gauss_markov` must be a tuple"),
        ({"sinusoid": PROCESS}, "`sinusoid` must be a tuple"),
        ({"sinusoid": (PROCESS,)}, "`sinusoid` must be a tuple"),
        ({"terms": {"random_walk": 1.0}, "bandwidth": 30.0}, "`bandwidth` must be a LowPass"),
    ],
)
def test_a_channel(arguments, words):
    with pytest.raises(DataError, match=words):
        ChannelModel(**arguments)


@pytest.mark.parametrize(
    "make",
    [
        lambda v: GaussMarkov(sigma=v, time=1.0),
        lambda v: GaussMarkov(sigma=1.0, time=v),
        lambda v: Sinusoid(amplitude=v, frequency=1.0),
        lambda v: Sinusoid(amplitude=1.0, frequency=v),
        lambda v: LowPass(order=1, corner=v),
        WHITE.scaled,
    ],
)
@pytest.mark.parametrize("value", [1e-300, 1e300, "1", True, math.nan, 0.0, -1.0, None])
def test_numbers_of_processes(make, value):
    with pytest.raises(DataError, match=r"positive number|1e-100 to 1e.100"):
        make(value)


@pytest.mark.parametrize("corner", [1e99, 1e50, 1e13, 1e-10])
def test_a_corner_beyond_any_rate(corner):
    """Products with the sample interval would not be numbers any more."""
    with pytest.raises(DataError, match=r"from 1e-09 to 1e.12 Hz, not 1e.*leave the bandwidth out"):
        LowPass(order=9, corner=corner)


@pytest.mark.parametrize("order", range(1, 10))
@pytest.mark.parametrize(("corner", "dt"), [(1e12, 1e6), (1e12, 0.01), (1e-9, 1e-9), (1e6, 0.01)])
def test_any_corner_at_any_rate(order, corner, dt):
    """White noise of the filter's whole power, N²ω/(2n·sin(π/2n)), where the corner is far above the rate."""
    model = ChannelModel(terms={"random_walk": 1.0}, bandwidth=LowPass(order=order, corner=corner))
    system = state_space(model, dt=dt)
    power = 2 * math.pi * corner / (2 * order * math.sin(math.pi / (2 * order)))
    assert float(system.H[0] @ system.P0 @ system.H[0]) == pytest.approx(power, rel=1e-9)
    m = np.array([1, 10, 1000])
    assert np.isfinite(system.avar(m)).all()
    if corner * dt > 1:
        np.testing.assert_allclose(system.avar(m), power / m, rtol=1e-9)
        record = simulate(
            NoiseModel(channels={"gyro_x": model}), duration=1000 * dt, rate=1 / dt, rng=seed_of("corner")
        )
        assert np.isfinite(record.streams[0].samples.read(0, 0, 1000)).all()
    assert np.isfinite(system.F).all()


@pytest.mark.parametrize("dt", [1e-300, 1e-10, 1e7, 1e300])
def test_steps_that_no_rate_has(dt):
    for call in (state_space, arma):
        with pytest.raises(OptionError, match=r"`dt` must be from 1e-09 to 1e.06 s, not 1"):
            call(WHITE, dt=dt)
    with pytest.raises(OptionError, match=r"`rate` must be from 1e-06 to 1e.09 Hz"):
        predict(MODEL, after=[1.0], rate=1 / dt)


@pytest.mark.parametrize(
    "m", [[2**70], [-(2**70)], [2**63], [1e300], [math.inf], [math.nan], [True], ["a"], [None], [1.5]]
)
def test_cluster_sizes(m):
    for avar in (state_space(WHITE, dt=0.01).avar, lambda m: WHITE.avar(m=m, tau0=0.01)):
        with pytest.raises(OptionError, match=r"`m` must be (whole numbers|at most 9\.0072e\+15) "):
            avar(m)


def test_a_value_beyond_a_double():
    with pytest.raises(OptionError, match="level '1e400 deg/s': is more than a double holds"):
        value_in_si("1e400 deg/s", "rad/s", "level")


def test_numbers_of_numpy_are_numbers():
    kinds = (np.float32(2), np.int64(2), np.float64(2), 2)
    for two in kinds:
        model = ChannelModel(
            terms={"random_walk": two},
            gauss_markov=[GaussMarkov(sigma=two, time=two)],
            sinusoid=(Sinusoid(amplitude=two, frequency=two),),
            bandwidth=LowPass(order=np.int64(2), corner=two),
        )
        assert type(model.terms["random_walk"]) is float
        assert model.gauss_markov == (GaussMarkov(sigma=2.0, time=2.0),)
        assert repr(model) == repr(WHITE.scaled(2e4)) + repr(model)[len(repr(WHITE.scaled(2e4))) :]
        assert Imperfections(lsb={"gyro": two}).lsb == {"gyro": 2}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"lsb": 0.1}, "`lsb` must be by channel or sensor"),
        ({"level": 0.1}, "`level` must be by channel"),
        ({"warm_up": {"gyro": (1, 2)}}, "the warm-up of gyro must be a WarmUp"),
        ({"outages": ((1, 2),)}, "`outages` must be a tuple of Outage"),
        ({"outages": Outage(start=1.0, length=1.0)}, "`outages` must be a tuple of Outage"),
        ({"temperature": 20.0}, "`temperature` must be a Temperature"),
        ({"lsb": {"gyro": 1e-320}}, "1e-100 to 1e.100"),
        ({"saturation": {"gyro": 1e300}}, "1e-100 to 1e.100"),
        ({"level": {"gyro": 1e300}}, "up to 1e.100"),
        ({"jitter": "a"}, "jitter"),
    ],
)
def test_imperfections(arguments, words):
    with pytest.raises(OptionError, match=words):
        Imperfections(**arguments)


@pytest.mark.parametrize("end", ["start", "end"])
def test_there_is_nothing_below_absolute_zero(end):
    assert Temperature(**{"start": 20.0, "end": 20.0, end: -273.0}).swing == 0
    with pytest.raises(OptionError, match=f"at the {end} must be above -273.15"):
        Temperature(**{"start": 20.0, "end": 20.0, end: -300.0})
    with pytest.raises(OptionError, match="`sensitivity`"):
        Temperature(start=20.0, end=20.0, sensitivity=1.0)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"model": {"gyro_x": WHITE}}, "`model` must be a NoiseModel"),
        ({"imperfections": {"lost": 0.1}}, "`imperfections` must be an Imperfections"),
        ({"duration": "a"}, "duration must be a positive number, not 'a'"),
        ({"rate": "a"}, "`rate` must be a positive number of hertz, not 'a'"),
        ({"duration": 1e300, "rate": 1e300}, r"`rate` must be from 1e-06 to 1e\+09 Hz, not 1e\+300"),
        ({"duration": 1e-290, "rate": 1e300}, r"`rate` must be from 1e-06 to 1e\+09 Hz"),
        ({"duration": 1e300}, r"are 1e.302 samples; at most"),
        ({"imperfections": Imperfections(outages=(Outage(start=10.0, length=1.0),))}, "10 s begins after the end"),
        ({"imperfections": Imperfections(outages=(Outage(start=0.0, length=99.0),))}, "99 s covers the whole record"),
    ],
)
def test_simulation(changed, words):
    given = {"model": MODEL, "duration": 10.0, "rate": 100.0, "rng": 1, **changed}
    with pytest.raises(OptionError, match=words):
        simulate(given.pop("model"), **given)


def test_an_outage_up_to_the_end_is_none_of_those():
    outages = (Outage(start=5.0, length=99.0), Outage(start=0.0, length=4.0))
    made = simulate(MODEL, duration=10.0, rate=100.0, rng=1, imperfections=Imperfections(outages=outages))
    assert np.isfinite(made.stream_of("gyro_x").column("gyro_x")).sum() == 102


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"dt": "a"}, "`dt` must be"),
        ({"dt": 0.01, "turn_on": "a"}, "`turn_on` must be"),
        ({"dt": 0.01, "tau_max": "a"}, "`tau_max` must be"),
        ({"dt": 0.01, "flicker_error": "a"}, "`error` must be"),
    ],
)
def test_state_space(arguments, words):
    with pytest.raises(OptionError, match=words):
        state_space(ChannelModel(terms={"bias_instability": 1.0}), **arguments)


def test_a_fast_filter_has_a_default_that_it_can_have():
    assert state_space(ChannelModel(terms={"bias_instability": 1.0}), dt=1e-9).tau_max == pytest.approx(1000.0)
