"""Formats results of peers.py as Markdown."""

import math
import sys
import textwrap
from pathlib import Path

import estimates

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from reporting import lines_of_table, number  # noqa: E402

HEADER = ["scene", "program", "version", "threads", "samples", "render [s]", "Msamples/s",
          "Skywave is", "rays a sample", "noise", "bias", "mean", "time x variance", "time x mse"]


def percent(value):
    return f"{number(100 * value)} %"


def bias_text(row):
    if row["estimate"]["bias2"] is None:
        return ""
    value, is_limit = estimates.bias(estimates.Estimate(**row["estimate"]))
    return ("< " if is_limit else "") + percent(value)


def mean_text(estimate):
    text = f"{100 * estimate['mean']:+.2f}"
    error = estimate["mean_error"]
    return text + (" %" if error is None else f" +- {100 * error:.2f} %")


def faster_text(row):
    if row["program"] == "Skywave" or "skywave_faster" not in row:
        return ""
    return "{:.2f} times as fast ({:.2f} to {:.2f})".format(row["skywave_faster"],
                                                          *row["skywave_faster_range"])


def job_rows(job, threads):
    rows = []
    for row in job["rows"]:
        if row.get("skipped"):
            rows.append([job["job"], row["program"], f"skipped: {row['skipped']}"]
                        + [""] * (len(HEADER) - 3))
            continue
        variance = row["estimate"]["variance"]
        rows.append([job["job"], row["program"], row["version"], str(threads), str(row["samples"]),
                     number(row["seconds"]), number(row["msamples_per_s"]), faster_text(row),
                     number(row.get("rays_per_sample")),
                     "" if variance is None else percent(math.sqrt(variance)), bias_text(row),
                     mean_text(row["estimate"]), number(row.get("time_variance")),
                     number(row.get("time_mse"))])
    return rows


def ahead(summary):
    """Returns a line for each program and job that beats the row of Skywave."""
    lines = []
    for job in summary["jobs"]:
        for row in job["rows"]:
            if row.get("skipped") or row["program"].startswith("Skywave"):
                continue
            better = [name for name, key in (("samples/s", "skywave_faster"),
                                             ("noise of equal samples", "sample_variance"),
                                             ("time x variance", "time_variance"),
                                             ("time x mse", "time_mse"))
                      if row.get(key) is not None and row[key] < 1]
            if better:
                lines.append(f"- {row['program']} is ahead of Skywave in {job['job']}: "
                             + ", ".join(better) + ".")
    return lines or ["- No program is ahead of Skywave in samples/s, noise of equal samples or "
                     "time x error."]


def wrapped(text):
    """Breaks a paragraph or an item of a list into lines as documents have them."""
    return textwrap.wrap(text, 100, subsequent_indent="  " if text.startswith("- ") else "",
                         break_long_words=False, break_on_hyphens=False)


def markdown(summary):
    """Returns the table and its notes, as docs/peers.md has them."""
    s = summary["settings"]
    rows = [row for job in summary["jobs"] for row in job_rows(job, s["threads"])]
    heading = (f"`{s['command']}`, {s['date']}, {s['processor']}, {s['threads']} threads, "
               f"{s['size']}, medians of {s['repeats']} alternated repeats, ratios by pair:")
    lines = ahead(summary)
    lines += [f"- *{job['job']}*: {job['title']}." for job in summary["jobs"]]
    lines += ["- Pixels that see nothing but surfaces are compared. *noise*: standard deviation of "
              "a value about the program's own expectation; *bias*: root mean square of the "
              "difference of the expectations of program and reference, or the largest that agrees "
              "with the repeats; *mean*: of the whole picture. All relative to the mean of the "
              "reference.",
              "- *time x variance*, *time x mse*: of the program, over that of Skywave: what equal "
              "noise and equal error cost.",
              "- " + s["reference"]]
    for program in summary["programs"]:
        lines.append(f"- {program['name']}: {program['settings']}. Time: {program['timing']}.")
    notes = [part for line in lines for part in wrapped(line)]
    return "\n".join([*wrapped(heading), "", *lines_of_table(HEADER, rows, 3), "", *notes]) + "\n"
