#!/usr/bin/env python3
"""Tests scripts/sheet.py and scripts/contact_sheet.py: PNGs there and back, and a sheet of small
models under two maps.

    tests/cli/contact_sheet_test.py PROGRAM
"""
import pathlib
import random
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

SCRIPTS = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts"
sys.dont_write_bytecode = True
sys.path.insert(0, str(SCRIPTS))
import sheet  # noqa: E402

PROGRAM = None
TRIANGLE = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
-0.1 0 0
0.1 0 0
0 0.15 0
3 0 1 2
"""


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def filtered(mode, row, above):
    """A row of RGB pixels after the filter `mode` of the specification of PNG."""
    def predicted(i):
        a, b, c = (row[i - 3] if i > 2 else 0), above[i], (above[i - 3] if i > 2 else 0)
        nearest = sorted((abs(a + b - c - x), order) for order, x in enumerate((a, b, c)))[0][1]
        return (0, a, b, (a + b) // 2, (a, b, c)[nearest])[mode]
    return bytes([mode, *((value - predicted(i)) % 256 for i, value in enumerate(row))])


class ContactSheet(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_every_filter_of_png_is_read(self):
        width, height = 20, 25
        draw = random.Random(1)
        # So few values that predictors tie, on both sides of 0, where bytes wrap around.
        rows = [bytes(draw.randrange(-4, 5) % 256 for _ in range(3 * width)) for _ in range(height)]
        raw = b"".join(filtered(y % 5, row, rows[y - 1] if y else bytes(3 * width))
                       for y, row in enumerate(rows))
        packed = zlib.compress(raw)
        (self.folder / "a.png").write_bytes(
            b"\x89PNG\r\n\x1a\n" +
            chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", packed[:40]) + chunk(b"IDAT", packed[40:]) + chunk(b"IEND", b""))
        picture = (width, height, b"".join(rows))
        self.assertEqual(sheet.read_png(self.folder / "a.png"), picture)
        sheet.write_png(self.folder / "b.png", *picture)
        self.assertEqual(sheet.read_png(self.folder / "b.png"), picture)

    def test_tiles_go_row_by_row(self):
        pictures = [(2, 1, bytes([10 * number + i for i in range(6)])) for number in range(6)]
        rows = [b"".join(pictures[number][2] for number in line) for line in ((0, 1, 2), (3, 4, 5))]
        self.assertEqual(sheet.tile(pictures, 3), (6, 2, b"".join(rows)))

    def test_a_sheet_has_a_row_for_each_model_and_a_column_for_each_map(self):
        data, out = self.folder / "data", self.folder / "out"
        for name in ("models", "hdri", "probes/latlong"):
            (data / name).mkdir(parents=True)
        (data / "models/killeroo.pbrt").write_text('Shape "sphere" "float radius" 60\n')
        (data / "models/bunny.ply").write_text(TRIANGLE)
        # Four by two grey texels of Radiance's format.
        (data / "hdri/noon_grass_1k.hdr").write_bytes(
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n" + b"\x80\x80\x80\x81" * 8)
        subprocess.run([PROGRAM, "probe", "calibrate", "--height", "16", "-o",
                        data / "probes/latlong/grace_latlong.exr"], check=True,
                       stdout=subprocess.DEVNULL)
        done = subprocess.run([sys.executable, "-B", SCRIPTS / "contact_sheet.py", data, out,
                               "--program", PROGRAM, "--spp", "1"], capture_output=True, text=True,
                              timeout=120, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        models, maps = ["bunny.pbrt", "killeroo.pbrt", "bunny.ply"], ["noon_grass_1k",
                                                                      "grace_latlong"]
        self.assertEqual(done.stdout.splitlines(), ["rows:    " + ", ".join(models),
                                                    "columns: " + ", ".join(maps)])
        width, height, rgb = sheet.read_png(out / "sheet.png")
        self.assertEqual((width, height), (2 * 160, 3 * 120))
        seen = set()
        for row, model in enumerate(models):
            for column, light in enumerate(maps):
                picture = sheet.read_png(out / f"{model}.{light}.png")
                seen.add(picture)
                tile = b""
                for y in range(120):
                    first = width * (120 * row + y) + 160 * column
                    tile += rgb[3 * first:3 * (first + 160)]
                self.assertEqual((160, 120, tile), picture)
        self.assertEqual(len(seen), 6)

    def test_a_folder_without_maps_is_refused(self):
        (self.folder / "models").mkdir()
        done = subprocess.run([sys.executable, "-B", SCRIPTS / "contact_sheet.py", self.folder,
                               self.folder / "out"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("no map in hdri/", done.stderr)


if __name__ == "__main__":
    PROGRAM = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
