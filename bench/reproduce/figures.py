"""Turns runs into comparable figures: medians, ratios, times to the same error."""

import math
from statistics import mean, median


def ours(runs, reference_mse=0.0):
    """Returns medians of times and means of errors; None without runs.

    The noise of the reference is independent of the row's, so the known excess of the squared
    distance (`reference_mse`, of the reference itself) is subtracted.
    """
    if not runs:
        return None
    result = {"seconds": median(run["seconds"] for run in runs),
              "table_seconds": median(run["table_seconds"] for run in runs), "runs": runs}
    for key in ("mse", "relative_mse", "squared_channel_sum", "thesis_luminance"):
        result[key] = mean(run[key] for run in runs)
    result["squared_distance"] = 3 * (result["mse"] - reference_mse)
    light = [run["light_error"] for run in runs if "light_error" in run]
    if light:
        result["light_error"] = mean(light)
    return result


def theirs(row):
    if row.seconds is None:
        return None
    result = {"seconds": row.seconds}
    if row.euclidean is not None:
        result["squared_distance"] = row.euclidean
    if row.luminance is not None:
        result["thesis_luminance"] = row.luminance
    return result


def seconds_at(error, plain, key):
    """Returns ('=' | '<' | '>', seconds) at which the curve of the plain rows reaches `error`.

    Points are connected by straight lines on logarithmic scales; of several crossings, the one
    after which the error stays below counts. Nothing is extrapolated: outside the curve, the time
    is that of its nearer end.
    """
    points = sorted((p["seconds"], p[key]) for p in plain)
    if error < points[-1][1]:
        return ">", points[-1][0]
    for (t0, e0), (t1, e1) in reversed(list(zip(points, points[1:]))):
        if e0 >= error >= e1:
            part = 0 if e0 == e1 else math.log(e0 / error) / math.log(e0 / e1)
            return "=", t0 * (t1 / t0) ** part
    return "<", points[0][0]


def compare(measured, base, plain):
    """Compares a row with the base row and with the curve of plain importance sampling.

    `at_equal_error` is (sign, speed-up over plain importance sampling at the row's error), a bound
    unless the sign is '='.
    """
    if not measured or not base:
        return None
    result = {"time": measured["seconds"] / base["seconds"]}
    for name, key in (("error", "squared_distance"), ("light_error", "light_error")):
        if key in measured and all(key in other for other in [base, *plain]):
            result[name] = measured[key] / base[key]
            if not plain:
                continue
            sign, seconds = seconds_at(measured[key], plain, key)
            result[f"at_equal_{name}"] = (sign, seconds / measured["seconds"])
    return result


def least_squares(rows, values):
    """Returns coefficients c with rows . c = values on average, or None if undetermined."""
    n = len(rows[0]) if rows else 0
    if len(rows) < n or n == 0:
        return None
    matrix = [[sum(row[i] * row[j] for row in rows) for j in range(n)]
              + [sum(row[i] * value for row, value in zip(rows, values))] for i in range(n)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(matrix[k][i]))
        matrix[i], matrix[pivot] = matrix[pivot], matrix[i]
        if abs(matrix[i][i]) < 1e-9:
            return None
        for k in range(n):
            if k != i:
                factor = matrix[k][i] / matrix[i][i]
                matrix[k] = [a - factor * b for a, b in zip(matrix[k], matrix[i])]
    return [matrix[i][n] / matrix[i][i] for i in range(n)]


def costs(table, of):
    """Returns the seconds for one more light or sample per hit, by least squares over the rows.

    `of(row)` returns a row's figures or None. Direct lighting only.
    """
    rows = [row for row in table.rows if row.seconds is not None and row.recipe and of(row)]
    plain = [row for row in rows if row.plain]
    hybrid = [row for row in rows if row.method == "HIB." and row.presampled]
    sample = least_squares([[1, row.drawn] for row in plain],
                           [of(row)["seconds"] for row in plain])
    parts = least_squares([[1, row.lights, row.drawn] for row in hybrid],
                          [of(row)["seconds"] for row in hybrid])
    return {"importance_sample": sample and sample[1],
            "directional_light": parts and parts[1], "presampled_sample": parts and parts[2]}


def floor(table, of):
    """Returns (error, share): the error with unlimited light samples, and its share of the base's.

    It is extrapolated from the two plain rows with most samples, assuming noise that halves when
    samples double. Direct lighting only: paths add camera samples, so nothing would be left.
    """
    if table.integrator != "direct":
        return None
    plain = sorted((row for row in table.rows if row.plain and of(row)), key=lambda r: r.drawn)
    if len(plain) < 2 or plain[-1].drawn != 2 * plain[-2].drawn:
        return None
    last = of(plain[-1])["squared_distance"]
    left = 2 * last - of(plain[-2])["squared_distance"]
    return left, left / last


def summarize(table, runs, reference_mse=0.0):
    """Returns all that is printed or written for a table; `runs` maps names of rows to runs."""
    measured = {row.name: ours(runs.get(row.name), reference_mse) for row in table.rows}
    sides = {"thesis": theirs, "ours": lambda row: measured[row.name]}
    result = {"table": table.name, "title": table.title, "base": table.base, "rows": [],
              "pairs": []}
    curves = {}
    for side, of in sides.items():
        # With photons the error has other parts, so no curve of plain rows falls with light
        # samples.
        plain = [of(row) for row in table.rows
                 if row.plain and of(row) and table.integrator != "photon"]
        curves[side] = (of(table.row(table.base)), plain)
        result[f"{side}_floor"] = floor(table, of)
        result[f"{side}_costs"] = costs(table, of) if table.integrator == "direct" else None
    for row in table.rows:
        entry = {"row": row.name, "method": row.method, "parameters": row.parameters,
                 "note": row.note, "recipe": vars(row.recipe) if row.recipe else None}
        for side, of in sides.items():
            entry[side] = of(row)
            entry[f"{side}_ratios"] = compare(of(row), *curves[side])
        result["rows"].append(entry)
    for name, plain_name in table.pairs:
        pair = {"row": name, "plain": plain_name}
        for side, of in sides.items():
            row, plain = of(table.row(name)), of(table.row(plain_name))
            if row and plain:
                pair[side] = {"faster": plain["seconds"] / row["seconds"]}
                if "squared_distance" in row:
                    pair[side]["error"] = row["squared_distance"] / plain["squared_distance"]
        result["pairs"].append(pair)
    return result
