#!/usr/bin/env bash
# Installs what the tests need where it may, then runs them all. Works on a bare Debian with Rust and gcc.
#
#   bash tests/run.sh            everything
#   bash tests/run.sh --no-setup use what is there, install nothing
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf '\n== %s\n' "$*"; }

# The window tests draw with software OpenGL; the last one opens the real program on a virtual display.
packages=(libegl1 libgl1-mesa-dri libx11-6 libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0 libwayland-egl1
    xvfb xauth python3-venv)

missing() {
    local p
    for p in "${packages[@]}"; do
        dpkg-query -W -f='${Status}' "$p" 2>/dev/null | grep -q 'install ok installed' || printf '%s ' "$p"
    done
}

if [ "${1:-}" != "--no-setup" ]; then
    if command -v apt-get >/dev/null && [ -n "$(missing)" ]; then
        if [ "$(id -u)" = 0 ]; then as_root=(env)
        elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then as_root=(sudo -n)
        else as_root=(); fi
        if [ ${#as_root[@]} -gt 0 ]; then
            say "Installing $(missing)"
            "${as_root[@]}" apt-get update -qq
            # shellcheck disable=SC2046
            "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $(missing) >/dev/null
        else
            say "Not installed, and no right to: $(missing)(tests that need them say that they were skipped)"
        fi
    fi
    # Python reads our recordings and tables without our code, and the BIDS validator our datasets.
    if [ -z "${DORSUM_PYTHON:-}" ]; then
        venv=target/python
        if ! cmp -s tests/python/requirements.txt "$venv/installed.txt"; then
            say "Preparing Python's readers in $venv"
            { python3 -m venv "$venv" && "$venv/bin/python" -m pip install -q --disable-pip-version-check \
                -r tests/python/requirements.txt && cp tests/python/requirements.txt "$venv/installed.txt"; } ||
                echo "No Python with what tests/python/requirements.txt names: the tests that need it say that they were skipped"
        fi
    fi
fi
if [ -z "${DORSUM_PYTHON:-}" ] && cmp -s tests/python/requirements.txt target/python/installed.txt; then
    export DORSUM_PYTHON="$PWD/target/python/bin/python"
fi

say "Tests"
cargo test --locked --no-fail-fast
