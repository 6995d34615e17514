"""The theory page in a browser: its numbers against those of the package, offline from a file, on a phone, by keys.

The page is made by `make alive`, which needs a toolchain for WebAssembly; without the page, the tests are skipped.
"""

import json
import math
import shutil
import subprocess
import sys
import time
import tomllib

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe

import sigmatau as st
from conftest import ROOT
from known import seed_of
from sigmatau.fitting.likelihood import fit_samples
from sigmatau.model.processes import LowPass
from sigmatau.noise.uncertainty import chi2_factors, degrees_of_freedom

PAGE = ROOT / "target" / "alive" / "index.html"
TERMS = ("quantization", "random_walk", "bias_instability", "rate_random_walk", "rate_ramp")
PHONE = {"viewport": {"width": 390, "height": 844}, "is_mobile": True, "has_touch": True}
LIMIT = 120  # longest time for an answer of a worker [s]

needs_page = pytest.mark.skipif(not PAGE.exists(), reason="no target/alive/index.html: make alive")


@pytest.fixture
def opened(browser):
    """Open the page from its file, without a network; at the end, check that it reported no error and asked for nothing."""
    contexts, complaints = [], []

    def open_page(**options):
        context = browser.new_context(**({"viewport": {"width": 1440, "height": 900}, "offline": True} | options))
        contexts.append(context)
        tab = context.new_page()
        tab.set_default_timeout(1000 * LIMIT)
        tab.on("console", lambda message: complaints.append(f"{message.type}: {message.text}"))
        tab.on("pageerror", lambda error: complaints.append(f"error: {error}"))
        tab.on("request", lambda request: complaints.append(request.url) if is_remote(request.url) else None)
        tab.goto(PAGE.as_uri())
        until(tab, "window.alive && alive.shown.fit")
        return tab

    yield open_page
    for context in contexts:
        context.close()
    assert complaints == []


@pytest.fixture
def plain_log(tmp_path):
    """Write a log: its head, and rows of a time, if there is a step, and white noise."""

    def write(name, head, *, step=0.01, gap=0.0, rows=2000):
        rng = np.random.default_rng(seed_of(name))
        log = tmp_path / name
        times = step * np.arange(rows) + gap * (np.arange(rows) > rows // 2)
        columns = [times, rng.normal(size=rows)] if step else [rng.normal(size=rows)]
        np.savetxt(log, np.column_stack(columns), fmt="%.6f", delimiter=",", header=head, comments="")
        return log

    return write


def is_remote(url):
    return url != PAGE.as_uri() and not url.startswith(("blob:", "data:"))


def until(tab, condition):
    """Wait for a condition; the policy of the page allows no text as code, in which Playwright's own wait consists."""
    end = time.monotonic() + LIMIT
    while not tab.evaluate(f"Boolean({condition})"):
        assert time.monotonic() < end, f"not in {LIMIT} s: {condition}"
        tab.wait_for_timeout(50)


def models(count):
    """Models in SI as the page has them: five terms, Gauss-Markov process, filter, sample interval."""
    rng = np.random.default_rng(seed_of("settings of the theory page"))
    for k in range(count):
        present = rng.random(6) < 0.7
        present[1] |= not present.any()
        sizes = 10 ** rng.uniform([-7, -6, -7, -8, -9, -6], [-4, -3, -4, -5, -6, -3]) * present
        order = k % 3 if present[1] else 0
        rate = float(rng.choice([1, 5, 20, 100, 1000]))
        yield [*sizes, 10 ** rng.uniform(0, 4), order, rate * 10 ** rng.uniform(-1.5, 0.3), 1 / rate]


def channel_model(values):
    """The same model in the package."""
    terms = {name: value for name, value in zip(TERMS, values[:5], strict=True) if value}
    sigma, correlation_time, order, corner, _ = values[5:]
    return st.ChannelModel(
        terms=terms,
        gauss_markov=(st.GaussMarkov(sigma=sigma, time=correlation_time),) if sigma else (),
        bandwidth=LowPass(order=int(order), corner=corner) if order else None,
    )


CURVES = """([model, samples]) => {
    const {sizes, frequencies} = alive.grids(samples, model[9]);
    return {sizes, frequencies, avar: [...alive.call("avar", model, sizes)].slice(0, sizes.length),
            psd: [...alive.call("psd", model, frequencies)].slice(0, frequencies.length)};
}"""


@needs_page
def test_curves_are_those_of_the_package(opened):
    tab = opened()
    largest = 0.0
    for values in models(30):
        shown = tab.evaluate(CURVES, [values, 100_000])
        model, tau0 = channel_model(values), values[9]
        avar = model.avar(m=[int(size) for size in shown["sizes"]], tau0=tau0)
        psd = model.psd(shown["frequencies"], tau0=tau0)
        for name, expected in (("avar", avar), ("psd", psd)):
            got = np.array(shown[name])
            # A density of 0 is that of a filter far above its corner, and of a model of a ramp alone.
            assert (got[expected == 0] == 0).all()
            seen = expected > 0
            largest = max(largest, float(np.abs(got[seen] / expected[seen] - 1).max(initial=0)))
    # The functions of the two mathematical libraries differ in the last bit.
    assert largest <= 1e-12


@needs_page
def test_curves_on_the_figures_follow_the_settings(opened):
    tab = opened()
    for name, unit in (("gyro", math.radians(1) / 3600), ("accel", 9.80665e-6)):
        tab.locator("#sensor").select_option(name)
        tab.locator("#slider-N").fill("260")
        until(tab, "alive.shown.fit")
        shown = tab.evaluate(
            """() => {
                const curve = alive.figures.curve(), density = alive.figures.density();
                return {model: alive.modelNow(), tau: curve.tau, adev: [...curve.all], f: density.f, psd: [...density.all]};
            }"""
        )
        model, tau0 = channel_model(shown["model"]), shown["model"][9]
        adev = model.adev(m=np.rint(np.array(shown["tau"]) / tau0).astype(int), tau0=tau0)
        assert np.array(shown["adev"]) * unit == pytest.approx(adev, rel=1e-12)
        assert np.array(shown["psd"]) * unit**2 == pytest.approx(model.psd(shown["f"], tau0=tau0), rel=1e-12)


RECORDED = """([model, samples, seed]) => {
    alive.call("simulate", model, samples, seed, 10);
    return {rate: [...alive.call("record")], fit: [...alive.call("fit")]};
}"""
RECORDS = [
    [0, 1e-4, 1e-5, 1e-6, 0, 0, 60, 0, 20, 0.01],
    [2e-5, 5e-5, 0, 0, 0, 0, 60, 0, 20, 0.01],
    [0, 1e-4, 0, 0, 0, 1e-4, 60, 0, 20, 0.05],
    [0, 1e-4, 1e-5, 0, 0, 0, 60, 1, 10, 0.01],
    [0, 1e-4, 0, 2e-6, 0, 0, 60, 2, 15, 0.01],
    [0, 1e-4, 0, 0, 3e-7, 0, 60, 0, 20, 0.02],
]


@needs_page
@pytest.mark.parametrize("values", RECORDS)
def test_coefficients_are_those_of_the_package(opened, values):
    tab = opened()
    samples, seed, rate = 100_000, 3, round(1 / values[9])
    got = tab.evaluate(RECORDED, [values, samples, seed])
    model = channel_model(values)
    if not values[7]:  # the generator of filtered noise has other states in the package
        simulated = st.simulate(
            st.NoiseModel(channels={"gyro_x": model}), duration=samples / rate, rate=rate, rng=seed
        ).streams[0]
        expected = np.asarray(simulated.samples.read(0, 0, samples))
        assert np.abs(np.array(got["rate"]) - expected).max() <= 1e-12 * np.abs(expected).max()
    record = st.Record.from_arrays(rate=rate, gyro_x=np.array(got["rate"]))
    fit = fit_samples(record.streams[0], "gyro_x")
    verdict, p_value, tau_min, tau_max = got["fit"][:4]
    assert ["adequate", "adequate_with", "widened"][int(verdict)] == fit.verdict
    assert p_value == pytest.approx(fit.p_value, abs=1e-3)
    assert (tau_min, tau_max) == pytest.approx((fit.tau_min, fit.tau_max), rel=1e-6)
    for k, name in enumerate(TERMS):
        observed, *numbers = got["fit"][4 + 6 * k : 9 + 6 * k]
        term = fit[name]
        assert bool(observed) == term.observed, name
        if term.observed:
            error = 0.01 * (term.high - term.low)
            assert numbers[:3] == pytest.approx([term.value, term.low, term.high], abs=error), name
        else:
            limit = math.nan if term.upper_limit is None else term.upper_limit
            assert numbers[3] == pytest.approx(limit, rel=0.01, nan_ok=True), name
    processes = np.array(got["fit"][39:]).reshape(-1, 2, 3)
    assert len(processes) == len(fit.gauss_markov)
    for numbers, process in zip(processes, fit.gauss_markov, strict=True):
        for ends, of in zip(numbers, (process.sigma, process.time), strict=True):
            assert ends == pytest.approx([of.value, of.low, of.high], abs=0.01 * (of.high - of.low))


@needs_page
def test_estimate_of_the_page_is_that_of_its_record(opened):
    tab = opened()
    shown, again = tab.evaluate(
        """() => {
            const {settings, figures} = alive;
            alive.call("simulate", alive.modelNow(), figures.samples(), settings.seed, 10);
            return [alive.shown.fit.values, [...alive.call("fit")]];
        }"""
    )
    assert len(shown) == len(again) > 30
    assert np.array_equal(np.array(shown, dtype=float), np.array(again, dtype=float), equal_nan=True)


@needs_page
def test_errors_and_lengths_are_those_of_the_package(opened):
    tab = opened()
    values = [0, 1e-4, 2e-5, 1e-6, 0, 0, 60, 0, 20, 0.01]
    coefficients = channel_model(values).terms
    n, sizes = 100_000, [1, 10, 1000, 30_000]
    got = np.array(tab.evaluate("([m, n, s]) => [...alive.call('freedom', m, n, s)]", [values, n, sizes])).reshape(
        -1, 3
    )
    edf = degrees_of_freedom(coefficients, n=n, m=sizes, tau0=0.01)
    assert got[:, 0] == pytest.approx(edf, rel=1e-9)
    for got_factors, factors in zip(got[:, 1:].T, chi2_factors(edf), strict=True):
        assert got_factors == pytest.approx(factors, rel=1e-9)
    # The length for an error: at it, the exact error is the one asked for, to the two digits of the search.
    needed = int(tab.evaluate("m => alive.call('needed', m, 1000, 0.05)[0]", values))
    (edf,) = degrees_of_freedom(coefficients, n=needed, m=[1000], tau0=0.01)
    assert 1 / math.sqrt(2 * edf) == pytest.approx(0.05, rel=0.02)
    kind = {"channel": "gyro_x", "quantity": "angular_rate", "rate_unit": "rad/s"}
    plan = st.plan(coefficients, "rate_random_walk", rate=100, value=1e-6, **kind)
    for power, expected in ((0.5, plan.half_in), (0.9, plan.most_in)):
        seconds = tab.evaluate("([m, p]) => alive.call('visible', m, 3, p)[0]", [values, power]) / 100
        assert seconds == pytest.approx(expected, rel=0.03)


@needs_page
@pytest.mark.parametrize("order", [1, 2])
def test_errors_and_lengths_include_the_filter(opened, order):
    """The scatter of simulated records is the exact error, within three standard errors."""
    tab = opened()
    n, rate, sizes, records = 3000, 20, [1, 2, 5, 20, 100, 1000], 600
    values = [0, 1e-4, 0, 1e-5, 0, 0, 60, order, 1.0, 1 / rate]
    edf = np.array(tab.evaluate("([m, n, s]) => [...alive.call('freedom', m, n, s)]", [values, n, sizes]))[::3]
    model = st.NoiseModel(channels={"gyro_x": channel_model(values)})
    rng = np.random.default_rng(seed_of("errors behind a filter"))
    avar = []
    for _ in range(records):
        log = st.simulate(model, duration=n / rate, rate=rate, rng=rng)
        avar.append(st.allan(log, taus=np.array(sizes) / rate)["gyro_x"].avar)
    squares = (np.array(avar) / model.channels["gyro_x"].avar(m=sizes, tau0=1 / rate) - 1) ** 2
    error = squares.std(axis=0) / math.sqrt(records)
    assert (np.abs(squares.mean(axis=0) - 2 / edf) < 3 * error).all()
    # Without the filter, an error would differ by 15 % or more.
    unfiltered = degrees_of_freedom(channel_model(values).terms, n=n, m=sizes, tau0=1 / rate)
    assert np.abs(np.sqrt(edf / unfiltered) - 1).max() > 0.15
    needed = int(tab.evaluate("m => alive.call('needed', m, 5, 0.05)[0]", values))
    (at_length,) = tab.evaluate("([m, n]) => [alive.call('freedom', m, n, [5])[0]]", [values, needed])
    assert 1 / math.sqrt(2 * at_length) == pytest.approx(0.05, rel=0.02)


@needs_page
def test_line_by_hand_reads_the_coefficient(opened):
    tab = opened()
    tab.get_by_role("button", name="Only N", exact=True).click()
    until(tab, "alive.shown.fit")
    tab.get_by_role("button", name="N −½").click()
    handle = tab.locator(".handle")
    handle.focus()
    assert tab.evaluate("alive.readings.size") == 0  # a reading counts once the line was moved
    assert "That is 1.6 times the chosen 0.15 (+60 %)." in tab.locator(".says").inner_text()  # above the curve at first
    laid = 1.6 * tab.evaluate("alive.settings.value.N")
    for _ in range(24):
        tab.keyboard.press("ArrowDown")
    assert tab.evaluate("alive.readings.get('N')") == pytest.approx(laid / 1.02**24, rel=1e-9)
    assert "N = " in handle.get_attribute("aria-valuetext")
    box = handle.bounding_box()
    tab.mouse.move(box["x"] + 14, box["y"] + 14)
    tab.mouse.down()
    tab.mouse.move(box["x"] + 14, box["y"] - 36, steps=3)
    tab.mouse.up()
    assert tab.evaluate("alive.readings.get('N')") > laid / 1.02**24


@needs_page
@pytest.mark.parametrize("sensor", ["gyro", "accel"])
def test_model_file_is_the_model(opened, sensor):
    tab = opened()
    tab.locator("#sensor").select_option(sensor)
    tab.evaluate("alive.settings.on.sigma = true; alive.settings.order = 2; alive.change()")
    until(tab, "alive.shown.fit && document.querySelector('#model-file').textContent.includes('corner')")
    written = st.NoiseModel.from_dict(tomllib.loads(tab.locator("#model-file").text_content()))
    (channel,) = written.channels.values()
    expected = channel_model(tab.evaluate("alive.modelNow()"))
    assert channel.terms == pytest.approx(dict(expected.terms), rel=1e-12)
    assert channel.gauss_markov[0].sigma == pytest.approx(expected.gauss_markov[0].sigma, rel=1e-12)
    assert channel.gauss_markov[0].time == expected.gauss_markov[0].time
    assert channel.bandwidth == expected.bandwidth


@needs_page
def test_ramp_alone_is_not_estimated(opened):
    tab = opened()
    tab.get_by_role("button", name="Only R", exact=True).click()
    tab.get_by_text("There is no noise to estimate.").wait_for()
    tab.get_by_role("button", name="Only K", exact=True).click()
    until(tab, "alive.shown.fit && alive.shown.fit.estimate && alive.shown.fit.estimate.terms.K.observed")
    tab.get_by_text("in 1 record of this noise").wait_for()
    tab.locator("#again").click()
    tab.get_by_text("in 2 records of this noise").wait_for()


@needs_page
def test_saved_record_gives_the_estimate_of_the_page(opened, tmp_path):
    tab = opened()
    tab.evaluate("Object.assign(alive.settings.value, {rate: 20, hours: 0.5}); alive.change()")
    until(tab, "alive.figures.samples() === 36000 && alive.shown.fit && alive.shown.fit.estimate")
    with tab.expect_download() as download:
        tab.get_by_role("button", name="Save as CSV").click()
    log = tmp_path / "simulated.csv"
    download.value.save_as(log)
    record = st.read(log)
    assert record.streams[0].grid.n == 36_000
    assert record.streams[0].grid.rate == pytest.approx(20, rel=1e-9)
    fit = fit_samples(record.streams[0], "gyro_x")
    shown = tab.evaluate("alive.shown.fit.estimate.terms.Q")
    assert shown["value"] == pytest.approx(fit["quantization"].value, rel=1e-6)  # the file has 12 digits


@needs_page
def test_log_gives_curve_density_and_command(opened, tmp_path):
    tab = opened()
    model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    stream = st.simulate(model, duration=200, rate=50, rng=1).streams[0]
    rate = np.degrees(np.asarray(stream.samples.read(0, 0, stream.grid.n)))
    log = tmp_path / "my log.csv"
    rows = "".join(f"{k / 50:.2f},{x:.9g}\n" for k, x in enumerate(rate))
    log.write_text(f"# a comment\ntime [s],wx [deg/s]\n{rows}", encoding="utf-8")
    tab.locator("#file").set_input_files(log)
    until(tab, "alive.shown.log && alive.shown.curve && alive.shown.density")
    curve = tab.evaluate("alive.shown.curve")
    expected = st.allan(st.Record.from_arrays(rate=50, unit={"gyro": "deg/s"}, gyro_x=rate), taus=curve["tau"])[
        "gyro_x"
    ]
    got = np.radians(np.array(curve["adev"])) / 3600
    assert got[: len(expected.adev)] == pytest.approx(expected.adev, rel=1e-6)  # the log has nine digits
    density = np.radians(1) ** 2 / 3600**2 * np.median(tab.evaluate("[...alive.shown.density.s]"))
    assert density == pytest.approx(1e-8, rel=0.15)  # bands of some hundred values
    assert tab.evaluate("alive.shown.fit") is None
    assert not tab.locator("#estimate").is_visible()
    command = tab.locator("#log pre").inner_text()
    assert command == "sigmatau analyze 'my log.csv' --channels 'gyro_x=wx [deg/s]' --unit gyro=deg/s"
    result = tmp_path / "r.json"
    words = [f"{ROOT}/.venv/bin/{command} --json r.json -q"] if (ROOT / ".venv").exists() else []
    if words:
        subprocess.run(words, shell=True, check=True, cwd=tmp_path)  # the command is one line of a shell
        assert json.loads(result.read_text(encoding="utf-8"))["channels"]["gyro_x"]["samples"] == 10_000
    damaged = tmp_path / "damaged.csv"
    damaged.write_text("t,x\n" + "0,1\n" * 600 + "0,1,2\n", encoding="utf-8")
    tab.locator("#file").set_input_files(damaged)
    tab.get_by_text("Line 602 has 3 values, not 2.").wait_for()


FILTERED = """([order, corner, rate, hours]) => {
    Object.assign(alive.settings.value, {N: 0.3, B: 10, K: 60, corner, rate, hours});
    Object.assign(alive.settings.on, {Q: false, N: true, B: true, K: true, R: false, sigma: false});
    alive.settings.order = order;
    alive.change();
}"""


@needs_page
@pytest.mark.parametrize(("order", "corner"), [(1, 20), (2, 45), (1, 60)])
def test_chosen_noise_behind_a_filter_is_that_of_its_samples(opened, order, corner):
    """Noise above half the rate folds back: the record holds N times `aliasing_inflation`."""
    tab, rate = opened(), 100
    tab.evaluate(FILTERED, [order, corner, rate, 1])
    until(tab, "alive.shown.fit && alive.shown.fit.estimate && alive.figures.samples() === 360000")
    folded = tab.evaluate("alive.shown.folded")
    fold = np.arange(-200_000, 200_001) * rate / corner
    inflation = math.sqrt(np.sum(1 / (1 + fold ** (2 * order))))
    assert folded["white"] / (0.3 * math.radians(1) / 60) == pytest.approx(inflation, rel=1e-4)  # the sum is truncated
    if order == 1 and corner == 20:  # AR(1): 1 + a² − 2a cos 2πf/rate is twice (1 − a)² at the corner of the samples
        a = math.exp(-2 * math.pi * corner / rate)
        half_power = rate / (2 * math.pi) * math.acos((1 + a * a - 2 * (1 - a) ** 2) / (2 * a))
        assert folded["corner"] == pytest.approx(half_power, rel=1e-6)
    row = tab.locator("#coefficients tr", has_text="Angle random walk").inner_text()
    assert f"in the record {0.3 * inflation:.3g}" in row
    assert f"the record holds N = {0.3 * inflation:.3g} deg/√h" in tab.locator("#folding").inner_text()
    assert ("above half the rate, 50 Hz" in tab.locator("#folding").inner_text()) == (corner > rate / 2)


@needs_page
@pytest.mark.parametrize("order", [1, 2])
def test_intervals_behind_a_filter_contain_the_noise_of_the_samples(opened, order):
    tab, records = opened(), 20
    tab.evaluate(FILTERED, [order, 20, 100, 0.25])
    for count in range(1, records + 1):
        tab.get_by_text(f"in {count} record{'s' if count > 1 else ''} of this noise").wait_for()
        if count < records:
            tab.locator("#again").click()
    _, _, holding, _, intervals, *_ = tab.locator("#tally").inner_text().split()
    # Five per record, of which some 95 % hold; below 86 % comes by chance in one of 1000 such counts.
    assert int(intervals) >= 3 * records
    assert int(holding) >= 0.86 * int(intervals)


@needs_page
def test_estimate_is_drawn_with_its_filter(opened):
    tab = opened()
    tab.evaluate(FILTERED, [1, 20, 100, 1])
    until(tab, "alive.shown.fit && alive.shown.fit.curve && alive.figures.samples() === 360000")
    first = tab.evaluate("[alive.shown.fit.curve.y[0], alive.figures.curve().all[0], alive.shown.curve.adev[0]]")
    # Without the filter, σ at one sample is 1.6 times that of the record.
    assert first == pytest.approx([first[2]] * 3, rel=0.01)


@needs_page
def test_missing_process_and_filter_keep_their_rows(opened):
    tab = opened()
    tab.evaluate("""() => {
        Object.assign(alive.settings.value, {sigma: 0.1, time: 10, corner: 900, hours: 0.2});
        alive.settings.on.sigma = true;
        alive.settings.order = 2;
        alive.change();
    }""")
    until(tab, "alive.shown.fit && alive.shown.fit.estimate && alive.figures.samples() === 36000")
    text = tab.locator("#coefficients").inner_text()
    assert "Gauss–Markov σ" in text
    assert "not seen; described by" in text
    assert "not seen: the samples look white" in text


@needs_page
def test_lengths_for_coefficients_are_those_of_the_information(opened):
    """White noise alone: δ = 1/√(2n). With a random walk, estimates of records of this length scatter by the error."""
    tab = opened()
    tab.get_by_role("button", name="Only N", exact=True).click()
    tab.locator("#plan-error").fill("2")
    tab.locator("#plan-error").press("Enter")
    tab.get_by_text("the shortest record").first.wait_for()
    needed = tab.evaluate("alive.lengths(alive.modelNow(), 0.02).N")
    assert needed == pytest.approx(1 / (2 * 0.02**2), rel=0.02)
    values, rate = [0, 1e-4, 0, 1e-5, 0, 0, 60, 0, 20, 0.1], 10
    model, records = channel_model(values), 40
    for letter, name, value, error in (("N", "random_walk", 1e-4, 0.03), ("K", "rate_random_walk", 1e-5, 0.1)):
        needed, fits = tab.evaluate("([m, error]) => alive.lengths(m, error)", [values, error]), []
        for seed in range(records):
            noise = st.NoiseModel(channels={"gyro_x": model})
            stream = st.simulate(noise, duration=needed[letter] / rate, rate=rate, rng=seed).streams[0]
            term = fit_samples(stream, "gyro_x", terms=("random_walk", "rate_random_walk"), processes=())[name]
            fits += [term.value / value] if term.observed else []
        assert len(fits) > 0.9 * records
        # The scatter of 40 records is uncertain by 11 %; a limited search for other parts remains in the fit.
        assert 0.7 < np.std(fits) / error < 1.4


@needs_page
def test_boxes_with_wrong_values_are_marked(opened):
    tab = opened()
    for box, words in (("abc", "τ must be a number"), ("0.001", "from 0.02 s"), ("1e9", "τ must be"), ("100", "")):
        tab.locator("#plan-tau").fill(box)
        tab.locator("#plan-tau").press("Enter")
        is_wrong = words != ""
        assert tab.locator("#plan-tau").get_attribute("aria-invalid") == str(is_wrong).lower()
        if is_wrong:
            assert words in tab.locator("#plan-state").inner_text()
            assert tab.locator("#plan").inner_text() == ""
    tab.get_by_text("eq. (26) asks for").wait_for()
    length = tab.get_by_label("Length, value")
    for typed in ("500", "8"):
        length.fill(typed)
        length.press("Enter")
        until(tab, "alive.settings.value.hours === 5.56")
        assert length.input_value() == "5.56"
        tab.get_by_text("The longest record of this page has 1,000,000 samples").wait_for()


@needs_page
def test_axes_are_drawn_again_after_a_chart_was_hidden(opened):
    tab = opened()
    count = "() => [...document.querySelectorAll('canvas.frame')].map((frame) => frame.toDataURL().length)"
    before = tab.evaluate(count)
    for display, expected in (("none", [len("data:,")] * 4), ("", before)):
        tab.evaluate(
            "(value) => document.querySelectorAll('.plot').forEach((each) => { each.style.display = value; })", display
        )
        end = time.monotonic() + LIMIT
        while tab.evaluate(count) != expected:
            assert time.monotonic() < end, display
            tab.wait_for_timeout(50)
    assert min(before) > 1000


@needs_page
def test_only_keeps_the_filter(opened):
    tab = opened()
    tab.get_by_role("button", name="MEMS").click()
    tab.get_by_role("button", name="Only N", exact=True).click()
    assert tab.evaluate("alive.settings.order") == 2


@needs_page
def test_gap_of_a_log_does_not_change_its_rate(opened, plain_log):
    tab = opened()
    tab.locator("#file").set_input_files(plain_log("gap.csv", "t,gx", gap=5))
    until(tab, "alive.shown.log && alive.shown.curve")
    message = tab.locator("#log p").inner_text()
    assert "2,000 rows at 100 Hz" in message
    assert "A gap of 5.01 s, 10 s after the start" in message
    low, adev, high = tab.evaluate("['low', 'adev', 'high'].map(name => alive.shown.curve[name].at(-1))")
    assert low < 0.7 * adev
    assert high > 2 * adev
    tab.locator("#file").set_input_files(plain_log("digits.csv", "time [ms],gx", step=1 / 0.75))
    until(tab, "alive.shown.log && alive.shown.log.name === 'digits.csv'")
    assert "2,000 rows at 750 Hz" in tab.locator("#log p").inner_text()


@needs_page
def test_refused_log_leaves_no_result(opened, plain_log, tmp_path):
    tab = opened()
    for name, words in (("rateless.txt", "no column of time was found"), ("hello.txt", "No row of numbers was found")):
        tab.locator("#file").set_input_files(plain_log("first.csv", "t,gx"))
        until(tab, "alive.shown.log && alive.shown.curve")
        log = plain_log(name, "gx", step=0) if name == "rateless.txt" else tmp_path / name
        if name == "hello.txt":
            log.write_text("hello", encoding="utf-8")
        tab.locator("#file").set_input_files(log)
        message = tab.get_by_text(words)
        message.wait_for()
        until(tab, "!alive.shown.log && alive.shown.fit")
        assert "first.csv" not in tab.locator("#log").inner_text()
        assert message.bounding_box()["y"] < 900  # on the screen
        assert tab.locator("#estimate").is_visible()


@needs_page
def test_table_of_the_estimate_fits_a_phone(opened):
    tab = opened(**PHONE)
    wide, screen = tab.evaluate(
        "(() => { const each = document.querySelector('#coefficients'); return [each.scrollWidth, each.clientWidth]; })()"
    )
    assert wide <= screen
    assert tab.get_by_role("heading", name="2. See its Allan deviation").is_visible()
    assert tab.get_by_label("Show each term").is_visible()


@needs_page
@pytest.mark.parametrize("options", [{}, {"color_scheme": "dark"}, PHONE, PHONE | {"color_scheme": "dark"}])
def test_page_is_accessible_and_not_wider_than_the_screen(opened, options):
    tab = opened(**options)
    wide, screen = tab.evaluate("[document.documentElement.scrollWidth, document.documentElement.clientWidth]")
    assert wide <= screen
    found = Axe().run(tab).response["violations"]
    assert [f"{each['id']}: {each['nodes'][0]['html'][:120]}" for each in found] == []


def test_modules_are_modules():
    """The scripts are read by node, and their names do not clash in the scope that they share on the page."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node (Node.js)")
    for path in sorted((ROOT / "crates" / "web" / "page").glob("*.js")):
        subprocess.run(
            [node, "--input-type=module", "--check"], input=path.read_text(encoding="utf-8"), text=True, check=True
        )
    sys.path.append(str(ROOT / "scripts"))
    import alive

    for scripts in (alive.OF_PAGE, alive.OF_WORKER):
        subprocess.run([node, "--check", "-"], input=alive.bundled(scripts), text=True, check=True)
