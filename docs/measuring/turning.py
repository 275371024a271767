#!/usr/bin/env python3
"""How far pictures change from step to step as the camera turns about a scene, renderer beside renderer; prints a Markdown table.

    turning.py --scene FILE ... [--vr target/release/vr] [--candidate FLAGS ...] [--steps 72] [--size 256]

For each axis of the world the camera goes once around the scene's target, as far away as in the scene, at right angles to the axis, which
points up in the picture. FLAGS are flags of `vr`; KEY=VALUE stands for --set KEY=VALUE; the first candidate is the one that the others
stand beside.

A change is the RMSE between neighbouring pictures, of all four premultiplied components. A renderer that jumps where it changes its ways
(shear-warp its axis at 45 degrees, say) has a largest change above that of one that does not, for the same step. Besides, of each step the
change is divided by the first candidate's: the largest of these is a jump that hides among larger changes elsewhere.

Needs numpy.
"""
import argparse
import os
import re
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import exr
from vr import Vr


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", nargs="+", required=True)
    parser.add_argument("--vr", default="target/release/vr")
    parser.add_argument("--candidate", action="append", default=[])
    parser.add_argument("--steps", type=int, default=72)
    parser.add_argument("--size", type=int, default=256)
    given = parser.parse_args()
    given.candidate = given.candidate or ["--renderer raycast", "--renderer shearwarp"]
    return given


def camera(scene):
    """Eye and target, as the scene file has them."""
    with open(scene) as f:
        text = f.read()
    found = (re.search(rf"^{key}\s*=\s*\[(.*?)\]", text, re.MULTILINE | re.DOTALL) for key in ("eye", "target"))
    return [np.array([float(x) for x in match.group(1).split(",")]) for match in found]


def pictures(vr, flags, scene, axis, given, folder):
    """One after another, the first again as the last."""
    eye, target = camera(scene)
    distance, up = np.linalg.norm(eye - target), np.eye(3)[axis]
    ahead, aside = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
    for step in range(given.steps + 1):
        angle = 2 * np.pi * step / given.steps
        at = target + distance * (np.cos(angle) * ahead + np.sin(angle) * aside)
        path = os.path.join(folder, "x.exr")
        place = [f"--{name}=" + ",".join(repr(float(x)) for x in value) for name, value in (("eye", at), ("up", up))]
        vr.write(" ".join([flags, f"--size {given.size}x{given.size}", *place]), path)
        yield exr.rgba(path)


def changes(vr, flags, scene, axis, given):
    """Of each step."""
    out, before = [], None
    with tempfile.TemporaryDirectory() as folder:
        for picture in pictures(vr, flags, scene, axis, given, folder):
            if before is not None:
                out.append(float(np.sqrt(np.mean((picture.astype(np.float64) - before) ** 2))))
            before = picture
    return np.array(out)


def main():
    given = arguments()
    print("| scene | axis | renderer | largest change | mean change | largest beside the first's |\n|---|---|---|--:|--:|--:|")
    for scene in given.scene:
        vr, name = Vr(given.vr, scene), os.path.splitext(os.path.basename(scene))[0]
        for axis in range(3):
            first = None
            for flags in given.candidate:
                now = changes(vr, flags, scene, axis, given)
                first = now if first is None else first
                beside = np.max(now / np.maximum(first, 1e-12))
                print(f"| {name} | {'xyz'[axis]} | `{flags}` | {now.max():.5f} | {now.mean():.5f} | {beside:.3f} |", flush=True)


if __name__ == "__main__":
    main()
