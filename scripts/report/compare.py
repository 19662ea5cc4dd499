#!/usr/bin/env python3
"""compare.py RUN_A RUN_B [--output DIR]: what two run folders differ in, row by row and problem by problem (docs/comparing.md).

Prints it and writes compare.md, compare.csv and report.html into DIR (default: runs/compare-A-B).
"""
import argparse
import math
import os
import sys

import numpy
import yaml

from files import write_whole
from html_page import Page
from runs import Run
from tables import UNKNOWN, Row, Table, markdown_table, tables_csv
from bootstrap import interval
from values import certain, interval_text, known

MOST_CHANGED, MOST_KEYS = 30, 40


class Bad(Exception):
    pass


def number(value, form):
    return form.format(value) if known(value) else UNKNOWN


def cells_of(run):
    """(condition, method) -> problems by scene, id and which estimate of the problem: joined runs have several, of as many seeds."""
    problems = run.made.problems
    error = "misclassified" if run.results["structures"] else "error_px" if run.results["unit"] == "px" else "angle_deg"
    problems = problems.assign(error=problems[error].astype(float), again=problems.groupby(["condition", "method", "scene", "id"]).cumcount())
    return {key: cell.set_index(["scene", "id", "again"]) for key, cell in problems.groupby(["condition", "method"], sort=False)}


def compared_row(a, b):
    """Of the problems that both have: mAA, mean over scenes, or without truth the median of inliers; B − A; medians of milliseconds."""
    row = {"problems": len(a), "ms": [float(cell["ms_total"].astype(float).median()) for cell in (a, b)]}
    of_a, of_b = a["accuracy"], b["accuracy"]
    if of_a.isna().all() or of_b.isna().all():
        row["values"] = [float(cell["inliers"].astype(float).median()) for cell in (a, b)]
        return row
    difference = (of_b - of_a).groupby(level=["scene", "id"]).mean().dropna()  # A problem of several seeds counts once.
    row["values"] = [float(of.groupby(level=["scene", "id"]).mean().groupby(level="scene").mean().mean()) for of in (of_a, of_b)]
    scenes = [scene.to_numpy() for _, scene in difference.groupby(level="scene", sort=False)]
    row["difference"] = interval(numpy.concatenate(scenes), [len(scene) for scene in scenes], 0)
    return row


def answer(problem):
    return problem["status"] if problem["status"] != "ok" else number(problem["error"], "{:.2f}")


def changes(a, b, condition, row):
    """The problems that are answered differently: how much, and a line of the table."""
    for key in a.index:
        one, other = a.loc[key], b.loc[key]
        change = [abs(other[what] - one[what]) for what in ("accuracy", "error")] + [abs(int(other["inliers"]) - int(one["inliers"]))]
        change = tuple(0 if math.isnan(value) else value for value in change)
        if one["status"] != other["status"] or any(change):
            yield change, [key[1], key[0], condition, row, answer(one), answer(other), str(one["inliers"]), str(other["inliers"])]


def flat(value, path=""):
    """key.path -> value on one line; maps of a list are told apart by their name, or by their place."""
    if isinstance(value, dict):
        return {key: one for k, v in value.items() for key, one in flat(v, f"{path}.{k}" if path else str(k)).items()}
    if isinstance(value, list) and value and all(isinstance(one, dict) for one in value):
        return {key: one for i, v in enumerate(value) for key, one in flat(v, f"{path}.{v.get('name', i)}").items()}
    return {path: yaml.safe_dump(value, default_flow_style=True, width=math.inf, allow_unicode=True).replace("\n...", "").strip()}


def changed_keys(a, b):
    with open(a.path("config.yaml"), encoding="utf-8") as one, open(b.path("config.yaml"), encoding="utf-8") as other:
        before, now = flat(yaml.safe_load(one)), flat(yaml.safe_load(other))
    lines = [f"{key}: {before.get(key, UNKNOWN)} → {now.get(key, UNKNOWN)}"
             for key in [*before, *(key for key in now if key not in before)] if before.get(key) != now.get(key)]
    return lines if len(lines) <= MOST_KEYS else lines[:MOST_KEYS] + [f"and {len(lines) - MOST_KEYS} more"]


def compare(a, b, name_a, name_b):
    """The tables of rows and of changed problems, remarks, changed keys."""
    both = f"'{name_a}' and '{name_b}'"
    if a.results["task"] != b.results["task"]:
        raise Bad(f"{both} are of different tasks: {a.results['task']} and {b.results['task']}")
    metric, other = a.results["accuracy"]["metric"], b.results["accuracy"]["metric"]
    if metric != other:
        raise Bad(f"{both} are judged by different metrics: {metric} and {other}")
    cells_a, cells_b = cells_of(a), cells_of(b)
    methods_a, methods_b = a.results["methods"], b.results["methods"]
    one_each = len(methods_a) == len(methods_b) == 1
    conditions_b = {one["name"] for one in b.results["conditions"]}
    rows, changed, remarks, no_problem = [], [], [], []
    for condition in a.results["conditions"]:
        for method in methods_a:
            counterpart = methods_b[0] if one_each else next((one for one in methods_b if one["name"] == method["name"]), None)
            if condition["name"] not in conditions_b or counterpart is None:
                continue
            first, second = cells_a.get((condition["name"], method["name"])), cells_b.get((condition["name"], counterpart["name"]))
            if first is None or second is None:
                continue
            label = method["label"] if method["name"] == counterpart["name"] else f"{method['label']} → {counterpart['label']}"
            shared = first.index.intersection(second.index, sort=False)
            if len(shared) == 0:
                no_problem.append(f"{label}, {condition['label']}: no problem is in both runs")
                continue
            one, two = first.loc[shared], second.loc[shared]
            if len(first) > len(shared) or len(second) > len(shared):
                remarks.append(f"{label}, {condition['label']}: {len(first) - len(shared)} problems of A alone and "
                               f"{len(second) - len(shared)} of B alone are left out")
            rows.append((label, condition["label"], compared_row(one, two)))
            changed += changes(one, two, condition["label"], label)
    if not rows:
        ids = [str(run.problems["id"].iloc[0]) if len(run.problems) else "" for run in (a, b)]
        drawn = f": their data was drawn with another seed or other options ({', '.join(ids)})" if any("@" in one for one in ids) else ""
        raise Bad(f"{both} share no row on the same problems{drawn}")
    for what, of_a, of_b in (("row", [] if one_each else methods_a, [] if one_each else methods_b),
                             ("condition", a.results["conditions"], b.results["conditions"])):
        for ours, theirs, name in ((of_a, of_b, name_a), (of_b, of_a, name_b)):
            no_problem += [f"{what} '{one['name']}' is in {name} alone" for one in ours if one["name"] not in {o["name"] for o in theirs}]
    truth = any("difference" in row for _, _, row in rows)
    of = f"{metric}, with 95 % paired bootstrap intervals" if truth else "median inliers (no truth)"
    table = Table(f"B minus A, {of}", ["row", "condition", "A", "B", "B − A", "problems", "ms A", "ms B"])
    form = "{:.3f}" if truth else "{:.1f}"
    for label, condition, row in rows:
        difference = row.get("difference")
        text = interval_text(difference, "difference") if difference else number(row["values"][1] - row["values"][0], "{:+.1f}")
        table.rows.append(Row([label, condition, *(number(value, form) for value in row["values"]), text, str(row["problems"]),
                               *(number(value, "{:.3g}") for value in row["ms"])], [i == 4 and certain(difference, "difference") for i in range(8)]))
    unit = "% of the points" if a.results["structures"] else "pixels" if a.results["unit"] == "px" else "degrees"
    most = Table(f"problems that changed most, errors in {unit}",
                 ["problem", "scene", "condition", "row", "error A", "error B", "inliers A", "inliers B"])
    for _, line in sorted(changed, key=lambda one: one[0], reverse=True)[:MOST_CHANGED]:
        most.add(line)
    return [table, most], no_problem + remarks, changed_keys(a, b)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("runs", nargs=2, metavar="RUN")
    parser.add_argument("--output", help="default: runs/compare-A-B")
    arguments = parser.parse_args()
    try:
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
        page.text(f"A: {names[0]}, B: {names[1]}")
        page.section("Rows")
        page.table(tables[0], "In bold where the interval leaves zero out.")
        page.section("Problems")
        page.table(tables[1]) if tables[1].rows else page.text("All problems have the same answers.")
        for line in remarks:
            page.text(line + ".")
        if keys:
            page.section("Configuration, A → B")
            page.pre("\n".join(keys))
        page.write(os.path.join(output, "report.html"))
        print(f"{text}\nwritten to {output}")
    except (Bad, OSError, KeyError, ValueError) as error:
        print(f"compare: {error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
