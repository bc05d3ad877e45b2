"""Formats a summary of figures.py as Markdown, and inserts it into a document."""

import re
import sys
import textwrap
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from reporting import lines_of_table, number


def ratio(ratios, key):
    if not ratios or key not in ratios:
        return ""
    sign, value = ratios[key] if isinstance(ratios[key], (tuple, list)) else ("=", ratios[key])
    return ("" if sign == "=" else sign + " ") + f"{value:.2f}"


def split(summary):
    """Returns rows of the thesis, and Skywave's own rows below the line."""
    rows = summary["rows"]
    return [[row for row in rows if row["thesis"]], [row for row in rows if not row["thesis"]]]


def name_of(row):
    if row["thesis"]:
        return row["parameters"]
    return f"`{row['recipe']['strategy']}`, {row['parameters']}"


def without_empty_columns(header, lines, keep):
    """Drops columns after the first `keep` in which no row has a figure."""
    used = [i < keep or any(cells[i] for cells in lines) for i in range(len(header))]
    header, *lines = [[cell for cell, use in zip(cells, used) if use]
                      for cells in [header, *lines]]
    return header, lines


def figures_table(rows, of_thesis):
    header = ["N", "method", "parameters"]
    header += ["thesis [s]", "Euc.", "Lum."] if of_thesis else []
    # If the thesis has no errors, a plain mean is dominated by bright pixels (a sun in a mirror).
    photons = of_thesis and not any("squared_distance" in row["thesis"] for row in rows)
    header += ["ours [s]", "3 mse", "as (T 8.1)", "Lum."] + ["relative mse"] * photons + ["light"]
    lines = []
    for row in rows:
        thesis, mine = row["thesis"] or {}, row["ours"] or {}
        cells = [row["row"], row["method"], name_of(row)]
        if of_thesis:
            cells += [number(thesis["seconds"], 6), number(thesis.get("squared_distance"), 6),
                      number(thesis.get("thesis_luminance"), 6)]
        cells += [number(mine.get("seconds")), number(mine.get("squared_distance"), 4),
                  number(mine.get("squared_channel_sum"), 4),
                  number(mine.get("thesis_luminance"), 4)]
        cells += [number(mine.get("relative_mse"), 4)] * photons
        cells.append(number(mine.get("light_error"), 4))
        lines.append(cells)
    return lines_of_table(*without_empty_columns(header, lines, 3), 3)


def ratios_table(rows, of_thesis):
    header, keys = ["N", "method", "parameters"], ["time", "error", "at_equal_error"]
    for key, name in zip(keys, ("time", "error", "faster at equal error")):
        header += [f"{name}: thesis", f"{name}: ours"] if of_thesis else [name]
    header += ["light error", "faster at equal light error"]
    lines = []
    for row in rows:
        cells = [row["row"], row["method"], name_of(row)]
        for key in keys:
            cells += [ratio(row["thesis_ratios"], key)] if of_thesis else []
            cells.append(ratio(row["ours_ratios"], key))
        cells += [ratio(row["ours_ratios"], "light_error"),
                  ratio(row["ours_ratios"], "at_equal_light_error")]
        lines.append(cells)
    return lines_of_table(*without_empty_columns(header, lines, 3), 3)


def pair_lines(summary):
    lines = []
    for pair in summary["pairs"]:
        parts = [f"{side} {pair[side]['faster']:.2f} times as fast"
                 + (f" with {pair[side]['error']:.3f} times the error" if "error" in pair[side]
                    else "")
                 for side in ("thesis", "ours") if side in pair]
        lines.append(f"- Row {pair['row']} against row {pair['plain']}: {'; '.join(parts)}.")
    for side in ("thesis", "ours"):
        if summary[f"{side}_floor"]:
            left, share = summary[f"{side}_floor"]
            lines.append(f"- Left at unlimited samples, {side}: {left:.4g}, "
                         f"{100 * share:.0f} % of the error of row {summary['base']}.")
    for side in ("thesis", "ours"):
        costs = summary[f"{side}_costs"]
        if costs and all(costs.values()):
            lines.append(f"- One more at every hit, {side}: a sample by importance "
                         f"{costs['importance_sample']:.3g} s, pre-sampled "
                         f"{costs['presampled_sample']:.3g} s, a directional light "
                         f"{costs['directional_light']:.3g} s.")
    return lines


def wrapped(line):
    """Lines of 100 columns at most; a table's row or a command stays one line."""
    if line.startswith(("|", "`")):
        return line
    return textwrap.fill(line, 100, subsequent_indent="  " if line.startswith("- ") else "",
                         break_long_words=False, break_on_hyphens=False)


def markdown(summary):
    above, below = split(summary)
    lines = []
    if summary.get("settings"):
        s, r = summary["settings"], summary["reference"]
        lines += [f"`{s['command']}`", "",
                  f"{s['date']}, {s['processor']}, {s['threads']} threads; {s['size']}, medians of "
                  f"times and means of errors, alternated repeats: {s['repeats']}. Reference: "
                  f"{r['samples_per_pixel']} x {r['light_samples']} samples a pixel by "
                  f"`{r['strategy']}` in "
                  f"{r['seconds']:.0f} s, its own 3 mse {3 * r['mse']:.2g}, which "
                  "is taken off those of the rows.", ""]
    else:
        lines += ["Not measured yet.", ""]
    lines += figures_table(above, True)
    if below:
        lines += ["", "Below the line, not in the thesis: ours with multiple importance sampling.",
                  "", *figures_table(below, False)]
    lines += ["", f"Against row {summary['base']} (time and error: less is better) and against "
              "the rows of plain importance sampling (times as fast: more is better):", "",
              *ratios_table(above, True)]
    if below:
        lines += ["", *ratios_table(below, False)]
    lines += ["", *pair_lines(summary)]
    notes = [f"- Row {row['row']}: {row['note']}." for row in summary["rows"] if row["note"]]
    lines += notes + [f"- {warning}." for warning in summary.get("warnings", [])]
    return "\n".join(map(wrapped, lines)) + "\n"


def insert(document, name, text):
    """Returns `document` with the text between the two markers of a table replaced."""
    begin, end = f"<!-- begin table {name} -->", f"<!-- end table {name} -->"
    pattern = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.DOTALL)
    if not pattern.search(document):
        raise ValueError(f"no place for table {name}: {begin} ... {end}")
    return pattern.sub(lambda _: f"{begin}\n\n{text}\n{end}", document, count=1)
