"""The peers' scenes as scene files of ours, and the error as the peers' README measures it. Needs numpy and the peers' `common.py`."""
import math
import os
import subprocess
import sys

import numpy as np

import common  # of the peers
import exr
from vr import Vr

SIZE = 512
REFERENCE_ERROR = "1e-5"
OUTLINE = 2.0  # pixels on either side of a projected edge of the box that do not count


def names(peers):
    """The scenes of uniform grids, shaded ones last."""
    found = [f[:-5] for f in os.listdir(os.path.join(peers, "scenes")) if f.endswith(".json") and "mltet" not in f]
    return sorted(found, key=lambda n: ("shaded" in n, n))


def load(peers, name):
    return common.load_scene(os.path.join(peers, "scenes", name + ".json"))


def write_toml(scene, volumes, path):
    """Writes a scene file that draws what the peers draw."""
    volume, transfer, camera, shading = (scene[k] for k in ("volume", "transfer_function", "camera", "shading"))
    lines = ["[volume]", f'path = "{os.path.join(os.path.abspath(volumes), volume["file"])}"', f'dims = {volume["dims"]}',
             'type = "u8"', f'spacing = {volume["spacing"]}', "[transfer]",
             f'unit_distance = {transfer["unit_distance"]}', 'opacity_rule = "power"', 'colors = "linear"', "points = ["]
    lines += [f"  {{value = {p[0]}, color = {p[1:4]}, opacity = {p[4]}}}," for p in transfer["points"]]
    lines += ["]"]
    if shading:
        lines += ["[shading]"] + [f"{k} = {shading[k]}" for k in ("ambient", "diffuse", "specular", "power")]
        lines += ["lights = [ {headlight = true} ]"]
    lines += ["[camera]", f'projection = "{camera["projection"]}"', f'eye = {camera["position"]}',
              f'target = {camera["focal_point"]}', f'up = {camera["view_up"]}']
    if camera["projection"] == "orthographic":
        lines += [f'height = {2 * camera["parallel_scale"]!r}']
    else:
        lines += [f'fov = {camera["fov_y_deg"]}']
    lines += ["[image]", f"size = [{SIZE}, {SIZE}]", ""]
    with open(path, "w") as f:
        f.write("\n".join(lines))


def kept(scene, size=SIZE):
    """Which pixels count: those whose centre is more than OUTLINE pixels from every projected edge of the box."""
    eye, forward, right, up = common.camera_basis(scene)
    camera = scene["camera"]
    extent = [(n - 1) * s for n, s in zip(scene["volume"]["dims"], scene["volume"]["spacing"])]
    corners = np.array([[extent[k] if b >> k & 1 else 0.0 for k in range(3)] for b in range(8)]) - eye
    x, y, depth = corners @ right, corners @ up, corners @ forward
    if camera["projection"] == "orthographic":
        scale = 1 / camera["parallel_scale"]
    else:
        scale = 1 / (depth * math.tan(math.radians(camera["fov_y_deg"]) / 2))
    points = np.stack([(x * scale + 1) * size / 2, (1 - y * scale) * size / 2], -1)
    centres = np.stack(np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5), -1)
    near = np.zeros((size, size), bool)
    for a, b in ((a, a | 1 << k) for a in range(8) for k in range(3) if not a >> k & 1):
        edge = points[b] - points[a]
        along = np.clip(((centres - points[a]) @ edge) / (edge @ edge), 0, 1)
        near |= np.linalg.norm(centres - points[a] - along[..., None] * edge, axis=-1) <= OUTLINE
    return ~near


class Judge:
    """Knows the exact picture of a scene."""

    def __init__(self, scene, reference):
        self.kept, self.exact = kept(scene), exr.rgba(reference)[..., :3].astype(np.float64)

    def __call__(self, image):
        """(RMSE, largest error) of premultiplied RGB."""
        error = (image[..., :3] - self.exact)[self.kept]
        return float(np.sqrt(np.mean(error ** 2))), float(np.abs(error).max())


def prepare(peers, work, program, name):
    """Makes what the scene needs and is not there yet: (scene, `vr` on it, judge)."""
    for folder in ("vol", "toml", "ref"):
        os.makedirs(os.path.join(work, folder), exist_ok=True)
    volumes = os.path.join(work, "vol")
    scene = load(peers, name)
    if not os.path.exists(os.path.join(volumes, scene["volume"]["file"])):
        generator = os.path.join(peers, "gen_volumes.py")
        subprocess.run([sys.executable, generator, volumes, scene["volume"]["name"]], check=True, stdout=subprocess.DEVNULL)
    toml = os.path.join(work, "toml", name + ".toml")
    write_toml(scene, volumes, toml)
    vr, reference = Vr(program, toml), os.path.join(work, "ref", name + ".exr")
    if not os.path.exists(reference):
        print(f"{name}: the exact picture, once", file=sys.stderr)
        half = os.path.join(work, "ref", name + ".half.exr")
        vr.write(f"--renderer physics tolerance={REFERENCE_ERROR}", half)
        os.replace(half, reference)
    return scene, vr, Judge(scene, reference)


def cells(entry):
    """Time and error in a table."""
    return f"{entry['ms']:.1f} (.{round(entry['rmse'] * 1e5):05d})"
