"""Reads EXR (scan lines, ZIP or uncompressed), PFM and PPM, writes PFM and PNG, in plain Python.

A picture is (width, height, rows from the top of r, g, b floats).
"""

import itertools
import struct
import zlib
from array import array

ZIP_LINES = {0: 1, 2: 1, 3: 16}  # lines per block by EXR's compression number


def text_at(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def exr_header(data):
    if data[:4] != b"\x76\x2f\x31\x01":
        raise ValueError("not an EXR file")
    attributes, at = {}, 8
    while data[at]:
        name, at = text_at(data, at)
        _, at = text_at(data, at)
        size, = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def exr_channels(block):
    """Returns [(name, bytes per sample)] in the file's order."""
    channels, at = [], 0
    while block[at]:
        name, at = text_at(block, at)
        kind, = struct.unpack_from("<i", block, at)
        channels.append((name, {0: 4, 1: 2, 2: 4}[kind]))
        at += 16
    return channels


def unzip(block):
    """Decodes EXR's ZIP: deflate, then differences, then separated even and odd bytes."""
    data = zlib.decompress(block)
    summed = bytes(itertools.accumulate(data, lambda a, b: (a + b - 128) & 255))
    result = bytearray(len(summed))
    half = (len(summed) + 1) // 2
    result[0::2], result[1::2] = summed[:half], summed[half:]
    return bytes(result)


def exr_window(attributes):
    """Returns (width, height, number of the first line)."""
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    return x1 - x0 + 1, y1 - y0 + 1, y0


def exr_width(path):
    return exr_window(exr_header(path.read_bytes())[0])[0]


def read_exr(path, names=("R", "G", "B")):
    """Reads the channels `names`; one that is not in the file is 0."""
    data = path.read_bytes()
    attributes, at = exr_header(data)
    compression = attributes["compression"][0]
    if compression not in ZIP_LINES or data[5] & 0x1a:
        raise ValueError(f"{path}: not scan lines with ZIP or without compression")
    width, height, y0 = exr_window(attributes)
    channels = exr_channels(attributes["channels"])
    line_bytes = width * sum(size for _, size in channels)
    rows = [None] * height
    lines = ZIP_LINES[compression]
    for offset in struct.unpack_from(f"<{-(-height // lines)}Q", data, at):
        y, size = struct.unpack_from("<2i", data, offset)
        block = data[offset + 8:offset + 8 + size]
        expected = line_bytes * min(lines, y0 + height - y)
        if compression and size < expected:
            block = unzip(block)
        for line in range(len(block) // line_bytes):
            row = array("f", bytes(4 * len(names) * width))
            position = line * line_bytes
            for name, size in channels:
                if name in names:
                    code = "e" if size == 2 else "f"
                    row[names.index(name)::len(names)] = array(
                        "f", struct.unpack_from(f"<{width}{code}", block, position))
                position += width * size
            rows[y - y0 + line] = row
    return width, height, rows


def read_ppm(path):
    """Returns levels 0 to 255 as the middles of their steps, for programs that truncate."""
    data = path.read_bytes()
    kind, width, height, top = data.split(None, 4)[:4]
    width, height = int(width), int(height)
    if kind != b"P6" or top != b"255":
        raise ValueError(f"{path}: not a PPM of 8 bits")
    levels = data[-3 * width * height:]
    return width, height, [array("f", ((level + 0.5) / 255 for level in levels[y:y + 3 * width]))
                           for y in range(0, len(levels), 3 * width)]


def read_pfm(path):
    data = path.read_bytes()
    kind, width, height, scale = data.split(None, 4)[:4]
    width, height = int(width), int(height)
    if kind != b"PF" or float(scale) >= 0:
        raise ValueError(f"{path}: not a PFM of three little-endian channels")
    line = 12 * width
    start = len(data) - line * height
    rows = [array("f", data[start + y * line:start + (y + 1) * line]) for y in range(height)]
    return width, height, rows[::-1]


def scaled(picture, factor):
    width, height, rows = picture
    return width, height, [array("f", (factor * x for x in row)) for row in rows]


def read(path):
    """Reads a picture by the ending of its name."""
    return {".exr": read_exr, ".pfm": read_pfm, ".ppm": read_ppm}[path.suffix](path)


def write_pfm(path, picture):
    width, height, rows = picture
    path.write_bytes(f"PF\n{width} {height}\n-1.0\n".encode()
                     + b"".join(row.tobytes() for row in reversed(rows)))


def to_bytes(row, exposure):
    """Returns sRGB of linear values, clipped."""
    def encode(x):
        x = min(max(exposure * x, 0), 1)
        return round(255 * (12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055))

    return bytes(map(encode, row))


def write_png_strip(path, pictures, exposure=1, gap=4):
    """Writes pictures of one height from left to right, with white between them."""
    height = min(picture[1] for picture in pictures)
    lines = []
    for y in range(height):
        parts = [to_bytes(rows[y], exposure) for _, _, rows in pictures]
        lines.append(b"\0" + (b"\xff" * 3 * gap).join(parts))
    width = (len(lines[0]) - 1) // 3

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(
            ">I", zlib.crc32(kind + body))

    path.write_bytes(b"\x89PNG\r\n\x1a\n"
                     + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(b"".join(lines), 9)) + chunk(b"IEND", b""))
