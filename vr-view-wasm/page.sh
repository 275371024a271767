#!/usr/bin/env bash
# Makes the page without a server, in one file: vr-view-wasm/page.sh [FILE] (vr.html if none is named). Needs the target:
# rustup target add wasm32-unknown-unknown
set -euo pipefail
page=$(realpath -m "${1:-vr.html}")
cd "$(dirname "$0")/.."
cargo build --release --target wasm32-unknown-unknown -p vr-view-wasm
cargo run --release --quiet -p vr-view-wasm --example package -- target/wasm32-unknown-unknown/release/vr_view_wasm.wasm "$page"
