#!/usr/bin/env bash
# doctor.sh [build|test] [--report]: what the machine lacks, all of it at once.
# As root where there is apt-get, installs it; elsewhere prints the line to run and fails.
# shellcheck source=scripts/common.sh
source "$(dirname "$0")/common.sh"

what=${1:-build}

# A C compiler that links: compilers without libc6-dev are common on Debian.
cc_links() {
    local out status=0
    out=$(mktemp)
    printf 'int main(void) { return 0; }\n' | cc -x c -o "$out" - >/dev/null 2>&1 || status=1
    rm -f "$out"
    return $status
}

has_cargo() { find_rust && cargo "$1" --version >/dev/null 2>&1; }

# A part of the toolchain comes from where the toolchain came from.
component() {
    if [[ -x $(dirname "$(command -v rustc || echo /none/)")/rustup ]]; then
        missing+=("$1: rustup component add $1")
    else
        missing+=("$1") && packages+=("$2")
    fi
}

# cargo asks the system for the roots of trust; a bare container may have none.
has_roots() { ! command -v apt-get >/dev/null || [[ -n ${SSL_CERT_FILE:-} || -s /etc/ssl/certs/ca-certificates.crt ]]; }

# Fill `missing` (for people) and `packages` (for apt-get).
examine() {
    missing=() packages=()
    command -v git >/dev/null || { missing+=("git") && packages+=(git); }
    command -v make >/dev/null || { missing+=("make") && packages+=(make); }
    cc_links || { missing+=("a C compiler that links") && packages+=(gcc libc6-dev); }
    has_roots || { missing+=("CA certificates") && packages+=(ca-certificates); }
    if ! find_python; then
        missing+=("Python ≥ 3.11 with venv and ensurepip${PYTHON:+ (PYTHON=$PYTHON is not)}")
        [[ -n ${PYTHON:-} ]] || packages+=(python3-venv)
    fi
    if ! find_rust; then
        missing+=("Rust ≥ 1.$RUST_MIN with cargo (found: $RUST_FOUND)") && packages+=(RUST CARGO)
    fi
    if [[ $what == test ]]; then
        has_cargo clippy || component clippy CLIPPY
        has_cargo fmt || component rustfmt RUSTFMT
    fi
}

candidate() { apt-cache policy "$1" 2>/dev/null | sed -n 's/^  Candidate: //p'; }

# Replace the placeholders by the names of this release (Debian 12 has a recent Rust only under the names -web), or drop
# them where it has none that is new enough.
name_packages() {
    local names=() named=() minor p
    minor=$(candidate rustc | sed -n 's/^1\.\([0-9]*\)\..*/\1/p')
    if [[ $(candidate rustc-web) == 1.* ]]; then
        names=(rustc-web cargo-web rust-web-clippy rustfmt-web)
    elif ((${minor:-0} >= RUST_MIN)); then
        names=(rustc cargo rust-clippy rustfmt)
    fi
    for p in "${packages[@]}"; do
        case $p in
        RUST) p=${names[0]:-} ;;
        CARGO) p=${names[1]:-} ;;
        CLIPPY) p=${names[2]:-} ;;
        RUSTFMT) p=${names[3]:-} ;;
        esac
        [[ -z $p ]] || named+=("$p")
    done
    packages=("${named[@]}")
}

examine
if ((${#missing[@]})) && command -v apt-get >/dev/null; then
    if ((EUID == 0)) && ((${#packages[@]})); then
        export DEBIAN_FRONTEND=noninteractive
        quietly "doctor: apt-get update" apt-get update || true # one broken source need not matter
        name_packages
        if ((${#packages[@]})); then
            quietly "doctor: apt-get install ${packages[*]}" apt-get install -y --no-install-recommends \
                -o DPkg::Lock::Timeout=120 "${packages[@]}"
            hash -r
            examine
        fi
    elif ((EUID != 0)); then
        # Without package lists, the names of Debian 12.
        [[ $(candidate rustc)$(candidate rustc-web) == *[0-9]* ]] || candidate() { echo 1.0; }
        name_packages
    fi
fi

# Of use, but not needed: without valgrind no instructions are counted, without chromium no page is opened, without PostgreSQL
# the store is tested on SQLite alone, without zsh and fish their completion is not tested. CI fails then. PostgreSQL keeps initdb off the path; its Debian package starts a server
# of its own unless it is told not to.
has_postgresql() { command -v initdb >/dev/null || compgen -G "/usr/lib/postgresql/*/bin/initdb" >/dev/null; }

useful=()
if [[ $what == test ]]; then
    # The shell has the engine of chromium without its windows, and takes half of its CPU time.
    for program in valgrind chromium-headless-shell zsh fish; do command -v $program >/dev/null || useful+=("$program"); done
    has_postgresql || useful+=(postgresql)
fi
if ((${#useful[@]})) && command -v apt-get >/dev/null && ((EUID == 0)); then
    export DEBIAN_FRONTEND=noninteractive
    [[ $(candidate zsh) == *[0-9]* ]] || quietly "doctor: apt-get update" apt-get update || true
    for program in "${useful[@]}"; do
        if [[ $program == chromium-headless-shell && $(candidate "$program") != *[0-9]* ]]; then
            command -v chromium >/dev/null && continue
            program=chromium
        fi
        [[ $(candidate "$program") == *[0-9]* ]] || continue
        if [[ $program == postgresql && ! -e /etc/postgresql-common/createcluster.conf ]]; then
            mkdir -p /etc/postgresql-common
            echo "create_main_cluster = false" >/etc/postgresql-common/createcluster.conf
        fi
        quietly "doctor: apt-get install $program" apt-get install -y --no-install-recommends --no-remove \
            -o DPkg::Lock::Timeout=120 -o Dpkg::Options::=--force-confold "$program" || true
    done
fi

if ((${#missing[@]})); then
    {
        echo "doctor: this machine lacks"
        printf '  - %s\n' "${missing[@]}"
        if command -v apt-get >/dev/null && ((EUID != 0)) && ((${#packages[@]})); then
            echo "Run as root:"
            echo "  apt-get update && apt-get install -y ${packages[*]}"
        fi
        if [[ ${missing[*]} == *"Rust ≥"* ]]; then
            echo "Rust also comes from https://rustup.rs (rustup update, if it is too old)."
        fi
    } >&2
    exit 1
fi
if [[ ${2:-} == --report ]]; then
    printf 'doctor: nothing is missing to %s\n' "$what"
    printf '  %-8s %s\n' git "$(git --version)" cc "$(cc --version | head -n 1)" python "$("$PYTHON" --version) ($PYTHON)" \
        rustc "$(rustc --version)" cargo "$(cargo --version)"
fi
