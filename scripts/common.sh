# shellcheck shell=bash
# shellcheck disable=SC2034 # names for the scripts that source this
# Sourced by the other scripts: run from the top of the tree, find Rust and Python, run long commands quietly.

set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

export MATURIN_NO_INSTALL_RUST=1 # otherwise the build downloads a toolchain by itself
export PIP_DISABLE_PIP_VERSION_CHECK=1
unset VIRTUAL_ENV CONDA_PREFIX PYTHONHOME PYTHONPATH # of another project: .venv is ours
unset PYTHONDONTWRITEBYTECODE # it makes each command that a test starts compile the package again: 0.3 s each

RUST_MIN=85        # 1.85
PY=.venv/bin/python # of the project, once it is there
LOG=target/setup-$(basename "$0" .sh).log

# rust_minor DIR: the 95 of "rustc 1.95.0", if DIR has both rustc and cargo of 1.x; else nothing
rust_minor() {
    local rustc
    [[ -x $1/cargo && -x $1/rustc ]] || return 0
    "$1/cargo" --version >/dev/null 2>&1 || return 0
    rustc=$("$1/rustc" --version 2>/dev/null) || return 0
    sed -n 's/^rustc 1\.\([0-9]*\)\..*/\1/p' <<<"$rustc"
}

# Put the first directory with a Rust that is new enough in front of PATH; RUST_FOUND is what there is.
find_rust() {
    local dir minor
    local -a dirs
    RUST_FOUND=none
    IFS=: read -ra dirs <<<"$PATH"
    for dir in "${dirs[@]}" "${CARGO_HOME:+$CARGO_HOME/bin}" "${HOME:-}/.cargo/bin" /usr/bin; do
        minor=$(rust_minor "$dir")
        [[ -n $minor ]] || continue
        if ((minor >= RUST_MIN)); then
            RUST_FOUND="1.$minor"
            [[ $(command -v rustc) == "$dir/rustc" ]] || export PATH="$dir:$PATH"
            return 0
        fi
        RUST_FOUND="1.$minor"
    done
    return 1
}

# good_python COMMAND: at least 3.11, and able to make a virtual environment
good_python() {
    "$1" -c 'import sys, ensurepip, ssl, venv; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1
}

# Set PYTHON, unless the caller has; fails if there is none that will do.
find_python() {
    local python
    if [[ -n ${PYTHON:-} ]]; then
        good_python "$PYTHON"
        return
    fi
    for python in python3.13 python3.12 python3.11 python3; do
        if good_python "$python"; then
            PYTHON=$python
            return 0
        fi
    done
    return 1
}

# quietly "what is being done" COMMAND…: one line on the terminal; what the command says goes to the log, shown if it fails
quietly() {
    local what=$1 TIMEFORMAT="   ${1%% (*}: %0R s, CPU %0U + %0S s"
    shift
    mkdir -p "$(dirname "$LOG")"
    printf '%s …\n' "$what" >&2
    printf '\n$ %s\n' "$*" >>"$LOG"
    local from
    from=$(($(wc -l <"$LOG") + 1))
    if ! time "$@" >>"$LOG" 2>&1 </dev/null; then
        printf '%s: failed:\n\n' "$what" >&2
        tail -n +"$from" "$LOG" | tail -n 80 >&2
        printf '\n(all of it: %s)\n' "$LOG" >&2
        return 1
    fi
}
