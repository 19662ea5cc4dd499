#!/usr/bin/env python3
"""effects.py RUN_FOLDER... [--page FILE.md]: what the factors of several tables decide, on one page (docs/comparing.md).

All effects side by side, then each table with its effects and their picture, its best rows with milliseconds, and its strata. Folders without
a whole run are named as not made.
"""
import argparse
import os

import told_tables
from files import BadInput, run_script, write_whole
from page import facts_of, picture_beside
from runs import Run
from tables import Row, Table, markdown_table
from values import certain, interval_text, known

BEST_ROWS = 8


def short_names(names):
    """Without the beginning, up to an underscore, that all of them share."""
    shared = os.path.commonprefix(names)
    end = shared.rfind("_") + 1
    return names if len(names) < 2 or end == 0 else [name[end:] for name in names]


def levels_of(run):
    """factor: level -> (its place, its effects)."""
    return {f"{factor['factor']}: {level['level']}": (i, level)
            for factor in run.results["effects"] for i, level in enumerate(factor["levels"])}


def all_levels(runs):
    """Of all runs, those of one factor together, in the order in which they first appear."""
    factors = {}
    for run in runs:
        for name in levels_of(run):
            factors.setdefault(name.split(": ")[0], {})[name] = None
    return [name for names in factors.values() for name in names]


def overview(runs, what, part, kind):
    columns = []
    for run, name in zip(runs, short_names([run.results["experiment"] for run in runs])):
        conditions = run.results["conditions"]
        columns += [name + (f": {one['label']}" if len(conditions) > 1 else "") for one in conditions]
    table = Table(f"effects on {what}, all tables", ["factor: level"] + columns)
    for name in all_levels(runs):
        at = [levels_of(run).get(name) for run in runs]
        values = []
        for run, found in zip(runs, at):
            values += [None] * len(run.results["conditions"]) if found is None or found[0] == 0 else found[1][part]
        first = all(found is None or found[0] == 0 for found in at)
        table.rows.append(Row([name + (" (first)" if first else "")] + [interval_text(value, kind) for value in values],
                              [False] + [certain(value, kind) for value in values]))
    return table


def best_rows(run, condition):
    conditions, metric = run.results["conditions"], run.results["accuracy"]["metric"]
    competing = {one["name"] for one in run.results["methods"] if one["competes"]}
    cells = [cell for cell in run.results["results"]
             if cell["condition"] == conditions[condition]["name"] and cell["method"] in competing and known(cell[metric + "_ci95"]["mean"])]
    cells.sort(key=lambda cell: -cell[metric + "_ci95"]["mean"])
    label = f", {conditions[condition]['label']}" if len(conditions) > 1 else ""
    table = Table("best rows" + label, ["method", metric, "hypotheses", "ms"])
    for cell in cells[:BEST_ROWS]:
        mean = cell["metrics"]["mean"]
        table.add([cell["label"], interval_text(cell[metric + "_ci95"], "value"), f"{mean['hypotheses']:.0f}", f"{mean['ms_total']:.3g}"])
    return table


def section(run, page):
    results = run.results
    name, experiment = os.path.splitext(os.path.basename(page or ""))[0], results["experiment"]
    text = f"## {results['title'] or experiment}\n\n"
    if run.partial:
        text += "**Partial results: the run was interrupted.**\n\n"
    text += results["setting"] + ".\n\n" + "".join(f"Left out: {what}.\n\n" for what in results["left_out"])
    for picture in ["effects"] + [f"strata_{strata['by']}" for strata in results["strata"]]:
        path = run.path(picture + ".png")
        if page and os.path.exists(path):
            text += picture_beside(path, page, f"{name}_{experiment}")
    strata = told_tables.strata_tables(results)
    for table in told_tables.effect_tables(results) + [best_rows(run, c) for c in range(len(results["conditions"]))] + strata:
        text += f"### {table.heading}\n\n{markdown_table(table)}\n"
    return text + f"Of the run {experiment}:\n\n" + "".join(f"- {fact}\n" for fact in facts_of(run)) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--page", help="a Markdown file, with its pictures beside it (default: it is printed)")
    parser.add_argument("--command", help="what the page says that it was written by (default: this call)")
    arguments = parser.parse_args()
    made = [folder for folder in arguments.folders if os.path.exists(os.path.join(folder, "run.json"))]
    runs = [Run(folder) for folder in made]
    for run in runs:
        if not run.results["effects"]:
            raise BadInput(f"the experiment of '{run.folder}' has no factors")
    if not runs:
        raise BadInput("none of these folders holds a run of diffsac_eval")
    if arguments.page:
        os.makedirs(os.path.dirname(os.path.abspath(arguments.page)), exist_ok=True)
    text = f"# What decides\n\nWritten by `{arguments.command or 'scripts/report/effects.py ' + ' '.join(arguments.folders)}`. {told_tables.EFFECT_NOTE}\n\n"
    text += "".join(f"Not made: {os.path.basename(os.path.normpath(folder))}.\n\n" for folder in arguments.folders if folder not in made)
    for table in (overview(runs, "the accuracy", "accuracy", "difference"), overview(runs, "milliseconds", "milliseconds", "ratio")):
        text += f"## {table.heading}\n\n{markdown_table(table)}\n"
    text += "".join(section(run, arguments.page) for run in runs)
    if arguments.page:
        write_whole(arguments.page, text)
    else:
        print(text, end="")


if __name__ == "__main__":
    run_script(main)
