#!/usr/bin/env python3
"""How time and memory grow with the volume: prints a Markdown table.

    growth.py --work DIR [--vr target/release/vr] [--sizes 128 256 512 1024] [--kinds fog blobs] [--threads 2] [FLAGS ...]

Two u8 volumes of n samples along each edge of the same cube, by closed formulae, written to DIR once: `fog` is visible everywhere and thin,
so that rays go all the way; `blobs` is empty but for a few Gaussians. 512x512 pixels, orthographic, oblique; a step of one voxel unless
FLAGS (KEY=VALUE, as --set takes it, or any flag of `vr`) say otherwise, so that rays take samples in proportion to n, while voxels grow with n^3.

Memory beyond the volume is the process's peak, less that of the same run on a volume of 2x2x2 (the program itself, the picture), less the
voxels. The volume is mapped from its file: its pages count where they were touched, and all are. Needs numpy.
"""
import argparse
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from vr import Vr

EDGE = 1024.0  # world length of the cube
BLOBS = [  # centre in [0, 1]^3, standard deviation, amplitude
    ((0.30, 0.35, 0.40), 0.040, 250.0), ((0.68, 0.60, 0.30), 0.050, 200.0), ((0.50, 0.72, 0.70), 0.030, 230.0),
    ((0.75, 0.25, 0.66), 0.045, 180.0), ((0.22, 0.70, 0.22), 0.035, 240.0),
]
WAVES = [  # cycles along x, y, z, and phase: a sum of products of sines
    ((3, 2, 4), 0.1), ((5, 7, 6), 1.3), ((11, 9, 8), 2.2), ((2, 5, 3), 0.7),
]
POINTS = {
    "fog": [(0, (0.3, 0.4, 0.7), 0.0005), (128, (0.75, 0.78, 0.8), 0.002), (255, (1.0, 0.85, 0.6), 0.005)],
    "blobs": [(0, (0.2, 0.3, 0.9), 0.0), (20, (0.2, 0.3, 0.9), 0.0), (120, (0.9, 0.7, 0.3), 0.02), (255, (1.0, 0.3, 0.2), 0.05)],
}
UNIT = 4.0  # world length that the opacities belong to


def slices(kind, n):
    """The volume, slice by slice: it need not fit into memory."""
    t = np.arange(n) / (n - 1)
    for z in t:
        v = np.zeros((n, n))
        if kind == "blobs":
            for (cx, cy, cz), sigma, amplitude in BLOBS:
                x, y, w = (np.exp(-0.5 * ((u - c) / sigma) ** 2) for u, c in ((t, cx), (t, cy), (z, cz)))
                v += amplitude * w * np.outer(y, x)
        else:
            for (fx, fy, fz), phase in WAVES:
                x, y, w = (np.sin(2 * np.pi * f * u + phase) for u, f in ((t, fx), (t, fy), (z, fz)))
                v += w * np.outer(y, x)
            v = 128 + 100 * v / len(WAVES)
        yield np.floor(np.clip(v, 0, 255) + 0.5).astype(np.uint8)


def scene(work, kind, n):
    """Path of a scene file; makes what is not there yet."""
    raw = os.path.join(os.path.abspath(work), f"{kind}{n}.raw")
    if not os.path.exists(raw):
        with open(raw + ".half", "wb") as f:
            for s in slices(kind, n):
                s.tofile(f)
        os.replace(raw + ".half", raw)
    points = ",\n".join(f"  {{value = {v}.0, color = {list(c)}, opacity = {a}}}" for v, c, a in POINTS[kind])
    toml = os.path.join(work, f"{kind}{n}.toml")
    with open(toml, "w") as f:
        f.write(f"""[volume]
path = "{raw}"
dims = [{n}, {n}, {n}]
type = "u8"
spacing = [{EDGE / (n - 1)!r}, {EDGE / (n - 1)!r}, {EDGE / (n - 1)!r}]
[transfer]
unit_distance = {UNIT}
points = [
{points}
]
[camera]
eye = [1300.0, -1000.0, 1100.0]
target = [512.0, 512.0, 512.0]
up = [0.0, 0.0, 1.0]
height = 1700.0
[image]
size = [512, 512]
""")
    return toml


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", required=True)
    parser.add_argument("--vr", default="target/release/vr")
    parser.add_argument("--sizes", nargs="+", type=int, default=[128, 256, 512, 1024])
    parser.add_argument("--kinds", nargs="+", choices=list(POINTS), default=list(POINTS))
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--frames", type=int, default=5)
    given, flags = parser.parse_known_args()
    os.makedirs(given.work, exist_ok=True)

    def bench(kind, n):
        return Vr(given.vr, scene(given.work, kind, n)).bench(" ".join(flags or ["step=1"]), given.threads, given.frames, 10)

    print("| volume | voxels | prepare, ms | frame, ms | CPU, ms | samples | CPU ns a sample | memory beyond, MB | of the volume |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|--:|", flush=True)
    for kind in given.kinds:
        base = bench(kind, 2)["peak_bytes"]
        for n in given.sizes:
            b = bench(kind, n)
            beyond = b["peak_bytes"] - base - n ** 3
            print(f"| {kind} {n}³ | {n ** 3 / 1e6:.1f} M | {b['prepare_ms']:.1f} | {b['median_ms']:.1f} | {b['cpu_ms']:.1f} "
                  f"| {b['samples'] / 1e6:.2f} M | {1e6 * b['cpu_ms'] / b['samples']:.2f} | {beyond / 1e6:.1f} "
                  f"| {100 * beyond / n ** 3:.1f} % |", flush=True)


if __name__ == "__main__":
    main()
