#!/usr/bin/env bash
# Builds the package's wheels into `dist/`: for this machine's system, or for the targets that are named.
#
#     ./wheels.sh                                                  # this system's own
#     ./wheels.sh x86_64-unknown-linux-gnu x86_64-unknown-linux-musl aarch64-unknown-linux-gnu
#     ./wheels.sh x86_64-apple-darwin aarch64-apple-darwin         # on macOS
#     ./wheels.sh x86_64-pc-windows-msvc                           # on Windows
#
# One wheel of the stable ABI does for all versions of Python from 3.10 on. Those for Linux are linked by Zig against
# glibc 2.17 (manylinux2014) or musl 1.2, so they run on systems older than the one they are built on. Maturin and Zig
# come from the package index, into an environment in `target`.
set -euo pipefail
cd "$(dirname "$0")"

environment=../target/wheel-builder
[ -d "$environment" ] || python3 -m venv "$environment"
bin="$environment/bin"
[ -d "$bin" ] || bin="$environment/Scripts"
"$bin/pip" install --quiet 'maturin>=1.9,<2' ziglang
PATH="$(cd "$bin" && pwd):$PATH"
build=(maturin build --release --locked --out dist)

if [ $# -eq 0 ]; then
  "${build[@]}"
fi
for target in "$@"; do
  rustup target add "$target"
  case "$target" in
    *-linux-gnu) "${build[@]}" --target "$target" --zig --compatibility manylinux2014 ;;
    *-linux-musl) "${build[@]}" --target "$target" --zig --compatibility musllinux_1_2 ;;
    *) "${build[@]}" --target "$target" ;;
  esac
done
