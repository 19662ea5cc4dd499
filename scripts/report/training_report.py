"""training_report.py [--running] FOLDER: of a training its curves (training_curve.png) and report.html, from metrics.csv and
config.yaml. diffsac_train calls it; while the training runs, the page asks the browser to load it again and again."""
import math
import os
import sys

import pandas

import files
import html_page
import pictures
from tables import Table

RELOAD_SECONDS = 10
CURVES = ("Losses, on the left axis: means over the iterations between two lines of metrics.csv, lower is better. Validation, on "
          "the right: on problems that are not trained on, higher is better.")
VALUES = ("data_wait_share: the part of the time that the training waited for data. First, smallest, largest and last value of each "
          "column of metrics.csv; at iteration: of the last.")


def is_loss(column):
    return "loss" in column


def validation_measure(column):
    """What a column of validation measures; empty for others."""
    return "" if is_loss(column) else next((measure for measure in ("mAA", "recall") if measure in column), "")


def short_number(value):
    return f"{value:.0f}" if 1000 <= abs(value) < 1e6 else f"{0.0 if abs(value) < 1e-12 else value:.3g}"


def values_table(metrics):
    table = Table("values", ["column", "first", "smallest", "largest", "last", "at iteration", "values"])
    for column in list(metrics.columns)[1:]:
        known = metrics[[metrics.columns[0], column]].dropna()
        if len(known):
            values = known[column]
            table.add([column] + [short_number(value) for value in (values.iloc[0], values.min(), values.max(), values.iloc[-1],
                                                                    known.iloc[-1, 0])] + [str(len(known))])
    return table


def read_text(path):
    if not os.path.exists(path):
        return ""
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.read()


def main(folder, running):
    path = os.path.join(folder, "metrics.csv")
    metrics = pandas.read_csv(path) if os.path.exists(path) else pandas.DataFrame()
    metrics = metrics.replace([math.inf, -math.inf], math.nan)
    page = html_page.Page("Training of " + os.path.basename(os.path.realpath(folder)))
    if running:
        page.reload_seconds = RELOAD_SECONDS
        page.subtitles.append(f"The training is running; this page loads itself again every {RELOAD_SECONDS} seconds.")
    if metrics.empty:
        page.subtitles.append("Nothing measured yet.")
    else:
        page.subtitles.append(f"To iteration {int(metrics.iloc[-1, 0])}.")
        if pictures.draw_training(folder, metrics, is_loss, validation_measure):
            page.section("Curves")
            with open(os.path.join(folder, "training_curve.png"), "rb") as file:
                page.picture(file.read(), CURVES)
        page.section("Values")
        page.table(values_table(metrics), VALUES)
    page.section("Configuration")
    page.pre(read_text(os.path.join(folder, "config.yaml")))
    page.write(os.path.join(folder, "report.html"))


if __name__ == "__main__":
    files.run_script(main, sys.argv[-1], "--running" in sys.argv[1:-1])
