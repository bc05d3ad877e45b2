#!/usr/bin/env python3
"""Renders the glTF assets of a folder beside their screenshots, as one HTML page.

    bench/fidelity/fidelity.py FOLDER --env sky.hdr -o fidelity.html --markdown fidelity.md

FOLDER has files of glTF at any depth, such as a copy of Khronos' sample assets. Of an asset that is
there in several forms, which stand in folders beside each other, one is rendered: plain glTF if
there is one, else GLB. Its screenshot is the image in a folder `screenshot` beside those.

An asset is rendered `as asked` if the program has no warning of it, it `differs` if a warning says
how, or it is `refused` with an error. The page shows all pictures, for people to look at; nothing
here compares them, because each program has a camera and a light of its own.
"""

import argparse
import base64
import html
import json
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from reporting import lines_of_table  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent.parent
FORMS = ["glTF", "glTF-Binary"]  # the first that is there is rendered; others come after
AS_ASKED, DIFFERS, REFUSED = "as asked", "differs", "refused"
MOST_EMBEDDED = 2 ** 20  # bytes of a screenshot
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
    return Result(asset, DIFFERS if warnings else AS_ASKED, warnings, seconds, png.read_bytes())


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
        rows.append(f'<tr class="{r.verdict.split()[0]}"><td>{html.escape(r.asset.name)}</td>'
                    f"<td>{picture}</td><td>{screenshot(r.asset)}</td>"
                    f"<td>{r.verdict}</td><td>{reasons}</td><td>{r.seconds:.1f}</td></tr>")
    head = "".join(f"<th>{name}</th>" for name in
                   ("asset", "picture", "screenshot", "rendered", "because", "seconds"))
    return (f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Fidelity</title>'
            f"<style>{STYLE}</style></head><body><h1>Fidelity</h1><p>{summary(results)}. Map: "
            f"{html.escape(Path(options.env).name)}.</p>"
            f"<table><tr>{head}</tr>{''.join(rows)}</table></body></html>\n")


def markdown(results):
    """Returns the table of docs/fidelity.md."""
    def cell(text):
        return text.replace("|", "\\|").replace("<", "&lt;")
    rows = [[cell(r.asset.name), r.verdict, cell("; ".join(r.reasons))] for r in results]
    return "\n".join(lines_of_table(["asset", "rendered", "because"], rows, 3)) + "\n"


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--skywave", default=ROOT / "build/release/skywave", type=Path)
    parser.add_argument("--env", required=True, help="map that lights all assets")
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--spp", default=64, type=int)
    parser.add_argument("--timeout", default=300, type=float, help="seconds for an asset")
    parser.add_argument("-o", "--output", default="fidelity.html", type=Path)
    parser.add_argument("--markdown", type=Path, help="also write the table to this file")
    return parser.parse_args(arguments)


def main(arguments=None):
    options = parse(arguments)
    assets = find_assets(options.folder)
    if not assets:
        sys.exit(f"{options.folder}: has no files of glTF")
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
