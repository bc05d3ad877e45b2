"""What several tests of the Python package need. PYTHONPATH names the package under test, and the
environment variable SKYWAVE_PROGRAM the program of the same build."""
import os
import pathlib
import shutil
import struct
import subprocess
import tempfile
import unittest
import zlib

import numpy

PROGRAM = os.environ.get("SKYWAVE_PROGRAM", "skywave")

# A pyramid: five vertices, six triangles, counter-clockwise seen from outside.
VERTICES = numpy.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1], [0, 1.6, 0]], numpy.float32)
FACES = numpy.array([[0, 1, 2], [0, 2, 3], [1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]],
                    numpy.uint32)
SMALL = {"size": (40, 30), "spp": 2}


def sky(height=16):
    """Returns a lat-long map with a sun, (height, 2 * height, 3)."""
    up = numpy.linspace(1, 0, height)[:, None, None]
    pixels = 0.3 + up * numpy.array([0, 0.3, 0.6])
    pixels = numpy.repeat(pixels, 2 * height, axis=1).astype(numpy.float32)
    pixels[height // 4, height // 2] = 400
    return pixels


def write_pfm(path, pixels):
    height, width, _ = pixels.shape
    pathlib.Path(path).write_bytes(b"PF\n%d %d\n-1.0\n" % (width, height) +
                                   numpy.ascontiguousarray(pixels[::-1], "<f4").tobytes())


def write_obj(path, vertices=VERTICES, faces=FACES):
    lines = ["v %.9g %.9g %.9g" % tuple(v) for v in vertices]
    lines += ["f %d %d %d" % tuple(f + 1) for f in faces.astype(int)]
    pathlib.Path(path).write_text("\n".join(lines) + "\n")


def write_ply(path, vertices=VERTICES, faces=FACES):
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}",
              "property float x", "property float y", "property float z",
              f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    data = ("\n".join(header) + "\n").encode() + vertices.astype("<f4").tobytes()
    data += b"".join(struct.pack("<Biii", 3, *map(int, face)) for face in faces)
    pathlib.Path(path).write_bytes(data)


def exr_channels(path):
    """Returns the float channels of an EXR of scan lines with ZIP compression, by name."""
    data = pathlib.Path(path).read_bytes()
    attributes, at = {}, 8

    def text():
        nonlocal at
        end = data.index(b"\0", at)
        word, at = data[at:end].decode(), end + 1
        return word

    while True:
        name = text()
        if not name:
            break
        text()  # type
        size = struct.unpack_from("<i", data, at)[0]
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    names = [entry.split(b"\0")[0].decode() for entry in _channel_entries(attributes["channels"])]
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    assert attributes["compression"] in (b"\2", b"\3"), attributes["compression"]  # ZIPS, ZIP
    rows = 1 if attributes["compression"] == b"\2" else 16
    channels = {name: numpy.empty((height, width), numpy.float32) for name in names}
    blocks = -(-height // rows)
    for offset in struct.unpack_from(f"<{blocks}Q", data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        raw = data[offset + 8:offset + 8 + size]
        count = min(rows, y1 + 1 - y)
        expected = count * width * 4 * len(names)
        if size < expected:  # else it is stored as it is
            delta = numpy.frombuffer(zlib.decompress(raw), numpy.uint8).astype(numpy.int64)
            delta[1:] -= 128
            halves = (numpy.cumsum(delta) & 255).astype(numpy.uint8)
            whole = numpy.empty_like(halves)
            middle = (len(halves) + 1) // 2
            whole[0::2], whole[1::2] = halves[:middle], halves[middle:]
            raw = whole.tobytes()
        block = numpy.frombuffer(raw, "<f4").reshape(count, len(names), width)
        for number, name in enumerate(names):
            channels[name][y - y0:y - y0 + count] = block[:, number]
    return channels


def _channel_entries(data):
    at = 0
    while data[at] != 0:
        end = data.index(b"\0", at) + 1 + 16
        yield data[at:end]
        at = end


class Case(unittest.TestCase):
    """A test in a scratch folder of its own."""

    def setUp(self):
        self.before = os.getcwd()
        self.folder = tempfile.mkdtemp()
        os.chdir(self.folder)

    def tearDown(self):
        os.chdir(self.before)
        shutil.rmtree(self.folder)

    def command(self, *words):
        done = subprocess.run([PROGRAM, *words], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def assert_same_bits(self, a, b):
        self.assertEqual((a.shape, a.dtype), (b.shape, b.dtype))
        self.assertEqual(a.tobytes(), b.tobytes())
