"""Draws frames with VTK's CPU ray caster (vtkFixedPointVolumeRayCastMapper) when told to, so that they can be drawn in turns with ours.

    vtk_worker.py PEERS SCENE.json VOLUMES THREADS      (started by against_vtk.py)

Reads lines `STEP FRAMES` or `STEP save FILE.npy`; answers each with a line of JSON: milliseconds of each frame, wall-clock and CPU, of the
whole frame and of its core, the casting of rays without the display of the picture. Frame k is the peers' camera frame k, which is the k-th
frame of `vr bench --azimuth-step 0.7`. One thread is pinned to a processor.
"""
import json
import sys
import time

peers, scene_path, volumes, threads = sys.argv[1:]
sys.path.insert(0, peers)
sys.argv = ["vtk_bench.py", scene_path, volumes, "unused", "--mapper", "fp", "--threads", threads]

import vtk_bench  # of the peers: reads its arguments when imported
import common
import numpy as np
import vtk

SIZE = 512
WARM_UP = (-2, -1)


def main():
    scene = common.load_scene(scene_path)
    vtk.vtkMultiThreader.SetGlobalDefaultNumberOfThreads(int(threads))
    window, renderer = vtk.vtkRenderWindow(), vtk.vtkRenderer()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    renderer.SetBackground(*scene["background"])
    renderer.SetBackgroundAlpha(0.0)
    window.AddRenderer(renderer)
    window.SetSize(SIZE, SIZE)
    mapper, volume = vtk_bench.build(scene, common.load_volume(scene, volumes))
    renderer.AddVolume(volume)

    def clocks():
        return np.array([time.perf_counter(), time.process_time()]) * 1e3

    begin, core = [None], [None]
    mapper.AddObserver("VolumeMapperRenderStartEvent", lambda *_: begin.__setitem__(0, clocks()))
    mapper.AddObserver("VolumeMapperRenderEndEvent", lambda *_: core.__setitem__(0, clocks() - begin[0]))

    def draw(frame):
        vtk_bench.set_camera(renderer, scene, frame)
        start = clocks()
        window.Render()
        window.WaitForCompletion()
        return [*(clocks() - start), *core[0]]

    print(json.dumps({"version": vtk.vtkVersion.GetVTKVersion()}), flush=True)
    for line in sys.stdin:
        step, *what = line.split()
        mapper.SetSampleDistance(float(step))
        for frame in WARM_UP:
            draw(frame)
        if what[0] == "save":
            draw(0)
            kind, image = vtk_bench.grab(window, mapper, SIZE, SIZE)
            np.save(what[1], image)
            answer = {"image": kind}
        else:
            times = [draw(frame) for frame in range(int(what[0]))]
            answer = dict(zip(("wall", "cpu", "core_wall", "core_cpu"), map(list, zip(*times))))
        print(json.dumps(answer), flush=True)


main()
