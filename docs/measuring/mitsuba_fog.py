#!/usr/bin/env python3
"""Random paths per second of Mitsuba 3 through fog, beside those of `vr`, on one processor.

    vr convert --phantom fog --phantom-size 256 fog.npy
    taskset -c 0 python3 mitsuba_fog.py fog.npy [VARIANT] [SIDE] [PATHS]

Mitsuba comes from the Python registry (`pip install mitsuba`). The fog fills the cube from -1 to 1: extinction 4 times the value, albedo 0.9, isotropic,
in the light of a sky of radiance 1, seen along an axis in parallel projection. VARIANT is scalar_rgb or llvm_ad_rgb, SIDE the
width of the picture, PATHS those of a pixel. The scene of `vr` is fog_sky.toml beside this script.
"""

import sys
import time

import mitsuba as mi
import numpy as np


def main():
    path = sys.argv[1]
    variant = sys.argv[2] if len(sys.argv) > 2 else "scalar_rgb"
    side = int(sys.argv[3]) if len(sys.argv) > 3 else 256
    paths = int(sys.argv[4]) if len(sys.argv) > 4 else 16
    mi.set_variant(variant)
    fog = np.load(path).astype(np.float32)
    to_world = mi.ScalarTransform4f().scale(2.0).translate([-0.5, -0.5, -0.5])
    extinction = {
        "type": "gridvolume",
        "grid": mi.VolumeGrid(fog[..., np.newaxis]),
        "to_world": to_world,
        "filter_type": "trilinear",
    }
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": 5},
            "sensor": {
                "type": "orthographic",
                "to_world": mi.ScalarTransform4f().look_at(origin=[0, 0, 5], target=[0, 0, 0], up=[0, 1, 0])
                @ mi.ScalarTransform4f().scale([1.0, 1.0, 1.0]),
                "film": {"type": "hdrfilm", "width": side, "height": side, "rfilter": {"type": "box"}},
                "sampler": {"type": "independent", "sample_count": paths},
            },
            "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}},
            "cube": {
                "type": "cube",
                "bsdf": {"type": "null"},
                "interior": {
                    "type": "heterogeneous",
                    "sigma_t": extinction,
                    "albedo": {"type": "constvolume", "value": {"type": "rgb", "value": 0.9}},
                    "scale": 4.0,
                    "phase": {"type": "isotropic"},
                },
            },
        }
    )
    np.array(mi.render(scene, spp=1))
    start = time.perf_counter()
    picture = np.array(mi.render(scene, spp=paths, seed=1))
    seconds = time.perf_counter() - start
    mean = picture[..., :3].mean()
    print(f"Mitsuba {mi.__version__} {variant}: {side * side * paths / seconds:.3g} paths a second, mean radiance {mean:.4f}")


if __name__ == "__main__":
    main()
