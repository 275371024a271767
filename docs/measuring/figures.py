#!/usr/bin/env python3
"""Makes the tables of the pages from measured values, and measures these again.

    figures.py --render                puts the values of docs/figures/figures.json into the pages
    figures.py --check                 fails where a page differs from that; Python alone, and a moment
    figures.py --list                  every table: its page, its commands, when and where it was measured, how to measure it again
    figures.py NAME ... [--times] [--vr target/release/vr] [--peers DIR] [--work DIR] [--cache DIR]
                                       measures these tables, writes the values and renders the pages
    figures.py NAME --from FILE        takes the values from what the table's command has printed elsewhere

A table stands in a page between `<!-- figures: NAME -->` and `<!-- /figures -->`; tables.md says what it looks like, with a place for each
number: {COLUMN:FORMAT} in the line of a row, {TABLE > ROW > COLUMN:FORMAT} anywhere (without TABLE: its own). A line with {row} is
repeated for every row that has no line of its own ({row=ROW}). `least` and `most` before a place are those of several columns, joined by
+, and with * for the row, of all rows. A cell without values is a dash.

Every value in figures.json has a unit, and the command, date and machine of its measurement. Errors and counts are the same on every
machine, busy or not, and are replaced. Times are replaced only with --times, on a machine left alone; ratios of times ("times") also
without, if the processor is the one that they were measured on: the text around a table may name it. What needs a thing that is absent
is kept, and a line says so. Measuring needs numpy, and the program, or cargo for examples and tests; --peers is the peers' folder, --work
holds what is made of it, and --cache the exact pictures.
"""
import argparse
import datetime
import functools
import glob
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
DATA = os.path.join(ROOT, "docs", "figures", "figures.json")
TABLES = os.path.join(HERE, "tables.md")
BLOCK = re.compile(r"^<!-- figures: (\S+) -->\n(.*?)^<!-- /figures -->$", re.MULTILINE | re.DOTALL)
PLACE = re.compile(r"\{(?:(least|most) )?([^{}]+?)(?::([^{}: ]+))?\}")
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
TIMES = ("ms", "ns", "a µs")  # units of what depends on the machine and on who else uses it
NUMBER = r"([-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?)"


# Values

class Values:
    """figures.json: of each table its units by column, the order of its rows, and measurements."""

    def __init__(self):
        with open(DATA) as f:
            self.tables = json.load(f)

    def rows(self, table):
        """Of a table, by row and column, whichever measurement they are from."""
        out = {row: {} for row in self.tables[table]["rows"]}
        for measurement in self.tables[table]["measured"]:
            for row, cells in measurement["values"].items():
                out[row].update(cells)
        return out

    def at(self, table, row, columns):
        """Values of columns joined by +, of a row, or of all for *."""
        rows = self.rows(table)
        found = [rows[r].get(column) for r in (rows if row == "*" else [row]) for column in columns.split(" + ")]
        return [value for value in found if value is not None]

    def record(self, table, command, values, times):
        """Puts new values in place of old ones; tells what has changed."""
        here, units = machine(), self.tables[table]["units"]
        measured, taken = self.tables[table]["measured"], {}
        for old in measured:
            same = old["machine"]["cpu"] == here["cpu"]
            for row, cells in old["values"].items():
                for column in list(cells):
                    new, unit = values.get(row, {}).get(column), units[column]
                    if new is None:
                        continue
                    if not times and (unit in TIMES or unit == "times" and not same):
                        print(f"{table}: {row}, {column}: kept at {cells[column]} {unit}, now {new:.4g} on {here['cpu']}")
                        continue
                    new = new if isinstance(new, str) else float(f"{new:.6g}")
                    if new != cells[column]:
                        print(f"{table}: {row}, {column}: {cells[column]} -> {new} {unit}")
                    taken.setdefault(row, {})[column] = new
                    del cells[column]
            old["values"] = {row: cells for row, cells in old["values"].items() if cells}
        # What has a place and was never measured has no old value.
        known = self.rows(table)
        for row in self.tables[table]["rows"]:
            for column, new in values.get(row, {}).items():
                if column in units and column not in known[row] and column not in taken.get(row, {}):
                    print(f"{table}: {row}, {column}: {new} {units[column]}")
                    taken.setdefault(row, {})[column] = new
        measured[:] = [old for old in measured if old["values"]]
        if taken:
            new = {"command": command, "date": str(datetime.date.today()), "machine": here}
            same = [old for old in measured if {k: old[k] for k in new} == new]
            if not same:
                measured.append(new | {"values": {}})
            for row, cells in taken.items():
                (same or measured)[-1]["values"].setdefault(row, {}).update(cells)

    def write(self):
        """Writes the file, a row of values in a line."""
        text = json.dumps(self.tables, ensure_ascii=False, indent=1)
        short = re.compile(r"(?<=: )(\{[^{}\[\]]*\}|\[[^{}\[\]]*\])")
        text = short.sub(lambda m: json.dumps(json.loads(m.group()), ensure_ascii=False), text)
        with open(DATA, "w") as f:
            f.write(text + "\n")


def machine():
    """The processor's name, and how many threads it has for this process."""
    try:
        with open("/proc/cpuinfo") as f:
            name = next(line.split(":", 1)[1].strip() for line in f if line.startswith("model name"))
    except (OSError, StopIteration):
        import platform
        name = platform.processor()
    return {"cpu": name, "threads": os.cpu_count()}


# Tables

def scientific(value, digits, between="e"):
    mantissa, exponent = f"{abs(value):.{digits}e}".split("e")
    exponent = str(int(exponent))
    return "−" * (value < 0) + mantissa + (between + exponent if between == "e" else between + exponent.translate(SUPERSCRIPTS))


def change(value):
    return "0" if value == 0 else f"{value:.1f}" if value >= 0.95 else scientific(value, 1)


FORMATS = {
    **{f"e{k}": lambda v, k=k: scientific(v, k) for k in range(3)},  # 2.4e-7
    **{f"p{k}": lambda v, k=k: scientific(v, k, "·10") for k in range(3)},  # 2.4·10⁻⁷
    "r": lambda v: f"{v:.5f}".lstrip("0"),  # .00709
    "gain": lambda v: f"{v:.1f}" if v >= 9.995 else f"{v:.2f}",
    "change": change,
    "also": lambda v: f", *{change(v)}*",  # nothing without a value
    "seconds": lambda v: f"{v / 1000:.1f}",  # of ms
    "size": lambda v: f"{abs(v):g}",  # without its sign
    "s": str,
}


def shown(value, form):
    if form in FORMATS:
        return FORMATS[form](value)
    text = format(value, form)
    return text if form.startswith("+") else text.replace("-", "−")


def filled(part, values, table, row):
    """A cell or a line with its numbers; a dash for a cell that has none."""
    lacking = []

    def place(match):
        which, path, form = match.groups()
        path = path.replace("\\|", "|")
        if form is None:
            return path.removeprefix("row=") if path.startswith("row=") else row
        path = table + " " + path if path.startswith("> ") else path
        found = values.at(*(path.split(" > ") if " > " in path else (table, row, path)))
        if form != "also":
            lacking.append(not found)
        if which:
            found = [(min if which == "least" else max)(found)]
        return shown(found[0], form) if found else ""

    text = PLACE.sub(place, part)
    if not any(lacking):
        return text
    if all(lacking) and part.startswith(" "):
        return " – "
    raise ValueError(f"{table}: no value for a number in {part.strip()!r}")


def templates():
    """What each table looks like."""
    with open(TABLES) as f:
        return dict(BLOCK.findall(f.read()))


def rendered(table, template, values):
    """The table's Markdown."""
    own = [label.replace("\\|", "|") for label in re.findall(r"\{row=(.*?)\}", template)]
    lines = []
    for line in template.splitlines():
        label = re.search(r"\{row=(.*?)\}", line)
        rows = [label.group(1).replace("\\|", "|")] if label else [None]
        if "{row}" in line:
            rows = [row for row in values.tables[table]["rows"] if row not in own]
        cells = re.split(r"(?<!\\)\|", line)
        lines += ["|".join(filled(cell, values, table, row) for cell in cells) for row in rows]
    return "\n".join(lines) + "\n"


def pages():
    """Paths of all that may hold tables."""
    found = [os.path.join(ROOT, "README.md")]
    for pattern in ("*/README.md", "*/src/*/README.md", "docs/figures/*.md"):
        found += sorted(glob.glob(os.path.join(ROOT, pattern)))
    return found


def render(check):
    """Brings the pages up to date, or with `check` tells which are not."""
    values, looks, stale, used = Values(), templates(), [], set()
    for path in pages():
        with open(path) as f:
            text = f.read()

        def table(match):
            name = match.group(1)
            if name not in looks or name in used:
                raise ValueError(f"{path}: table {name} " + ("stands elsewhere, too" if name in used else "is not in tables.md"))
            used.add(name)
            return f"<!-- figures: {name} -->\n{rendered(name, looks[name], values)}<!-- /figures -->"

        new = BLOCK.sub(table, text)
        if new != text:
            stale.append(os.path.relpath(path, ROOT))
            if not check:
                with open(path, "w") as f:
                    f.write(new)
    for name in sorted((set(looks) | set(values.tables)) - used):
        raise ValueError(f"table {name} stands in no page")
    return stale


# Measurements: each function gives (command, values by row and column), one after another.

class Absent(Exception):
    """What a measurement needs and is not there."""


@functools.lru_cache(maxsize=None)
def output(command):
    """What a command line prints, run in the repository, once for all tables."""
    words = shlex.split(command)
    try:
        done = subprocess.run(words, capture_output=True, text=True, cwd=ROOT)
    except FileNotFoundError:
        raise Absent(words[0])
    if done.returncode:
        raise Absent(f"a command that succeeds: {command}: {done.stderr.strip()[-300:]}")
    return done.stdout


def taken(patterns, text, rename=lambda row: row):
    """Values by row and column, of lines that look as a pattern says: {row} a text, {COLUMN} a number."""
    values = {}
    for pattern in patterns:
        parts = re.split(r"\{(.*?)\}", pattern)
        columns = parts[1::2]
        kinds = ["(.+?)" if column == "row" else NUMBER for column in columns]
        line = "".join(re.escape(between) + kind for between, kind in zip(parts[::2], kinds + [""]))
        for match in re.finditer(f"^{line}$", text, re.MULTILINE):
            cells = dict(zip(columns, match.groups()))
            row = rename(cells.pop("row", ""))
            values.setdefault(row, {}).update((c, float(v.replace("−", "-"))) for c, v in cells.items() if c)
    return values


class Printed:
    """A command that prints the values, in lines as the patterns say."""

    def __init__(self, command, *patterns, rename=lambda row: row):
        self.command, self.patterns, self.rename = command, patterns, rename

    def read(self, text):
        return [(self.command, taken(self.patterns, text, self.rename))]

    def __call__(self, given):
        return self.read(output(self.command))


class Together:
    """Several of them."""

    def __init__(self, *parts):
        self.parts = parts

    def __call__(self, given):
        return [done for part in self.parts for done in part(given)]


class Needs:
    """A measurement that has to be made by hand, with its reason."""

    def __init__(self, what):
        self.what = what

    def __call__(self, given):
        raise Absent(self.what)


def program(given, scene):
    """`vr` on a scene file."""
    from vr import Vr
    if not os.path.exists(given.vr):
        raise Absent(f"{given.vr} (cargo build --release, or --vr)")
    return Vr(given.vr, scene)


def peer_scene(given, name):
    """Path of a scene file of one of the peers' scenes, with its volume; makes what is not there yet."""
    peer_scenes = peers(given)
    for folder in ("vol", "toml"):
        os.makedirs(os.path.join(given.work, folder), exist_ok=True)
    volumes, scene = os.path.join(given.work, "vol"), peer_scenes.load(given.peers, name)
    if not os.path.exists(os.path.join(volumes, scene["volume"]["file"])):
        make = [sys.executable, os.path.join(given.peers, "gen_volumes.py"), volumes, scene["volume"]["name"]]
        subprocess.run(make, check=True, stdout=subprocess.DEVNULL)
    path = os.path.join(given.work, "toml", name + ".toml")
    peer_scenes.write_toml(scene, volumes, path)
    return path


def peers(given):
    """The module peer_scenes."""
    if not given.peers or not given.work:
        raise Absent("the peers' folder (--peers DIR --work DIR)")
    sys.path.insert(0, os.path.abspath(given.peers))
    import peer_scenes
    return peer_scenes


def in_turns(given, scene, base, listed, rounds=3, frames=3):
    """What settings.py measures, by setting."""
    import settings
    program(given, scene)
    told = argparse.Namespace(vr=given.vr, base=base, setting=listed, threads=1, rounds=rounds, frames=frames, azimuth_step=10)
    return {line["setting"]: line for line in settings.measure(told, scene)}


def exact_error(given, vr, options):
    """RMSE of the scene's own view, RGBA, over all pixels. The exact picture takes a minute, once."""
    from vr import flags
    with tempfile.TemporaryDirectory() as folder:
        told = vr.run("render", flags(f"{options} --error full --cache {given.cache} -o {folder}/x.exr"))
    return told["error"]["rmse"]


def rules(given):
    """Errors of the rules; no time."""
    for row in ("mni opaque", "mni translucent", "blobs opaque", "blobs translucent"):
        name = row.replace("blobs", "blobs256").replace(" ", "_") + "_ortho"
        vr = program(given, peer_scene(given, name))
        values = {f"{rule} {step}": exact_error(given, vr, f"step={step} vector=off rule={rule}")
                  for rule in ("midpoint", "linear", "quadratic") for step in (4, 2, 1, 0.5, 0.25)}
        command = f"vr render --scene {name}.toml --set step=… --set vector=off --set rule=… --error full"
        yield command, {row: values}


def accelerations(given):
    """What each gains and changes. The scan and its transfer functions are not measured."""
    from vr import listed
    base, *others = listed(os.path.join(HERE, "accelerations.txt"))
    table = Values().tables["raycast-accelerations"]["rows"]
    for short, name in (("fog", "fog256_translucent_ortho"), ("blobs", "blobs256_opaque_ortho")):
        found, values = in_turns(given, peer_scene(given, name), base, others), {table[0]: {}}
        values[table[0]][f"{short} ms"] = found[base]["ms"]
        for row, setting in zip(table[1:], others):
            line = found[setting]
            values[row] = {f"{short} gain": line["gain"], f"{short} change": line["change"], f"{short} rmse": line["error"]["rmse"]}
        command = f"docs/measuring/settings.py --scene {name}.toml --base '{base}' --settings docs/measuring/accelerations.txt --frames 3"
        yield command, values
    print("raycast-accelerations: the scan's columns are kept: they need the head and its two transfer functions", file=sys.stderr)


def turned(given):
    """Changes from step to step."""
    import numpy as np
    import turning
    told = argparse.Namespace(steps=72, size=256)
    for name in ("mni_translucent_ortho", "blobs256_opaque_ortho"):
        scene = peer_scene(given, name)
        for axis in range(3):
            first, values = None, {}
            for flags in ("--renderer raycast", "--renderer shearwarp"):
                now = turning.changes(program(given, scene), flags, scene, axis, told)
                first = now if first is None else first
                beside = float(np.max(now / np.maximum(first, 1e-12)))
                values[f"{name} | {'xyz'[axis]} | `{flags}`"] = {"largest": float(now.max()), "mean": float(now.mean()), "beside": beside}
            yield f"docs/measuring/turning.py --scene {name}.toml", values


def canonical(given):
    """Errors of sheets on the embedded scene. The order is not measured."""
    vr, values = program(given, os.path.join(ROOT, "vr-cli", "src", "embedded.toml")), {"sheets": {}, "other": {}}
    flags = {("sheets", f"{d:g}"): f"slice-distance={d:g}" for d in (2, 1, 0.5, 0.25)}
    flags |= {("other", "gaussian"): "kernel=gaussian", ("other", "voxels"): "kernel=gaussian classification=voxels"}
    for (row, column), options in flags.items():
        values[row][column] = exact_error(given, vr, f"--renderer splat --size 200x200 {options}")
    return [("vr render --renderer splat --set slice-distance=… --size 200x200 --error full", values)]


def picture_errors(table, flags):
    """RMSE of ours on the peers' scenes, as against_vtk.py and against_volpack.py have it: by column, of the flags for a row."""
    def measure(given):
        peer_scenes, rows, values = peers(given), Values().rows(table), {}
        program(given, "")
        print(f"{table}: times and the peers' errors are kept; the exact pictures take minutes each, once", file=sys.stderr)
        for row, cells in rows.items():
            if not set(flags) & set(cells):
                continue
            kind = "" if row.endswith(" persp") or " ortho" in row else "_persp" if table == "shearwarp-in-perspective" else "_ortho"
            _, vr, judge = peer_scenes.prepare(given.peers, given.work, given.vr, row.replace(" ", "_") + kind)
            values[row] = {column: judge(vr.picture(of(cells)))[0] for column, of in flags.items() if column in cells}
        return [(f"docs/measuring/figures.py {table} --peers PEERS --work WORK", values)]
    return measure


def brute(given):
    """Texture slices beside the ray caster that takes every sample."""
    base, values = "--renderer raycast step=1 leaping=none termination=1", {}
    formats = {"scalar": "scalar", "pre-integrated": "pre-integrated", "compressed": "compressed"}
    for short, name in (("fog", "fog256_translucent_ortho"), ("blobs", "blobs256_opaque_ortho")):
        flags = {row: f"--renderer texslice slice-distance=1 format={word} skip=false termination=1" for row, word in formats.items()}
        found = in_turns(given, peer_scene(given, name), base, list(flags.values()))
        for row, line in flags.items():
            values.setdefault(row, {})[short] = 1 / found[line]["gain"]
    return [(f"docs/measuring/settings.py --scene … --base '{base}' --setting '{flags['scalar']}' …", values)]


def bounds(text):
    """The example's lines: a scene, a setting, its time."""
    values = {}
    for name, n, what, ms in re.findall(r"^(\S+) (\d+) ((?:step|promise) \S+) +([\d.]+) ms", text, re.MULTILINE):
        row = ("Marschner-Lobb" if name == "marschner-lobb" else name) + f" {n}"
        values.setdefault(row, {})["fifth" if what == "step 0.2" else what.split()[1]] = float(ms)
    return values


class Bounds(Printed):
    def read(self, text):
        return [(self.command, bounds(text))]


def with_prefix(prefix):
    return lambda row: row.replace("fog |", prefix + " |")


OVERLAP = "cargo run --release -p vr-splat --example overlap"
SPEED = "cargo run --release -p vr-splat --example splat_speed"
SLICES = "cargo run --release -p vr-texslice --example figures"
TURN = "cargo run --release -p vr-texslice --example brightness"
VOLPACK = Needs("VolPack and the peers' folder: docs/measuring/against_volpack.py")
BY_HAND = "its command's output read by hand: "
SHEAR = {"classic rmse": "classification=voxels slice-distance=1 termination=0.99", "values rmse": "slice-distance=1", "default rmse": "",
         "cubic rmse": "warp=cubic", "fine rmse": "texel=0.5 slice-distance=1"}
SHEAR = {column: lambda cells, f=flags: "--renderer shearwarp " + f for column, flags in SHEAR.items()}
LOCAL = "steps=local local-error="
RAYS = {f"{k} rmse": lambda cells, f=f: f for k, f in
        (("step 2", "step=2"), ("step 1", "step=1"), ("local 0.02", LOCAL + "0.02"), ("local 0.006", LOCAL + "0.006"))}


def spelled(setting):
    """Flags of `step 1, a 0.3`."""
    step, *screen = setting.split(", a ")
    kind, size = step.split()
    return ("step=" if kind == "step" else LOCAL) + size + "".join(f" screen=adaptive screen-threshold={t}" for t in screen)


EQUAL = {"rmse": lambda cells: "step=1", "adaptive rmse": lambda cells: spelled("step 1, a 0.08"),
         "equal rmse": lambda cells: spelled(cells["equal setting"]), "half equal rmse": lambda cells: spelled(cells["half equal setting"])}

HOW = {
    "raycast-vtk": picture_errors("raycast-vtk", EQUAL),
    "raycast-vtk-ratios": Needs("VTK (pip install vtk) and the peers' folder: docs/measuring/against_vtk.py"),
    "raycast-kernels": Needs("several commands: cargo bench -p vr-raycast --bench sampling, settings.py, growth.py, instructions.sh"),
    "raycast-rules": rules,
    "raycast-accelerations": accelerations,
    "raycast-bounds": Bounds("cargo run --release -p vr-raycast --example promise_time"),
    "shearwarp": VOLPACK,
    "shearwarp-volpack": picture_errors("shearwarp-volpack", SHEAR),
    "shearwarp-goals": VOLPACK,
    "shearwarp-parallel": picture_errors("shearwarp-parallel", SHEAR | RAYS),
    "shearwarp-in-perspective": picture_errors("shearwarp-in-perspective", SHEAR | RAYS),
    "shearwarp-perspective": Needs("the peers' folder: docs/measuring/against_volpack.py --perspective, read by hand"),
    "shearwarp-preparation": VOLPACK,
    "shearwarp-stages": Needs(BY_HAND + "cargo bench -p vr-shearwarp --bench stages"),
    "shearwarp-own-error": Printed("cargo run --release -p vr-shearwarp --example own_error",
                                   "| {row} | {own max} | {own rmse} | {max} | {rmse} |"),
    "shearwarp-brightness": Needs(BY_HAND + "cargo run --release -p vr-shearwarp --example turntable"),
    "shearwarp-turning": turned,
    "shearwarp-memory": Printed("cargo run --release -p vr-shearwarp --example memory",
                                "| {row} | {stored} % | {bytes} | {one} | {three} |"),
    "splat": Needs(BY_HAND + "cargo test --release -p vr-splat --test all line_integrals -- --nocapture"),
    "splat-sums": Printed(OVERLAP, "| Bilinear | {} | {bilinear} |", "| BSpline | {} | {b-spline} |", "| Cone | 1.6 | {cone} |",
                          *(f"| Gaussian | {r} | {{gaussian {r}}} |" for r in ("1.5", "2", "2.5", "3")), "| Sinc | 3 | {sinc} |",
                          rename=lambda row: "Σ w − 1"),
    "splat-overlap": Printed(OVERLAP, "| {row} | {samples} ({samples bias}) | {axis} ({}) | "
                             + " | ".join(f"{{image {d}}} ({{}})" for d in ("4", "2", "1", "0.5", "0.25")) + " |"),
    "splat-middles": Printed("cargo run --release -p vr-splat --example sheet_error", "| {row} | {2} | {1} | {0.5} | {0.25} |"),
    "splat-popping": Printed(OVERLAP, "| {row} | {} | {} | {} | {43} | {44} | {45} | {46} | {47} | {} | {} |",
                             rename={"Axis": "the volume's own sheets", "Image": "sheets parallel to the image"}.get),
    "splat-canonical": canonical,
    "splat-points": Together(*(Printed(SPEED, f"| {kind} | {n} | {{}} | {{{kind}}} | {{{kind} sorting}} | {{}} |",
                                       rename=lambda _, row=row: row)
                               for kind in ("plummer", "turbulence")
                               for n, row in ((10 ** 5, "10⁵"), (10 ** 6, "10⁶"), (10 ** 7, "10⁷")))),
    "splat-speed": Together(*(Printed(SPEED, f"| {kind} | {{row}} | {{{kind} prepare}} | {{{kind}}} | {{}} | {{{kind} met}} |",
                                      rename={"image": "image, bilinear", "image gaussian": "image, Gaussian",
                                              "image voxels": "image, voxels, Gaussian", "axis voxels": "axis, voxels, Gaussian",
                                              "samples": "samples, Gaussian"}.get) for kind in ("blobs", "fog"))),
    "splat-visible": Needs("the thresholds that leave so many voxels: they were not recorded"),
    "texslice-model": Needs(BY_HAND + "cargo test --release -p vr-texslice --test all model -- --nocapture"),
    "texslice-orders": Printed(SLICES, "| {row} | {1}, {1/2}, {1/4}, {1/8}, {1/16} | {order} |"),
    "texslice-thin": Printed("cargo test --release -p vr-texslice --test all pictures::thin -- --nocapture",
                             "d = {row}: pre-integrated at 2d {pre-integrated}, post-classified at d/2 {planes}",
                             rename={"0.25": "¼", "0.5": "½", "1": "1"}.get),
    "texslice-textures": Printed(SLICES, "| {row} | {2} ({2 max}) | {1} ({1 max}) | {1/2} ({1/2 max}) | {1/4} ({1/4 max}) |"),
    "texslice-brightness": Together(Printed(TURN, "| {row} | {bias} % | {}° | {step} % |"),
                                    Printed(TURN + " -- fov=40 scenes=fog distance=1", "| {row} | {bias} % | {}° | {step} % |",
                                            rename=with_prefix("fog, 40°"))),
    "texslice-speed": Needs(BY_HAND + "docs/measuring/settings.py, the ray caster's brute force in turns"),
    "texslice-brute": brute,
    "view": Printed("cargo run --release --workspace --example page_times -- target/release/vr VOLUME",
                    "{row}: load {load} before", "{row}: first picture after {first} s, listening after {listening} s",
                    "{row}: {rate} pictures a second in an orbit", "{row}: move to picture {move} ms, 95 %: {move 95} ms",
                    "{row}: pictures {width} pixels wide, RMSE {rmse}", "{row}: all pixels after {whole} ms", "{row}: sharp after {sharp} ms",
                    "{row}: measured after {measured} ms", "{row}: proven after {proven} ms", "{row}: edit to picture {edit} ms, 95 %: {edit 95} ms",
                    "{row}: edited pictures {edit width} pixels wide, RMSE {edit rmse}",
                    "{row}: edited pictures drawn by raycast in {} ms, prepared in {prepared} ms",
                    rename={"bonsai.nii.gz": "bonsai", "cthead_256x256x99.mhd": "CT head",
                            "bonsai_512x512x512_uint8.raw": "bonsai 512³", "fog": "fog"}.get),
}


def measure(name, given):
    """Measures a table, or says why its values are kept."""
    how = HOW.get(name, Needs("that the tables are measured again whose numbers it has"))
    try:
        if given.source:
            with open(given.source) as f:
                done = how.read(f.read())
        else:
            done = how(given)
        for command, new in done:
            values = Values()  # now, for others may have written meanwhile; and after each part, for it may take long
            values.record(name, command, new, given.times)
            values.write()
    except (Absent, ImportError) as e:
        what = f"Python's {e.name}" if isinstance(e, ImportError) else e
        print(f"{name}: kept; measuring it needs {what}", file=sys.stderr)
        for old in Values().tables.get(name, {"measured": []})["measured"]:
            print(f"  {old['date']}, {old['machine']['cpu']}: {old['command']}", file=sys.stderr)
        return


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", metavar="NAME", nargs="*")
    parser.add_argument("--render", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--times", action="store_true")
    parser.add_argument("--vr", default=os.path.join(ROOT, "target", "release", "vr"))
    parser.add_argument("--peers")
    parser.add_argument("--work")
    parser.add_argument("--cache", default=os.path.join(tempfile.gettempdir(), "vr-exact"))
    parser.add_argument("--from", dest="source")
    given = parser.parse_args()
    sys.path.insert(0, HERE)
    if unknown := set(given.names) - set(templates()):
        parser.error(f"no such table: {', '.join(sorted(unknown))}; known: {', '.join(templates())}")
    if given.source and (len(given.names) != 1 or not isinstance(HOW.get(given.names[0]), Printed)):
        parser.error("--from goes with one table whose command prints its values")
    if given.list:
        for name, table in Values().tables.items():
            how = HOW[name].what if isinstance(HOW[name], Needs) else ""
            print(name + (f" (not by this script: needs {how})" if how else ""))
            for old in table["measured"]:
                print(f"  {old['date']}, {old['machine']['cpu']}, {old['machine']['threads']} threads: {old['command']}")
    for name in given.names:
        measure(name, given)
    if given.check or given.render or given.names:
        try:
            stale = render(given.check)
        except ValueError as e:
            sys.exit(str(e))
        if given.check and stale:
            sys.exit(f"not what docs/figures/figures.json says (docs/measuring/figures.py --render): {', '.join(stale)}")
    elif not given.list:
        parser.error("--render, --check, --list, or names of tables")


if __name__ == "__main__":
    main()
