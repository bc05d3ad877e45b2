#!/usr/bin/env python3
"""Kills `skywave batch` by SIGKILL over and over, and gives the same command again each time.

    tests/cli/batch_kill_test.py PROGRAM [--kills N] [--seed N]

Half of the kills come at random moments, the others while a file is being written. After each, all
pictures have to be whole and to have the bytes of an uninterrupted run. Whenever a batch ends, all
pictures are there, nothing else is left, and the next batch begins in an empty folder.
"""
import argparse
import collections
import hashlib
import pathlib
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zlib

PICTURES = 20
JOB = """
[base]
scene = "spheres"
[axes]
look = [
  { label = "long", size = "128x96", spp = 64 },
  { label = "large", size = "160x120", spp = 1, aovs = "all" },
  { label = "map", size = "48x32", spp = 1, env = "sky.pfm", strategy = "importance" },
  { label = "guided", size = "64x64", spp = 8, env = "sky.pfm", integrator = "bdpt" },
]
seed = "1-5"
[output]
path = "{look}/{seed:02}.exr"
"""


def write_map(path, width, height):
    """Writes an illumination map: a gradient and a sun."""
    rows = b"".join(struct.pack("<3f", x / width, y / height, 50 if (x, y) == (3, 9) else 1)
                    for y in range(height) for x in range(width))
    path.write_bytes(b"PF\n%d %d\n-1.0\n" % (width, height) + rows)


def check_exr(data):
    """Raises unless `data` is a whole OpenEXR file of scan lines compressed by ZIP."""
    assert data[:8] == struct.pack("<II", 20000630, 2), "not an EXR of scan lines"
    at, attributes = 8, {}
    while data[at] != 0:
        name, kind = data[at:at + 512].split(b"\0")[:2]
        at += len(name) + len(kind) + 2
        (length,) = struct.unpack_from("<I", data, at)
        attributes[name] = data[at + 4:at + 4 + length]
        at += 4 + length
    at += 1
    assert attributes[b"compression"] == b"\3", "not compressed by ZIP"
    left, top, right, bottom = struct.unpack("<4i", attributes[b"dataWindow"])
    channels, bytes_per_pixel = attributes[b"channels"], 0
    while channels[0] != 0:
        end = channels.index(b"\0") + 1
        bytes_per_pixel += {0: 4, 1: 2, 2: 4}[channels[end]]
        channels = channels[end + 16:]
    blocks = -(-(bottom - top + 1) // 16)
    offsets = struct.unpack_from(f"<{blocks}Q", data, at)
    at += 8 * blocks
    for block, offset in enumerate(offsets):
        assert offset == at, f"block {block} is not where the table says"
        first, size = struct.unpack_from("<iI", data, at)
        raw = (right - left + 1) * min(16, bottom - first + 1) * bytes_per_pixel
        assert first == top + 16 * block and at + 8 + size <= len(data), f"block {block} is torn"
        if size < raw:
            block_bytes = zlib.decompress(data[at + 8:at + 8 + size])
            assert len(block_bytes) == raw, f"block {block} is short"
        at += 8 + size
    assert at == len(data), "bytes after the last block"


def check_png(data):
    """Raises unless `data` is a PNG with all of its chunks."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n", "not a PNG"
    at, pixels, kind = 8, b"", None
    while kind != b"IEND":
        (length,) = struct.unpack_from(">I", data, at)
        kind, body = data[at + 4:at + 8], data[at + 8:at + 8 + length]
        (checksum,) = struct.unpack_from(">I", data, at + 8 + length)
        assert zlib.crc32(kind + body) == checksum, f"chunk {kind} is torn"
        if kind == b"IDAT":
            pixels += body
        at += 12 + length
    assert at == len(data), "bytes after the end"
    zlib.decompress(pixels)


def files_in(folder):
    """Returns the files below `folder` by their relative names."""
    return {str(path.relative_to(folder)): path for path in folder.rglob("*") if path.is_file()}


def is_picture(name):
    return name.endswith((".exr", ".png"))


def hashes_of(folder):
    """Returns the hashes of all pictures, which have to be whole."""
    hashes = {}
    for name, path in files_in(folder).items():
        if not is_picture(name):
            continue
        data = path.read_bytes()
        try:
            (check_exr if name.endswith(".exr") else check_png)(data)
        except Exception as error:
            sys.exit(f"{name} ({len(data)} bytes) is not whole: {error}")
        hashes[name] = hashlib.sha256(data).hexdigest()
    return hashes


class Batch:
    """A batch of 20 pictures, and what an uninterrupted run makes of it."""

    def __init__(self, program, scratch):
        self.program, self.scratch, self.folder = program, scratch, scratch / "killed"
        (scratch / "job.toml").write_text(JOB)
        write_map(scratch / "sky.pfm", 128, 64)
        start = time.monotonic()
        self.finish(scratch / "whole")
        self.seconds = time.monotonic() - start
        self.hashes = hashes_of(scratch / "whole")
        self.reports = {"job.batch.json", "job.batch.html"}
        if len(self.hashes) != 2 * PICTURES:
            sys.exit(f"the uninterrupted run made {len(self.hashes)} files")

    def start(self, folder):
        # Two pictures are made of several waves, so that checkpoints of them are written.
        return subprocess.Popen(
            [self.program, "batch", "job.toml", "-q", "-o", str(folder), "--checkpoint", "0.05"],
            cwd=self.scratch, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def finish(self, folder):
        """Runs the batch to its end."""
        _, errors = self.start(folder).communicate(timeout=300)
        if errors:
            sys.exit(errors.decode())

    def check(self, complete):
        """Fails unless the pictures that are there are right, and all are if it is `complete`."""
        hashes = hashes_of(self.folder)
        for name, value in hashes.items():
            if value != self.hashes[name]:
                sys.exit(f"{name} differs from that of the uninterrupted run")
        if complete and len(hashes) < len(self.hashes):
            sys.exit(f"missing: {sorted(set(self.hashes) - set(hashes))}")
        left = set(files_in(self.folder)) - set(hashes) - self.reports
        if complete and left:
            sys.exit(f"left over: {sorted(left)}")
        return left


def wait_for_write(process, folder, generator):
    """Returns while a file is being written, one of the next ten."""
    skipped, seen = generator.randrange(10), set()
    pause = generator.uniform(0, 0.002)
    while process.poll() is None:
        new = {name for name in files_in(folder) if name.endswith(".part")} - seen
        if new and skipped <= len(seen):
            time.sleep(pause)  # the beginning, the middle or the end
            return
        seen |= new


def kill_once(batch, generator):
    """Starts the batch, kills it, and returns whether it was not faster."""
    process = batch.start(batch.folder)
    if generator.random() < 0.5:
        try:
            process.wait(generator.uniform(0, 0.3 * batch.seconds))
        except subprocess.TimeoutExpired:
            pass
    else:
        wait_for_write(process, batch.folder, generator)
    killed = process.poll() is None
    process.kill()
    _, errors = process.communicate()
    if errors or (process.returncode not in (0, -9)):
        sys.exit(f"exit code {process.returncode}: {errors.decode()}")
    return killed and process.returncode != 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    generator = random.Random(arguments.seed)
    with tempfile.TemporaryDirectory() as scratch:
        batch = Batch(arguments.program.resolve(), pathlib.Path(scratch))
        kills, batches, found = 0, 1, collections.Counter()
        batch.folder.mkdir()
        while kills < arguments.kills:
            if kill_once(batch, generator):
                kills += 1
                left = batch.check(complete=False)
                found.update({pathlib.Path(name).suffixes[0] + " being written"
                              if name.endswith(".part") else "checkpoint" for name in left})
                found["nothing beside pictures"] += not left
            else:
                batch.check(complete=True)
                shutil.rmtree(batch.folder)
                batch.folder.mkdir()
                batches += 1
        batch.finish(batch.folder)
        batch.check(complete=True)
    print(f"{kills} kills of {batches} batches of {PICTURES} pictures, which took "
          f"{batch.seconds:.1f} s uninterrupted; after so many kills there was")
    for what, count in found.most_common():
        print(f"  {count:4} {what}")


if __name__ == "__main__":
    main()
