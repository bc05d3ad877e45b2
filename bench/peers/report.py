"""Formats results of peers.py as Markdown."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from reporting import lines_of_table, number


def signed_percent(ratio):
    return "" if ratio is None else f"{100 * (ratio - 1):+.2f} %"


def job_table(job):
    header = ["program", "samples", "render [s]", "Msamples/s", "Skywave is", "rays a sample",
              "mse", "relative mse", "mean", "worst block", "time x mse"]
    rows = []
    for row in job["rows"]:
        if row.get("skipped"):
            rows.append([row["program"], f"skipped: {row['skipped']}"] + [""] * (len(header) - 2))
            continue
        rows.append([row["program"], str(job["samples"]), number(row["seconds"]),
                     number(row["msamples_per_s"]),
                     "" if row["program"] == "Skywave" or "skywave_faster" not in row
                     else "{:.1f} times as fast ({:.1f} to {:.1f})".format(
                         row["skywave_faster"], *row["skywave_faster_range"]),
                     number(row.get("rays_per_sample")), number(row["mse"]),
                     number(row["relative_mse"]), signed_percent(row["mean_ratio"]),
                     f"{100 * row['worst_block']:.1f} %",
                     "" if "skywave_efficiency" not in row
                     else f"{row['skywave_efficiency']:.1f}"])
    return lines_of_table(header, rows, 1)


def markdown(summary):
    s = summary["settings"]
    lines = [f"`{s['command']}`", "",
             f"{s['date']}, {s['processor']}, {s['threads']} threads, {s['size']}, medians of "
             f"{s['repeats']} alternated repeats, ratios by pair.", ""]
    for job in summary["jobs"]:
        lines += [job["title"] + ":", "", *job_table(job), ""]
    lines += ["- *mean* and *worst block*: against the reference, of the picture and of that of "
              f"its {s['blocks']} blocks that is farthest away.",
              "- *time x mse*: of the program, over that of Skywave: what the same error costs.",
              "- " + s["reference"]]
    for program in summary["programs"]:
        version = f" {program['version']}" if program["version"] else ""
        lines.append(f"- {program['name']}{version}: {program['settings']}. Time: "
                     f"{program['timing']}.")
    return "\n".join(lines) + "\n"
