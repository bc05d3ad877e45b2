#!/usr/bin/env python3
"""Measures `skywave batch` with many small pictures in one process, as Markdown tables.

    bench/batch/measure.py [--program build/release/skywave] [--pictures 1000] [--alone 50] ...

The pictures are ten turns of the light by seeds. It shows the wall time against the sum of the
times of rendering alone, the memory of the process after so many pictures, and the time of one
process per picture, of which --alone are run. Needs the standard library only, and a machine that
does nothing else.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from reporting import lines_of_table, processor  # noqa: E402

JOB = """
[base]
scene = "{scene}"
size = "{size}"
spp = {spp}
[axes]
seed = "1-{seeds}"
env-rotate = {{ from = 0, to = 360, steps = 10 }}
[output]
path = "out/{{env-rotate:03}}_{{seed:04}}.exr"
"""


def memory(process):
    """Returns the resident memory of a process [MiB]; None once it has ended."""
    try:
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    except OSError:
        return None
    found = re.search(r"VmRSS:\s+(\d+) kB", status)
    return int(found[1]) / 1024 if found else None


def pictures_in(folder):
    try:
        return sum(entry.name.endswith(".exr") for entry in os.scandir(folder))
    except FileNotFoundError:
        return 0


def watch(process, folder, samples):
    """Appends (pictures, memory) while the process runs."""
    while process.poll() is None:
        now = memory(process)
        if now is not None:
            samples.append((pictures_in(folder), now))
        time.sleep(0.05)


def render_batch(program, scratch):
    """Returns the wall time, batch.json and the samples of memory."""
    start, samples = time.monotonic(), []
    process = subprocess.Popen([program, "batch", "job.toml", "-q"], cwd=scratch)
    watcher = threading.Thread(target=watch, args=(process, scratch / "out", samples))
    watcher.start()
    code = process.wait()
    seconds = time.monotonic() - start
    watcher.join()
    if code != 0:
        sys.exit(f"skywave batch ended with {code}")
    return seconds, json.loads((scratch / "out/job.batch.json").read_text()), samples


def render_alone(program, scratch, pictures):
    """Returns the wall time of one process for each of `pictures`."""
    start = time.monotonic()
    for number, picture in enumerate(pictures):
        options = [word for name, value in picture["options"].items() if name != "scene"
                   for word in (f"--{name}", value)]
        output = scratch / f"alone_{number}.exr"
        subprocess.run([program, "render", picture["options"]["scene"], "-q", "-o", str(output),
                        *options], check=True, cwd=scratch)
    seconds = time.monotonic() - start
    for number, picture in enumerate(pictures):
        together = (scratch / picture["output"]).read_bytes()
        if (scratch / f"alone_{number}.exr").read_bytes() != together:
            sys.exit(f"{picture['output']} differs from that of skywave render")
    return seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", type=pathlib.Path, default="build/release/skywave")
    parser.add_argument("--pictures", type=int, default=1000, help="a multiple of 10")
    parser.add_argument("--alone", type=int, default=50, help="pictures with their own process")
    parser.add_argument("--scene", default="gallery")
    parser.add_argument("--size", default="160x120")
    parser.add_argument("--spp", type=int, default=4)
    arguments = parser.parse_args()
    program = arguments.program.resolve()
    load = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        (scratch / "job.toml").write_text(JOB.format(
            scene=arguments.scene, size=arguments.size, spp=arguments.spp,
            seeds=arguments.pictures // 10))
        plan = json.loads(subprocess.run([program, "batch", "job.toml", "--list", "--json"],
                                         cwd=scratch, check=True, capture_output=True).stdout)
        wall, summary, samples = render_batch(program, scratch)
        step = max(1, len(plan["pictures"]) // max(1, arguments.alone))
        chosen = plan["pictures"][::step][:arguments.alone]
        alone = render_alone(program, scratch, chosen)

    parts = {name: sum(picture["seconds"][name] for picture in summary["pictures"])
             for name in ("load", "render", "write")}
    count = len(plan["pictures"])
    print(f"{count} pictures of {arguments.scene}, {arguments.size}, {arguments.spp} spp; "
          f"{processor()}, {os.cpu_count()} threads; load before: {load:.2f}\n")
    per_picture = alone / len(chosen)
    rows = [["one process, wall", f"{wall:.2f}", f"{1e3 * wall / count:.1f}"]]
    rows += [[f"sum of {name}", f"{parts[name]:.2f}", f"{1e3 * parts[name] / count:.1f}"]
             for name in ("render", "load", "write")]
    rows += [[f"{count} processes, from {len(chosen)}", f"{per_picture * count:.2f}",
              f"{1e3 * per_picture:.1f}"]]
    print("\n".join(lines_of_table(["what", "[s]", "per picture [ms]"], rows, 1)))
    print(f"\nwall / sum of render: {wall / parts['render']:.3f}; "
          f"processes / wall: {per_picture * count / wall:.2f}\n")
    marks = sorted({mark for mark in (1, 10, 100, count // 2, count) if mark <= count})
    rows = []
    for mark in marks:
        until = [size for number, size in samples if number <= mark]
        rows.append([str(mark), f"{until[-1]:.1f}", f"{max(until):.1f}"])
    print("\n".join(lines_of_table(["pictures", "memory [MiB]", "most so far [MiB]"], rows, 0)))


if __name__ == "__main__":
    main()
