#!/usr/bin/env python3
"""Tests the page of skywave batch: it is well-formed, its links exist, and it needs no network.

    tests/cli/batch_page_test.py PROGRAM
"""
import base64
import html.parser
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest
import urllib.parse

PROGRAM = None
VOID = {"meta", "img", "br", "link"}
JOB = """
[base]
scene = "spheres"
size = "320x40"
spp = 1
[axes]
look = [{ label = "a <b> & \\"c\\"", exposure = 1 }, { label = "dark", exposure = -2 }]
env = ["bad.hdr", "good.pfm"]
seed = "1-%d"
[output]
path = "out/100%% #{look}/{env} {seed}.exr"
"""


class Page(html.parser.HTMLParser):
    """The addresses, pictures and texts of a page; fails where tags do not match."""

    def __init__(self):
        super().__init__()
        self.open, self.addresses, self.images, self.texts = [], [], [], []
        self.rows, self.figures = 0, 0

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.addresses += [attributes[name] for name in ("href", "src") if name in attributes]
        if tag == "img":
            self.images.append(attributes)
        self.rows += tag == "tr" and "class" in attributes
        self.figures += tag == "figure"
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-3:]}"
        self.open.pop()

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("style", "script"):
            self.texts.append(data)


def jpeg_size(data):
    """Returns width and height from the frame header of a baseline JPEG."""
    at = 2
    while data[at + 1] != 0xC0:
        at += 2 + struct.unpack(">H", data[at + 2:at + 4])[0]
    height, width = struct.unpack(">HH", data[at + 5:at + 9])
    return width, height


class BatchPage(unittest.TestCase):
    def page(self, seeds):
        """Returns the page of a batch of 4 * `seeds` pictures, half of which fail, and its folder.
        """
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        folder = pathlib.Path(scratch.name)
        (folder / "job.toml").write_text(JOB % seeds)
        (folder / "bad.hdr").write_text("no map")
        (folder / "good.pfm").write_bytes(b"PF\n8 4\n-1.0\n" + struct.pack("<96f", *[0.5] * 96))
        done = subprocess.run([PROGRAM, "batch", "job.toml", "-q"], cwd=folder,
                              capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 65, done.stderr)
        pages = list(folder.rglob("*.html"))
        self.assertEqual([page.name for page in pages], ["job.batch.html"])
        return pages[0].read_text(encoding="utf-8"), pages[0].parent

    def check(self, seeds):
        text, folder = self.page(seeds)
        page = Page()
        page.feed(text)
        page.close()
        self.assertEqual(page.open, [])
        self.assertEqual(page.rows, 4 * seeds)
        self.assertEqual(page.figures, 4 * seeds)
        self.assertEqual(len(page.images), 2 * seeds)
        for address in page.addresses:
            if address.startswith("data:"):
                continue
            path = urllib.parse.unquote(urllib.parse.urlsplit(address).path)
            self.assertTrue((folder / path).is_file(), address)
        self.assertEqual(re.findall(r"(?:https?:)?//", re.sub(r"base64,[^\"]*", "", text)), [])
        for image in page.images:
            data = base64.b64decode(image["src"].partition("base64,")[2], validate=True)
            self.assertEqual(jpeg_size(data), (160, 20))
            self.assertEqual((image["width"], image["height"]), ("160", "20"))
        words = "".join(page.texts)
        self.assertIn('a <b> & "c"', words)
        self.assertLess(words.index("Failures"), words.index("Pictures"))
        self.assertIn("bad.hdr", words[words.index("Failures"):words.index("Pictures")])
        return text

    def test_grid(self):
        self.assertIn('class="grid"', self.check(2))

    def test_flow(self):
        self.assertIn('class="flow"', self.check(9))


if __name__ == "__main__":
    PROGRAM = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
