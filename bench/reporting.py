"""What the reports of bench/reproduce and bench/peers share."""

from pathlib import Path


def number(value, digits=3):
    """Text of a figure; nothing for None, no exponents where there is a number to write."""
    if value is None:
        return ""
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text else text


def lines_of_table(header, rows, right_from):
    """Markdown; columns from `right_from` on stand to the right."""
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
