#!/usr/bin/env bash
# venv.sh runtime|dev|docs|bench|release: bring .venv up to a lock file. The stamp of each, .venv/.NAME.lock, is a copy of the lock
# file it was installed from, so that nothing is done until the lock file changes.
# shellcheck source=scripts/common.sh
source "$(dirname "$0")/common.sh"

want=$1
given=${PYTHON:-}

up_to_date() { cmp -s "requirements/$1.txt" ".venv/.$1.lock"; }

# install NAME "what it is" [pip option…]
install() {
    local name=$1 what=$2
    shift 2
    up_to_date "$name" && return
    # What is imported is compiled then: most of a package never is.
    quietly "$what" "$PY" -m pip install --no-compile --require-hashes "$@" -r "requirements/$name.txt"
    cp "requirements/$name.txt" ".venv/.$name.lock"
}

version() { "$1" -c 'import sys; print(sys.version_info[:2])' 2>/dev/null || echo none; }

# Anew when there is none, its Python is gone, another Python is asked for, or the runtime lock file has changed.
if ! up_to_date runtime || ! "$PY" -m pip --version >/dev/null 2>&1 || [[ -n $given && $(version "$given") != "$(version "$PY")" ]]; then
    find_python
    rm -rf .venv
    quietly "making .venv with $("$PYTHON" --version)" "$PYTHON" -m venv .venv
fi
install runtime "installing the Python packages (a minute the first time)"
case $want in
dev)
    install dev "installing the packages of the tests (a minute the first time)"
    install bench "installing the peers that the tests compare with" --no-deps
    ;;
docs) install docs "installing the packages of the documentation (half a minute the first time)" ;;
release) install release "installing the packages of a release (zig is large)" ;;
bench) install bench "installing the peers that the benchmark compares with" --no-deps ;;
esac
