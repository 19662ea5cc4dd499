"""Writes results.json, results.csv, reliability.csv, table.md, table.tex and table.csv."""
import csv
import io
import json
import math

import files
import page
import reliability
import tables
from values import known


def _csv(header, rows):
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([header, *rows])
    return out.getvalue()


def _finite(value):
    """Replaces infinities by None, because JSON has none."""
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def long_lines(results):
    """Yields (scene, condition, method, metric, value) of results.csv. `scene` names strata as well, `method` effects and comparisons."""
    conditions, metric = [one["name"] for one in results["conditions"]], results["accuracy"]["metric"]

    def lines(scene, condition, method, name, interval):
        yield scene, condition, method, name, interval["mean"]
        if known(interval["low"]):
            yield from ((scene, condition, method, f"{name}_{end}", interval[end]) for end in ("low", "high"))

    def effect_lines(effects, scene):
        for c, condition in enumerate(conditions):
            for factor in effects:
                for level in factor["levels"]:
                    method = f"{factor['factor']}={level['level']}"
                    for part, name in (("accuracy", metric), ("milliseconds", "ms")):
                        if level[part][c]:
                            yield from lines(scene, condition, method, name, level[part][c])
                    yield scene, condition, method, "combinations", level["combinations"][c]

    for cell in results["results"]:
        for scene, metrics in cell["metrics"].items():
            yield from ((scene, cell["condition"], cell["method"], name, value) for name, value in metrics.items())
    yield from effect_lines(results["effects"], "mean")
    for strata in results["strata"]:
        for one in strata["bins"] if any(any(one["problems"]) for one in strata["bins"]) else ():
            for cell, interval, counts in zip(results["results"], one["accuracies"], one["records"]):
                if counts["problems"]:
                    place = one["name"], cell["condition"], cell["method"]
                    yield from lines(*place, metric, interval)
                    yield from ((*place, name, counts[name]) for name in ("problems", "failures"))
            for (a, b), row in zip(results["compare"], one["differences"]):
                for condition, interval in zip(conditions, row):
                    if interval:
                        yield from lines(one["name"], condition, f"{a} - {b}", metric, interval)
            yield from effect_lines(one["effects"], one["name"])


def write_numbers(run):
    results = run.results
    names = results["experiment"], results["dataset"]
    rows = [[*names, *line[:-1], f"{line[-1]:.9g}" if known(line[-1]) and math.isfinite(line[-1]) else ""] for line in long_lines(results)]
    files.write_whole(run.path("results.csv"), _csv(["experiment", "dataset", "scene", "condition", "method", "metric", "value"], rows))
    curves = reliability.table_of(run)
    if curves:
        files.write_whole(run.path("reliability.csv"), _csv(["method", "condition", "scene", "low", "high", "points", "predicted", "inliers"], curves))
    else:
        files.remove(run.path("reliability.csv"))
    files.write_whole(run.path("table.md"), page.markdown_report(run))
    files.write_whole(run.path("table.tex"), tables.latex_report(run))
    files.write_whole(run.path("table.csv"), tables.tables_csv(run.tables))
    files.write_whole(run.path("results.json"), json.dumps(_finite(results), ensure_ascii=False, indent=1) + "\n")
