#!/usr/bin/env bash
# lock.sh: write requirements/*.txt anew from pyproject.toml, with the newest versions that go together on Python 3.11
# and later. uv comes from PyPI into a scratch environment; nothing of this machine's index settings gets into the files.
# shellcheck source=scripts/common.sh
source "$(dirname "$0")/common.sh"
ALLANTOOLS=2024.6 # a peer of benches/; its own requirements are not installed

find_python
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$PYTHON" -m venv "$scratch/venv"
quietly "fetching uv" "$scratch/venv/bin/python" -m pip install uv

lock() {
    local name=$1
    shift
    {
        printf '# Written by "make lock".\n'
        (cd "$scratch" && env -u PIP_FIND_LINKS -u UV_FIND_LINKS venv/bin/uv pip compile --quiet --universal \
            --python-version 3.11 --fork-strategy fewest --generate-hashes --no-emit-index-url --no-emit-find-links \
            --no-header "$@" --output-file "$name.txt" >/dev/null && cat "$name.txt")
    } >"requirements/$name.txt.new"
    mv "requirements/$name.txt.new" "requirements/$name.txt"
}

cp pyproject.toml "$scratch"
"$PYTHON" -c 'import sys, tomllib
print(*tomllib.load(open("pyproject.toml", "rb"))["build-system"]["requires"], sep="\n")' >"$scratch/build-system.requires.in"
printf 'allantools==%s\n' "$ALLANTOOLS" >"$scratch/allantools.in"

lock runtime pyproject.toml build-system.requires.in --extra plot
lock dev pyproject.toml build-system.requires.in --extra plot --extra pdf --extra figure --extra app --extra formats --extra postgresql --extra cluster --group dev --constraint runtime.txt --no-annotate
lock docs pyproject.toml --extra plot --extra store --group docs --constraint dev.txt --no-annotate
lock release --group pyproject.toml:release --constraint dev.txt --no-annotate
lock bench allantools.in --group pyproject.toml:bench --no-deps --constraint dev.txt --no-annotate
grep -c == requirements/*.txt
