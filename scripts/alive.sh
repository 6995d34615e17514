#!/usr/bin/env bash
# alive.sh: crates/web as WebAssembly, and the theory page with it: target/alive/index.html.
# Needs a Rust that has the standard library of wasm32-unknown-unknown, or that of Debian 12 with its source and lld. As root where
# there is apt-get, installs the latter; elsewhere prints the line to run.
# shellcheck source=scripts/common.sh
source "$(dirname "$0")/common.sh"

TARGET=wasm32-unknown-unknown
PACKAGES=(rustc-web cargo-web rust-web-src lld)
# Vectors of 128 bits, which all browsers have since 2023; relaxed ones are left out in Cargo.toml.
FEATURES="-C target-feature=+simd128"

has_target() { find_rust && [[ -d $(rustc --print target-libdir --target $TARGET 2>/dev/null) ]]; }
has_source() { [[ -x /usr/bin/cargo && -d /usr/lib/rustlib/src/rust/library ]] && command -v wasm-ld >/dev/null; }

if ! has_target && ! has_source && command -v apt-get >/dev/null && ((EUID == 0)); then
    export DEBIAN_FRONTEND=noninteractive
    quietly "alive: apt-get update" apt-get update || true
    quietly "alive: apt-get install ${PACKAGES[*]}" apt-get install -y --no-install-recommends \
        -o DPkg::Lock::Timeout=120 "${PACKAGES[@]}" || true
fi

export CARGO_TARGET_DIR=$PWD/target/web
build=(build --manifest-path crates/web/Cargo.toml --release --locked --target $TARGET)
if has_target; then
    RUSTFLAGS=$FEATURES quietly "compiling crates/web (minutes the first time)" cargo "${build[@]}"
elif has_source; then
    # The standard library is compiled from its source, which stable toolchains allow with RUSTC_BOOTSTRAP only.
    RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 RUSTFLAGS="-C linker=wasm-ld $FEATURES" \
        quietly "compiling crates/web and the standard library (minutes the first time)" \
        /usr/bin/cargo "${build[@]}" -Zbuild-std=std,panic_abort
else
    {
        echo "alive: this machine lacks a Rust for $TARGET. Run one of:"
        echo "  rustup target add $TARGET"
        echo "  apt-get install ${PACKAGES[*]}   (as root, Debian 12)"
    } >&2
    exit 1
fi
find_python
"$PYTHON" scripts/alive.py "target/web/$TARGET/release/sigmatau_web.wasm" target/alive/index.html
