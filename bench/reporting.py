"""Shared by the reports of bench/reproduce and bench/peers."""

from pathlib import Path


def number(value, digits=3):
    """Formats a figure; nothing for None, and no exponent if the number can be written out."""
    if value is None:
        return ""
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text else text


def lines_of_table(header, rows, right_from):
    """Formats a Markdown table; columns from `right_from` on are right-aligned."""
    marks = ["---" if i < right_from else "---:" for i in range(len(header))]
    return ["| " + " | ".join(cells) + " |" for cells in [header, marks, *rows]]


def processor():
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return "unknown processor"
