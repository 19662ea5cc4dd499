#!/usr/bin/env python3
"""verdicts.py RUN... [--methods A,B] [--output PAGE.md]: what estimates say of themselves beside the truth (docs/metrics.md#verdicts-beside-the-truth).

Of each run folder, condition and row: how often the model is right (at most 5 degrees), nearly right (10) or wrong, by what is said of it.
The runs are of diffsac_eval over two views whose poses are known. Prints the page, or writes it.
"""
import argparse
import math
import os

import pandas as pd

from files import BadInput, run_script, write_whole
from runs import Run
from tables import UNKNOWN, Table, markdown_table

RIGHT, NEARLY = 5.0, 10.0  # Degrees.
UNDETERMINED = ("pure rotation", "static", "plane", "line")
LIKELY_WRONG = 0.5  # kLikelyWrong of estimate/robust_estimator.h.
VERDICTS = ("determined", "may be wrong", *UNDETERMINED, "may be chance", "ambiguous", "not tested", "failed")
NEEDED = ("angle_deg", "pose_deg", "degeneracy", "has_ambiguous_pose")


def errors_of(problems):
    """error_probability; where there is none, as of others' estimators, NaN."""
    return problems["error_probability"] if "error_probability" in problems else problems["pose_deg"] * float("nan")


def verdicts_of(problems):
    """One of VERDICTS for each problem: failed, else may be chance, else ambiguous, else may be wrong, else what is said of t."""
    verdict = problems["degeneracy"].str.replace("_", " ")
    verdict = verdict.mask((verdict == "determined") & (problems["has_ambiguous_pose"] == 1), "ambiguous")
    verdict = verdict.mask((verdict == "determined") & (errors_of(problems) > LIKELY_WRONG), "may be wrong")
    verdict = verdict.mask(problems["log10_nfa"] > 0, "may be chance")
    return verdict.mask((problems["status"] != "ok") | (problems["failed"] == 1), "failed")


def wilson(count, of, z=1.959964):
    """The 95 % interval of a share (Wilson, JASA 1927)."""
    share, spread = count / of, z * z / of
    middle, half = share + spread / 2, z * math.sqrt((share * (1 - share) + spread / 4) / of)
    return max(0.0, (middle - half) / (1 + spread)), min(1.0, (middle + half) / (1 + spread))


def share_text(count, of):
    if of == 0:
        return UNKNOWN
    low, high = wilson(count, of)
    return f"{count} of {of}: {100 * count / of:.1f} % [{100 * low:.1f}, {100 * high:.1f}]"


def shares(cell):
    """(count, of): right models whose pose is taken back; wrong poses without any warning."""
    right, off = cell["angle_deg"] <= RIGHT, cell["pose_deg"] > NEARLY
    taken_back = right & off & cell["degeneracy"].str.replace("_", " ").isin(UNDETERMINED)
    unwarned = off & cell["verdict"].isin(("determined", "not tested"))  # Of right models too: a t of the wrong sign, or where there is none.
    wrong = (cell["angle_deg"] > NEARLY) | unwarned
    return (int(taken_back.sum()), int(right.sum())), (int(unwarned.sum()), int(wrong.sum()))


def warning_table(cells):
    """How many wrong models (> 10 degrees) a warning at some error_probability tells, by how often it is given falsely."""
    table = Table("", ["row", "area under the curve", *(f"wrong ones told at {rate} % false warnings" for rate in (5, 15)),
                       f"told above {LIKELY_WRONG:g}", "falsely"])
    for label, cell in cells.items():
        known = cell[errors_of(cell).notna()]
        wrong, said = known["angle_deg"] > NEARLY, errors_of(known)
        if not wrong.any() or wrong.all():
            continue
        ranks = said.rank()
        count = wrong.sum()
        area = (ranks[wrong].sum() - count * (count + 1) / 2) / (count * (~wrong).sum())
        told = [share_text(int((said[wrong] > said[~wrong].quantile(1 - rate)).sum()), int(count)) for rate in (0.05, 0.15)]
        above = said > LIKELY_WRONG
        table.add([label, f"{area:.3f}", *told, share_text(int(above[wrong].sum()), int(count)),
                   share_text(int(above[~wrong].sum()), int((~wrong).sum()))])
    return table


def verdict_table(cell):
    table = Table("", ["verdict", "model right", "nearly", "wrong", "all", "given pose ≤ 10°"])
    right, nearly = cell["angle_deg"] <= RIGHT, cell["angle_deg"] <= NEARLY
    for verdict in (*VERDICTS, "all"):
        of = cell["verdict"].eq(verdict) | (verdict == "all")
        counts = [of & right, of & nearly & ~right, of & ~nearly, of, of & (cell["pose_deg"] <= NEARLY)]
        if of.any() or verdict not in ("not tested", "line"):
            table.add([verdict] + [str(int(count.sum())) for count in counts])
    return table


def cells_of(run, methods):
    """(heading, problems) of each condition and row, of the problems whose pose is known."""
    problems = run.problems
    missing = [name for name in NEEDED if name not in problems]
    if missing:
        raise BadInput(f"{run.folder}: problems.csv has no {', '.join(missing)}: not of two views, or of an earlier version")
    problems = problems[problems["pose_deg"].notna() & problems["angle_deg"].notna()]
    problems = problems.assign(verdict=verdicts_of(problems))
    labels = {one["name"]: one["label"] for one in run.facts["methods"]}
    unknown = [name for name in methods if name not in labels]
    if unknown:
        raise BadInput(f"{run.folder} has no row {', '.join(unknown)}, but: {', '.join(labels)}")
    for (condition, method), cell in problems.groupby(["condition", "method"], sort=False):
        if not methods or method in methods:
            yield [run.facts["experiment"], run.facts["task"], condition, labels[method]], cell


def page(runs, methods):
    summary = Table("", ["run", "task", "condition", "row", "right poses taken back", "wrong poses without warning"])
    parts, cells = [], {}
    for run in runs:
        for names, cell in cells_of(run, methods):
            for label in ("all", f"{names[1]}: {names[0]}, {names[2]}, {names[3]}"):
                cells[label] = pd.concat([cells[label], cell]) if label in cells else cell
            summary.add(names + [share_text(*share) for share in shares(cell)])
            parts.append(f"## {names[1]}: {names[0]}, {names[2]}, {names[3]}\n\n{markdown_table(verdict_table(cell))}")
    if not parts:
        raise BadInput("no run has a problem whose pose is known")
    return (f"# Verdict × truth\n\nA model is right if it is off by at most {RIGHT:g}°, nearly right up to {NEARLY:g}° (the larger of R and t, t of either sign). "
            f"A right pose is taken back where the verdict leaves t open and the pose that is given is off by more than {NEARLY:g}°. A wrong pose has no "
            "warning where the verdict is `determined`, or the row has none (`not tested`). `may be wrong`: `error_probability` is above .5. "
            "Brackets: 95 % intervals (Wilson), in which several seeds of a problem count as so many problems. How the runs are made: "
            "[metrics](../metrics.md#verdicts-beside-the-truth).\n\n"
            + markdown_table(summary) + "\n## How far can wrong models be told?\n\nBy `error_probability`: of models off by more than "
            f"{NEARLY:g}°, how many a warning reaches that is given for so many of the others.\n\n"
            + markdown_table(warning_table(cells)) + "\n" + "\n".join(parts))


def main(folders, methods, output):
    text = page([Run(folder) for folder in folders], methods)
    if output:
        os.makedirs(os.path.dirname(output) or ".", exist_ok=True)
        write_whole(output, text)
    else:
        print(text, end="")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("runs", nargs="+", help="folders of diffsac_eval")
    parser.add_argument("--methods", default="", help="rows, by their names; default: all")
    parser.add_argument("--output", help="the page, Markdown")
    arguments = parser.parse_args()
    run_script(main, arguments.runs, [name for name in arguments.methods.split(",") if name], arguments.output)
