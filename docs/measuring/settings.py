#!/usr/bin/env python3
"""Times settings of `vr` in turns and compares their pictures: what each acceleration gains, and what it changes. Prints Markdown.

    settings.py --scene FILE ... --base FLAGS --setting FLAGS ... [--settings FILE] [--vr target/release/vr]
        [--threads 1] [--rounds 3] [--frames 5] [--azimuth-step 10] [--json OUT]

FLAGS are flags of `vr`; KEY=VALUE stands for --set KEY=VALUE. FILE has one setting a line; # starts a comment. In each round every setting
draws the same turning views. A time is the median over rounds: of CPU time on one thread (pinned; it does not see who else uses the
machine), of wall-clock time on several. Gain: time of the base over time of the setting, and its samples over the setting's. Change: largest
difference of any component of frame 0 from the base's. Error: against the reference, frame 0, RGBA on 64x64 of its pixels. Needs numpy.
"""
import argparse
import json
import os
import statistics
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from vr import Vr, listed


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", nargs="+", required=True)
    parser.add_argument("--base", default="")
    parser.add_argument("--setting", action="append", default=[])
    parser.add_argument("--settings")
    parser.add_argument("--vr", default="target/release/vr")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--azimuth-step", type=float, default=10)
    parser.add_argument("--json")
    given = parser.parse_args()
    if given.settings:
        given.setting += listed(given.settings)
    return given


def measure(given, scene):
    """A line for the base and for each setting that can draw the scene."""
    vr = Vr(given.vr, scene)
    base, lines = vr.picture(given.base), {}
    for setting in [given.base, *given.setting]:
        try:
            change = float(abs(vr.picture(setting) - base).max())
        except RuntimeError as e:  # a combination that is refused: that is an answer, too
            print(f"{setting}: {e}", file=sys.stderr)
            continue
        lines.setdefault(setting, {"scene": scene, "setting": setting, "change": change, "wall": [], "cpu": []})
    for k in range(given.rounds):
        for setting, line in lines.items():
            b = vr.bench(setting, given.threads, given.frames, given.azimuth_step, error=k == 0)
            line["wall"] += b["frames_ms"]
            line["cpu"].append(b["cpu_ms"])
            line["samples"], line["prepare_ms"] = b["samples"], b["prepare_ms"]
            line["error"] = b.get("error") or line["error"]
    for line in lines.values():
        line["ms"] = statistics.median(line["cpu" if given.threads == 1 else "wall"])
        line["gain"] = lines[given.base]["ms"] / line["ms"]
        line["gain_samples"] = lines[given.base]["samples"] / max(line["samples"], 1)
    return list(lines.values())


def main():
    given, results = arguments(), []
    print(f"{given.threads} thread{'s' * (given.threads > 1)}, {'CPU' if given.threads == 1 else 'wall-clock'} time, median; "
          f"turning by {given.azimuth_step:g} degrees a frame\n")
    print("| scene | setting | prepare, ms | frame, ms | gain | samples | fewer by | change | max error | RMSE |")
    print("|---|---|--:|--:|--:|--:|--:|--:|--:|--:|", flush=True)
    for scene in given.scene:
        for r in measure(given, scene):
            results.append(r)
            name = os.path.splitext(os.path.basename(scene))[0]
            change = "0" if r["change"] == 0 else f"{r['change']:.1e}"
            print(f"| {name} | {r['setting'] or 'default'} | {r['prepare_ms']:.1f} | {r['ms']:.1f} | {r['gain']:.2f} "
                  f"| {r['samples'] / 1e6:.2f} M | {r['gain_samples']:.2f} | {change} | {r['error']['max']:.1e} "
                  f"| {r['error']['rmse']:.1e} |", flush=True)
            if given.json:
                with open(given.json, "w") as f:
                    json.dump(results, f, indent=1)


if __name__ == "__main__":
    main()
