"""Runs the program `vr` for scripts that time it."""
import json
import os
import subprocess
import tempfile


def flags(text):
    """`step=1 --max-error 0.01` as a list of arguments: KEY=VALUE stands for --set KEY=VALUE."""
    out = []
    for word in text.split():
        option = "=" in word and not word.startswith("-") and not (out and out[-1] == "--set")
        out += ["--set", word] if option else [word]
    return out


def listed(path):
    """The lines of a file of flags; # starts a comment."""
    with open(path) as f:
        lines = (line.split("#")[0].strip() for line in f)
        return [line for line in lines if line]


def pinned(threads):
    """Holds a process of one thread to one processor, the last; None for several threads."""
    return (lambda: os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})) if threads == 1 else None


class Vr:
    """The program, and a scene file."""

    def __init__(self, program, scene):
        self.program, self.scene = os.path.abspath(program), scene

    def run(self, command, arguments, threads=None):
        """What it prints with --json."""
        line = [self.program, command, "--scene", self.scene, *arguments, "--json", "--quiet"]
        line += ["--threads", str(threads)] if threads else []
        done = subprocess.run(line, capture_output=True, text=True, preexec_fn=pinned(threads))
        if done.returncode:
            raise RuntimeError(f"{' '.join(line)}: {done.stderr.strip()}")
        return json.loads(done.stdout)

    def write(self, options, path):
        """Draws the scene's own view into an .exr."""
        self.run("render", ["--error", "none", "-o", path, *flags(options)])

    def picture(self, options):
        """The scene's own view: float32 of shape (height, width, 4)."""
        import exr
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "x.exr")
            self.write(options, path)
            return exr.rgba(path)

    def bench(self, options, threads, frames, azimuth_step, error=False):
        """`vr bench`."""
        arguments = ["--frames", str(frames), "--azimuth-step", str(azimuth_step), *flags(options)]
        return self.run("bench", arguments + ["--error"] * error, threads)
