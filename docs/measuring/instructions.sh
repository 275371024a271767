#!/usr/bin/env bash
# Instructions per sample: a figure that does not depend on the machine's mood. Needs valgrind and python3.
#
#   instructions.sh [VR [FLAG ...]]
#
# VR: target/release/vr if absent. FLAGs go to `vr bench`, KEY=VALUE as --set KEY=VALUE; step=1 if absent.
#
# Callgrind counts the instructions of one frame and of three frames of the same view, on one thread; half the difference is one frame:
# set-up of rays, sampling, table, compositing, without reading and preparation. It is divided by the samples taken. Valgrind knows
# instructions up to AVX2 and hides AVX-512, so run-time dispatch takes the AVX2 kernels here, whatever the processor has.
#
# The scenes: a dense fog in which no ray ends early, u8 and f32, of 64 samples along each edge.
set -euo pipefail
vr=${1:-target/release/vr}
shift || true
flags=()
for flag in "$@"; do
    case $flag in -*) flags+=("$flag") ;; *=*) flags+=(--set "$flag") ;; *) flags+=("$flag") ;; esac
done
[ ${#flags[@]} -gt 0 ] || flags=(--set step=1)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

python3 - "$work" <<'PYTHON'
import math, struct, sys
n, work = 64, sys.argv[1]
wave = lambda f, k, phase: math.sin(2 * math.pi * f * k / (n - 1) + phase)
values = [128 + 100 * wave(3, x, 0.1) * wave(2, y, 0.7) * wave(4, z, 1.3) for z in range(n) for y in range(n) for x in range(n)]
with open(f"{work}/u8.raw", "wb") as f:
    f.write(bytes(int(v + 0.5) for v in values))
with open(f"{work}/f32.raw", "wb") as f:
    f.write(struct.pack(f"<{n ** 3}f", *values))
for kind in ("u8", "f32"):
    with open(f"{work}/{kind}.toml", "w") as f:
        f.write(f"""[volume]
path = "{kind}.raw"
dims = [{n}, {n}, {n}]
type = "{kind}"
endian = "little"
spacing = [1.0, 1.0, 1.0]
[transfer]
unit_distance = 1.0
points = [ {{value = 0.0, color = [0.3, 0.4, 0.7], opacity = 0.001}}, {{value = 255.0, color = [1.0, 0.85, 0.6], opacity = 0.01}} ]
[camera]
eye = [150.0, -120.0, 110.0]
target = [31.5, 31.5, 31.5]
up = [0.0, 0.0, 1.0]
height = 110.0
[image]
size = [96, 96]
""")
PYTHON

# Instructions of a run of so many frames, and the samples of one of them.
run() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$vr" bench --scene "$work/$1.toml" --frames "$2" --warm-up 0 --azimuth-step 0 \
        --threads 1 --json --quiet "${flags[@]}" >"$work/out" 2>"$work/log" || { cat "$work/log" >&2; return 1; }
    echo "$(sed -n 's/.*Collected *: *\([0-9]*\).*/\1/p' "$work/log") $(sed -n 's/.*"samples": *\([0-9]*\).*/\1/p' "$work/out")"
}
for kind in u8 f32; do
    one=$(run $kind 1)
    three=$(run $kind 3)
    read -r one samples <<<"$one"
    read -r three again <<<"$three"
    [ "$samples" = "$again" ] || { echo "the same view took $samples and $again samples" >&2; exit 1; }
    awk -v k=$kind -v a="$one" -v b="$three" -v s="$samples" \
        'BEGIN { printf "%-4s %8.2f instructions a sample (%.1f M a frame, %d samples)\n", k, (b - a) / 2 / s, (b - a) / 2e6, s }'
done
