#!/usr/bin/env bash
# wheel.sh [TRIPLE…]: the source distribution, a wheel for each target from it, and their checks; then the smoke test of this
# machine's wheel in an empty environment of each Python that is here. Without a TRIPLE: this machine's, and the other Linux
# one if its standard library of Rust is installed. PYTHONS="python3.12 python3.13" chooses the Pythons.
# shellcheck source=scripts/common.sh
source "$(dirname "$0")/common.sh"
find_rust

host=$(rustc -vV | sed -n 's/^host: //p')
targets=("$@")
if ((${#targets[@]} == 0)); then
    targets=("$host")
    for target in x86_64-unknown-linux-gnu aarch64-unknown-linux-gnu; do
        if [[ $target != "$host" && -d $(rustc --print sysroot)/lib/rustlib/$target/lib ]]; then targets+=("$target"); fi
    done
fi

rm -rf dist
quietly "making the source distribution" "$PY" scripts/distribute.py sdist
for target in "${targets[@]}"; do
    zig=()
    if [[ $target == *-linux-gnu ]]; then zig=(--zig); fi
    quietly "building the wheel for $target (two minutes)" "$PY" scripts/distribute.py wheel --target "$target" "${zig[@]}"
done
"$PY" scripts/distribute.py check
"$PY" scripts/distribute.py recipe
quietly "twine check" "$PY" -m twine check --strict dist/*
quietly "abi3audit" "$PY" -m abi3audit --strict dist/*.whl

# No compiler and no program of the machine on the path, and no network where that can be arranged.
offline=()
if unshare -rn true 2>/dev/null; then offline=(unshare -rn); fi
wheel=$(compgen -G "dist/*${host%%-*}*.whl" | head -n 1)
for python in ${PYTHONS:-python3.11 python3.12 python3.13 python3.14}; do
    if ! good_python "$python"; then
        echo "smoke test: no $python here"
        continue
    fi
    scratch=$(mktemp -d)
    quietly "installing the wheel for $python" bash -c \
        "$python -m venv $scratch/venv && $scratch/venv/bin/python -m pip install --no-compile --only-binary :all: $wheel"
    "${offline[@]}" env -i HOME="$scratch" PATH="$scratch/venv/bin" LANG=C.UTF-8 "$scratch/venv/bin/python" -I tests/smoke.py
    rm -rf "$scratch"
done
ls -l dist
