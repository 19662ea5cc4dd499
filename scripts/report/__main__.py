"""python3 scripts/report FOLDER: makes tables, pictures and report.html of a run of diffsac_eval (from problems.csv, estimates.h5 and run.json), or
report.html of a folder of diffsac_pair. Can be repeated. docs/report.md lists the files."""
import os
import sys

import examples
import files
import html_page
import labels
import match_pictures
import photographs
import pictures
import problem_list
import runs
import words
import written


def draw_pictures(run, fits):
    """What the run has something for, with what the page says of it. An earlier run's picture must not stand for one that this
    run has not."""
    accuracy = run.results["accuracy"]["title"]
    joins = "; a curve joins budgets of one estimator."
    angles = "; R: of the rotation alone, t: of the translation alone." if run.results["poses"] else "."
    drawings = [("curve", pictures.draw_curve, accuracy + ", higher is better."),
                ("bars", pictures.draw_bars, f"{accuracy}, higher is better, with 95 % intervals{angles}"),
                ("budget", pictures.draw_budget, f"{accuracy} against the median number of hypotheses{joins}"),
                ("time", pictures.draw_time, f"{accuracy} against the median milliseconds{joins}"),
                ("reliability", pictures.draw_reliability, "How often a point is an inlier, by the probability that was said of it."),
                ("effects", pictures.draw_effects, f"What the levels of each factor add to {accuracy} of the first, and by how much "
                 "they multiply its milliseconds.")]
    shown = [(name, caption) for name, draw, caption in drawings if draw(run) or files.remove(run.path(name + ".png"))]
    for strata in run.results["strata"]:
        if pictures.draw_strata(run, strata):
            shown.append(("strata_" + strata["by"], f"{accuracy} by {strata['title']}; below the bins, how many problems they have."))
    for name in os.listdir(run.folder):
        if name.startswith("strata_") and name.endswith(".png") and name[:-4] not in dict(shown):
            files.remove(run.path(name))
    pictures.draw_fits(run, fits) or files.remove(run.path("fits.png"))
    pictures.draw_confidence(run, fits) or files.remove(run.path("confidence.png"))
    match_pictures.draw_matches(run, fits)
    return shown


def add_tables(page, run):
    page.section("Tables")
    page.tables(run.tables)
    page.words(words.words_of(run.tables))
    page.text("\n".join(run.notes))
    if run.results["experiment_notes"]:
        page.text(run.results["experiment_notes"])


def picture_in(run, name):
    with open(run.path(name + ".png"), "rb") as file:
        return file.read()


def fit_caption(run, fit, example):
    results = run.results
    text = f"{results['methods'][fit['method']]['label']}, {example.id}"
    if len(results["conditions"]) > 1:
        text += f", {results['condition_label']} {results['conditions'][fit['condition']]['label']}"
    if fit["status"] != "ok":
        return f"{text}: no model ({fit['status']})"
    if fit["shown_error"] is not None:
        unit = results["unit"] if fit["error"]["recall"] is not None or results["unit"] != "%" else "°"
        text += f": error {float(fit['shown_error']):.3g}{'' if unit == '°' else ' '}{unit}"
    points = len(example.points)
    found = match_pictures.found_inliers(fit, points)
    if example.inliers is None:
        return f"{text}; {int(found.sum())} of {points} points are inliers"
    right = int((found & example.inliers).sum())
    return (f"{text}; {points} points, inliers: {right} right, {int(found.sum()) - right} wrong, "
            f"{int(example.inliers.sum()) - right} missed")


def add_problems(page, run):
    problems, pairs = problem_list.ProblemList(run), run.results["two_view"]
    if problems.problems.empty:
        return
    page.section("Pairs" if pairs else "Problems")
    notes = problem_list.add_pair_pictures(page, problems, run.examples, run.estimates) if pairs and run.examples else []
    text, left_out = problems.json(run.estimates)
    page.json("problems", text)
    if left_out:
        notes.append(f"{left_out} lines are not in this list, which holds the largest, the smallest and evenly spread errors of each "
                     "method; problems.csv has them all.")
    for note in notes:
        page.text(note)
    page.place("problem-list")
    page.script("report.js")


def write_page(run, fits, shown):
    page = html_page.Page(run.title)
    page.subtitles = [run.results["setting"], f"diffsac_eval, revision {run.results['git_revision']}, {run.results['machine']}"]
    if run.partial:
        page.warning("Partial results: the run was interrupted.")
    for row in run.results["left_out"]:
        page.text(f"Left out: {row}.")
    add_tables(page, run)
    if shown:
        page.section("Curves and bars")
    for name, caption in shown:
        page.picture(picture_in(run, name), caption)
    if fits and fits.fits and not run.results["two_view"]:  # Two views have theirs in the list of pairs.
        page.section("Fits")
        if not run.partial:
            page.picture(picture_in(run, "fits"), "The kept fits, a column a condition.")
        for fit in fits.fits:
            page.text(fit_caption(run, fit, fits.example(fit)))
    add_problems(page, run)
    page.write(run.path("report.html"))


def main(folder):
    if os.path.exists(os.path.join(folder, "pairs.json")):
        return photographs.write_page(folder)
    run = runs.Run(folder)
    written.write_numbers(run)
    labels.write_labels(run)
    fits = examples.open_fits(run)
    shown = [] if run.partial else draw_pictures(run, fits)
    write_page(run, fits, shown)


if __name__ == "__main__":
    files.run_script(main, sys.argv[1])
