#!/usr/bin/env bash
# test.sh [STEP…]: the checks and tests, each with its time, up to the first that fails. Without a STEP, all of them: those
# that only read while the extension is compiled, then those of Python beside those of Rust. Cargo works on one thing at a
# time, so that clippy would hold up the extension, and with it the tests of Python.
READ_STEPS="format lint types"
RUN_STEPS="imports stubs python" # that need the extension
RUST_STEPS="rustfmt clippy rust instructions"
SITE_STEPS="docs" # beside those of Python
# shellcheck source=scripts/common.sh
source "$(dirname "$0")/common.sh"
find_rust
export PYO3_PYTHON=$PWD/$PY # one interpreter for every cargo command, or the binding is compiled again and again
export PATH="$PWD/.venv/bin:$PATH"

# A process more than cores, because some tests wait for workers that were killed. BLAS gets one thread: the matrices are small,
# and threads would wait for each other.
# What failed runs again, alone, and shows the values of its assertions: to prepare them for all tests takes 20 s of CPU time. It
# decides only if nothing but tests in a browser failed (code 9 of tests/conftest.py), because a browser on a busy machine can be late.
python_tests() {
    local status=0
    export OPENBLAS_NUM_THREADS=1
    python -m pytest --numprocesses "$(($(nproc) + 1))" --dist worksteal --assert=plain || status=$?
    ((status == 1 || status == 9)) || return "$status"
    echo "── python: again, alone, what failed above"
    python -m pytest --numprocesses 0 --last-failed --long -v || return 1
    ((status == 9))
}

run() {
    case $1 in
    format) ruff format --check ;;
    lint) ruff check ;;
    rustfmt) cargo fmt --all --check ;;
    # Optimised like the others, so that macros and build scripts are compiled once.
    clippy) cargo clippy --release --workspace --all-targets --locked --quiet -- -D warnings ;;
    types) python -m mypy && python scripts/user_code.py ;;
    stubs) python -m mypy.stubtest --mypy-config-file pyproject.toml sigmatau._core ;;
    imports) lint-imports --no-logo ;;
    # Optimised, and of the whole workspace, so that what the extension was built from is not compiled again; `make fuzz`
    # has overflow checks.
    rust) cargo test --release --workspace --tests --locked --quiet ;;
    instructions) python benches/instructions.py ;;
    python) python_tests ;;
    long) OPENBLAS_NUM_THREADS=1 python -m pytest --long -m long ;; # every night
    docs) scripts/venv.sh docs && python docs/website/build.py --all ;;
    *) echo "no step $1; the steps are: $READ_STEPS $RUN_STEPS $RUST_STEPS $SITE_STEPS long" >&2 && return 2 ;;
    esac
}

run_all() {
    local step status
    for step in "$@"; do
        printf '── %s\n' "$step"
        status=0
        TIMEFORMAT="── $step: %0R s, CPU %0U + %0S s"
        time run "$step" || status=$?
        if ((status)); then
            printf '── %s FAILED (again, alone: make test STEPS=%s)\n' "$step" "$step"
            return "$status"
        fi
        printf '── %s passed\n\n' "$step"
    done
}

if (($#)); then
    scripts/venv.sh dev
    scripts/build.sh
    run_all "$@"
else
    log=$(mktemp) site_log=$(mktemp)
    trap 'rm -f "$log" "$site_log"' EXIT
    scripts/venv.sh runtime
    # shellcheck disable=SC2086 # lists of words
    { scripts/venv.sh dev && scripts/venv.sh docs && run_all $READ_STEPS; } &
    reading=$! rust='' site='' status=0
    scripts/build.sh || status=$?
    if ((status == 0)); then
        # shellcheck disable=SC2086
        run_all $RUST_STEPS >"$log" 2>&1 &
        rust=$!
    fi
    wait "$reading" || status=$?
    if ((status == 0)); then
        # shellcheck disable=SC2086
        run_all $SITE_STEPS >"$site_log" 2>&1 &
        site=$!
        # shellcheck disable=SC2086
        (run_all $RUN_STEPS) || status=$? # a shell of its own: no CPU time of the others is counted
    fi
    [[ -z $rust ]] || wait "$rust" || status=$?
    [[ -z $site ]] || wait "$site" || status=$?
    cat "$log" "$site_log"
    ((status == 0)) || exit "$status"
fi
printf '── all passed, %d s\n' "$SECONDS"
