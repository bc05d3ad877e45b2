"""Pictures of the truth test: reading uncompressed EXRs, writing textures."""

import struct
import zlib


def read_exr(path):
    """Returns the size and the channels, by name, of an uncompressed EXR of scan lines whose
    channels are 32-bit numbers."""
    with open(path, "rb") as file:
        data = file.read()
    at, attributes = 8, {}
    while data[at]:
        end = data.index(0, at)
        name, at = data[at:end], end + 1
        at = data.index(0, at) + 1
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    if attributes[b"compression"] != b"\0":
        raise ValueError(f"{path} is compressed")
    names, entries, place = [], attributes[b"channels"], 0
    while entries[place]:
        end = entries.index(0, place)
        names.append((entries[place:end].decode(), struct.unpack_from("<i", entries, end + 1)[0]))
        place = end + 17
    x0, y0, x1, y1 = struct.unpack("<4i", attributes[b"dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = {name: [] for name, _ in names}
    for offset in struct.unpack_from(f"<{height}Q", data, at + 1):
        place = offset + 8
        for name, kind in names:
            letter, size = {0: ("I", 4), 1: ("e", 2), 2: ("f", 4)}[kind]
            channels[name].append(struct.unpack_from(f"<{width}{letter}", data, place))
            place += width * size
    return width, height, channels


def write_png(path, rows, bits=8):
    """Writes pixels of 8 or 16 bits: a number each, or a tuple of three, or of four with alpha."""
    first = rows[0][0]
    channels = len(first) if isinstance(first, tuple) else 1
    lines = b"".join(b"\0" + b"".join(v.to_bytes(bits // 8, "big") for p in row
                                      for v in (p if channels > 1 else (p,))) for row in rows)

    def chunk(kind, body):
        return (struct.pack(">I", len(body)) + kind + body +
                struct.pack(">I", zlib.crc32(kind + body)))
    kind = {1: 0, 3: 2, 4: 6}[channels]
    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), bits, kind, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) +
                   chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b""))


def write_pfm(path, rows):
    """Writes one number a pixel; the first row is the top one."""
    with open(path, "wb") as file:
        file.write(f"Pf\n{len(rows[0])} {len(rows)}\n-1\n".encode())
        for row in reversed(rows):
            file.write(struct.pack(f"<{len(row)}f", *row))
