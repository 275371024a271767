#!/usr/bin/env python3
"""First pictures of volumes: `vr render FILE` without a flag, on one sheet, with figures for each.

    look.py --vr target/release/vr --data ../shared/data --vtk VENV/bin/python --sheet docs/look.jpg --table docs/figures/look.md

Needs Python 3 with numpy and Pillow and, for the pictures of VTK beside ours (vtk_look.py), a Python with vtk. Figures, of what is not black: the larger of the filled parts of width and height; mean and standard
deviation of luma, of 255; parts within 5 % of black and of white; mean difference of neighbouring pixels (detail); and the RMSE of the
picture against the reference on a subgrid of pixels, as `vr render` measures it.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

SIDE = 256
PATIENT = {"RAS", "LAS", "LPS"}
# Pictures in a line; pairs, with VTK's.
COLUMNS = 8
PATTERNS = [
    "raw/*.raw", "raw/*.raw.gz", "raw/*.raw.bz2", "raw/nucleon.vvd", "nrrd/*.nrrd", "nrrd/*.nhdr", "nrrd/headsq/*.nhdr",
    "nrrd/ball/BallBinary30x30x30.nrrd", "nifti/*.nii", "nifti/*.nii.gz", "metaimage/*.mha", "metaimage/*.mhd", "dicom/pet_head",
    "dicom/single/emri_small.dcm", "vtk/*.vti", "vtk/ironProt.vtk", "vtk/heart.vtk", "mrc/*", "pvm/*.pvm", "slc/*.slc", "dx/*.general",
    "zarr/*.zarr", "vdb/bonsai*.vdb", "bad/rgb24.nii.gz", "particles/*.npy",
]


def volumes(data):
    """The files of the patterns, those of raw that say their size."""
    for pattern in PATTERNS:
        for path in sorted(data.glob(pattern)):
            if not path.name.endswith(".raw") or "x" in path.name:
                yield path


def vtk_picture(options, path, work):
    """What VTK shows of the same voxels; None where there are none, or no VTK."""
    info = subprocess.run([options.vr, "info", path, "--json", "-q"], capture_output=True, text=True)
    described = json.loads(info.stdout) if info.returncode == 0 else {}
    if options.vtk is None or "dims" not in described:
        return None
    volume, out = Path(work) / "x.vti", Path(work) / "vtk.png"
    if subprocess.run([options.vr, "convert", path, volume, "-q"], capture_output=True).returncode != 0:
        return None  # a shear, which VTK's images cannot have
    kind = "patient" if (described["file"] or {}).get("space", "") in PATIENT else "other"
    worker = Path(__file__).with_name("vtk_look.py")
    subprocess.run([options.vtk, worker, volume, out, str(SIDE), kind], capture_output=True, check=True, timeout=600)
    return np.asarray(Image.open(out).convert("RGB"))


def figures(picture):
    luma = picture @ [0.2126, 0.7152, 0.0722]
    seen = luma > 4
    if not seen.any():
        return {"fills": 0.0, "luma": 0.0, "spread": 0.0, "black": 1.0, "white": 0.0, "detail": 0.0}
    rows, columns = np.flatnonzero(seen.any(1)), np.flatnonzero(seen.any(0))
    fills = max(np.ptp(rows) + 1, np.ptp(columns) + 1) / SIDE
    change = np.abs(np.diff(luma, axis=1))[seen[:, 1:]].mean()
    values = luma[seen]
    return {"fills": fills, "luma": values.mean(), "spread": values.std(), "black": (values <= 13).mean(),
            "white": (values >= 242).mean(), "detail": change}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vr", default="target/release/vr")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--vtk", help="a Python that has the module vtk")
    parser.add_argument("--sheet", type=Path)
    parser.add_argument("--table", type=Path)
    parser.add_argument("files", nargs="*", type=Path)
    options = parser.parse_args()
    files = options.files or list(volumes(options.data))
    pictures, rows = [], []
    with tempfile.TemporaryDirectory() as work:
        for path in files:
            name = path.relative_to(options.data).as_posix() if path.is_relative_to(options.data) else path.name
            out = Path(work) / "x.png"
            run = subprocess.run([options.vr, "render", path, "--size", f"{SIDE}x{SIDE}", "--json", "-o", out],
                                 capture_output=True, text=True, timeout=600)
            if run.returncode != 0:
                print(f"{name}: {run.stderr.strip().splitlines()[-1]}")
                continue
            picture = np.asarray(Image.open(out).convert("RGB"), dtype=float)
            error = json.loads(run.stdout)["error"]
            look = next((line.removeprefix("note: look: ") for line in run.stderr.splitlines() if "look: " in line), "")
            found = figures(picture)
            rows.append((name, look.split(",")[0], found, error["rmse"]))
            pictures.append((name, picture.astype(np.uint8)))
            beside = vtk_picture(options, path, work)
            if beside is not None:
                pictures.append(("VTK", beside))
            elif options.vtk:
                pictures.append(("not for VTK", np.zeros_like(pictures[-1][1])))
            print(name, {k: round(float(v), 3) for k, v in found.items()}, f"RMSE {error['rmse']:.1e}", flush=True)
    if options.sheet:
        lines = -(-len(pictures) // COLUMNS)
        sheet = Image.new("RGB", (COLUMNS * SIDE, lines * SIDE))
        for i, (name, picture) in enumerate(pictures):
            at = (i % COLUMNS * SIDE, i // COLUMNS * SIDE)
            sheet.paste(Image.fromarray(picture), at)
            ImageDraw.Draw(sheet).text((at[0] + 4, at[1] + 3), name[:42], fill=(255, 224, 96))
        sheet.save(options.sheet, optimize=True, quality=86)
    if options.table:
        head = "| volume | kind | fills | luma | spread | near black | near white | detail | RMSE |\n|---|---|--:|--:|--:|--:|--:|--:|--:|\n"
        line = "| {} | {} | {fills:.2f} | {luma:.0f} | {spread:.0f} | {black:.2f} | {white:.2f} | {detail:.1f} | {:.1e} |\n"
        body = "".join(line.format(name, kind, error, **found) for name, kind, found, error in rows)
        options.table.write_text("# First pictures\n\nMade by `docs/measuring/look.py`, which says what the columns are; the pictures are [look.jpg](../look.jpg), with those of VTK (vtk_look.py) beside them.\n\n" + head + body)


if __name__ == "__main__":
    main()
