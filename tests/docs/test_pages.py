"""Every code block of the pages runs, and shows what it printed; what stands in the text is there too."""

import re
import shlex
import tomllib
from itertools import pairwise

import pytest
from pages import (
    RUN,
    SHOWN,
    UNRUN,
    BrokenPageError,
    blocks,
    excerpt,
    program_of,
    prose,
    run_page,
    statements,
    without_comments,
)

from conftest import ROOT
from sigmatau.cli.app import EXAMPLES, app

PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("**/*.md")])
TEXTS = {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8") for path in PAGES}
BLOCKS = {name: blocks(text) for name, text in TEXTS.items()}
RUN_ELSEWHERE = ("docs/tutorial/README.md",)  # by test_tutorial.py
RUNNING = [name for name in TEXTS if any(block.language in RUN for block in BLOCKS[name]) and name not in RUN_ELSEWHERE]
COMMANDS = [
    (name, statement)
    for name in TEXTS
    for block in BLOCKS[name]
    if block.language == "sh"
    for statement in statements(block.content)
]


@pytest.mark.parametrize("name", RUNNING)
def test_page(name, tmp_path):
    run_page(ROOT / name, tmp_path).check()


GUIDE = {without_comments(statement).strip() for name, statement in COMMANDS if name == "docs/guide.md"}


@pytest.mark.parametrize("command", EXAMPLES)
def test_examples_of_help(command, tmp_path, monkeypatch):
    """In the folder of the guide, which runs some of the commands itself."""
    monkeypatch.setattr("sigmatau.cli.demo._HOURS", 0.05)  # two hours are in docs/paper/units.md
    further = [line for line in statements(EXAMPLES[command]) if without_comments(line).strip() not in GUIDE]
    examples = "\n".join(further).replace("--idle 60", "--idle 0.2 --every 0.1")
    examples = examples.replace("--hours 2 --rate 100", "--hours 0.1 --rate 100")
    examples = re.sub(r"(sigmatau app\b.*)", r"\1 --help", examples)  # it would wait for a page
    run_page(ROOT / "docs" / "guide.md", tmp_path, f"```sh\n{examples}\n```\n")


# Pages with text blocks that are no output, or whose output is checked elsewhere.
OTHER_TEXT = {
    "CONTRIBUTING.md": "a diagram",
    "docs/study/paper-claims.md": "tests/lab/datasheets/test_paper_claims.py",
    "docs/coming-from/": "what is typed in other programs",
}


def test_no_command_is_outside_of_a_block_that_runs():
    indented = re.compile(r"^(?: {4,}|\t)(?:\$ )?(?:sigmatau|pip|python|make) ", flags=re.MULTILINE)
    for name, text in TEXTS.items():
        for block in BLOCKS[name]:
            place = f"{name}, line {block.line}"
            assert block.language in (*RUN, *SHOWN) or block.language.startswith("{"), place  # a directive of Sphinx
            if block.language not in RUN:
                assert not re.search(r"^(\$ )?sigmatau [a-z]", block.content, flags=re.MULTILINE), place
        assert not indented.search(prose(text)), name


def test_every_output_is_compared():
    """Outputs and written files are shown as such, or have a comment that says why not; toml and csv are input."""
    for name in (name for name in TEXTS if not name.startswith(tuple(OTHER_TEXT))):
        for block in BLOCKS[name]:
            written = block.language in ("text", "yaml", "json", "xml", "python-file")
            assert not written or block.shows or block.note, f"{name}, line {block.line}"


def test_every_program_that_does_not_run_is_in_a_page():
    assert {program_of(statement) for _, statement in COMMANDS} & UNRUN.keys() == UNRUN.keys()


# In the text of the pages


SPANS = [(name, span) for name, text in TEXTS.items() for span in re.findall(r"`([^`\n]+(?:\n[^`\n]+)?)`", prose(text))]
SPANS += [(name, statement) for name, statement in COMMANDS if program_of(statement) in UNRUN]


def options_of(command):
    """The options of a command, with their short forms."""
    return {option for argument in command.assemble_argument_collection() for option in argument.names}


def parser_of(words):
    """The command of a command line, and the words behind its name."""
    command = app
    while words and not words[0].startswith("-") and words[0] in command:
        command, words = command[words[0]], words[1:]
    return command, words


def words_of(text):
    try:
        return shlex.split(text, comments=True)
    except ValueError:
        return text.split()


def test_command_lines_in_the_text_have_options_that_exist():
    found = 0
    for name, span in SPANS:
        words = words_of(span)
        if "sigmatau" not in words[:-1] or "…" in words[:2]:
            continue
        command, rest = parser_of(words[words.index("sigmatau") + 1 :])
        assert (
            command is not app
            or rest[0].isupper()
            or rest[0] in ("help", "--version", "--help", "--install-completion")
        ), f"{name}: no command `{span}`"
        for word in rest:
            option = word.split("=")[0]
            if option.startswith("--") and command is not app:
                found += 1
                assert option in options_of(command) | {"--help"}, f"{name}: no option {option} in `{span}`"
    assert found > 20


def commands_of(command):
    """All commands below a command."""
    for name in command:
        if not name.startswith("-"):
            yield command[name]
            yield from commands_of(command[name])


def test_options_in_the_text_exist():
    """Not in pages on other programs, nor in the changelog."""
    known = {option for command in commands_of(app) if command.default_command for option in options_of(command)}
    known |= {"--help"}
    found = 0
    for name, span in SPANS:
        if span.startswith("--") and name != "CHANGELOG.md" and "coming-from" not in name:
            found += 1
            assert span.split()[0].split("=")[0] in known, f"{name}: `{span}`"
    assert found > 80


def test_targets_of_make_exist():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z-]+):", makefile, flags=re.MULTILINE))
    script = (ROOT / "scripts" / "test.sh").read_text(encoding="utf-8")
    steps = set(re.findall(r"^    (\w+)\)", script, flags=re.MULTILINE))
    variables = set(re.findall(r"\$\((?:if \$\(|or \$\()?([A-Z]+)\)", makefile))
    found = 0
    for name, span in SPANS:
        words = words_of(span)
        if words[:1] != ["make"]:
            continue
        for word in words[1:]:
            found += 1
            left, _, value = word.partition("=")
            assert (left in variables) if value else (left in targets), f"{name}: `{span}`"
            if left == "STEPS":
                assert set(value.split()) <= steps, f"{name}: `{span}`"
    assert found > 10


def test_extras_of_pip_exist():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    named = {
        (name, extra.strip())
        for name, span in SPANS
        if "pip install" in span
        for group in re.findall(r"(?:sigmatau|\.)\[([^\]]+)\]", span)
        for extra in group.split(",")
    }
    assert named
    for name, extra in named:
        assert extra in extras, f"{name}: no extra {extra}"


def test_scripts_of_python_exist():
    found = 0
    for name, span in SPANS:
        words = words_of(span)
        if not any(re.fullmatch(r"(?:\S*/)?python3?", word) for word in words[:-1]):
            continue
        for before, word in pairwise(words):
            place = ROOT / (word.replace(".", "/") if before == "-m" else word)
            if before == "-m" and word.split(".")[0] in ("benches", "studies"):
                found += 1
                assert place.with_suffix(".py").exists() or (place / "__main__.py").exists(), f"{name}: `{span}`"
            elif word.endswith(".py") or word.startswith("tests/"):
                found += 1
                assert place.exists(), f"{name}: `{span}`"
    assert found > 5


# The harness finds what is wrong


GOOD = """
<!-- save: imu.toml -->
```toml
[channels.gyro_x]
random_walk = "0.3 deg/sqrt(h)"
```

```sh
sigmatau simulate imu.toml --hours 0.01 --rate 10 --seed 1 -o log.npy -q   # ten times a second
sigmatau analyze "unit #1.csv"    # exit code 1: don't
sigmatau datasheet show stim300 --model --bias minimum > stim300.toml
head -1 stim300.toml | wc -l
```

```text
1
```

```sh
sigmatau export --list
```

```text
kalibr        Kalibr imu.yaml: N and K, continuous, one number for three axes
…
ros           ROS sensor_msgs/Imu covariances of one sample, measured or N^2*rate of a model, by axis
```

```python
import sigmatau

walk = sigmatau.NoiseModel.read("imu.toml").channels["gyro_x"]["random_walk"]
```

In a line of text.

```python
print(f"{walk:.6f} rad")
```

```text
0.000087 rad
```
"""


def test_a_page_without_a_fault(tmp_path):
    page = run_page(ROOT / "CHANGELOG.md", tmp_path, GOOD)
    page.check()
    assert page.written() == GOOD
    assert (tmp_path / "log.npy").exists()
    assert len(page.shown) == 3


@pytest.mark.parametrize(
    ("old", "new", "error"),
    [
        ("--hours 0.01", "--hour 0.01", BrokenPageError),
        ("# exit code 1", "# exit code 2", BrokenPageError),
        ("```text\n1\n", "```text\n2\n", BrokenPageError),
        ("kalibr        Kalibr", "zz            Kalibr", BrokenPageError),
        ("0.000087 rad", "0.000088 rad", BrokenPageError),
        ("head -1 stim300.toml | wc -l", "make build && sigmatau demo", BrokenPageError),
        ('["random_walk"]', '["walk"]', KeyError),
        ("<!-- save: imu.toml -->\n```toml", "<!-- output: first page -->\n```text", BrokenPageError),
        ("```toml\n[", "```sh\n# not closed 'by a quotation\necho '", BrokenPageError),
    ],
)
def test_a_fault_is_found(old, new, error, tmp_path):
    assert GOOD.count(old) == 1
    with pytest.raises(error):
        run_page(ROOT / "CHANGELOG.md", tmp_path, GOOD.replace(old, new)).check()


def test_excerpts():
    printed = "gyro_x  0.30  good\n\ngyro_y  0.31  good\ngyro_x  0.32  good\nend\n"
    assert excerpt(printed, "") == printed
    assert excerpt(printed, "gyro_y  0.29  good\n…\nend\n") == "gyro_y  0.31  good\n…\nend\n"
    assert excerpt(printed, "gyro_x  0.32  good\n") == "gyro_x  0.32  good\n"  # the row with these numbers
    for shown in ("end\ngyro_y  0.31  good\n", "gyro_z  0.31  good\n", "gyro_y  0.31  poor\n"):
        with pytest.raises(BrokenPageError):
            excerpt(printed, shown)
