"""Man pages, completion and help are of one source: the commands. Every command shows an example."""

import json
import os
import re
import shutil
import subprocess

import pytest
from scripts_of import script

from conftest import ROOT
from sigmatau.cli.app import EXAMPLES, app

manual = script("manual")
COMMANDS = manual.commands()
LEAVES = [words for words in COMMANDS if not any(other[:-1] == words for other in COMMANDS)]
SHELLS = ("bash", "zsh", "fish")


@pytest.fixture(scope="module")
def pages():
    return {words: manual.page(words) for words in [(), *COMMANDS]}


@pytest.fixture(scope="module")
def completions(tmp_path_factory):
    folder = tmp_path_factory.mktemp("completion")
    for shell in SHELLS:
        (folder / f"sigmatau.{shell}").write_text(app.generate_completion(shell=shell), encoding="utf-8")
    return folder


def options_of(words):
    command = app
    for word in words:
        command = command[word]
    arguments = command.assemble_argument_collection(parse_docstring=True)
    return {name for one in arguments if one.show for name in one.names if name.startswith("-")}


def test_every_command_has_an_example_of_itself():
    assert {" ".join(words) for words in LEAVES} == set(EXAMPLES)
    for name, examples in EXAMPLES.items():
        assert f"sigmatau {name} " in examples, name


@pytest.mark.parametrize("words", LEAVES, ids=" ".join)
def test_a_page_has_every_option_and_the_examples(words, pages):
    shown = pages[words].replace("\\-", "-")
    options = options_of(words)
    assert len(options) >= 2
    assert options <= set(re.findall(r"--?[a-z][a-z-]*", shown))
    assert ".SH EXAMPLES" in pages[words]
    assert "Exit codes" not in shown  # they are a list
    assert shown.count("\n.TP\n\\fB143\\fR\n") == 1


def test_the_first_page_leads_to_the_others(pages):
    for words in COMMANDS:
        assert words[0] in pages[()]
        assert f"\\fBsigmatau\\-{words[0]}\\fR(1)" in pages[()]


def test_no_text_becomes_a_command_of_roff(pages):
    macros = {".TH", ".SH", ".TP", ".nf", ".fi", ".ad", ".nh"}
    for words, page in pages.items():
        for line in page.splitlines():
            assert line.split(" ")[0] in macros or not line.startswith((".", "'")), (words, line)
            assert not re.search(r"\\(?![-e&]|f[BR]|\((?:aq|ga|ha|ti))", line), (words, line)
    assert manual.roff(".TH \\ 'x'") == "\\&.TH \\e \\(aqx\\(aq"


def test_man_shows_the_pages_without_a_warning(pages, tmp_path):
    if shutil.which("man") is None or shutil.which("groff") is None:
        pytest.skip("no man-db with groff")
    for words, page in pages.items():
        file = tmp_path / f"{'-'.join(('sigmatau', *words))}.1"
        file.write_text(page, encoding="utf-8")
    command = ["man", "--warnings=w", "--encoding=UTF-8", "-l", *map(str, sorted(tmp_path.glob("*.1")))]
    environment = os.environ | {"MANWIDTH": "80", "MANPAGER": "cat", "LC_ALL": "C.UTF-8"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
    assert done.stderr == ""
    assert done.stdout.count("EXIT STATUS") == len(pages)
    assert "FAST-LIO …" in done.stdout  # not ASCII


def shell(name):
    found = shutil.which(name)
    if found is None:
        assert not os.environ.get("CI"), f"{name} is not installed, and CI must not skip the test of its completion"
        pytest.skip(f"no {name}: apt-get install {name}")
    return found


# A program in each shell that loads the script as --install-completion installs it. bash and fish print what they complete
# for `sigmatau ana`; zsh completes only at a terminal, so it prints the function that completes `sigmatau`.
ASK = {
    "bash": 'source "$1"; COMP_WORDS=(sigmatau ana); COMP_CWORD=1; _sigmatau; printf "%s\\n" "${COMPREPLY[@]}"',
    "fish": 'source $argv[1]; complete --do-complete "sigmatau ana"',
    "zsh": "fpath=($1:h $fpath); autoload -Uz compinit; compinit -u -D; f=${_comps[sigmatau]}; $f 2>/dev/null; which $f",
}


@pytest.mark.parametrize("name", SHELLS)
def test_completion_loads(name, completions, tmp_path):
    program, file = shell(name), completions / f"sigmatau.{name}"
    if name == "zsh":
        file = file.rename(completions / "_cyclopts_sigmatau")
    subprocess.run([program, "-n", str(file)], check=True)
    quiet = {"bash": ["--norc"], "zsh": ["-f"], "fish": ["--no-config"]}[name]
    arguments = [program, *quiet, "-c", ASK[name], *([] if name == "fish" else ["ask"]), str(file)]
    done = subprocess.run(
        arguments, capture_output=True, text=True, env=os.environ | {"HOME": str(tmp_path)}, check=True
    )
    assert done.stderr == ""
    assert done.stdout.startswith("_cyclopts_sigmatau () {" if name == "zsh" else "analyze")
    assert re.search(r"\banalyze\b", done.stdout)


def test_completion_knows_every_command_and_option(completions):
    texts = {file.suffix[1:] or "zsh": file.read_text(encoding="utf-8") for file in completions.iterdir()}
    for words in LEAVES:
        for option in options_of(words):
            assert all(option in text for text in (texts["bash"], texts["zsh"]))
            assert option.lstrip("-") in texts["fish"]


def test_the_schema_of_the_result_is_named_by_the_smoke_test():
    """tests/smoke.py runs against an installed package, which has only the newest schema."""
    text = (ROOT / "tests" / "smoke.py").read_text(encoding="utf-8")
    (newest,) = (ROOT / "python" / "sigmatau" / "schema").glob("*.json")
    assert newest.name in text
    assert json.loads(newest.read_text(encoding="utf-8"))["properties"]["schema"]["const"] == int(newest.name[7])
