#!/usr/bin/env bash
# test.sh [STEP…]: the checks and tests, each with its time, up to the first that fails. Without a STEP, all of them:
ALL="format lint rustfmt clippy types stubs imports rust instructions python"
# shellcheck source=scripts/common.sh
source "$(dirname "$0")/common.sh"
find_rust
export PYO3_PYTHON=$PWD/$PY # one interpreter for every cargo command, or the binding is compiled again and again
export PATH="$PWD/.venv/bin:$PATH"

# One process a core; none of them starts threads of BLAS, which would wait for each other.
python_tests() { OPENBLAS_NUM_THREADS=1 python -m pytest --numprocesses "$(nproc)" --dist worksteal; }

run() {
    case $1 in
    format) ruff format --check ;;
    lint) ruff check ;;
    rustfmt) cargo fmt --all --check ;;
    clippy) cargo clippy --workspace --all-targets --locked --quiet -- -D warnings ;;
    types) python -m mypy ;;
    stubs) python -m mypy.stubtest --mypy-config-file pyproject.toml sigmatau._core ;;
    imports) lint-imports --no-logo ;;
    # Optimised, so that what the extension was built from is not compiled again; `make fuzz` has overflow checks.
    rust) cargo test --release -p sigmatau-core -p sigmatau-formats --locked --quiet ;;
    instructions) python benches/instructions.py ;;
    python) python_tests ;;
    *) echo "no step $1; the steps are: $ALL" >&2 && return 2 ;;
    esac
}

read -ra steps <<<"${*:-$ALL}"
for step in "${steps[@]}"; do
    printf '── %s\n' "$step"
    start=$SECONDS status=0
    run "$step" || status=$?
    if ((status)); then
        printf '── %s FAILED after %d s (again, alone: make test STEPS=%s)\n' "$step" $((SECONDS - start)) "$step"
        exit "$status"
    fi
    printf '── %s passed, %d s\n\n' "$step" $((SECONDS - start))
done
printf '── %s: all passed, %d s\n' "${steps[*]}" "$SECONDS"
