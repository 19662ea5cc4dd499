#!/usr/bin/env python3
"""compare.py RUN_A RUN_B [--output DIR]: what two run folders differ in, row by row and problem by problem (docs/comparing.md).

Prints it and writes compare.md, compare.csv and report.html into DIR (default: runs/compare-A-B).
"""
import argparse
import os

import numpy

from files import BadInput, run_script, write_whole
from html_page import Page
from runs import Run, flat
from tables import UNKNOWN, Row, Table, markdown_table, tables_csv
from bootstrap import interval
from values import certain, interval_text, known

MOST_CHANGED, MOST_KEYS = 30, 40
PLACE = ["condition", "row", "scene", "id", "again"]


def number(value, form):
    return form.format(value) if known(value) else UNKNOWN


def side(run, one_each):
    """Returns problems with the columns that pair them: condition, row, scene, id, and number of the estimate (joined seeds have several)."""
    problems = run.made.problems
    error = "misclassified" if run.results["structures"] else "error_px" if run.results["unit"] == "px" else "angle_deg"
    problems = problems.assign(row="" if one_each else problems["method"], error=problems[error].astype(float))
    return problems.assign(again=problems.groupby(PLACE[:4]).cumcount())[[*PLACE, "accuracy", "error", "status", "inliers", "ms_total"]]


def means_over_scenes(values, pairs):
    """Averages the seeds of each problem."""
    return values.groupby([pairs["scene"], pairs["id"]], sort=False).mean().dropna()


def compared_row(pairs, labels, truth):
    """Returns mAA as mean over scenes (median of inliers without truth), B − A, and medians of milliseconds."""
    ms = [number(pairs[name].median(), "{:.3g}") for name in ("ms_total_a", "ms_total_b")]
    difference = means_over_scenes(pairs["accuracy_b"] - pairs["accuracy_a"], pairs)
    if not truth or difference.empty:
        values = [float(pairs[name].median()) for name in ("inliers_a", "inliers_b")]
        return Row([*labels, *(f"{value:.1f}" for value in values), f"{values[1] - values[0]:+.1f}", str(len(pairs)), *ms], [False] * 8)
    values = [means_over_scenes(pairs[name], pairs).groupby("scene").mean().mean() for name in ("accuracy_a", "accuracy_b")]
    scenes = [scene.to_numpy() for _, scene in difference.groupby("scene", sort=False)]
    told = interval(numpy.concatenate(scenes), [len(scene) for scene in scenes], 0)
    return Row([*labels, *(number(value, "{:.3f}") for value in values), interval_text(told, "difference"), str(len(pairs)), *ms],
               [i == 4 and certain(told, "difference") for i in range(8)])


def changed_table(pairs, labels, unit):
    """Lists problems with different estimates, largest change first."""
    change = [(pairs[name + "_b"] - pairs[name + "_a"]).abs().fillna(0) for name in ("accuracy", "error", "inliers")]
    pairs = pairs.assign(**{f"change_{i}": one for i, one in enumerate(change)})
    pairs = pairs[(pairs["status_a"] != pairs["status_b"]) | (sum(change) > 0)].sort_values(["change_0", "change_1", "change_2"], ascending=False, kind="stable")
    table = Table(f"problems that changed most, errors in {unit}",
                  ["problem", "scene", "condition", "row", "error A", "error B", "inliers A", "inliers B"])
    for one in pairs.head(MOST_CHANGED).to_dict("records"):
        answers = [one["status" + of] if one["status" + of] != "ok" else number(one["error" + of], "{:.2f}") for of in ("_a", "_b")]
        table.add([one["id"], one["scene"], *labels[one["condition"], one["row"]][::-1], *answers, str(one["inliers_a"]), str(one["inliers_b"])])
    return table


def changed_keys(a, b):
    before, now = (flat(run.facts["configuration"]) for run in (a, b))
    lines = [f"{key}: {before.get(key, UNKNOWN)} → {now.get(key, UNKNOWN)}" for key in {**before, **now} if before.get(key) != now.get(key)]
    return lines if len(lines) <= MOST_KEYS else lines[:MOST_KEYS] + [f"and {len(lines) - MOST_KEYS} more"]


def compare(a, b, name_a, name_b):
    """Returns the tables of rows and of changed problems, remarks, and changed keys."""
    both = f"'{name_a}' and '{name_b}'"
    for what, of in (("of different tasks", lambda run: run.results["task"]), ("judged by different metrics", lambda run: run.results["accuracy"]["metric"])):
        if of(a) != of(b):
            raise BadInput(f"{both} are {what}: {of(a)} and {of(b)}")
    methods, conditions = (([{one["name"]: one["label"] for one in run.results[what]} for run in (a, b)]) for what in ("methods", "conditions"))
    one_each = len(methods[0]) == len(methods[1]) == 1
    first, second = side(a, one_each), side(b, one_each)
    pairs = first.merge(second, on=PLACE, suffixes=("_a", "_b"))
    counts = [of.groupby(["condition", "row"], sort=False).size() for of in (first, second, pairs)]
    labels, absent, remarks = {}, [], []
    for place in counts[0].index.intersection(counts[1].index, sort=False):
        names = [next(iter(of)) if one_each else place[1] for of in methods]
        label = methods[0][names[0]] + ("" if names[0] == names[1] else f" → {methods[1][names[1]]}")
        labels[place] = [label, conditions[0][place[0]]]
        alone = [counts[i][place] - counts[2].get(place, 0) for i in (0, 1)]
        if place not in counts[2]:
            absent.append(f"{label}, {labels[place][1]}: no problem is in both runs")
        elif any(alone):
            remarks.append(f"{label}, {labels[place][1]}: {alone[0]} problems of A alone and {alone[1]} of B alone are left out")
    if pairs.empty:
        ids = [str(one["id"].iloc[0]) if len(one) else "" for one in (first, second)]
        drawn = f": their data was drawn with another seed or other options ({', '.join(ids)})" if any("@" in one for one in ids) else ""
        raise BadInput(f"{both} share no row on the same problems{drawn}")
    for what, (of_a, of_b) in (("row", ({}, {}) if one_each else methods), ("condition", conditions)):
        absent += [f"{what} '{one}' is in {name} alone" for ours, theirs, name in ((of_a, of_b, name_a), (of_b, of_a, name_b)) for one in ours if one not in theirs]
    truth = (pairs["accuracy_a"] - pairs["accuracy_b"]).notna().any()
    of = f"{a.results['accuracy']['metric']}, with 95 % paired bootstrap intervals" if truth else "median inliers (no truth)"
    table = Table(f"B minus A, {of}", ["row", "condition", "A", "B", "B − A", "problems", "ms A", "ms B"])
    table.rows = [compared_row(own, labels[place], truth) for place, own in pairs.groupby(["condition", "row"], sort=False)]
    unit = "% of the points" if a.results["structures"] else "pixels" if a.results["unit"] == "px" else "degrees"
    return [table, changed_table(pairs, labels, unit)], absent + remarks, changed_keys(a, b)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("runs", nargs=2, metavar="RUN")
    parser.add_argument("--output", help="default: runs/compare-A-B")
    arguments = parser.parse_args()
    names = [os.path.basename(os.path.normpath(folder)) for folder in arguments.runs]
    output = arguments.output or f"runs/compare-{names[0]}-{names[1]}"
    if names[0] == names[1]:
        names = arguments.runs
    tables, remarks, keys = compare(*(Run(folder) for folder in arguments.runs), *names)
    title = f"{names[1]} against {names[0]}"
    text = f"# {title}\n\nA: {names[0]}, B: {names[1]}. In bold where the interval leaves zero out.\n"
    text += "".join(f"\n## {table.heading}\n\n{markdown_table(table)}" for table in tables if table.rows)
    if not tables[1].rows:
        text += "\nAll problems have the same answers.\n"
    text += "".join(f"\n{line}.\n" for line in remarks)
    if keys:
        text += "\n## configuration, A → B\n\n" + "".join(f"    {line}\n" for line in keys)
    os.makedirs(output, exist_ok=True)
    write_whole(os.path.join(output, "compare.md"), text)
    write_whole(os.path.join(output, "compare.csv"), tables_csv(tables))
    page = Page(title)
    page.table(tables[0], "In bold where the interval leaves zero out.")
    page.table(tables[1])
    page.pre("\n".join([*remarks, *keys]))
    page.write(os.path.join(output, "report.html"))
    print(f"{text}\nwritten to {output}")


if __name__ == "__main__":
    run_script(main)
