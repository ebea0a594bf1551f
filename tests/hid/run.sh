#!/usr/bin/env bash
# The real HID stack, tried in a small Linux guest: bash tests/hid/run.sh
#
# Boots a stock kernel with UHID in an emulator (no KVM, no root, nothing installed), plugs emulated devices into it and
# drives them through hidraw. Prints a table, one check a line. Needs an amd64 Debian with apt-get, for 115 MB of packages
# fetched once into target/hid, and libc6-dev for the static link; a qemu-system-x86_64 on the path is used if there.
# `run.sh FAULT` gives every device a fault (short, loses, shifted, frozen, alias, page, stays, deaf, stranger, bent): the run must fail.
# HID_PROGRAM=PATH takes a program that is built already.
# Exit codes: 0 all holds, 1 a check fails, 2 it cannot be tried here.
set -euo pipefail
cd "$(dirname "$0")/../.."
here=$PWD/tests/hid work=$PWD/target/hid
packages=$work/packages guest=$work/guest root=$work/root

cannot() { echo "hid: cannot be tried here: $*" >&2; exit 2; }

# apt-get with lists, archives and a list of installed packages of its own: the system's are neither read nor written.
private_apt() {
    apt-get -q -o Dir::State::Lists="$packages/lists" -o Dir::State::Status="$packages/none-installed" \
        -o Dir::Cache="$packages" -o Dir::Cache::Archives="$packages/archives" -o Debug::NoLocking=1 \
        -o APT::Architecture=amd64 -o APT::Install-Recommends=false -o APT::Sandbox::User="$(id -un)" "$@"
}

fetch() {
    [ "$(uname -m)" = x86_64 ] || cannot "the guest is x86_64, this machine is $(uname -m)"
    command -v apt-get >/dev/null && command -v dpkg-deb >/dev/null || cannot "no apt-get and dpkg-deb to fetch the guest's kernel with"
    mkdir -p "$packages/lists/partial" "$packages/archives/partial"
    : >"$packages/none-installed"
    local wanted=(busybox-static udev linux-image-amd64)
    command -v qemu-system-x86_64 >/dev/null || wanted+=(qemu-system-x86)
    echo "fetching ${wanted[*]} into target/hid, once" >&2
    private_apt update >"$work/fetch.log" 2>&1 || cannot "apt-get update fails, see target/hid/fetch.log"
    private_apt install -y --download-only "${wanted[@]}" >>"$work/fetch.log" 2>&1 ||
        cannot "no packages ${wanted[*]} to be had, see target/hid/fetch.log"

    rm -rf "$root" && mkdir -p "$root"
    local deb
    for deb in "$packages"/archives/*.deb; do
        case ${deb##*/} in
            linux-image-[0-9]*)
                dpkg-deb --fsys-tarfile "$deb" | tar -xf - -C "$root" --wildcards './boot/vmlinuz-*' '*/hid.ko*' '*/hid-generic.ko*' '*/uhid.ko*' ;;
            *) dpkg-deb --extract "$deb" "$root" ;;
        esac
    done
    rm -rf "$packages/archives"
    touch "$root/complete"
}

# An initramfs: busybox, the three modules, init and the program under test.
pack() {
    rm -rf "$guest" && mkdir -p "$guest/bin" "$guest/modules"
    cp "$root/bin/busybox" "$guest/bin/busybox"
    local module
    for module in hid hid-generic uhid; do
        local file
        file=$(find "$root/lib/modules" -name "$module.ko*" | head -1)
        case $file in
            *.ko) cp "$file" "$guest/modules/" ;;
            *.ko.xz) xz -dc "$file" >"$guest/modules/$module.ko" ;;
            *.ko.zst) zstd -dcq "$file" >"$guest/modules/$module.ko" ;;
            *) cannot "the kernel package has no module $module" ;;
        esac
    done
    install -m 755 "$here/init" "$guest/init"
    install -m 755 "$1" "$guest/bin/hid"
    # udev, with the libraries of its own distribution, reads the rule that comes with Dorsum.
    mkdir -p "$guest/run" "$guest/lib" "$guest/etc/udev/rules.d" "$guest/usr/lib/udev/rules.d"
    cp "$here/../../assets/70-dorsum.rules" "$guest/etc/udev/rules.d/"
    cp "$root/bin/udevadm" "$guest/bin/udevadm"
    local library
    own "$root/bin/udevadm" --list | sed -n 's/.*=> \([^ ]*\) .*/\1/p' | while read -r library; do
        cp -L "$library" "$guest/lib/"
    done
    ln -s lib "$guest/lib64"
    strip "$guest/bin/hid" 2>/dev/null || true
    (cd "$guest" && find . -mindepth 1 | sort | "$guest/bin/busybox" cpio -o -H newc 2>/dev/null) >"$work/initramfs"
}

# Runs a fetched program with the libraries of its own distribution, whatever this system has.
own() {
    local program=$1 lib=$root/lib/x86_64-linux-gnu:$root/usr/lib/x86_64-linux-gnu list=()
    shift
    if [ "${1:-}" = --list ]; then list=(--list) && shift; fi
    "$root/lib/x86_64-linux-gnu/ld-linux-x86-64.so.2" --library-path "$lib" "${list[@]}" "$program" "$@"
}

emulator() {
    if command -v qemu-system-x86_64 >/dev/null; then
        qemu-system-x86_64 "$@"
    else
        QEMU_MODULE_DIR=$root/usr/lib/x86_64-linux-gnu/qemu own "$root/usr/bin/qemu-system-x86_64" \
            -L "$root/usr/share/qemu" -L "$root/usr/share/seabios" "$@"
    fi
}

case " ${1:-} " in
    "  " | *" short "* | *" loses "* | *" shifted "* | *" frozen "* | *" alias "* | *" page "* | *" stays "* | *" deaf "* | *" stranger "* | *" bent "*) ;;
    *) cannot "no fault is called '$1'; allowed: short, loses, shifted, frozen, alias, page, stays, deaf, stranger, bent" ;;
esac
mkdir -p "$work"
[ -e "$root/complete" ] || fetch

program=${HID_PROGRAM:-}
if [ -z "$program" ]; then
    program=$(cargo rustc --locked --no-default-features --test hid --message-format=json-render-diagnostics \
        -- -C target-feature=+crt-static | sed -n 's/.*"executable":"\([^"]*\/hid-[^"]*\)".*/\1/p') && [ -n "$program" ] || cannot "the program does not build"
fi
pack "$program"

# Two serial lines: the table on the first, the kernel's own words on the second.
# The guest ends itself; should it hang, the check's own limit ends it.
emulator -M pc -accel tcg -cpu max -m 256 -nodefaults -display none -no-reboot \
    -kernel "$(find "$root/boot" -name 'vmlinuz-*' | sort | tail -1)" -initrd "$work/initramfs" \
    -append "console=ttyS1 panic=-1 quiet${1:+ HID_FAULT=$1}" -serial stdio -serial "file:$work/kernel.log" </dev/null \
    2>"$work/emulator.log" | tr -d '\r' | tee "$work/table.txt" || true

case $(tail -1 "$work/table.txt") in
    "checks: "*", failed: 0") ;;
    "checks: "*) exit 1 ;;
    *) cannot "the guest came to no end, see target/hid/{emulator,kernel}.log" ;;
esac
