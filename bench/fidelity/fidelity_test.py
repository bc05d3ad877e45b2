#!/usr/bin/env python3
"""Tests the page of fidelity on small assets; in a browser, where there is one.

    bench/fidelity/fidelity_test.py build/release/skywave
"""

import base64
import json
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
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
