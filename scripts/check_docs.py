#!/usr/bin/env python3
"""Checks every Markdown file of the tree: its commands run, its links and files exist, its prose is
wrapped.

    scripts/check_docs.py [PROGRAM] [--text-only] [--verbose] [FILE...]

PROGRAM (default: build/release/skywave) runs the commands of every ```sh block in a scratch folder,
smaller and with fewer samples than the documents say. Maps, models and pictures that the commands
read are small stand-ins that this script makes. A ```toml block is a job file of which
`skywave batch` lists the pictures. A block with a comment

    <!-- not run: why -->

in the line before it is listed and not run. Also checked: relative links and their anchors, paths
and file names in backticks, and lines of prose, which have at most 100 columns (tables, code, URLs
and the tables that bench/reproduce writes excepted). Exit code 1: something failed, as file:line.
Python 3 and nothing else; about a minute.
"""
import argparse
import json
import pathlib
import re
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
COLUMNS = 100
NOT_RUN = re.compile(r"<!-- not run: (.+?) -->")


class Document:
    """The lines of a file, and the kind of each line: prose, table, code, generated."""

    def __init__(self, path):
        self.path = path
        self.name = str(path.relative_to(ROOT))
        self.lines = path.read_text(encoding="utf-8").split("\n")
        self.kinds, self.blocks = [], []  # blocks: (first line, commands, reason not to run)
        self.jobs = []  # the same of job files
        fence, generated, block = None, False, None
        for number, line in enumerate(self.lines, 1):
            text = line.strip()
            if text.startswith("```"):
                if fence is None:
                    fence = text[3:]
                    block = (number + 1, [], self.reason_before(number))
                else:
                    if fence in ("sh", "toml"):
                        (self.blocks if fence == "sh" else self.jobs).append(block)
                    fence = None
                self.kinds.append("code")
                continue
            if fence is not None:
                block[1].append(line)
                self.kinds.append("code")
                continue
            if text.startswith("<!-- begin table"):
                generated = True
            self.kinds.append("generated" if generated else "table" if text.startswith("|")
                              else "prose")
            if text.startswith("<!-- end table"):
                generated = False

    def reason_before(self, number):
        for line in reversed(self.lines[:number - 1]):
            if line.strip():
                found = NOT_RUN.match(line.strip())
                return found.group(1) if found else None
        return None

    def anchors(self):
        """Returns GitHub's names of the headings."""
        names = set()
        for line, kind in zip(self.lines, self.kinds):
            if kind == "prose" and line.startswith("#"):
                heading = re.sub(r"[^\w\- ]", "", line.lstrip("#").strip().lower())
                names.add(heading.replace(" ", "-"))
        return names


# ---- Text ----

def tracked_files():
    listed = subprocess.run(["git", "-C", str(ROOT), "ls-files", "-co", "--exclude-standard"],
                            capture_output=True, text=True)
    if listed.returncode == 0:
        return [line for line in listed.stdout.splitlines() if (ROOT / line).exists()]
    return [str(path.relative_to(ROOT)) for path in ROOT.rglob("*")
            if path.is_file() and "build" not in path.relative_to(ROOT).parts]


def check_widths(document, fail):
    for number, (line, kind) in enumerate(zip(document.lines, document.kinds), 1):
        if kind != "prose" or len(line) <= COLUMNS or "http" in line or line.startswith("!["):
            continue
        fail(document, number, f"{len(line)} columns")


def check_links(document, documents, fail):
    for number, (line, kind) in enumerate(zip(document.lines, document.kinds), 1):
        if kind == "code":
            continue
        for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "", line)):
            if re.match(r"[a-z]+:", target):
                continue
            file, _, anchor = target.partition("#")
            path = (document.path.parent / file).resolve() if file else document.path
            if not path.exists():
                fail(document, number, f"no such file: {target}")
            elif anchor and path in documents and anchor not in documents[path].anchors():
                fail(document, number, f"no such heading: {target}")


def braces(text):
    """Expands a/{b,c}.h to a/b.h, a/c.h."""
    found = re.search(r"\{([^{}]*)\}", text)
    if not found:
        return [text]
    return [expanded for part in found.group(1).split(",")
            for expanded in braces(text[:found.start()] + part + text[found.end():])]


def check_paths(document, files, fail):
    """Checks that `folder/file` exists if `folder` does, and `file.cc` somewhere in the tree."""
    folders = {file.split("/")[0] for file in files if "/" in file}
    names = {file.rsplit("/", 1)[-1] for file in files}
    for number, (line, kind) in enumerate(zip(document.lines, document.kinds), 1):
        if kind in ("code", "generated"):
            continue
        for quoted in re.findall(r"`([^`]+)`", line):
            for text in quoted.split():
                if not re.fullmatch(r"\.?[\w{},.*-]+(/[\w{},.*-]+)*/?", text):
                    continue
                if "/" not in text:
                    source = re.fullmatch(r"[a-z][\w-]*\.(h|cc|py|sh|cmake)", text)
                    if source and text not in names:
                        fail(document, number, f"no file of that name: {text}")
                    continue
                here = document.path.parent.relative_to(ROOT)
                for path in braces(text):
                    if any(part.isupper() for part in re.split(r"[/.]", path)):
                        continue  # a placeholder: kernels/bsdf/NAME.cc
                    near = [str(base / path).rstrip("/") for base in (pathlib.Path(), here)]
                    if path.split("/")[0] not in folders and not (ROOT / near[1]).exists():
                        continue
                    if not any(list(ROOT.glob(candidate)) for candidate in near):
                        fail(document, number, f"no such file: {path}")


# ---- Stand-ins for what the commands read ----

CUBE_CORNERS = [(x, y, z) for x in (-1, 1) for y in (0, 2) for z in (-1, 1)]
CUBE_SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE = [triangle for a, b, c, d in CUBE_SIDES for triangle in ((a, b, c), (a, c, d))]


def sky_pfm():
    """Returns a lat-long map with a sun as a little-endian PFM, bottom row first."""
    width, height = 64, 32
    pixels = b""
    for y in range(height):
        for x in range(width):
            up = y / height
            sun = 400.0 if (x, y) == (20, 24) else 0.0
            pixels += struct.pack("<3f", 0.3 + sun, 0.3 + 0.3 * up + sun, 0.3 + 0.6 * up + sun)
    return b"PF\n%d %d\n-1.0\n" % (width, height) + pixels


def cube_ply():
    lines = ["ply", "format ascii 1.0", f"element vertex {len(CUBE_CORNERS)}", "property float x",
             "property float y", "property float z", f"element face {len(CUBE)}",
             "property list uchar int vertex_indices", "end_header"]
    lines += ["%d %d %d" % corner for corner in CUBE_CORNERS]
    lines += ["3 %d %d %d" % triangle for triangle in CUBE]
    return "\n".join(lines) + "\n"


def cube_obj():
    lines = ["v %d %d %d" % corner for corner in CUBE_CORNERS]
    lines += ["f %d %d %d" % tuple(corner + 1 for corner in triangle) for triangle in CUBE]
    return "\n".join(lines) + "\n"


def cloud_ply():
    points = "".join("%d %d %d\n" % corner for corner in CUBE_CORNERS)
    return ("ply\nformat ascii 1.0\n" + f"element vertex {len(CUBE_CORNERS)}\n"
            + "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n" + points)


def pbrt_mesh():
    points = " ".join("%d %d %d" % corner for corner in CUBE_CORNERS)
    indices = " ".join("%d %d %d" % triangle for triangle in CUBE)
    return f'Shape "trianglemesh" "point P" [{points}] "integer indices" [{indices}]\n'


def cube_glb():
    points = b"".join(struct.pack("<3f", *corner) for corner in CUBE_CORNERS)
    indices = b"".join(struct.pack("<3H", *triangle) for triangle in CUBE)
    text = json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.4, 0.3, 1]}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(CUBE_CORNERS), "type": "VEC3",
             "min": [-1, 0, -1], "max": [1, 2, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 3 * len(CUBE), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(points)},
                        {"buffer": 0, "byteOffset": len(points), "byteLength": len(indices)}],
        "buffers": [{"byteLength": len(points) + len(indices)}]}).encode()
    text += b" " * (-len(text) % 4)
    data = points + indices
    data += b"\0" * (-len(data) % 4)
    chunks = (struct.pack("<I4s", len(text), b"JSON") + text +
              struct.pack("<I4s", len(data), b"BIN\0") + data)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def make_stand_ins(program, folder):
    """Makes everything that commands of the documents read and that the tree does not have."""
    def run(*arguments):
        subprocess.run([program, *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL)

    (folder / "map.pfm").write_bytes(sky_pfm())
    for name in ("probe.hdr", "sky.hdr", "probe.exr", "sky.exr"):
        run("probe", "convert", "map.pfm", name, "--to", "latlong")
    (folder / "model.obj").write_text(cube_obj())
    (folder / "cloud.ply").write_text(cloud_ply())
    (folder / "bunny.ply").write_text(cube_ply())
    (folder / "helmet.glb").write_bytes(cube_glb())
    (folder / "scene.pbrt").write_text(
        'LookAt 4 3 6  0 1 0  0 1 0\nCamera "perspective" "float fov" 40\nWorldBegin\n' +
        pbrt_mesh())
    (folder / "skies").mkdir()
    shutil.copy(folder / "sky.hdr", folder / "skies/noon.hdr")
    for name in ("grace.exr", *(f"skies/clouds_{frame:04}.exr" for frame in range(36, 41))):
        shutil.copy(folder / "sky.exr", folder / name)
    (folder / "examples").mkdir()
    for job in (ROOT / "examples").glob("*.toml"):
        (folder / "examples" / job.name).write_text(quick_job(job.read_text()))
    data = folder / "DATA"
    (data / "models").mkdir(parents=True)
    (data / "probes/latlong").mkdir(parents=True)
    (data / "models/killeroo.pbrt").write_text(pbrt_mesh())
    (data / "models/bunny.ply").write_text(cube_ply())
    for name in ("galileo", "grace", "rnl"):
        shutil.copy(folder / "sky.exr", data / f"probes/latlong/{name}_latlong.exr")
    for name, seed in (("a.exr", "1"), ("reference.exr", "2")):
        run("render", "furnace", "--size", "16x12", "--spp", "1", "--seed", seed, "-q", "-o", name)
    shutil.copy(folder / "a.png", folder / "photo.png")
    shutil.copy(folder / "map.pfm", folder / "white.pfm")
    (folder / "year.csv").write_text("sky-000,sky-145\n0.2,1\n0.1,3\n")


# ---- Commands ----

def quick_job(text):
    """Returns a job file with less work."""
    for key, value in (("size", '"32x24"'), ("spp", "1"), ("steps", "2")):
        text = re.sub(rf"\b{key} = [^\s,}}]+", f"{key} = {value}", text)
    return text


# These changes make a command quick: values that replace those of the document, and flags that are
# added if it has none of `unless`.
QUICK = {
    "render": ({"--size": "64x48", "--spp": "8"}, ("--crop",)),
    "paths": ({"--size": "32x24", "--spp": "2"}, ()),
    "converge": ({"--size": "32x24", "--budgets": "1,2", "--repeats": "2", "--reference-spp": "4"},
                 ()),
    "bench": ({"--size": "64x48", "--spp": "2", "--repetitions": "1"}, ()),
}
DROPPED = {"converge": ("--time",)}


def quick(words):
    """Returns the command with less work; `words` begins with skywave."""
    if len(words) < 2 or words[1] not in QUICK or "--help" in words:
        return words
    values, unless = QUICK[words[1]]
    if any(flag in words for flag in unless):
        values = {flag: value for flag, value in values.items() if flag != "--size"}
    kept, skip = [], False
    for word in words:
        if skip:
            skip = False
        elif word in values or word in DROPPED.get(words[1], ()):
            skip = True
        else:
            kept.append(word)
    # They precede lists, which would swallow the words after them.
    return kept[:3] + [word for pair in values.items() for word in pair] + kept[3:]


def commands_of(lines, first):
    """Returns (line number, words) of each command, without comments and continuations."""
    pending, start = "", 0
    for number, line in enumerate(lines, first):
        pending, start = pending + line, start if pending else number
        if line.endswith("\\"):
            pending = pending[:-1]
            continue
        words = shlex.split(pending, comments=True)
        pending = ""
        if words:
            yield start, words


def run_command(program, words, folder):
    """Returns the error of a command, or nothing."""
    if words[0] == "skywave":
        words = quick(words)
        words[0] = str(program)
    elif words[0].startswith("scripts/") and (ROOT / words[0]).exists():
        words[0] = str(ROOT / words[0])
    else:
        return f"this script does not know the program {words[0]}; mark the block as not run"
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=120)
    if done.returncode == 0:
        return None
    messages = [line for line in (done.stderr + done.stdout).split("\n")
                if line.strip() and not line.startswith("Run with --help")]
    return (f"exit code {done.returncode}: {shlex.join(words[1:])}: " +
            (messages[-1] if messages else "no message"))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", type=pathlib.Path,
                        default=ROOT / "build/release/skywave")
    parser.add_argument("files", nargs="*", type=pathlib.Path, help="default: all of the tree")
    parser.add_argument("--text-only", action="store_true", help="run no command")
    parser.add_argument("--verbose", action="store_true", help="print each command and its time")
    options = parser.parse_args()

    files = tracked_files()
    documents = {path: Document(path) for path in
                 sorted(ROOT / file for file in files if file.endswith(".md"))}
    chosen = [path.resolve() for path in options.files] or list(documents)
    failures = []

    def fail(document, number, message):
        failures.append(f"{document.name}:{number}: {message}")
        print(failures[-1], file=sys.stderr)

    for path in chosen:
        check_widths(documents[path], fail)
        check_links(documents[path], documents, fail)
        check_paths(documents[path], files, fail)

    ran = skipped = 0
    if not options.text_only:
        program = options.program.resolve()
        if not program.exists():
            sys.exit(f"no program: {program}")
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            make_stand_ins(program, folder)
            for path in chosen:
                document = documents[path]
                for first, lines, reason in document.blocks:
                    if reason is not None:
                        print(f"{document.name}:{first}: not run: {reason}")
                        skipped += 1
                        continue
                    for number, words in commands_of(lines, first):
                        start = time.monotonic()
                        problem = run_command(program, words, folder)
                        ran += 1
                        if options.verbose:
                            print(f"{time.monotonic() - start:6.2f} s  {document.name}:{number}")
                        if problem:
                            fail(document, number, problem)
                for first, lines, reason in document.jobs:
                    job = folder / f"job_{ran}.toml"
                    job.write_text("\n".join(lines) + "\n")
                    words = ["skywave", "batch", job.name, "--list"]
                    problem = None if reason else run_command(program, words, folder)
                    ran += reason is None
                    if problem:
                        fail(document, first, problem)
    print(f"{len(chosen)} documents, {ran} commands run, {skipped} blocks not run, "
          f"{len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
