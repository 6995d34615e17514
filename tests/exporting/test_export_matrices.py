"""State space and the sheet of IEEE Std 952: read by json, NumPy, SciPy and a parser of the sheet."""

import io
import json
import math
import re
import zipfile

import numpy as np
import pytest

from sigmatau import DataError, OptionError
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid
from sigmatau.statespace.state_space import StateSpace, state_space

MATRICES = ("F", "G", "H", "Qd", "R", "P0")
DT = 0.01

FULL = ChannelModel(
    terms={
        "quantization": 1e-6,
        "random_walk": 1e-4,
        "bias_instability": 5e-5,
        "rate_random_walk": 1e-6,
        "rate_ramp": -1e-9,
    },
    gauss_markov=(GaussMarkov(sigma=3e-5, time=250.0),),
    sinusoid=(Sinusoid(amplitude=1e-4, frequency=0.37),),
)
NARROW = ChannelModel(
    terms={"random_walk": 1e-3}, bandwidth=LowPass(order=3, corner=20.0), quantity="acceleration", unit="m/s^2"
)
MODEL = NoiseModel(channels={"gyro_x": FULL, "accel_z": NARROW})


def of_json(text):
    systems = json.loads(text, parse_constant=pytest.fail)["systems"]
    return {name: {key: np.array(value) for key, value in content.items()} for name, content in systems.items()}


def of_npz(content):
    found = {}
    with np.load(io.BytesIO(content), allow_pickle=False) as archive:
        for key in archive.files:
            name, part = key.rsplit(".", 1)
            found.setdefault(name, {})[part] = archive[key]
    return found


def of_mat(content):
    from scipy.io import loadmat

    found = {}
    for name, structure in loadmat(io.BytesIO(content)).items():
        if not name.startswith("__"):
            parts = {key: structure[0, 0][key] for key in structure.dtype.names}
            for key in ("states", "inputs"):  # cell arrays of strings
                parts[key] = np.array([str(cell[0]) for cell in parts[key].ravel()])
            found[name] = parts
    return found


FORMS = {".json": of_json, ".npz": of_npz, ".mat": of_mat}


@pytest.mark.parametrize("output", ["rate", "increments", "integrated"])
@pytest.mark.parametrize("ending", FORMS)
def test_matrices_read_back_to_the_same_bits(ending, output, tmp_path):
    path = tmp_path / f"imu{ending}"
    choices = Choices(filter_rate=1 / DT, names={"output": output}, horizon=500.0)
    written = export(MODEL, to="state-space", path=path, choices=choices)
    assert path.read_bytes() == (written if isinstance(written, bytes) else written.encode())
    found = FORMS[ending](written)
    assert sorted(found) == sorted(MODEL.channels)
    for name, channel in MODEL.channels.items():
        system = state_space(channel, dt=DT, output=output, tau_max=500.0)
        for key in MATRICES:
            want = getattr(system, key)
            got = np.asarray(found[name][key], dtype=float).reshape(want.shape)
            assert (got == want).all()
        assert found[name]["states"].tolist() == list(system.states)
        assert found[name]["inputs"].tolist() == list(system.inputs)
        assert float(np.squeeze(found[name]["dt_s"])) == DT
        unit = channel.unit if output == "rate" else f"({channel.unit})*s"
        assert str(np.squeeze(found[name]["unit_of_y"])) == unit


def test_a_filter_of_the_file_has_the_allan_variance_of_the_model():
    found = of_json(export(MODEL, to="state-space", choices=Choices(step=DT)))["gyro_x"]
    system = StateSpace(
        **{key: found[key] for key in MATRICES},
        states=tuple(found["states"]),
        inputs=tuple(found["inputs"]),
        dt=float(found["dt_s"]),
    )
    sizes = [1, 10, 1000, 100_000]
    error = 2.1 * float(found["flicker_error"])  # of the deviation, said in the file
    np.testing.assert_allclose(system.avar(sizes), FULL.avar(m=sizes, tau0=DT), rtol=error)
    assert 0 < error < 0.03


def test_choices_are_in_the_matrices():
    quiet = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    chosen = Choices(step=DT, noise_factor=2.0, walk_factor=3.0, walk={"gyro": 1e-6})
    found = of_json(export(quiet, to="state-space", choices=chosen))["gyro_x"]
    assert found["R"][0, 0] == pytest.approx(4e-8 / DT, rel=1e-12)
    assert found["Qd"][0, 0] == pytest.approx(9e-12 * DT, rel=1e-12)
    slow = of_json(export(MODEL, to="state-space", choices=Choices(step=DT, walk_factor=3.0)))["gyro_x"]
    plain = of_json(export(MODEL, to="state-space", choices=Choices(step=DT)))["gyro_x"]
    slow_states = [not re.match("sinusoid|angle", state) for state in plain["states"]]
    ratio = np.diag(slow["P0"])[slow_states] / np.where(
        np.diag(plain["P0"])[slow_states], np.diag(plain["P0"])[slow_states], 1
    )
    assert ratio[ratio > 0] == pytest.approx(9.0, rel=1e-12)
    assert (slow["R"] == plain["R"]).all()


@pytest.mark.parametrize("form", ["channels", "joint"])
def test_a_random_walk_that_was_chosen_is_in_the_variance_of_a_measurement(form):
    hidden = ChannelModel(terms={"quantization": 1e-6}, limits={"random_walk": 5e-5})
    quiet = NoiseModel(channels={"gyro_x": hidden})
    for chosen, n in ((3e-5, 3e-5), ("upper-limit", 5e-5)):
        choices = Choices(step=DT, noise={"gyro": chosen}, noise_factor=2.0, names={"form": form})
        (found,) = of_json(export(quiet, to="state-space", choices=choices)).values()
        assert found["R"][0, 0] == pytest.approx(4 * n**2 / DT, rel=1e-12)


FOUR = {"quantization": 1e-6, "random_walk": 1e-4, "bias_instability": 5e-5, "rate_random_walk": 1e-6}


class TestJoint:
    @pytest.mark.parametrize("output", ["rate", "increments", "integrated"])
    @pytest.mark.parametrize("term", ["quantization", "random_walk", "bias_instability", "rate_random_walk", "narrow"])
    def test_what_is_shared_is_in_the_sum(self, term, output):
        """σ² of the sum of two channels is that of both and twice ρ times the shared term of them."""
        rho = 0.6
        narrow = term == "narrow"
        term = "random_walk" if narrow else term
        bandwidth = LowPass(order=2, corner=20.0) if narrow else None
        a = ChannelModel(terms=FOUR, bandwidth=bandwidth)
        b = a.scaled(3.0)
        model = NoiseModel(channels={"gyro_x": a, "gyro_y": b}, correlation={term: {("gyro_y", "gyro_x"): rho}})
        choices = Choices(step=DT, names={"form": "joint", "output": output})
        found = of_json(export(model, to="state-space", choices=choices))["joint"]
        assert found["measurements"].tolist() == ["gyro_x", "gyro_y"]
        assert np.linalg.eigvalsh(found["Qd"]).min() > -1e-20
        both = np.ones((1, 2))
        total = StateSpace(
            F=found["F"],
            G=found["G"],
            H=both @ found["H"],
            Qd=found["Qd"],
            R=both @ found["R"] @ both.T,
            P0=found["P0"],
            states=tuple(found["states"]),
            inputs=tuple(found["inputs"]),
            dt=DT,
            output=output,
        )
        sizes = [1, 10, 1000]
        alone = state_space(a, dt=DT, output=output).avar(sizes)
        part = state_space(a.parts()[term], dt=DT, output=output).avar(sizes)
        np.testing.assert_allclose(total.avar(sizes), (1 + 9) * alone + 2 * rho * 3 * part, rtol=1e-9)


def test_state_space_refuses():
    for names, what in (({"output": "angle"}, "output"), ({"form": "both"}, "form")):
        with pytest.raises(OptionError, match=what):
            export(MODEL, to="state-space", choices=Choices(step=DT, names=names))
    with pytest.raises(OptionError, match="step of the filter"):
        export(MODEL, to="state-space")
    with pytest.raises(OptionError, match="so no walk approximates it"):
        export(
            NoiseModel(channels={"gyro_x": {"bias_instability": 1e-5}}),
            to="state-space",
            choices=Choices(step=DT, walk={"gyro": "horizon"}, horizon=10.0, filter_rate=100.0),
        )
    white = NoiseModel(channels={"gyro_x": {"random_walk": 1e-5}})
    with pytest.raises(OptionError, match="no flicker noise"):
        export(white, to="state-space", choices=Choices(step=DT, horizon=10.0))
    with pytest.raises(OptionError, match="every axis separately"):
        export(MODEL, to="state-space", choices=Choices(step=DT, axes="mean"))


HOSTILE = '../gyro"}, "x": {"F\n\\\u2028'


def test_hostile_names(tmp_path):
    model = NoiseModel(channels={f"gyro_{HOSTILE}": {"random_walk": 1e-4}})
    found = of_json(export(model, to="state-space", choices=Choices(step=DT)))
    assert list(found) == [f"gyro_{HOSTILE}"]
    for ending in (".npz", ".mat"):
        with pytest.raises(DataError, match="channel"):
            export(model, to="state-space", path=tmp_path / f"a{ending}", choices=Choices(step=DT))
    assert list(tmp_path.iterdir()) == []
    export(MODEL, to="state-space", path=tmp_path / "a.npz", choices=Choices(step=DT))
    assert all(re.fullmatch(r"[a-z_]+\.\w+\.npy", n) for n in zipfile.ZipFile(tmp_path / "a.npz").namelist())
    sheet = export(NoiseModel(channels={"gyro_x\n\ngyro_y [rad/s]\x85": {"random_walk": 1e-4}}), to="ieee952")
    (name,) = sheet_of(sheet)
    assert re.fullmatch(r"gyro_x..gyro_y \[rad/s\].", name)


TO_SI = {
    "arcsec": math.pi / 180 / 3600,
    "µrad": 1e-6,
    "°/√h": math.pi / 180 / 60,
    "°/h": math.pi / 180 / 3600,
    "(°/h)/√h": math.pi / 180 / 3600 / 60,
    "(°/h)/h": math.pi / 180 / 3600**2,
    "m/s": 1.0,
    "m/s/√h": 1 / 60,
    "µg": 9.80665e-6,
    "m/s²": 1.0,
    "µg/√h": 9.80665e-6 / 60,
    "(m/s²)/√h": 1 / 60,
    "µg/h": 9.80665e-6 / 3600,
    "(m/s²)/h": 1 / 3600,
}


def sheet_of(text):
    """Rows by channel and letter: cells between two blanks or more."""
    found = {}
    for block in text.split("\n\n")[2:]:
        if re.match("No interval: |Cannot be told: |Not in the model: ", block):
            continue
        head, *rows = block.rstrip("\n").split("\n")
        cells = [re.split(r" {2,}", row.strip()) for row in rows]
        found[re.fullmatch(r"(.*) \[.*?\]", head)[1]] = cells
    return found


def test_sheet():
    terms = {
        "quantization": 4.7e-6,
        "random_walk": 2.1e-4,
        "bias_instability": 6.5e-5,
        "rate_random_walk": 1.7e-6,
        "rate_ramp": -3.3e-9,
    }
    intervals = {term: tuple(sorted((0.95 * value, 1.04 * value))) for term, value in terms.items()}
    gyro = ChannelModel(terms=terms, intervals=intervals)
    accel = ChannelModel(terms=terms, intervals=intervals, quantity="acceleration", unit="m/s^2", level=0.9)
    found = sheet_of(export(NoiseModel(channels={"gyro_x": gyro, "accel_x": accel}), to="ieee952"))
    for channel, level in (("gyro_x", "95 %"), ("accel_x", "90 %")):
        letters = {"Q": "quantization", "N": "random_walk", "B": "bias_instability", "K": "rate_random_walk"}
        letters["R"] = "rate_ramp"
        assert {row[0] for row in found[channel]} == set(letters)
        for letter, _, value, interval, si in found[channel]:
            term = letters[letter]
            assert float(si.split()[0]) == terms[term]
            number, unit = value.split(" ")
            size = TO_SI[unit]
            # Printed with as many decimals as give half of the interval, which is 4.5 % of the value, two digits.
            assert float(number) * size == pytest.approx(terms[term], rel=0.051 * 0.045)
            low, high, shown = re.fullmatch(r"\[(.*), (.*)\] \((.*)\)", interval).groups()
            assert shown == level
            assert [float(low) * size, float(high) * size] == pytest.approx(intervals[term], rel=0.051 * 0.045)
    assert [row[2].split(" ")[1] for row in found["gyro_x"]] == ["arcsec", "µrad", "°/√h", "°/h", "(°/h)/√h", "(°/h)/h"]


def test_sheet_of_what_was_not_seen_and_what_is_beside_the_five():
    gyro = ChannelModel(
        terms={"random_walk": 2.1e-4},
        limits={"bias_instability": 1e-5, "rate_random_walk": 2e-6},
        gauss_markov=(GaussMarkov(sigma=3e-5, time=250.0),),
        sinusoid=(Sinusoid(amplitude=1e-4, frequency=0.37),),
        bandwidth=LowPass(order=2, corner=30.0),
    )
    other = ChannelModel(terms={"random_walk": 0.1}, quantity="signal", unit="V")
    found = sheet_of(export(NoiseModel(channels={"gyro_x": gyro, "battery": other}), to="ieee952"))
    rows = {row[0]: row[1:] for row in found["gyro_x"]}
    assert rows["B"] == ["bias instability", "below 2.1 °/h", "not observed (95 %)", "below 1.0e-05 rad/s"]
    assert rows["Q"] == ["quantization", "not in the model"]
    assert rows["N"][2] == "no interval"
    si = {letter: float(row[-1].split()[0]) for letter, row in rows.items() if letter not in "QNBKR"}
    assert si == {"σ1": 3e-5, "Tc1": 250.0, "qc1": 3e-5 * math.sqrt(2 / 250), "Ω1": 1e-4, "f1": 0.37, "fc": 30.0}
    assert found["battery"][1] == ["N", "random walk", "0.1 V*sqrt(s)", "no interval", "0.1 V*sqrt(s)"]
    for choice in (
        {"noise_factor": 2.0},
        {"walk": {"gyro": 1.0}},
        {"noise": {"gyro": 1.0}},
        {"step": 1.0},
        {"axes": "mean"},
    ):
        with pytest.raises(OptionError, match="ieee952"):
            export(NoiseModel(channels={"gyro_x": gyro}), to="ieee952", choices=Choices(**choice))
