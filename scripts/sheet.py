"""Combines PNG files written by the renderer on one sheet. Needs Python 3 only."""
import shutil
import struct
import subprocess
import sys
import zlib


def read_png(path):
    """Returns (width, height, RGB bytes) of an 8-bit RGB PNG, as the renderer writes them."""
    data = path.read_bytes()
    at, compressed, width, height = 8, b"", 0, 0
    while at < len(data):
        (length,) = struct.unpack(">I", data[at:at + 4])
        kind, body = data[at + 4:at + 8], data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            if (depth, color, interlaced) != (8, 2, 0):
                sys.exit(f"{path}: not an 8-bit RGB PNG")
        elif kind == b"IDAT":
            compressed += body
        at += 12 + length
    raw, stride = zlib.decompress(compressed), width * 3
    rows, above = [], bytes(stride)
    for y in range(height):
        mode, *row = raw[y * (stride + 1):(y + 1) * (stride + 1)]
        for i in range(stride):
            a, b, c = (row[i - 3] if i > 2 else 0), above[i], (above[i - 3] if i > 2 else 0)
            p = a + b - c
            paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row[i] = (row[i] + (0, a, b, (a + b) // 2, paeth)[mode]) & 255
        rows.append(bytes(row))
        above = row
    return width, height, b"".join(rows)


def write_png(path, width, height, rgb):
    def chunk(kind, body):
        return (struct.pack(">I", len(body)) + kind + body +
                struct.pack(">I", zlib.crc32(kind + body)))
    rows = b"".join(b"\0" + rgb[y * width * 3:(y + 1) * width * 3] for y in range(height))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" +
                     chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def tile(pictures, columns):
    """Combines pictures of one size, row by row, to one (width, height, RGB bytes)."""
    width, height, _ = pictures[0]
    stride, rows = width * 3, []
    for first in range(0, len(pictures), columns):
        line = pictures[first:first + columns]
        for y in range(height):
            rows += [rgb[y * stride:(y + 1) * stride] for _, _, rgb in line]
    return width * columns, height * (len(pictures) // columns), b"".join(rows)


def write_sheet(path, pictures, columns):
    """Writes pictures from read_png, row by row, to path, and as .jpg next to it if cjpeg is
    installed."""
    width, height, rgb = tile(pictures, columns)
    write_png(path, width, height, rgb)
    if shutil.which("cjpeg"):
        subprocess.run(["cjpeg", "-quality", "80", "-outfile", path.with_suffix(".jpg")],
                       input=b"P6 %d %d 255\n" % (width, height) + rgb, check=True)
