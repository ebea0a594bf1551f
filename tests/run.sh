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
    # Python's own MCAP reader checks that our recordings are readable without our code.
    if [ -z "${DORSUM_PYTHON:-}" ]; then
        venv=target/python
        if ! "$venv/bin/python" -c 'import mcap, mcap_protobuf' 2>/dev/null; then
            say "Preparing Python's MCAP reader in $venv"
            { python3 -m venv "$venv" && "$venv/bin/python" -m pip install -q --disable-pip-version-check \
                'mcap>=1.2,<2' 'mcap-protobuf-support>=0.5,<1'; } ||
                echo "No Python with MCAP: the test that needs it says that it was skipped"
        fi
    fi
fi
if [ -z "${DORSUM_PYTHON:-}" ] && target/python/bin/python -c 'import mcap, mcap_protobuf' 2>/dev/null; then
    export DORSUM_PYTHON="$PWD/target/python/bin/python"
fi

say "Tests"
cargo test --locked --no-fail-fast
