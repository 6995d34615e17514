#!/usr/bin/env bash
# fuzz.sh SECONDS: mutated files to every parser. To the compiled ones by cargo-fuzz, so many seconds each; each run is
# written to target/fuzz/NAME.log, what was found to crates/formats/fuzz/artifacts. Stable Rust will do: no sanitizer is
# used, which code without `unsafe` does not need; overflows, panics, hangs of 5 s and more than 512 MB end a run.
# shellcheck source=scripts/common.sh
source "$(dirname "$0")/common.sh"

seconds=$1
out=$PWD/target/fuzz
find_rust
export RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR=$PWD/target/fuzz-build
bin=$PWD/target/fuzz-bin
if [[ ! -x $bin/bin/cargo-fuzz ]]; then
    quietly "compiling cargo-fuzz (two minutes the first time)" cargo install cargo-fuzz --locked --root "$bin"
fi
export PATH=$bin/bin:$PATH
mkdir -p "$out"
"$PY" -m benches.seeds "$out/seeds"
failed=0
for target in ${TARGETS:-text sentences ulog dataflash mcap bag messages}; do
    mkdir -p "$out/corpus/$target" "$out/seeds/$target"
    verdict="nothing found"
    (cd crates/formats && cargo fuzz run -s none "$target" "$out/corpus/$target" "$out/seeds/$target" -- \
        -max_total_time="$seconds" -max_len=65536 -timeout=5 -rss_limit_mb=512 -print_final_stats=1) \
        >"$out/$target.log" 2>&1 || { failed=1 verdict="FAILED: $out/$target.log"; }
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$out/$target.log")
    printf '%-10s %12s inputs, %s\n' "$target" "${runs:-0}" "$verdict"
done
# The readers in Python and the libraries they use, and files that are not logs: 25 times as many mutants as the tests read.
SIGMATAU_MUTANTS=10 "$PY" -m pytest tests/io tests/cli/test_mutated_files.py -k "mutat or mutant" \
    --numprocesses "$(nproc)" --dist worksteal || failed=1
# Ends of processes at any time, 200 of each kind; what they left is printed.
SIGMATAU_KILLS=200 "$PY" -m pytest --long tests/test_kills.py -rP || failed=1
# Odd records through every command.
SIGMATAU_ODD_RECORDS=3000 "$PY" -m pytest tests/test_odd_records.py --numprocesses "$(nproc)" --dist worksteal || failed=1
exit "$failed"
