#!/usr/bin/env python3
"""Times `vr` and VolPack, the original shear-warp, in turns, in one run, on the peers' scenes; prints Markdown tables.

    against_volpack.py --peers DIR --work DIR --vr target/release/vr [--volpack PROGRAM] [--scenes WORD ...]
        [--candidate FLAGS ...] [--candidates FILE] [--rounds 5] [--frames 9] [--json OUT]
        [--size 1024] [--threads 1 2] [--preparation] [--perspective]

DIR of --work holds what is made once, as for against_vtk.py, and the peers' program `volpack_bench` where --volpack names no other. FLAGS
are flags of `vr`; KEY=VALUE stands for --set KEY=VALUE. FILE has one candidate a line; # starts a comment. Words of --scenes select scenes
that contain one of them, of the orthographic ones without shading.

In each round VolPack draws some frames (its program up to three times as many where times scatter), then every candidate the same turning
views, 512x512. All are pinned to one processor, the last. A time is the median over rounds of the median over frames, of CPU time: it
does not see who else uses the machine. Wall-clock times do, and are those of the best round. RMSE: premultiplied RGB of frame 0 against
the exact picture, without 2 pixels around the outline of the box. Ratios are VolPack's over ours: above 1, ours is faster, or more
accurate. VolPack runs with run-length encoding, drops no voxel, and ends rays at an opacity of 0.99.

--size N: time of NxN pixels over that of 512x512, of VolPack and of ours.
--threads N ...: wall-clock time on one thread over that on N, of ours; holds only on a machine left alone.
--preparation: wall-clock time in ms before the first frame: of VolPack to classify the voxels, of ours to prepare; and what our first frame
    takes above later ones.
--perspective: without VolPack, which has none: time in perspective over that of the same scene in orthographic projection, in turns.

Needs numpy; to build VolPack's program, also a C compiler and libvolpack1-dev.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
from vr import listed, pinned

SETTING = ("-algo", "rle", "-minop", "0", "-maxray", "0.99")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--vr", default="target/release/vr")
    parser.add_argument("--volpack")
    parser.add_argument("--scenes", nargs="+", default=[""])
    parser.add_argument("--candidate", action="append", default=[])
    parser.add_argument("--candidates")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--frames", type=int, default=9)
    parser.add_argument("--size", type=int)
    parser.add_argument("--threads", nargs="+", type=int, default=[1])
    parser.add_argument("--preparation", action="store_true")
    parser.add_argument("--perspective", action="store_true")
    parser.add_argument("--json")
    given = parser.parse_args()
    if given.candidates:
        given.candidate += listed(given.candidates)
    given.candidate = list(dict.fromkeys(given.candidate)) or ["--renderer shearwarp"]
    given.threads = [n for n in given.threads if n > 1]
    if given.perspective and (given.size or given.threads or given.preparation):
        parser.error("--perspective stands alone")
    given.peers = os.path.abspath(given.peers)
    sys.path.insert(0, given.peers)  # for peer_scenes
    if not given.volpack:
        given.volpack = os.path.join(os.path.abspath(given.work), "volpack_bench")
        if not given.perspective and not os.path.exists(given.volpack):
            subprocess.run(["make", "-s", "-C", given.peers, f"BIN={given.volpack}"], check=True)
    return given


class VolPack:
    """The peers' program that times VolPack, and a scene."""

    def __init__(self, program, peers, volumes, name):
        self.program, self.volumes = os.path.abspath(program), volumes
        self.drawn = {}  # frames of the last round, by size
        line = [sys.executable, os.path.join(peers, "scene_flat.py"), os.path.join(peers, "scenes", name + ".json")]
        self.scene = subprocess.run(line, capture_output=True, check=True).stdout

    def run(self, size, frames):
        """What it tells, and the picture of frame 0."""
        import numpy as np
        with tempfile.TemporaryDirectory() as folder:
            line = [self.program, self.volumes, folder, "-size", str(size), *SETTING, "-tag", "volpack-q", "-frames", str(frames)]
            done = subprocess.run(line, input=self.scene, capture_output=True, preexec_fn=pinned(1))
            if done.returncode:
                raise RuntimeError(f"{' '.join(line)}: {done.stderr.decode().strip()}")
            (told,) = (f for f in os.listdir(folder) if f.endswith(".json"))
            with open(os.path.join(folder, told)) as f:
                told = json.load(f)
            return told, np.load(os.path.join(folder, told["image"]))

    def picture(self):
        from peer_scenes import SIZE
        return self.run(SIZE, 1)[1]

    def bench(self, size, frames):
        told, _ = self.run(size, frames)
        setup, self.drawn[size] = told["setup_s"], told["frames"]
        return {"cpu_ms": told["ms_cpu_median"], "wall_ms": told["ms_median"], "frames": told["frames"],
                "prepare_ms": 1e3 * setup["classify"], "build_ms": 1e3 * setup["build"]}


class Ours:
    """A candidate on a scene. Its frames begin with the peers' frame 1, as VolPack's do."""

    def __init__(self, vr, scene, options):
        import common
        self.vr, self.options, self.turn = vr, options, scene["camera"]["azimuth_step_deg"]
        self.begin = "--eye=" + ",".join(repr(float(x)) for x in common.camera_position(scene, 1))

    def picture(self):
        return self.vr.picture(self.options)

    def bench(self, size, frames, threads=1, flags=""):
        told = self.vr.bench(f"{self.options} --size {size}x{size} {self.begin} {flags}", threads, frames, self.turn)
        return {"cpu_ms": told["cpu_ms"], "wall_ms": told["median_ms"], "frames": frames, "frames_ms": told["frames_ms"],
                "prepare_ms": told["prepare_ms"], "samples": told["samples"], "peak_bytes": told["peak_bytes"]}


def in_turns(rounds, runs):
    """Does each of the runs, under its key, once in every round: lists of answers under the same keys."""
    answers = {key: [] for key in runs}
    for _ in range(rounds):
        for key, run in runs.items():
            answers[key].append(run())
    return answers


def entry(answers, error):
    """The figures of one table cell, with all that they come from."""
    return {"ms": middle(answers, "cpu_ms"), "rmse": error[0], "max": error[1], "rounds": answers}


def middle(answers, what):
    return statistics.median(a[what] for a in answers)


def best(answers, what):
    return min(a[what] for a in answers)


def able(candidates, judge):
    """Errors of those that can draw the scene, by their flags."""
    errors = {}
    for options, ours in candidates.items():
        try:
            errors[options] = judge(ours.picture())
        except RuntimeError as e:  # an option that this scene cannot have
            print(e, file=sys.stderr)
    return errors


def against(given, name):
    """VolPack and the candidates on one scene."""
    import peer_scenes
    size, frames = peer_scenes.SIZE, given.frames
    scene, vr, judge = peer_scenes.prepare(given.peers, given.work, given.vr, name)
    volpack = VolPack(given.volpack, given.peers, os.path.join(given.work, "vol"), name)
    candidates = {options: Ours(vr, scene, options) for options in given.candidate}
    errors, volpack_error = able(candidates, judge), judge(volpack.picture())

    runs = {}
    for n in filter(None, (size, given.size)):
        runs["volpack", n] = lambda n=n: volpack.bench(n, frames)
        for options in errors:
            runs[options, n] = lambda n=n, ours=candidates[options]: ours.bench(n, volpack.drawn[n])
    for options in errors:
        for threads in given.threads:
            runs[options, "threads", threads] = lambda t=threads, ours=candidates[options]: ours.bench(size, volpack.drawn[size], t)
        if given.preparation:
            runs[options, "first"] = lambda ours=candidates[options]: ours.bench(size, 1, flags="--warm-up 0")
    answers = in_turns(given.rounds, runs)

    def grown(who):
        return middle(answers[who, given.size], "cpu_ms") / middle(answers[who, size], "cpu_ms")

    theirs = entry(answers["volpack", size], volpack_error) | {"prepare_ms": best(answers["volpack", size], "prepare_ms")}
    if given.size:
        theirs |= {"grown": grown("volpack"), "large": answers["volpack", given.size]}
    result = {"scene": name, "load": os.getloadavg()[0], "volpack": theirs, "candidates": {}}
    for options, error in errors.items():
        mine = entry(answers[options, size], error)
        mine |= {"ratio": theirs["ms"] / mine["ms"], "rmse_ratio": theirs["rmse"] / mine["rmse"]}
        if given.size:
            mine |= {"grown": grown(options), "large": answers[options, given.size]}
        wall = best(answers[options, size], "wall_ms")
        mine["threads"] = {n: wall / best(answers[options, "threads", n], "wall_ms") for n in given.threads}
        mine["on_threads"] = {n: answers[options, "threads", n] for n in given.threads}
        mine["prepare_ms"] = best(answers[options, size], "prepare_ms")
        if given.preparation:
            mine["first_extra_ms"] = best(answers[options, "first"], "wall_ms") - wall
        result["candidates"][options] = mine
    return result


def in_perspective(given, name):
    """The candidates on one scene in both projections."""
    import peer_scenes
    kinds, runs, errors = ("ortho", "persp"), {}, {}
    for kind in kinds:
        scene, vr, judge = peer_scenes.prepare(given.peers, given.work, given.vr, name.replace("_ortho", "_" + kind))
        candidates = {options: Ours(vr, scene, options) for options in given.candidate}
        for options, error in able(candidates, judge).items():
            errors[options, kind] = error
            runs[options, kind] = lambda ours=candidates[options]: ours.bench(peer_scenes.SIZE, given.frames)
    answers = in_turns(given.rounds, runs)
    result = {"scene": name.replace("_ortho", ""), "load": os.getloadavg()[0], "candidates": {}}
    for options in given.candidate:
        if all((options, kind) in errors for kind in kinds):
            mine = {kind: entry(answers[options, kind], errors[options, kind]) for kind in kinds}
            result["candidates"][options] = mine | {"ratio": mine["persp"]["ms"] / mine["ortho"]["ms"]}
    return result


def columns(given):
    """What the table of a candidate tells: title, what the cell says of (result, candidate's part), and the number its mean is of."""
    from peer_scenes import SIZE, cells
    if given.perspective:
        return [("orthographic", lambda r, c: cells(c["ortho"]), None), ("perspective", lambda r, c: cells(c["persp"]), None),
                ("perspective / orthographic", None, lambda r, c: c["ratio"])]
    out = [("VolPack", lambda r, c: cells(r["volpack"]), None), ("ours", lambda r, c: cells(c), None),
           ("VolPack / ours: time", None, lambda r, c: c["ratio"]), ("RMSE", None, lambda r, c: c["rmse_ratio"])]
    if given.size:
        out += [(f"{given.size}² / {SIZE}²: VolPack", None, lambda r, c: r["volpack"]["grown"]), ("ours", None, lambda r, c: c["grown"])]
    out += [(f"1 / {n} threads, wall-clock", None, lambda r, c, n=n: c["threads"][n]) for n in given.threads]
    if given.preparation:
        out += [("prepare: VolPack", lambda r, c: f"{r['volpack']['prepare_ms']:.0f}", None),
                ("ours", lambda r, c: f"{c['prepare_ms']:.0f}", None),
                ("first frame", lambda r, c: f"{c['first_extra_ms']:+.0f}", None)]
    return out


def table(given, options, results):
    """All scenes of one candidate, and geometric means."""
    lines, shown = [], columns(given)
    lines.append(f"\n`{options}`: ms a frame (CPU time, median; RMSE)\n")
    lines.append("| " + " | ".join(["scene", *(title for title, _, _ in shown)]) + " |")
    lines.append("|---|" + "--:|" * len(shown))
    numbers = {k: [] for k, (_, _, number) in enumerate(shown) if number}
    for result in results:
        mine, line = result["candidates"].get(options), [result["scene"]]
        for k, (_, cell, number) in enumerate(shown):
            if mine is None:
                line.append("–")
            elif number:
                numbers[k].append(number(result, mine))
                line.append(f"{numbers[k][-1]:.2f}")
            else:
                line.append(cell(result, mine))
        lines.append("| " + " | ".join(line) + " |")
    means = [f"{statistics.geometric_mean(numbers[k]):.2f}" if numbers.get(k) else "" for k in range(len(shown))]
    lines.append("| " + " | ".join(["geometric mean", *means]) + " |")
    return "\n".join(lines)


def main():
    given = arguments()
    import peer_scenes
    scenes = [n for n in peer_scenes.names(given.peers) if n.endswith("_ortho") and any(word in n for word in given.scenes)]
    results = []
    for name in scenes:
        print(name, file=sys.stderr)
        try:
            results.append((in_perspective if given.perspective else against)(given, name))
        except RuntimeError as e:  # a program ended while it was timed: the other scenes are worth their tables
            print(f"{name}: {e}", file=sys.stderr)
        if given.json:
            with open(given.json, "w") as f:
                json.dump(results, f, indent=1)
    for options in given.candidate:
        print(table(given, options, results), flush=True)


if __name__ == "__main__":
    main()
