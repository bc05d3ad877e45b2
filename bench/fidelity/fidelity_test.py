#!/usr/bin/env python3
"""Tests the page of fidelity on small assets; in a browser, where there is one.

    bench/fidelity/fidelity_test.py build/release/skywave
"""

import base64
import json
import math
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
from array import array
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import fidelity  # noqa: E402

PROGRAM = None


def triangle(material):
    """Returns a document of one triangle."""
    corners = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    uri = "data:application/octet-stream;base64," + base64.b64encode(corners).decode()
    return {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                           "min": [0, 0, 0], "max": [1, 1, 0]}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "buffers": [{"byteLength": 36, "uri": uri}], "materials": [material]}


def png():
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(
            ">I", zlib.crc32(kind + data))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(b"\0\xff\0\0")) + chunk(b"IEND", b""))


class Page(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        self.put("Plain/glTF/Plain.gltf", json.dumps(triangle({})))
        self.put("Plain/glTF-Embedded/Plain.gltf", "not the form that is rendered")
        extensions = {"KHR_materials_dispersion": {}}
        self.put("Prism/glTF/Prism.gltf",
                 json.dumps(triangle({"name": "a<b|c", "extensions": extensions})))
        self.put("Broken/glTF/Broken.gltf", "{")
        self.env = self.folder / "white.pfm"
        self.env.write_bytes(b"PF\n2 1\n-1\n" + struct.pack("<6f", *[1] * 6))
        (self.folder / "Plain/screenshot").mkdir()
        (self.folder / "Plain/screenshot/screenshot.png").write_bytes(png())

    def put(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def test_assets_are_found_once(self):
        assets = fidelity.find_assets(self.folder)
        self.assertEqual([asset.name for asset in assets], ["Broken", "Plain", "Prism"])
        self.assertEqual(assets[1].file.parent.name, "glTF")
        self.assertEqual(assets[1].screenshot.name, "screenshot.png")
        self.assertIsNone(assets[0].screenshot)

    def test_verdicts_and_reasons_are_those_of_the_program(self):
        output, table = self.folder / "page.html", self.folder / "table.md"
        with redirect_stdout(StringIO()) as said:
            fidelity.main([str(self.folder), "--skywave", PROGRAM, "--env", str(self.env), "--size",
                           "16x12", "--spp", "1", "-o", str(output), "--markdown", str(table)])
        self.assertIn("3 assets: 1 rendered as asked, 1 with a warning of how they differ, "
                      "1 refused", said.getvalue())
        rows = table.read_text().splitlines()[2:]
        self.assertTrue(rows[0].startswith("| Broken | refused | "))
        self.assertEqual(rows[1], "| Plain | as asked |  |")
        self.assertIn("| Prism | differs | material 'a&lt;b\\|c': the extension", rows[2])
        text = output.read_text()
        self.assertEqual(text.count("<img"), 3)  # two pictures and a screenshot
        self.assertNotIn("http", text)
        self.assertNotIn("a<b", text)
        self.open(output, text)

    def test_cycles_is_asked_for_the_same_view_and_may_be_missing(self):
        python, job = self.folder / "python", self.folder / "job.json"
        python.write_text(f'#!/bin/sh\ncp "$2" {job}\necho "no module named bpy" >&2\nexit 1\n')
        python.chmod(0o755)
        table = self.folder / "table.md"
        with redirect_stdout(StringIO()):
            fidelity.main([str(self.folder), "--skywave", PROGRAM, "--env", str(self.env), "--size",
                           "16x12", "--spp", "1", "--cycles", str(python), "--only", "Plain", "-o",
                           str(self.folder / "page.html"), "--markdown", str(table)])
        self.assertEqual(table.read_text().splitlines()[2:],
                         ["| Plain | as asked |  | Cycles: no module named bpy |"])
        asked = json.loads(job.read_text())
        self.assertEqual(asked["size"], [16, 12])
        # The triangle's box has its middle here, and a diagonal of the square root of 2.
        for a, b in zip(asked["target"], (0.5, 0.5, 0)):
            self.assertAlmostEqual(a, b)
        distance = math.dist(asked["eye"], asked["target"])
        self.assertAlmostEqual(math.sin(math.radians(20)) * distance, math.sqrt(0.5))
        with self.assertRaisesRegex(SystemExit, "has no Plian"):
            fidelity.main([str(self.folder), "--env", str(self.env), "--only", "Plian"])

    def test_pictures_are_compared_by_blocks_where_the_asset_is(self):
        def picture(*blocks):
            row = array("f", (value for value in blocks for _ in range(3 * fidelity.BLOCK)))
            return len(blocks) * fidelity.BLOCK, fidelity.BLOCK, [row] * fidelity.BLOCK

        covered = (3 * fidelity.BLOCK, fidelity.BLOCK,
                   [array("f", [1] * 2 * fidelity.BLOCK + [0.9] * fidelity.BLOCK)] * fidelity.BLOCK)
        self.assertEqual(fidelity.difference(picture(1, 2, 9), picture(0.8, 2, 1), covered),
                         "+7.1% on average; 22.2% or less in half of 2 blocks, 22% in the worst")
        nowhere = (covered[0], covered[1], [array("f", [0] * covered[0])] * covered[1])
        self.assertEqual(fidelity.difference(picture(1, 2, 9), picture(1, 2, 9), nowhere),
                         "no block is covered")

    def open(self, output, text):
        """Opens the page in a browser, which must find in it what was written."""
        browser = shutil.which("chromium") or shutil.which("chromium-headless-shell")
        if browser is None:
            print("there is no chromium")
            return
        dom = subprocess.run(
            [browser, "--headless", "--no-sandbox", "--disable-gpu",
             f"--user-data-dir={self.folder / 'profile'}", "--dump-dom", output.as_uri()],
            capture_output=True, text=True, timeout=60, check=True).stdout
        for part in ("<tr", "<img", "</table>"):
            self.assertEqual(dom.count(part), text.count(part), part)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop()
    unittest.main()
