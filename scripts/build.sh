#!/usr/bin/env bash
# build.sh: the extension, optimised, into python/sigmatau, and the package into .venv in editable form, so that edits of
# Python files are seen at once. Nothing is done when no file is newer than the stamp .venv/.built.
# shellcheck source=scripts/common.sh
source "$(dirname "$0")/common.sh"

newer() { find crates Cargo.toml Cargo.lock pyproject.toml \( -name tests -o -path crates/web \) -prune -o -newer .venv/.built -print; }
if [[ -e .venv/.built && -n $(find python/sigmatau -name '_core*.so') && -z $(newer) ]]; then
    exit 0
fi

find_rust
touch .venv/.building # before, so that an edit while it compiles counts
# Through pip and the maturin of the lock file; `maturin develop` would install the dependency groups as well, unlocked.
export PATH="$PWD/.venv/bin:$PATH"
quietly "compiling (a minute the first time)" "$PY" -m pip install --verbose --no-deps --no-build-isolation --editable .
rm -f target/wheels/sigmatau-*.whl # editable, under the name of a release; releases are in dist/
mv .venv/.building .venv/.built
echo "   built: .venv/bin/sigmatau"
