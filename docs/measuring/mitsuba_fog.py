#!/usr/bin/env python3
"""Random paths per second of Mitsuba 3 through the phantom fog, beside those of `vr-light`, on one processor.

    cargo build --release -p vr-light --example fog_paths
    taskset -c 0 target/release/examples/fog_paths 256 128 32
    taskset -c 0 docs/measuring/mitsuba_fog.py [VARIANT] [PATHS]

Mitsuba and numpy come from the Python registry (`pip install mitsuba numpy`). VARIANT is scalar_rgb or, where LLVM serves, llvm_ad_rgb; PATHS are
those of a pixel, 32. The scene is that of the example: 256³ samples of the fog, albedo 0.9, Henyey-Greenstein with g = 0.5, uniform light of radiance 0.5 and a
sun, a picture of 128² pixels. Mitsuba interpolates the extinction, `vr` the value: means agree to about a thousandth.
"""

import math
import sys
import time

import mitsuba as mi
import numpy as np

# The fog's formula is that of vr-core/src/phantom/fog.rs.
WAVES = 12
SAMPLES = 256
MASK = (1 << 64) - 1


class SplitMix64:
    def __init__(self):
        self.state = 0

    def unit(self):
        self.state = (self.state + 0x9E3779B97F4A7C15) & MASK
        z = self.state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
        return ((z ^ (z >> 31)) >> 11) / 2**53

    def between(self, low, high):
        return low + (high - low) * self.unit()


def extinction():
    random = SplitMix64()
    places = np.linspace(-1, 1, SAMPLES)
    total = np.zeros((SAMPLES,) * 3)
    for _ in range(WAVES):
        z, azimuth = random.between(-1, 1), random.between(0, 2 * math.pi)
        ring = math.sqrt(1 - z * z)
        direction = np.array([ring * math.cos(azimuth), ring * math.sin(azimuth), z])
        wave = direction * (2 * math.pi / random.between(0.4, 2))
        phase = random.between(0, 2 * math.pi)
        x, y, z = places[None, None, :], places[None, :, None], places[:, None, None]
        total += 0.5 * np.cos(wave[0] * x + wave[1] * y + wave[2] * z + phase)
    value = 1 / (1 + np.exp(-total))
    low, high = 1 / (1 + math.exp(6)), 1 / (1 + math.exp(-6))
    opacity = 0.004 + (value - low) / (high - low) * (0.08 - 0.004)
    return (-np.log1p(-opacity) / (2 / 64)).astype(np.float32)


def scene(paths):
    at = mi.ScalarTransform4f
    elevation, azimuth = math.radians(20), math.radians(30)
    towards = [math.sin(azimuth) * math.cos(elevation), math.sin(elevation), math.cos(azimuth) * math.cos(elevation)]
    eye = [math.sqrt(3) / math.sin(math.radians(15)) * x for x in towards]
    sun = np.array([1.0, 2.0, 1.0]) / math.sqrt(6)
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": 5},
            "sensor": {
                "type": "perspective",
                "fov": 30,
                "to_world": at().look_at(origin=eye, target=[0, 0, 0], up=[0, 1, 0]),
                "film": {"type": "hdrfilm", "width": 128, "height": 128, "rfilter": {"type": "box"}},
                "sampler": {"type": "independent", "sample_count": paths},
            },
            "fog": {
                "type": "cube",
                "bsdf": {"type": "null"},
                "interior": {
                    "type": "heterogeneous",
                    "albedo": {"type": "constvolume", "value": {"type": "rgb", "value": 0.9}},
                    "phase": {"type": "hg", "g": 0.5},
                    "sigma_t": {
                        "type": "gridvolume",
                        "grid": mi.VolumeGrid(extinction()[..., None]),
                        "to_world": at().translate([-1, -1, -1]).scale([2, 2, 2]),
                        "filter_type": "trilinear",
                    },
                },
            },
            "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 0.5}},
            "sun": {"type": "directional", "direction": list(-sun), "irradiance": {"type": "rgb", "value": math.pi}},
        }
    )


def main():
    variant = sys.argv[1] if len(sys.argv) > 1 else "scalar_rgb"
    paths = int(sys.argv[2]) if len(sys.argv) > 2 else 32
    mi.set_variant(variant)
    loaded = scene(paths)
    before = None
    for turn in range(4):
        start = time.perf_counter()
        picture = np.array(mi.render(loaded, spp=paths, seed=turn))
        seconds = time.perf_counter() - start
        # Two pictures of other seeds differ by √2 of the error of one.
        error = math.nan if before is None else math.sqrt(((picture - before) ** 2).mean() / 2)
        before = picture
        print(
            f"{variant}: {128 * 128 * paths / seconds:.0f} paths/s, mean green {picture[..., 1].mean():.4f}, "
            f"error {error:.5f}, error·√s {error * math.sqrt(seconds):.5f}"
        )


if __name__ == "__main__":
    main()
