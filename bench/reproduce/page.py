"""Draws a table's errors over times, as figure 8.2 of the thesis has them, and a page of all.

Everything on the page is in its file, so it can be read without a network. The dots are scattered
and carry the numbers of their rows, which the curves of `skywave converge` do not have.
"""

import base64
import html
import math

WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 620, 420, 70, 34, 16, 50
# Colours that can be told apart with impaired colour vision (Okabe and Ito 2008).
COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000"]


def power_fit(points):
    """Returns (c, k) of error = c * seconds^k by least squares of logarithms, or None."""
    logs = [(math.log(t), math.log(e)) for t, e in points if t > 0 and e > 0]
    if len({x for x, _ in logs}) < 2:
        return None
    mean_x = sum(x for x, _ in logs) / len(logs)
    mean_y = sum(y for _, y in logs) / len(logs)
    slope = (sum((x - mean_x) * (y - mean_y) for x, y in logs)
             / sum((x - mean_x) ** 2 for x, _ in logs))
    return math.exp(mean_y - slope * mean_x), slope


def series_of(summary, side):
    """Returns {method: [(seconds, error, name of the row)]} of the rows that have both."""
    series = {}
    for row in summary["rows"]:
        figures = row[side]
        if figures and figures.get("squared_distance", 0) > 0:
            series.setdefault(row["method"], []).append(
                (figures["seconds"], figures["squared_distance"], row["row"]))
    return series


def ticks(low, high):
    return [m * 10 ** e for e in range(math.floor(math.log10(low)) - 1,
                                       math.ceil(math.log10(high)) + 1)
            for m in (1, 2, 5) if low * 0.999 <= m * 10 ** e <= high * 1.001]


def chart(summary, side, title):
    """Returns an SVG of 3 mse over seconds: a dot for each row with its number, and for each method
    of three rows or more the power of time that fits them best; empty if there is nothing."""
    series = series_of(summary, side)
    points = [point for rows in series.values() for point in rows]
    if not points:
        return ""
    x_low, x_high = min(p[0] for p in points) / 1.2, max(p[0] for p in points) * 1.2
    y_low, y_high = min(p[1] for p in points) / 1.3, max(p[1] for p in points) * 1.3

    def x_of(seconds):
        share = math.log(seconds / x_low) / math.log(x_high / x_low)
        return LEFT + share * (WIDTH - LEFT - RIGHT)

    def y_of(error):
        share = math.log(error / y_low) / math.log(y_high / y_low)
        return HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM)

    height = HEIGHT + 20 * len(series)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" '
           f'viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>',
           f'<text x="{LEFT}" y="20" font-size="15" font-weight="bold">{html.escape(title)}</text>']
    for value in ticks(x_low, x_high):
        out.append(f'<path d="M{x_of(value):.1f},{TOP}V{HEIGHT - BOTTOM}" stroke="#e4e4e4"/>'
                   f'<text x="{x_of(value):.1f}" y="{HEIGHT - BOTTOM + 16}" '
                   f'text-anchor="middle">{value:g}</text>')
    for value in ticks(y_low, y_high):
        out.append(f'<path d="M{LEFT},{y_of(value):.1f}H{WIDTH - RIGHT}" stroke="#e4e4e4"/>'
                   f'<text x="{LEFT - 6}" y="{y_of(value) + 4:.1f}" '
                   f'text-anchor="end">{value:g}</text>')
    out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 12}" '
               'text-anchor="middle">seconds</text>'
               f'<text transform="translate(14,{HEIGHT / 2}) rotate(-90)" '
               'text-anchor="middle">3 mse</text>')
    for i, (method, rows) in enumerate(series.items()):
        color = COLORS[i % len(COLORS)]
        fit = power_fit([point[:2] for point in rows]) if len(rows) >= 3 else None
        legend = html.escape(method)
        if fit:
            ends = [min(p[0] for p in rows), max(p[0] for p in rows)]
            path = "L".join(f"{x_of(t):.1f},{y_of(fit[0] * t ** fit[1]):.1f}" for t in ends)
            out.append(f'<path d="M{path}" stroke="{color}" fill="none"/>')
            legend += f": {fit[0]:.3g} t^{fit[1]:.2f}"
        for seconds, error, name in rows:
            out.append(f'<circle cx="{x_of(seconds):.1f}" cy="{y_of(error):.1f}" r="3.5" '
                       f'fill="{color}"/><text x="{x_of(seconds) + 5:.1f}" '
                       f'y="{y_of(error) - 4:.1f}" font-size="9" fill="#505050">'
                       f'{html.escape(name)}</text>')
        row = HEIGHT + 20 * i + 8
        out.append(f'<circle cx="{LEFT + 6}" cy="{row}" r="4" fill="{color}"/>'
                   f'<text x="{LEFT + 16}" y="{row + 4}">{legend}</text>')
    return "\n".join(out + ["</svg>"])


def image(file, alt):
    """Returns a picture as a part of a page; a remark if there is none."""
    if not file.is_file():
        return f"<span>{html.escape(alt)}: not rendered</span>"
    data = base64.b64encode(file.read_bytes()).decode()
    return f'<img src="data:image/png;base64,{data}" alt="{html.escape(alt)}">'


def section(summary, text, pictures):
    """Returns a table's part of the page. `pictures` has ROW.png and ROW.error.png of rows."""
    charts = [chart(summary, side, f"Table {summary['table']}, {side}")
              for side in ("thesis", "ours")]
    shown = [row for row in summary["rows"] if (pictures / f"{row['row']}.png").is_file()]
    cells = "".join(
        f"<figure>{image(pictures / (row['row'] + '.png'), 'row ' + row['row'])}"
        f"{image(pictures / (row['row'] + '.error.png'), 'error of row ' + row['row'])}"
        f"<figcaption>Row {html.escape(row['row'])}: {html.escape(row['method'])} "
        f"{html.escape(row['parameters'])}</figcaption></figure>" for row in shown)
    return (f"<section><h2>Table {summary['table']}. {html.escape(summary['title'])}</h2>"
            f'<div class="charts">{"".join(charts)}</div><div class="rows">{cells}</div>'
            f"<pre>{html.escape(text)}</pre></section>")


def page(sections):
    style = ("body{font:15px sans-serif;margin:2em;max-width:1320px}img{width:300px;margin:2px}"
             "figure{display:inline-block;margin:4px}figcaption{font-size:12px}"
             "pre{overflow-x:auto;font-size:12px}svg{vertical-align:top}")
    return ("<!doctype html><html lang=\"en\"><meta charset=\"utf-8\">"
            f"<title>Tables of the thesis</title><style>{style}</style><body>"
            "<h1>Tables of the thesis, repeated</h1><p>Errors over times, with the power of time "
            "that fits the rows of each method; then rows with high contrast, and the logarithm of "
            "their squared error from a millionth of the scale (dark) to all of it.</p>"
            + "".join(sections) + "</body></html>\n")
