"""Read every layout of the corpus like its owner: ``python tests/layouts/run.py [PROGRAM]``, see ``--help``.

The first command is ``PROGRAM analyze FILE`` with the layout's first options. A question (exit code 2) is answered with
the options that its message proposes, if any, otherwise with those of the layout. The numbers come from ``--json``. A row
of the table has one of these grades:

- ``at once``: the first command is right.
- ``suggested``: right with the options that the message proposes.
- ``asked``: the file lacks what is asked for, and the layout's options are right; or a refusal is right.
- ``misled``: as ``asked``, but the options that the message proposes do not work.
- ``refused``: the file states all, or the options that answer the question do not work.
- ``WRONG``: exit code 0 with a wrong rate, mean or random walk, with exchanged or missing channels, or for a moving sensor.
"""

import argparse
import collections
import dataclasses
import importlib
import json
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from generator import LAYOUTS
from recording import Layout

LONGEST_MESSAGE = 220  # characters of a message in the table
SUGGESTIONS = 3  # proposals of a message that are followed, one after another
RATE_TOLERANCE = 0.005  # relative
WALK_TOLERANCE = 0.10  # relative tolerance; a random walk is wrong beyond it and 1.5 half widths of its interval
WALK_HALF_WIDTHS = 1.5
MEAN_TOLERANCE = 0.02  # relative tolerance, in addition to six standard errors and a tenth of a step of the file

OPTION = re.compile(
    r"--(?P<name>channels|unit|rate|topic|scale|offset|input|skip|layout)[ =](?P<value>(?:\"[^\"]*\"|'[^']*'|[^\s;)]+)"
    r"(?: [\w.]+=[^\s;)]+)*)"
)
EXAMPLE = re.compile(r"(?:e\.g\.|for example|such as)(?: by| with)?\s*$")
ALTERNATIVE = re.compile(r"\bor(?: by| with)?\s*$")
PLACEHOLDER = re.compile(r"^(?:[A-Z]{2,}|N)$|…|<|\.\.\.|=(?:[A-Z]{2,}|N)\b|=\?")
PAIRS = ("channels", "unit", "scale", "offset")  # options whose values are NAME=VALUE
OF_THE_FILE = (
    "channels",
    "topic",
    "skip",
)  # options that name parts of the file, which an owner copies even from an example
GRADES = ("at once", "suggested", "asked", "misled", "refused", "WRONG")


@dataclasses.dataclass(frozen=True)
class Answer:
    """Result of the program for a file: exit code, standard error, and the JSON if it wrote one."""

    code: int
    message: str
    result: dict[str, object]


@dataclasses.dataclass(frozen=True)
class Verdict:
    """Grade of a layout, its reason, and the options of the last command."""

    grade: str
    reason: str
    options: tuple[str, ...] = ()


def analyze(program: list[str], path: Path, options: tuple[str, ...]) -> Answer:
    """Run the program once."""
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "result.json"
        done = subprocess.run(
            [*program, "analyze", str(path), *options, "--json", str(output)],
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )
        result = json.loads(output.read_text()) if output.exists() else {}
    return Answer(done.returncode, done.stderr.replace(str(path), path.name), result)


def find_suggestion(message: str) -> tuple[str, ...]:
    """Options that a message proposes literally, without units, rates and scales that are examples or alternatives."""
    options: dict[str, str] = {}
    example_end = -1
    for match in OPTION.finditer(message):
        name, value = match["name"], match["value"].rstrip(".,:")
        if ALTERNATIVE.search(message[: match.start()]):
            continue
        if EXAMPLE.search(message[: match.start()]) or not message[max(example_end, 0) : match.start()].strip():
            example_end = match.end() if name not in OF_THE_FILE else -1
            if example_end > 0:
                continue
        if PLACEHOLDER.search(value) or (name in PAIRS and "=" not in value):
            continue
        if re.match(
            r"\s*(?:\(or|and)\b", message[match.end() :]
        ):  # "--unit time=s (or ms)", "--channels x=4, and name all …"
            continue
        if name in options and options[name] != value and name != "unit":
            return ()
        present = options.get(name)
        options[name] = value if present in (None, value) else f"{present} {value}"
    flat: list[str] = []
    for name, value in options.items():
        words = shlex.split(value)
        keys = [word.partition("=")[0] for word in words]
        if name not in PAIRS or len(set(keys)) == len(keys):  # "--unit time=ms, --unit time=s or …" are alternatives
            flat += [f"--{name}", *words]
    return tuple(flat)


def merge_options(options: tuple[str, ...], further: tuple[str, ...]) -> tuple[str, ...]:
    """Join options; those that are given again replace the earlier ones, except units."""
    names = {word for word in further if word.startswith("--") and word != "--unit"}
    words: list[str] = []
    dropped = False
    for word in options:
        dropped = word in names if word.startswith("--") else dropped
        if not dropped:
            words.append(word)
    return (*words, *further)


def vary_answers(answers: tuple[tuple[str, ...], ...], present: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Expand answers: without columns that are already chosen, and without units that the program may already know."""
    attempts: list[tuple[str, ...]] = []
    for answer in answers:
        pairs = dict(zip(answer[::2], answer[1::2], strict=True))
        if "--channels" in present:
            pairs.pop("--channels", None)
        units = pairs.get("--unit", "").split(",")
        for without in ((), ("time",), ("accel",), ("accel", "time")):
            rest = [unit for unit in units if unit.partition("=")[0] not in without]
            varied = {**pairs, "--unit": ",".join(rest)}
            attempts.append(tuple(word for pair in varied.items() if pair[1] for word in pair))
    return list(dict.fromkeys(attempt for attempt in attempts if attempt))


def check_result(described: Layout, answer: Answer) -> str:
    """Describe the fault of the numbers of a finished analysis; empty if they are correct."""
    if described.motion:
        return "a moving record has exit code 0"
    channels = {
        name: data
        for name, data in answer.result.get("channels", {}).items()
        if data.get("quantity") in ("angular_rate", "acceleration")
    }
    surplus = sorted(set(channels) - set(described.channels))
    if surplus:
        return f"channels that the file does not have: {', '.join(surplus)}"
    text = json.dumps(answer.result.get("findings", [])) + answer.message
    for channel in described.channels:
        if channel not in channels:
            if channel in text or f"{channel[:-2]} " in text:
                continue
            return f"{channel} is missing without a finding"
        reason = check_channel(described, channel, channels[channel])
        if reason:
            return f"{channel}: {reason}"
    return ""


def check_channel(described: Layout, channel: str, data: dict) -> str:
    """Describe the fault of a channel: its rate, its mean, or its random walk."""
    rate, right_rate = data["sample_rate_hz"], described.rate_of(channel)
    if abs(rate / right_rate - 1) > RATE_TOLERANCE:
        return f"{rate:.5g} Hz, not {right_rate:g} Hz"
    walk = described.random_walk(channel)
    mean, right_mean = data["mean"]["value"], described.mean(channel)
    step = described.gyro_step if channel.startswith("gyro") else described.accel_step
    margin = 6 * walk / described.seconds**0.5 + MEAN_TOLERANCE * abs(right_mean) + 0.1 * step
    if abs(mean - right_mean) > margin:
        return f"mean {mean:.4g}, not {right_mean:.4g} (SI)"
    term = ((data.get("fit") or {}).get("terms") or {}).get("random_walk") or {}
    if not term.get("observed"):
        limit = term.get("upper_limit")
        return f"random walk below {limit:.3g}, not {walk:.3g}" if limit is not None and limit < 0.9 * walk else ""
    value, half_width = term["value"], (term["high"] - term["low"]) / 2
    if abs(value - walk) > WALK_HALF_WIDTHS * half_width and abs(value / walk - 1) > WALK_TOLERANCE:
        return f"random walk {value:.3g} ± {half_width:.2g}, not {walk:.3g}"
    return ""


def is_right(described: Layout, answer: Answer) -> bool:
    """Whether an answer needs no further command."""
    if described.motion:
        return answer.code == 5
    return answer.code == 0 and not check_result(described, answer)


def first_line(answer: Answer) -> str:
    """Return the exit code and the first line of the message, or the last line of a traceback."""
    lines = [line for line in answer.message.splitlines() if line.strip()] or [""]
    text = lines[-1] if lines[0].startswith("Traceback") else lines[0].removeprefix("sigmatau: ")
    return f"exit {answer.code}: {text if len(text) <= LONGEST_MESSAGE else text[:LONGEST_MESSAGE] + '…'}"


def follow_suggestions(
    options: tuple[str, ...], answer: Answer, path: Path, program: list[str], fixed: tuple[str, ...] = ()
) -> tuple[tuple[str, ...], Answer]:
    """Run the program with the options that its messages propose until there are no new ones; return the last options and
    answer.

    A proposal that replaces one of the options `fixed`, units apart, is not followed.
    """
    for _ in range(SUGGESTIONS):
        proposed = find_suggestion(answer.message) if answer.code == 2 else ()
        if set(proposed) <= set(options) or merge_options(fixed, proposed) != (*fixed, *proposed):
            break
        options = merge_options(options, proposed)
        answer = analyze(program, path, options)
    return options, answer


def judge(described: Layout, path: Path, program: list[str]) -> Verdict:
    """Run the commands that an owner of the file would run, and grade the answers."""
    question = analyze(program, path, described.options)
    options, answer = follow_suggestions(described.options, question, path, program)
    followed = options != described.options
    if answer.code == 0 and (reason := check_result(described, answer)):
        return Verdict("WRONG", f"obeyed: {reason}" if followed else reason, options)
    if "Traceback" in answer.message:
        return Verdict("refused", first_line(answer), options)
    if not described.readable:
        return Verdict("asked", first_line(question))
    if is_right(described, answer):
        return Verdict("suggested" if followed else "at once", "", options)
    if described.asks and not described.answers and answer.code in (1, 2):
        return Verdict("asked", first_line(question))
    attempts = [(True, reply) for reply in vary_answers(described.answers, options)] if followed else []
    attempts += [(False, reply) for reply in vary_answers(described.answers, described.options)]
    texts = [first_line(question)]
    for obeying, reply in attempts:
        command = merge_options(options if obeying else described.options, reply)
        command, last = follow_suggestions(command, analyze(program, path, command), path, program, fixed=reply)
        if last.code == 0 and (reason := check_result(described, last)):
            return Verdict("WRONG", f"{'obeyed and ' if obeying else ''}answered: {reason}", command)
        if is_right(described, last):
            if followed and not obeying and answer.code != 0:
                proposed = shlex.join(options[len(described.options) :])
                return Verdict("misled", f"proposed {proposed}", command)
            if described.asks and question.code == 2:
                return Verdict("asked", described.asks, command)
            return Verdict("refused", f"states all, but {first_line(question)}", command)
        texts.append(first_line(last))
    return Verdict("refused", " | then ".join(texts[:2]), options)


def main() -> None:
    """Write the files, run the program on each, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("program", nargs="?", default=".venv/bin/sigmatau")
    parser.add_argument("--folder", type=Path, help="where the files are written (default: a temporary folder)")
    parser.add_argument("--only", nargs="+", default=[], help="names of layouts")
    parser.add_argument("--module", help="layouts of a module of studies/layouts, such as blind, instead of the corpus")
    arguments = parser.parse_args()
    layouts = LAYOUTS
    if arguments.module:
        sys.path.append(str(Path(__file__).resolve().parents[2] / "studies" / "layouts"))
        named = vars(importlib.import_module(arguments.module)).values()
        layouts = tuple(value for value in named if isinstance(value, Layout))
    program = [str(Path(arguments.program).resolve())]
    counts: collections.Counter[str] = collections.Counter()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        chosen = [described for described in layouts if not arguments.only or described.name in arguments.only]
        for described in chosen:
            place = folder / described.name
            place.mkdir(parents=True, exist_ok=True)
            verdict = judge(described, described.save(place), program)
            counts[verdict.grade] += 1
            used = shlex.join(verdict.options).replace(str(folder), "")
            print(
                f"{described.name:28} {verdict.grade:10} {verdict.reason}{'  [' + used + ']' if used else ''}",
                flush=True,
            )
    print()
    print(f"{len(chosen)} layouts: " + ", ".join(f"{counts[grade]} {grade}" for grade in GRADES))
    sys.exit(1 if counts["WRONG"] else 0)


if __name__ == "__main__":
    main()
