"""Gazebo: a model in SDF with the noise of its IMU, and the parameters of the plugins of RotorS and PX4's SITL.

Its biases are first-order Gauss-Markov processes. Its sensor uses the standard deviation of a sample, N·√rate, and drives
its bias with white noise of density ``dynamic_bias_stddev``², so that the bias has the standard deviation
dynamic_bias_stddev·√(time/2). The plugins use densities.
"""

from __future__ import annotations

import math
import re
from xml.sax.saxutils import quoteattr

from sigmatau.exporting.gauss_markov import (
    OWN_PROCESSES,
    Process,
    noises_and_processes,
    omitted_by_process,
    replaced_noise,
)
from sigmatau.exporting.target import Target
from sigmatau.exporting.text import comment, joined, measured, plain_name
from sigmatau.exporting.turn_on import TURN_ON_NAMES, turn_on, turn_on_axes, unknown_turn_on
from sigmatau.exporting.values import Number, Numbers
from sigmatau.hints import Hint
from sigmatau.results import seconds

_SENSORS = (
    ("gyro", "angular_velocity", "gyroscope", "rad/s"),
    ("accel", "linear_acceleration", "accelerometer", "m/s^2"),
)


def write(numbers: Numbers) -> str:
    """The text of the file."""
    values = noises_and_processes(numbers)
    started = {sensor: turn_on_axes(numbers, sensor, minimum=0.0) or (None, None, None) for sensor, *_ in _SENSORS}
    link = quoteattr(plain_name(numbers.name("link", "imu_link"), "link"))
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<sdf version="1.9">',
        *(_comment("  ", sentence) for sentence in replaced_noise(numbers)),
        *(_comment("  ", sentence) for sentence in omitted_by_process(numbers, has_turn_on=True)),
        '  <model name="imu">',
        f"    <link name={link}>",
        '      <sensor name="imu" type="imu">',
        f"        <update_rate>{numbers.rate_text()}</update_rate>",
        "        <imu>",
    ]
    for sensor, element, _, unit in _SENSORS:
        noise, bias = values[sensor]
        lines += [
            f"          <{element}>",
            _comment(
                "            ", f"stddev: {unit} per sample, N*sqrt(rate), two-sided; {joined(n.words for n in noise)}"
            ),
            _comment(
                "            ",
                f"dynamic bias: {unit}/s/sqrt(Hz), sigma*sqrt(2/time), and s; {joined(b.words for b in bias)}",
            ),
            *(_comment("            ", words) for words in _turn_on_words(unit, started[sensor])),
            *(_axis(numbers.rate(), *row) for row in zip("xyz", noise, bias, started[sensor], strict=True)),
            f"          </{element}>",
        ]
    lines += ["        </imu>", "      </sensor>", "    </link>", *_plugin(numbers, values), "  </model>", "</sdf>"]
    return "\n".join(lines) + "\n"


def _turn_on_words(unit: str, axes: tuple[Number | None, ...]) -> list[str]:
    """Comment on a known turn-on bias."""
    words = joined(number.words for number in axes if number is not None)
    return [f"bias_stddev: {unit}, turn-on bias, which decays with the correlation time; {words}"] if words else []


def _axis(rate: float, axis: str, noise: Number, bias: Process, start: Number | None) -> str:
    turn_on = "" if start is None else f"<bias_mean>0</bias_mean><bias_stddev>{measured(start.value)}</bias_stddev>"
    return (
        f'            <{axis}><noise type="gaussian"><mean>0</mean>'
        f"<stddev>{measured(noise.value * math.sqrt(rate))}</stddev>{turn_on}"
        f"<dynamic_bias_stddev>{measured(bias.density)}</dynamic_bias_stddev>"
        f"<dynamic_bias_correlation_time>{measured(bias.time)}</dynamic_bias_correlation_time></noise></{axis}>"
    )


def _plugin(
    numbers: Numbers, values: dict[str, tuple[tuple[Number, Number, Number], tuple[Process, Process, Process]]]
) -> list[str]:
    if numbers.choices.axes == "each":
        worst = Hint("axes", value="worst")
        return [_comment("    ", f"the plugins of RotorS and PX4 have one number for three axes: {worst} writes them")]
    filename = quoteattr(plain_name(numbers.name("plugin", "libgazebo_imu_plugin.so"), "plugin"))
    lines = [
        _comment(
            "    ",
            "for Gazebo classic with the plugin of PX4 or RotorS, instead of the sensor; delete it for the new Gazebo",
        ),
        f'    <plugin name="imu_plugin" filename={filename}>',
        f"      <linkName>{plain_name(numbers.name('link', 'imu_link'), 'link')}</linkName>",
    ]
    for sensor, _, word, unit in _SENSORS:
        (noise, *_), (bias, *_) = values[sensor]
        start = turn_on(numbers, sensor, minimum=0.0)
        lines += [
            _comment("      ", f"{unit}/sqrt(Hz), N, two-sided; {noise.words}"),
            f"      <{word}NoiseDensity>{measured(noise.value)}</{word}NoiseDensity>",
            _comment("      ", f"{unit}/s/sqrt(Hz), sigma*sqrt(2/time); {bias.words}"),
            f"      <{word}RandomWalk>{measured(bias.density)}</{word}RandomWalk>",
            _comment(
                "      ", f"s, correlation time {seconds(bias.time)} s of a standard deviation {bias.sigma:.4g} {unit}"
            ),
            f"      <{word}BiasCorrelationTime>{measured(bias.time)}</{word}BiasCorrelationTime>",
            _comment(
                "      ",
                f"{unit}; {unknown_turn_on(sensor) if start is None else start.words}",
            ),
            f"      <{word}TurnOnBiasSigma>{'0.0' if start is None else measured(start.value)}</{word}TurnOnBiasSigma>",
        ]
    return [*lines, "    </plugin>"]


def _comment(indent: str, words: str) -> str:
    """An XML comment, which must not contain two hyphens: ``--axes`` becomes ``option axes``."""
    text = re.sub(r"--(?=[a-z])", "option ", comment(words))
    while "--" in text:
        text = text.replace("--", "- -")
    return f"{indent}<!-- {text} -->"


TARGET = Target(
    name="gazebo",
    program="Gazebo (SDF, RotorS, PX4 SITL)",
    columns=("N·√f, N; σ·√(2/Tc), Tc", "`--filter-rate`; `--horizon`, if the curve has no minimum"),
    summary="Gazebo SDF: N*sqrt(rate), a Gauss-Markov bias, by axis; parameters of RotorS' and PX4's plugin",
    ending=".sdf",
    write=write,
    needs_rate=True,
    has_process=True,
    has_horizon=True,
    unused=(OWN_PROCESSES,),
    needs_axes=True,
    per_axis=True,
    names={
        "link": "imu_link",
        "plugin": "libgazebo_imu_plugin.so",
        **TURN_ON_NAMES,
    },
)
