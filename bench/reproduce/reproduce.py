#!/usr/bin/env python3
"""Repeats tables 8.2 to 8.9 of the thesis on hybrid sampling; see docs/reproduction.md.

    bench/reproduce/reproduce.py 8.2 --data DATA -o OUT
    bench/reproduce/reproduce.py all --data DATA --quick
    bench/reproduce/reproduce.py 8.5 --data DATA --document docs/reproduction_tables.md
    bench/reproduce/reproduce.py all --data DATA -o OUT --references   # these need no quiet machine
    bench/reproduce/reproduce.py 8.2 --data DATA -o OUT --repeats 1    # a first part
    bench/reproduce/reproduce.py 8.2 --data DATA -o OUT --repeats 3 --resume

DATA holds models/{killeroo.pbrt,buddha.obj,sponza.obj} and
probes/latlong/{galileo,grace,rnl}_latlong.exr.
OUT receives table_8.2.md, table_8.2.json, table_8.2.svg (errors over times), index.html (all of it,
without network), the reference and a picture of every row. Tables whose data are missing are named
and skipped. Exit code 1: nothing was measured, or a row failed.
"""

import argparse
import json
import sys
import time
from datetime import date
from pathlib import Path

import figures
import measure
import page
import report  # finds bench/reporting.py
from photon_tables import PHOTON_TABLES
from reporting import processor
from tables import TABLES as LIGHT_TABLES

TABLES = LIGHT_TABLES | PHOTON_TABLES


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tables", nargs="+", choices=[*TABLES, "all"], metavar="TABLE",
                        help="8.2 to 8.9, or all")
    parser.add_argument("--data", type=Path, metavar="DATA", help="folder of models and probes")
    parser.add_argument("--program", type=Path, metavar="FILE",
                        default=measure.REPOSITORY / "build" / "release" / "skywave")
    parser.add_argument("--size", metavar="WxH", help="film (default: 640x480; quick: 80x60)")
    parser.add_argument("--repeats", type=int, metavar="N", help="default: 5; quick: 2")
    parser.add_argument("--reference", metavar="SxL", help="samples a pixel x light samples a hit "
                        "(default: 1024x32 direct, 32768x1 path; quick: 64x16, 512x1)")
    parser.add_argument("--rows", metavar="N,N,...", help="only these (ours are s1, s2, ...)")
    parser.add_argument("--threads", type=int, default=0, help="0: as many as there are")
    parser.add_argument("--busy", action="store_true",
                        help="times are processor time over threads: for a machine with other work")
    parser.add_argument("--quick", action="store_true", help="small and rough: does it work?")
    parser.add_argument("-o", "--output", type=Path, default=Path("reproduction"), metavar="OUT")
    parser.add_argument("--document", type=Path, metavar="FILE",
                        help="also put each table between its markers in this file")
    parser.add_argument("--references", action="store_true",
                        help="make the references only, whose time does not matter")
    parser.add_argument("--resume", action="store_true",
                        help="keep the runs that OUT's JSON already holds, measure what is missing")
    parser.add_argument("--unmeasured", action="store_true",
                        help="render nothing: the thesis's figures with ours left open")
    options = parser.parse_args(arguments)
    if "all" in options.tables:
        options.tables = list(TABLES)
    options.size = options.size or ("80x60" if options.quick else "640x480")
    options.repeats = options.repeats or (2 if options.quick else 5)
    if not options.unmeasured:
        if options.data is None:
            parser.error("--data is needed")
        if not options.program.is_file():
            parser.error(f"{options.program} does not exist: build it, or say --program")
    try:
        if options.reference:
            options.reference = tuple(map(int, options.reference.split("x")))
            samples, light_samples = options.reference
    except ValueError:
        parser.error("--reference is two numbers, such as 1024x32")
    return options


def say(text):
    print(text, file=sys.stderr, flush=True)


def command_of(table, options):
    """Returns the command that repeats the measurement, without the folders of this machine."""
    words = ["bench/reproduce/reproduce.py", table.name, "--data DATA", f"--size {options.size}",
             f"--repeats {options.repeats}"]
    if options.quick:
        words.append("--quick")
    if options.busy:
        words.append("--busy")
    if options.reference:
        words.append("--reference {}x{}".format(*options.reference))
    if options.rows:
        words.append(f"--rows {options.rows}")
    if options.threads:
        words.append(f"--threads {options.threads}")
    return " ".join(words)


def chosen_rows(table, options):
    rows = [row for row in table.rows if row.recipe]
    if options.rows:
        names = options.rows.split(",")
        rows = [row for row in rows if row.name in names]
    return rows


def write(summary, options):
    options.output.mkdir(parents=True, exist_ok=True)
    stem = options.output / f"table_{summary['table']}"
    Path(f"{stem}.json").write_text(json.dumps(summary, indent=1) + "\n")
    Path(f"{stem}.md").write_text(report.markdown(summary))
    Path(f"{stem}.svg").write_text(page.chart(summary, "ours", f"Table {summary['table']}"))


def write_page(summaries, options):
    """Writes index.html of the tables that this run has measured."""
    sections = [page.section(summary, report.markdown(summary),
                             options.output / "pictures" / f"table_{summary['table']}")
                for summary in summaries]
    (options.output / "index.html").write_text(page.page(sections))


def warnings_of(summary):
    """Returns warnings to read before believing the figures."""
    own = 3 * summary["reference"]["mse"]
    touched = [row["row"] for row in summary["rows"]
               if row["ours"] and row["ours"]["squared_distance"] < 10 * own]
    warnings = list(summary["warnings"])
    if touched:
        warnings.append("The reference's own error, which is taken off, is more than a tenth of "
                        "that of rows " + ", ".join(touched))
    return warnings


def earlier_runs(table, facts, options):
    """Returns runs by row that OUT holds for this table, if they were measured in the same way."""
    file = options.output / f"table_{table.name}.json"
    if not (options.resume and file.is_file()):
        return {}
    summary = json.loads(file.read_text())
    settings = summary["settings"]
    now = {"size": options.size, "threads": options.threads or "all", "version": facts["version"],
           "processor": processor()}
    if any(settings[key] != now[key] for key in now) or summary["reference"] != facts:
        raise measure.Failed(f"{file} was measured otherwise: remove it, or do not --resume")
    return {row["row"]: row["ours"]["runs"] for row in summary["rows"] if row["ours"]}


def make_session(table, options):
    reference = options.reference or (table.quick_reference if options.quick else table.reference)
    return measure.Session(options.program, table, options.data.resolve(),
                           options.output.resolve(), options.size, options.threads, reference,
                           options.busy)


def measure_table(table, options):
    """Returns (summary, any row was rendered, all were). Writes files after every repeat."""
    rows, failed = chosen_rows(table, options), {}
    if not rows:
        raise measure.Failed(f"no row of {options.rows} can be rendered")
    session = make_session(table, options)
    picture, facts = session.reference(say)
    light_pictures = session.light_references(1, say)
    runs = earlier_runs(table, facts, options)
    settings = {"command": command_of(table, options), "date": date.today().isoformat(),
                "processor": processor(), "threads": options.threads or "all",
                "size": options.size, "version": facts["version"]}
    summary = None
    for repeat in range(options.repeats):
        start = time.monotonic()
        # All rows take turns within a repeat, and each repeat starts with a different one, so that
        # a slow minute of the machine does not affect a single row.
        first = repeat * len(rows) // options.repeats
        for row in rows[first:] + rows[:first]:
            if row.name in failed or len(runs.get(row.name, [])) > repeat:
                continue
            try:
                runs.setdefault(row.name, []).append(
                    session.measure(row, repeat + 1, picture, facts["scene_hash"],
                                    light_pictures if repeat == 0 else {}))
            except measure.Failed as reason:
                failed[row.name] = str(reason)
                say(f"{table.name} row {row.name}: {reason}")
        say(f"table {table.name}: repeat {repeat + 1} of {options.repeats} took "
            f"{time.monotonic() - start:.0f} s")
        summary = figures.summarize(table, runs, facts["mse"])
        summary.update(schema="skywave-reproduction-1", settings=settings, reference=facts,
                       warnings=[f"Row {name} failed: {why}" for name, why in failed.items()])
        settings["repeats"] = repeat + 1
        summary["warnings"] = warnings_of(summary)
        write(summary, options)
    return summary, bool(runs), not failed


def main(arguments):
    options = parse(arguments)
    measured, whole, summaries = False, True, []
    for name in options.tables:
        table = TABLES[name]
        if options.unmeasured:
            summary, measured = figures.summarize(table, {}), True
        else:
            try:
                options.output.mkdir(parents=True, exist_ok=True)
                if options.references:
                    session, measured = make_session(table, options), True
                    session.reference(say)
                    session.light_references(1, say)
                    continue
                summary, any_row, all_rows = measure_table(table, options)
            except measure.Absent as path:
                say(f"table {name} is left out: {path} does not exist")
                continue
            except measure.Failed as reason:
                say(f"table {name} failed: {reason}")
                whole = False
                continue
            measured, whole = measured or any_row, whole and all_rows
            summaries.append(summary)
        text = report.markdown(summary)
        print(f"Table {name}. {table.title}\n\n{text}", flush=True)
        if options.document:
            document = options.document.read_text()
            options.document.write_text(report.insert(document, name, text))
    if summaries:
        write_page(summaries, options)
    if not measured:
        say("nothing was measured")
    return 0 if measured and whole else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
