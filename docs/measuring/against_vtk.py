#!/usr/bin/env python3
"""Times `vr` and VTK's CPU ray caster in turns, in one run, on the peers' scenes; prints Markdown tables.

    against_vtk.py --peers DIR --work DIR --vr target/release/vr [--scenes WORD ...] [--threads 1 2]
        [--same-step FLAGS] [--candidate FLAGS ...] [--candidates FILE] [--rounds 3] [--frames 5] [--json OUT]

DIR of --work holds what is made once: volumes in `vol` (by the peers' gen_volumes.py), scene files in `toml`, exact pictures in `ref`
(`vr render --renderer physics`, within 1e-5; minutes). FLAGS are flags of `vr`; KEY=VALUE stands for --set KEY=VALUE. FILE has one
candidate a line; # starts a comment. Words of --scenes select scenes that contain one of them.

For each scene: every candidate is drawn once for its error and timed quickly; the cheapest whose RMSE is at most VTK's, for each of VTK's
steps, is then timed with VTK and with --same-step in turns: in each round, some frames of each. Every program draws the same turning
views. A time is the median over all rounds: of CPU time on one thread (pinned; it does not see who else uses the machine), of
wall-clock time on several. RMSE: premultiplied RGB of frame 0, without 2 pixels around the outline of the box, as the peers have it. Of
shaded scenes only the speed at the same step is compared: VTK defines its gradients and its light otherwise. VTK's time is that of its
whole frame, as a user waits for it and as the peers have it; the summary also tells the ratios to its core, the casting of rays alone.
Needs numpy and vtk.
"""
import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
from vr import Vr, listed

STEPS = ("1.0", "0.5")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--vr", default="target/release/vr")
    parser.add_argument("--scenes", nargs="+", default=[""])
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--same-step", default="step=1")
    parser.add_argument("--candidate", action="append", default=[])
    parser.add_argument("--candidates")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--json")
    given = parser.parse_args()
    if given.candidates:
        given.candidate += listed(given.candidates)
    given.peers = os.path.abspath(given.peers)
    sys.path.insert(0, given.peers)  # for peer_scenes
    return given


class Vtk:
    """A process that draws with VTK."""

    def __init__(self, peers, scene, volumes, threads):
        path = os.path.join(peers, "scenes", scene + ".json")
        command = [sys.executable, os.path.join(HERE, "vtk_worker.py"), peers, path, volumes, str(threads)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.version = self.answer()["version"]

    def answer(self):
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError("VTK ended; does `vtk_bench.py` of the peers run here?")
        return json.loads(line)

    def ask(self, step, what):
        self.process.stdin.write(f"{step} {what}\n")
        self.process.stdin.flush()
        return self.answer()

    def picture(self, step):
        import numpy as np
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "x.npy")
            self.ask(step, f"save {path}")
            return np.load(path)

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def clock(times, threads, part=""):
    """The time that counts, of many frames."""
    return statistics.median(times[part + ("cpu" if threads == 1 else "wall")])


def measure(given, name, threads, known):
    """One scene on so many threads. `known` keeps the errors of pictures: they do not depend on threads."""
    import peer_scenes
    scene, vr, judge = peer_scenes.prepare(given.peers, given.work, given.vr, name)
    turn = scene["camera"]["azimuth_step_deg"]
    vtk = Vtk(given.peers, name, os.path.join(given.work, "vol"), threads)

    def error_of(what, draw):
        if (name, what) not in known:
            try:
                known[name, what] = judge(draw(what))
            except RuntimeError as e:  # an option set that this scene cannot have
                print(f"{name}: {e}", file=sys.stderr)
                known[name, what] = (math.inf, math.inf)
        return known[name, what]

    vtk_error = {step: error_of(step, vtk.picture) for step in STEPS}

    tried = []
    for options in [] if scene["shading"] else given.candidate:
        error = error_of(options, vr.picture)
        if error[0] <= max(e[0] for e in vtk_error.values()):
            quick = vr.bench(options, threads, 3, turn)
            time = quick["cpu_ms"] if threads == 1 else quick["min_ms"]
            tried.append({"options": options, "error": error, "quick_ms": time})
    best = {}
    for step in STEPS:
        good = [t for t in tried if t["error"][0] <= vtk_error[step][0]]
        best[step] = min(good, key=lambda t: t["quick_ms"])["options"] if good else None

    ours = {given.same_step: error_of(given.same_step, vr.picture)}
    ours |= {t["options"]: t["error"] for t in tried if t["options"] in best.values()}
    times = {key: {"wall": [], "cpu": [], "core_wall": [], "core_cpu": []} for key in [*STEPS, *ours]}
    samples, prepare_ms = {}, {}
    for _ in range(given.rounds):
        for step in STEPS:
            answer = vtk.ask(step, given.frames)
            for kind, ms in answer.items():
                times[step][kind] += ms
        for options in ours:
            answer = vr.bench(options, threads, given.frames, turn)
            times[options]["wall"] += answer["frames_ms"]
            times[options]["cpu"].append(answer["cpu_ms"] or math.nan)
            samples[options], prepare_ms[options] = answer["samples"], answer["prepare_ms"]
    vtk.close()
    result = {"scene": name, "threads": threads, "vtk": {}, "shaded": bool(scene["shading"]), "load": os.getloadavg()[0],
              "vtk_version": vtk.version, "times": times, "tried": tried}
    for step in STEPS:
        core = clock(times[step], threads, "core_")
        result["vtk"][step] = {"ms": clock(times[step], threads), "core_ms": core, "rmse": vtk_error[step][0]}

    def of_ours(options, step):
        if options is None:
            return None
        ms = clock(times[options], threads)
        return {"options": options, "ms": ms, "rmse": ours[options][0], "max": ours[options][1], "samples": samples[options],
                "prepare_ms": prepare_ms[options], "ratio": result["vtk"][step]["ms"] / ms,
                "core_ratio": result["vtk"][step]["core_ms"] / ms}

    result["same_step"] = of_ours(given.same_step, "1.0")
    result["equal_error"] = {step: of_ours(best[step], step) for step in STEPS}
    return result


def row(result):
    from peer_scenes import cells
    line = [result["scene"], cells(result["vtk"]["1.0"]), cells(result["same_step"]), f"{result['same_step']['ratio']:.1f}"]
    for step in STEPS:
        mine = result["equal_error"][step]
        if step == "0.5":
            line.append(cells(result["vtk"][step]))
        line += [f"{cells(mine)} {mine['options']}", f"{mine['ratio']:.1f}"] if mine else ["–", "–"]
    return "| " + " | ".join(line) + " |"


def summary(results):
    columns = {"same step": [r["same_step"] for r in results]}
    for step in STEPS:
        columns[f"equal error, step {float(step):g}"] = [e for r in results if (e := r["equal_error"][step])]
    lines = []

    def mean(ratios):
        return math.exp(statistics.fmean(math.log(r) for r in ratios))

    for what, entries in columns.items():
        if entries:
            whole, core = ([e[key] for e in entries] for key in ("ratio", "core_ratio"))
            lines.append(f"- {what}: least {min(whole):.1f}, geometric mean {mean(whole):.1f}, of {len(whole)} scenes "
                         f"(of VTK's core alone: {min(core):.1f}, {mean(core):.1f})")
    lacking = [f"{r['scene']} ({step})" for r in results for step in STEPS if not r["shaded"] and not r["equal_error"][step]]
    if lacking:
        lines.append("- no candidate is as accurate as VTK on: " + ", ".join(lacking))
    return "\n".join(lines)


def main():
    given = arguments()
    import peer_scenes
    scenes = [n for n in peer_scenes.names(given.peers) if any(word in n for word in given.scenes)]
    results, known = [], {}
    for threads in given.threads:
        print(f"\n{threads} thread{'s' * (threads > 1)}: ms a frame ({'CPU' if threads == 1 else 'wall-clock'} time, median; RMSE)\n")
        print(f"| scene | VTK, step 1 | ours, {given.same_step} | ratio | ours at that RMSE or less | ratio "
              "| VTK, step 0.5 | ours at that RMSE or less | ratio |")
        print("|---|--:|--:|--:|--:|--:|--:|--:|--:|", flush=True)
        for name in scenes:
            results.append(measure(given, name, threads, known))
            print(row(results[-1]), flush=True)
            if given.json:
                with open(given.json, "w") as f:
                    json.dump(results, f, indent=1)
        print("\n" + summary([r for r in results if r["threads"] == threads]), flush=True)


if __name__ == "__main__":
    main()
