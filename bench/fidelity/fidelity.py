#!/usr/bin/env python3
"""Renders the glTF assets of a folder beside their screenshots, as one HTML page.

    bench/fidelity/fidelity.py FOLDER --env sky.hdr -o fidelity.html --markdown fidelity.md

FOLDER has files of glTF at any depth, such as a copy of Khronos' sample assets. Of an asset that is
there in several forms, which stand in folders beside each other, one is rendered: plain glTF if
there is one, else GLB. Its screenshot is the image in a folder `screenshot` beside those.

An asset is rendered `as asked` if the program has no warning of it, it `differs` if a warning says
how, or it is `refused` with an error. The page shows all pictures, for people to look at. With
--cycles PYTHON, a Python that has bpy (bench/peers/setup.sh blender), Cycles renders each asset
under the same map from the same camera, too, and the means of blocks of both pictures are compared;
screenshots are of other cameras and lights.
"""

import argparse
import base64
import html
import json
import math
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "peers"))
import pictures  # noqa: E402
from reporting import lines_of_table  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent.parent
FORMS = ["glTF", "glTF-Binary"]  # the first that is there is rendered; others come after
AS_ASKED, DIFFERS, REFUSED = "as asked", "differs", "refused"
MOST_EMBEDDED = 2 ** 20  # bytes of a screenshot
DEPTH = 8                # surfaces of a path, in both programs
FIELD_OF_VIEW = 40.0     # [degrees], of the shorter side
VIEW = (0.55, 0.35, 0.76)  # towards the eye with --cycles: three quarters, from a little above
BLOCK = 12               # pixels along a side of what is compared
STYLE = """
body { font: 14px sans-serif; margin: 2em; color: #222; background: #fff }
table { border-collapse: collapse } td, th { padding: 6px; border-bottom: 1px solid #ccc;
vertical-align: top; text-align: left } img { max-width: 320px; max-height: 240px }
.differs { background: #fff6dd } .refused { background: #fde4e4 }
"""


@dataclass
class Asset:
    name: str
    file: Path
    screenshot: Path | None = None


@dataclass
class Result:
    asset: Asset
    verdict: str
    reasons: list = field(default_factory=list)  # warnings, or the error
    seconds: float = 0
    picture: bytes = b""
    cycles: bytes = b""          # the picture of Cycles
    difference: str = ""         # of both, or why there is none


def form_of(file):
    """Orders the forms of an asset."""
    parent = file.parent.name
    return (FORMS.index(parent) if parent in FORMS else len(FORMS), str(file))


def find_assets(folder):
    """Returns the assets below a folder by name."""
    files = sorted(p for p in folder.rglob("*") if p.suffix.lower() in (".gltf", ".glb"))
    groups = {}
    for file in files:
        # Files of one name whose folders have the same parent are forms of one asset.
        groups.setdefault((file.parent.parent, file.stem), []).append(file)
    assets = []
    for (parent, stem), forms in groups.items():
        shots = sorted((parent / "screenshot").glob("*")) if parent != folder.parent else []
        assets.append(Asset(stem, min(forms, key=form_of), shots[0] if shots else None))
    return sorted(assets, key=lambda asset: (asset.name.lower(), str(asset.file)))


def render(asset, options, scratch):
    """Renders an asset and returns its Result."""
    picture, stats = scratch / "picture.exr", scratch / "stats.json"
    png = picture.with_suffix(".png")
    for path in (picture, stats, png):
        path.unlink(missing_ok=True)
    command = [options.skywave, "render", asset.file, "-o", picture, "--stats", stats, "--quiet",
               "--size", options.size, "--spp", str(options.spp), "--env", options.env]
    camera = camera_of(asset, options, scratch) if options.cycles else None
    if camera:
        command += ["--eye", triple(camera["eye"]), "--target", triple(camera["target"]),
                    "--up", "0,1,0", "--fov", FIELD_OF_VIEW, "--max-depth", DEPTH,
                    "--filter", "box", "--aovs", "coverage"]
    start = time.monotonic()
    try:
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True,
                              timeout=options.timeout, check=False)
    except subprocess.TimeoutExpired:
        return Result(asset, REFUSED, [f"takes more than {options.timeout} s"], options.timeout)
    seconds = time.monotonic() - start
    if done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if line.startswith("skywave: ")]
        reason = lines[-1].removeprefix("skywave: ") if lines else f"exit code {done.returncode}"
        return Result(asset, REFUSED, [short(reason, asset)], seconds)
    warnings = [short(text, asset) for text in json.loads(stats.read_text()).get("warnings", [])]
    result = Result(asset, DIFFERS if warnings else AS_ASKED, warnings, seconds, png.read_bytes())
    if camera:
        add_cycles(result, picture, camera, options, scratch)
    return result


def triple(point):
    return ",".join(f"{x:.9g}" for x in point)


def camera_of(asset, options, scratch):
    """Returns eye and target that see the whole asset, or None where it has no extent."""
    info = scratch / "info.json"
    done = subprocess.run([str(options.skywave), "info", str(asset.file), "--json", str(info)],
                          capture_output=True, timeout=options.timeout, check=False)
    if done.returncode != 0:
        return None
    bounds = json.loads(info.read_text()).get("bounds")
    radius = math.dist(bounds["low"], bounds["high"]) / 2 if bounds else 0
    if radius == 0:
        return None
    middle = [(a + b) / 2 for a, b in zip(bounds["low"], bounds["high"])]
    distance = radius / math.sin(math.radians(FIELD_OF_VIEW / 2)) / math.hypot(*VIEW)
    return {"eye": [m + distance * v for m, v in zip(middle, VIEW)], "target": middle}


def add_cycles(result, ours, camera, options, scratch):
    """Renders the asset with Cycles, and compares the pictures."""
    picture, job = scratch / "cycles.exr", scratch / "cycles.json"
    picture.unlink(missing_ok=True)
    job.write_text(json.dumps(
        {**camera, "file": str(result.asset.file.resolve()), "depth": DEPTH,
         "map": str(Path(options.env).resolve()), "field_of_view": FIELD_OF_VIEW,
         "samples": options.spp, "size": [int(n) for n in options.size.split("x")],
         "picture": str(picture)}))
    script = Path(__file__).resolve().parent / "cycles_asset.py"
    try:
        done = subprocess.run([str(options.cycles), str(script), str(job)], capture_output=True,
                              text=True, timeout=options.timeout, check=False)
        problem = done.stderr.strip().splitlines()[-1:] if done.returncode != 0 else []
    except subprocess.TimeoutExpired:
        problem = [f"takes more than {options.timeout} s"]
    if problem or not picture.exists():
        result.difference = f"Cycles: {problem[0] if problem else 'no picture'}"
        return
    stops = float(pictures.exr_header(ours.read_bytes())[0]["pngExposure"])
    theirs = pictures.read_exr(picture)
    pictures.write_png_strip(picture.with_suffix(".png"), [theirs], exposure=2 ** stops)
    result.cycles = picture.with_suffix(".png").read_bytes()
    result.difference = difference(pictures.read_exr(ours), theirs,
                                   pictures.read_exr(ours, ("coverage.V",)))


def block_means(picture, coverage):
    """Returns the mean luminance of the pixels of each block that the asset covers.

    A block without a quarter of such pixels has None.
    """
    width, height, rows = picture
    means = []
    for top in range(0, height, BLOCK):
        for left in range(0, width, BLOCK):
            pixels = [(x, row) for row, covered in
                      zip(rows[top:top + BLOCK], coverage[2][top:top + BLOCK])
                      for x in range(left, min(left + BLOCK, width)) if covered[x] >= 1]
            total = sum(0.2125 * row[3 * x] + 0.7154 * row[3 * x + 1] + 0.0721 * row[3 * x + 2]
                        for x, row in pixels)
            means.append(total / len(pixels) if 4 * len(pixels) >= BLOCK ** 2 else None)
    return means


def difference(ours, theirs, coverage):
    """Says how block means of two pictures differ, in relation to their mean.

    Where that is below a tenth of the mean of all blocks, it is this tenth: a black block of one is
    no infinite difference.
    """
    pairs = [(a, b) for a, b in zip(block_means(ours, coverage), block_means(theirs, coverage))
             if a is not None]
    if not pairs:
        return "no block is covered"
    mean = sum(a + b for a, b in pairs) / (2 * len(pairs))
    parts = sorted(abs(a - b) / max((a + b) / 2, 0.1 * mean, 1e-30) for a, b in pairs)
    whole = sum(a - b for a, b in pairs) / max(sum(b for _, b in pairs), 1e-30)
    return (f"{whole:+.1%} on average; {parts[len(parts) // 2]:.1%} or less in half of "
            f"{len(parts)} blocks, {parts[-1]:.0%} in the worst")


def short(text, asset):
    """Leaves out the path of the file, which stands beside the text."""
    return text.removeprefix(f"{asset.file}: ")


def image(data, suffix):
    kind = {".jpg": "jpeg", ".jpeg": "jpeg"}.get(suffix, suffix.lstrip("."))
    return f'<img alt="" src="data:image/{kind};base64,{base64.b64encode(data).decode()}">'


def screenshot(asset):
    if asset.screenshot is None:
        return ""
    if asset.screenshot.stat().st_size > MOST_EMBEDDED:
        return html.escape(asset.screenshot.name)
    return image(asset.screenshot.read_bytes(), asset.screenshot.suffix.lower())


def summary(results):
    counts = {verdict: sum(r.verdict == verdict for r in results)
              for verdict in (AS_ASKED, DIFFERS, REFUSED)}
    return (f"{len(results)} assets: {counts[AS_ASKED]} rendered as asked, {counts[DIFFERS]} with "
            f"a warning of how they differ, {counts[REFUSED]} refused")


def page(results, options):
    rows = []
    for r in results:
        reasons = "<br>".join(html.escape(reason) for reason in r.reasons)
        picture = image(r.picture, ".png") if r.picture else ""
        cycles = image(r.cycles, ".png") if r.cycles else ""
        peer = (f"<td>{cycles}</td><td>{html.escape(r.difference)}</td>" if options.cycles else "")
        rows.append(f'<tr class="{r.verdict.split()[0]}"><td>{html.escape(r.asset.name)}</td>'
                    f"<td>{picture}</td>{peer}<td>{screenshot(r.asset)}</td>"
                    f"<td>{r.verdict}</td><td>{reasons}</td><td>{r.seconds:.1f}</td></tr>")
    columns = ["asset", "picture", "screenshot", "rendered", "because", "seconds"]
    if options.cycles:
        columns[2:2] = ["Cycles", "difference"]
    head = "".join(f"<th>{name}</th>" for name in columns)
    return (f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Fidelity</title>'
            f"<style>{STYLE}</style></head><body><h1>Fidelity</h1><p>{summary(results)}. Map: "
            f"{html.escape(Path(options.env).name)}.</p>"
            f"<table><tr>{head}</tr>{''.join(rows)}</table></body></html>\n")


def markdown(results):
    """Returns the table of docs/fidelity.md."""
    def cell(text):
        return text.replace("|", "\\|").replace("<", "&lt;")
    peer = any(r.difference for r in results)
    rows = [[cell(r.asset.name), r.verdict, cell("; ".join(r.reasons)),
             *([cell(r.difference)] if peer else [])] for r in results]
    columns = ["asset", "rendered", "because", *(["difference to Cycles"] if peer else [])]
    return "\n".join(lines_of_table(columns, rows, len(columns))) + "\n"


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--skywave", default=ROOT / "build/release/skywave", type=Path)
    parser.add_argument("--env", required=True, help="map that lights all assets")
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--spp", default=64, type=int)
    parser.add_argument("--cycles", metavar="PYTHON", type=Path,
                        help="Python with bpy, which renders the assets with Cycles, too")
    parser.add_argument("--only", metavar="NAME", action="append",
                        help="render this asset; may be given more than once (default: all)")
    parser.add_argument("--timeout", default=300, type=float, help="seconds for an asset")
    parser.add_argument("-o", "--output", default="fidelity.html", type=Path)
    parser.add_argument("--markdown", type=Path, help="also write the table to this file")
    return parser.parse_args(arguments)


def main(arguments=None):
    options = parse(arguments)
    assets = find_assets(options.folder)
    if not assets:
        sys.exit(f"{options.folder}: has no files of glTF")
    if options.only:
        missing = set(options.only) - {asset.name for asset in assets}
        if missing:
            sys.exit(f"{options.folder}: has no {', '.join(sorted(missing))}")
        assets = [asset for asset in assets if asset.name in options.only]
    results = []
    with tempfile.TemporaryDirectory() as scratch:
        for i, asset in enumerate(assets):
            results.append(render(asset, options, Path(scratch)))
            print(f"{i + 1}/{len(assets)} {asset.name}: {results[-1].verdict}", flush=True)
    options.output.write_text(page(results, options))
    if options.markdown:
        options.markdown.write_text(markdown(results))
    print(summary(results))
    print(options.output)


if __name__ == "__main__":
    main()
