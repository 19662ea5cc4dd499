"""scripts/report over small runs of diffsac_eval. report_test.py BUILD SOURCE: status 4 where modules are missing."""
import base64
import importlib.util
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import types
import unittest

BUILD, SOURCE = sys.argv[1:3]
sys.path.insert(0, os.path.join(SOURCE, "scripts", "report"))
try:
    import numpy as np
    import PIL.Image

    docs, examples, files, html_page, match_pictures, pictures, problem_list, runs, tables, told_tables, training_report, verdicts, words = (
        importlib.import_module(name) for name in ("docs", "examples", "files", "html_page", "match_pictures", "pictures", "problem_list", "runs",
                                                   "tables", "told_tables", "training_report", "verdicts", "words"))
    spec = importlib.util.spec_from_file_location("report_main", os.path.join(SOURCE, "scripts", "report", "__main__.py"))
    report_main = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(report_main)
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(4)

NASTY = "</script><script>alert(1)</script>"
PAIRS = f"""
name: pairs
task: fundamental
problems: 7
data: {{type: synthetic_two_view, task: fundamental, num_points: 40}}
conditions:
  - {{name: "0.2", value: 0.2, data: {{outlier_ratio: 0.2}}}}
  - {{name: "0.6", value: 0.6, data: {{outlier_ratio: 0.6}}}}
methods:
  - {{name: many, type: ransac, label: "{NASTY}", max_iterations: 300}}
  - {{name: few, type: ransac, max_iterations: 3}}
  - {{name: oracle, type: oracle}}
report:
  title: "{NASTY}"
  series: {{ransac: [many, few]}}
  compare: {{many: few}}
  strata: [{{by: inlier_share, bins: [0.5]}}, {{by: scene}}]
  figures: {{bars: [many, few]}}
"""
LINES = """
name: lines
task: line
problems: 3
data: {type: synthetic_structures, task: line, structures: 2, num_points: 60}
methods:
  - {name: ransac, type: ransac, max_iterations: 50}
  - {name: oracle, type: oracle}
"""


class Page:
    """report.html taken apart."""

    def __init__(self, folder):
        with open(os.path.join(folder, "report.html"), encoding="utf-8") as file:
            self.html = file.read()
        self.body = re.sub(r"<(script|style).*?</\1>", "", self.html, flags=re.DOTALL)
        self.data = {name: json.loads(content) if kind == "json" else base64.b64decode(content) for kind, name, content in
                     re.findall(r'<script type="application/([a-z-]+)" id="([^"]+)">(.*?)</script>', self.html, re.DOTALL)}


def evaluate(folder, config, *arguments):
    path = folder + ".yaml"
    with open(path, "w", encoding="utf-8") as file:
        file.write(config)
    subprocess.run([os.path.join(BUILD, "bin", "diffsac_eval"), "--config", path, "--threads", "1", "--output", folder, *arguments],
                   check=True, capture_output=True)
    report_main.main(folder)


class RunTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = tempfile.TemporaryDirectory()
        cls.pairs, cls.lines = (os.path.join(cls.work.name, name) for name in ("pairs", "lines"))
        evaluate(cls.pairs, PAIRS)
        evaluate(cls.lines, LINES)
        cls.page, cls.run_of_pairs = Page(cls.pairs), runs.Run(cls.pairs)

    @classmethod
    def tearDownClass(cls):
        cls.work.cleanup()

    def changed(self, change):
        """The folder of a copy of the run of pairs whose run.json is changed, with its page."""
        folder = tempfile.mkdtemp(dir=self.work.name)
        for name in ("config.yaml", "problems.csv", "estimates.h5"):
            shutil.copy(os.path.join(self.pairs, name), folder)
        facts = json.loads(json.dumps(self.run_of_pairs.facts))
        change(facts, folder)
        files.write_whole(os.path.join(folder, "run.json"), json.dumps(facts))
        report_main.main(folder)
        return folder

    def test_pictures_are_there(self):
        for name in ("curve", "bars", "budget", "time", "strata_inlier_share", "strata_scene"):
            with PIL.Image.open(os.path.join(self.pairs, name + ".png")) as picture:
                self.assertGreater(picture.width, 600, name)
        self.assertEqual(len([name for name in os.listdir(self.pairs) if name.startswith("matches_")]), 4)
        self.assertTrue(os.path.exists(os.path.join(self.lines, "fits.png")))
        self.assertFalse(os.path.exists(os.path.join(self.lines, "curve.png")))
        self.assertFalse([name for name in os.listdir(self.pairs) if name.startswith(".")])

    def test_page_has_tables_and_every_problem_and_loads_nothing(self):
        for table in self.run_of_pairs.tables:
            self.assertIn(f"<caption>{html_page.markupsafe.escape(table.heading)}", self.page.body)
        self.assertNotRegex(self.page.html, "https?:|@import|<script>alert")
        problems = self.page.data["problems"]
        self.assertEqual((len(problems["problems"]), len(problems["lines"])), (14, 42))
        self.assertEqual(problems["methods"], [NASTY, "few", "oracle"])
        self.assertEqual(problems["method"], 0)
        table = self.run_of_pairs.problems
        for line in problems["lines"]:
            one = problems["problems"][line[0]]
            row = table[(table["id"] == one[0]) & (table["condition"] == problems["conditions"][one[2]])
                        & (table["method"] == ("many", "few", "oracle")[line[1]])].iloc[0]
            self.assertAlmostEqual(float(line[3]), row["angle_deg"], delta=1e-3 * row["angle_deg"] + 1e-9)
            self.assertEqual(line[6], row["inliers"])

    def test_matches_are_there_to_a_quarter_pixel_with_the_inliers_of_each_method_and_of_the_truth(self):
        shown = self.page.data["pictures"]
        pairs, estimates = self.run_of_pairs.examples, self.run_of_pairs.estimates
        self.assertEqual(len(shown), 14)
        example = pairs.at(9)
        packed = self.page.data[f"points-{shown[9][0]}"]
        step = np.frombuffer(packed[:4], "<f4")[0]
        self.assertEqual(step, 0.25)
        places = np.frombuffer(packed[4:], "<i2").reshape(-1, 4) * step
        self.assertLessEqual(np.abs(places - example.points).max(), 0.126)
        self.assertEqual(shown[9][7:], [1, [0, 1, 2]])
        masks = np.unpackbits(np.frombuffer(self.page.data["masks-9"], np.uint8).reshape(4, 5), axis=1, bitorder="little")
        np.testing.assert_array_equal(masks[0], example.inliers)
        of_cell = estimates[example.condition, 1]
        np.testing.assert_array_equal(masks[2], of_cell.mask(of_cell.at[example.index], 40))

    def test_partial_runs_and_what_an_earlier_run_left(self):
        page = Page(self.changed(lambda facts, folder: facts.update(partial=True)))
        self.assertIn("Partial results: the run was interrupted.", page.body)
        self.assertNotIn("<img", page.body)

        def without_strata(facts, folder):
            facts["configuration"]["report"]["strata"] = []
            for name in ("strata_scene.png", "matches_of_an_earlier_run.png", "reliability.csv"):
                files.write_whole(os.path.join(folder, name), "old")

        folder = self.changed(without_strata)
        for name in ("strata_scene.png", "matches_of_an_earlier_run.png", "reliability.csv"):
            self.assertFalse(os.path.exists(os.path.join(folder, name)), name)

    def test_without_estimates_the_examples_have_their_inliers(self):
        folder = os.path.join(self.work.name, "kept")
        evaluate(folder, PAIRS, "--set", "estimates=false", "--set", "examples=2")
        page = Page(folder)
        self.assertEqual([picture[8] for picture in page.data["pictures"]], [[0, 1, 2]] * 4)
        self.assertIn("4 of 14 pairs have a picture", page.body)

    def test_long_lists_keep_the_worst_the_best_and_some_between(self):
        errors = np.array([(37 * i) % 100 for i in range(100)], dtype=float)
        errors[5] = math.nan
        shown = errors[problem_list.largest_smallest_and_spread(errors, 12)]
        self.assertEqual(len(shown), 12)
        self.assertTrue({99, 98, 97, 96, 95, 94, 0, 1} <= set(shown[~np.isnan(shown)]) and np.isnan(shown).sum() == 1)
        before, problem_list.MOST_LINES = problem_list.MOST_LINES, 1
        text, left_out = problem_list.ProblemList(self.run_of_pairs).json({})
        problem_list.MOST_LINES = before
        self.assertEqual((len(json.loads(text)["lines"]), left_out), (42, 0))  # Never fewer than a few of each method.

    def test_several_structures(self):
        page = Page(self.lines)
        problems = page.data["problems"]
        self.assertEqual((problems["unit"], problems["structures"], len(problems["lines"][0])), ("%", True, 9))
        self.assertIn("Fits</h2>", page.body)
        self.assertIn("recall", page.body)
        self.assertNotIn("mAA@", page.body)
        self.assertRegex(page.body, r"ransac, .*: error [0-9.]+ %; 60 points, inliers: \d+ right")

    def test_points_that_say_nothing_are_drawn_as_well(self):
        fits = examples.open_fits(runs.Run(self.lines))
        for points in (np.zeros((0, 2)), np.full((3, 2), np.nan), np.zeros((1, 3)), np.zeros((0, 4)), np.ones((2, 4))):
            count = len(points)
            for structures in ({}, {"structures": {"models": [], "labels": [0] * count, "true_models": []}}):
                fit = {**fits.fits[0], "inliers": [], "model": [], "true_model": [], **structures}
                if not structures:
                    fit.pop("structures", None)
                example = fits.example(fits.fits[0])
                example.points = points
                figure = pictures.plt.figure()
                pictures._draw_fit(figure.add_subplot(projection="3d" if points.shape[1] == 3 else None), fit, example)
                pictures.plt.close(figure)
        for points in (np.zeros((0, 6)), np.full((3, 6), np.nan), np.ones((2, 6))):
            for moved in (False, True):
                figure = pictures.plt.figure()
                fit = {"inliers": [1] * len(points), "model": np.eye(3, 4).ravel().tolist()}
                pictures._draw_clouds(figure.add_subplot(projection="3d"), fit, points, moved)
                pictures.plt.close(figure)

    def test_reverse_steps(self):
        class Traced:
            trace = {"timesteps": [9.0, 1.0], "confidence": [[0.5, None, -1, 1], [1, None, 0, -1]], "set_size": 2, "downwards": False}

            def example(self, trace):
                return type("Example", (), {"points": np.arange(8.0).reshape(4, 2)})

        run = self.run_of_pairs
        self.assertTrue(pictures.draw_confidence(run, Traced()))
        self.assertFalse(pictures.draw_confidence(run, None))
        Traced.trace["timesteps"] = [9.0]
        self.assertFalse(pictures.draw_confidence(run, Traced()))

    def test_effects_and_reliability(self):
        def change(facts, folder):
            facts["configuration"]["report"]["factors"] = {"draws": ["many", "few"]}
            bins = [[9, 0.5 * b, 0.4 * b] for b in range(10)]
            facts["reliability"] = [{"label": label, "condition": c, "scenes": {"s": bins}} for label in ("a", "b") for c in (0, 1)]

        page = Page(self.changed(change))
        self.assertIn("What the levels of each factor add to", page.body)
        self.assertIn("How often a point is an inlier", page.body)

    def test_what_cannot_be_written_is_one_line_and_a_status(self):
        folder = self.changed(lambda facts, folder: None)
        os.remove(os.path.join(folder, "table.tex"))
        os.mkdir(os.path.join(folder, "table.tex"))
        done = subprocess.run([sys.executable, "-B", os.path.join(SOURCE, "scripts", "report"), folder], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (4, 1))
        self.assertIn("table.tex", done.stderr)


class PartsTest(unittest.TestCase):
    TABLE = tables.Table("h <1>", ["method", "mAA", "n"], [
        tables.Row(["50% & more_less", "0.850", "–"], [False, True, False], ["", "[0.75, 0.95]", ""]),
        tables.Row(["paper", "+0.2 [0.1, 0.3]", "3"], [False] * 3, [], True)])

    def test_tables_in_their_forms(self):
        self.assertEqual(tables.markdown_table(self.TABLE).splitlines()[2], "| 50% & more_less |       **0.850** |   – |")
        latex = tables.latex_table(self.TABLE)
        self.assertIn("\\begin{tabular}{lrr}\n\\toprule\n", latex)
        self.assertIn("50\\% \\& more\\_less & \\textbf{0.850} & -- \\\\\n\\midrule\npaper", latex)
        self.assertEqual(tables.tables_csv([self.TABLE, self.TABLE]).split("\n\n")[0],
                         'h <1>\nmethod,mAA,n\n50% & more_less,0.850,\npaper,"+0.2 [0.1, 0.3]",3')

    def test_what_is_told_of_numbers(self):
        def interval(mean, low=None, high=None):
            return {"mean": mean, "low": low, "high": high}

        levels = [{"level": "plain", "accuracy": [interval(0.375, 0.3, 0.4), None], "milliseconds": [interval(0.5, 0.5, 0.5)] * 2,
                   "combinations": [2, 2]},
                  {"level": "good", "accuracy": [interval(0.625, 0.5, 0.7), None], "milliseconds": [interval(10, 9.5, 10.5)] * 2,
                   "combinations": [2, 1]}]
        effects = [{"factor": "score", "levels": levels},
                   {"factor": "draws", "levels": [dict(levels[0], level="few"), dict(levels[0], level="many")]}]
        bins = [{"label": "< 0.5", "problems": [3, 0], "accuracies": [interval(0.0), interval(1.0)], "effects": effects,
                 "differences": [[interval(1.0), None]]},
                {"label": "≥ 0.5", "problems": [6, 0], "accuracies": [interval(1.0, 1.0, 1.0)] * 2, "effects": effects,
                 "differences": [[interval(0.0, 0.0, 0.0), None]]}]
        results = {
            "accuracy": {"metric": "mAA@10deg"}, "condition_label": "matches", "effects": effects, "compare": [["good", "plain"]],
            "conditions": [{"name": "all", "label": "all", "rows_share_problems": True},
                           {"name": "ratio", "label": "ratio", "rows_share_problems": True}],
            "methods": [{"name": "plain", "label": "Plain", "competes": True}, {"name": "good", "label": "Good", "competes": True}],
            "results": [{"condition": "all", "method": name, "mAA@10deg_ci95": interval(0.5)} for name in ("plain", "good")],
            "differences": [dict(interval(0.475, 0.45, 0.5), a="good", b="plain", condition="all", metric="mAA@10deg")],
            "strata": [{"by": "inlier_share", "title": "share of true inliers", "rows": ["plain", "good"], "bins": bins, "unknown": [1, 0]},
                       {"by": "scene", "title": "scene", "rows": ["plain"], "bins": bins, "unknown": [0, 0]},
                       {"by": "baseline", "title": "true baseline", "rows": [], "bins": [], "unknown": [9, 9]}],
            "beside_paper": [{"method": "good", "paper_row": "RANSAC", "condition": 0, "metric": "mAA", "paper": 0.83,
                              "ours": interval(0.85, 0.75, 0.95), "problems": 4}],
            "learned": {"good": {"parameters": 7, "samples": 0, "run_samples": 0, "start": ""}}}
        told = {table.heading: table for table in told_tables.told_tables(results)}
        self.assertEqual(len(told), 1 + 2 + 2 * 3 + 2 * 2 + 2)

        def cells(heading, row):
            return told[heading].rows[row].cells

        of = ", mean over the other factors' levels, with 95 % bootstrap intervals"
        self.assertEqual(cells("differences in mAA@10deg with 95 % bootstrap intervals", 0), ["Good − Plain", "+0.475 [+0.450, +0.500]", "–"])
        self.assertEqual(cells("effects on mAA@10deg" + of, 0), ["score: plain", "0.375 [0.300, 0.400]", "–"])
        self.assertEqual(cells("effects on mAA@10deg" + of, 1)[1], "+0.625 [+0.500, +0.700]")
        self.assertEqual(told["effects on mAA@10deg" + of].rows[1].best, [False, True, False])
        self.assertEqual(cells("effects on milliseconds, as ratios" + of, 1)[1], "×10 [9.5, 10.5]")
        strata = told["mAA@10deg by share of true inliers (problems), matches all"]
        self.assertEqual(strata.columns, ["method", "< 0.5 (3)", "≥ 0.5 (6)"])
        self.assertEqual([(row.cells, row.best) for row in strata.rows], [(["Plain", "0.000", "1.000"], [False, False, True]),
                                                                         (["Good", "1.000", "1.000"], [False, True, True])])
        self.assertEqual(strata.rows[0].intervals, ["", "", "[1.000, 1.000]"])
        self.assertEqual(cells("differences in mAA@10deg by scene (problems), matches all", 0), ["Good − Plain", "+1.000", "+0.000 [+0.000, +0.000]"])
        self.assertEqual(cells("ours beside the paper's, which was measured on other data", 0),
                         ["Good / RANSAC", "all", "mAA", "0.83", "0.850 [0.750, 0.950]", "+0.020", "4"])
        self.assertEqual(cells("learned rows", 0), ["Good", "7", "–", "–", "–"])
        notes = "\n".join(told_tables.told_notes(results))
        self.assertIn("Of fewer combinations: score: good 1 of 2.", notes)
        self.assertIn("In no stratum, as their share of true inliers is unknown: all 1 problems.", notes)
        self.assertIn("Strata by true baseline are left out: it is known of no problem.", notes)
        for cell in results["results"]:
            cell["mAA@10deg_ci95"]["mean"] = None
        self.assertIn("Strata are left out: the truth is not known.", told_tables.told_notes(results))
        self.assertEqual([table.heading[:23] for table in told_tables.told_tables(results)], ["effects on milliseconds", "ours beside the paper's", "learned rows"])

    def test_a_page_has_values_to_sort_by_and_texts_stay_texts(self):
        page = html_page.Page(NASTY)
        page.tables([self.TABLE])
        page.text(NASTY)
        page.json("j", json.dumps(NASTY))
        html = page.html()
        self.assertNotIn("<script>alert", html)
        self.assertIn('data-value="0.85">0.850 <small>[0.75, 0.95]</small></td>', html)
        self.assertIn('<tbody class="paper">', html)
        self.assertIn('data-value="0.2">+0.2 <small>[0.1, 0.3]</small>', html)
        for cell, value in (("85 %", 85.0), ("1.5e-3", 0.0015), ("3 views", None), ("", None), ("–", None), ("-2", -2.0)):
            self.assertEqual(html_page.number_of(cell), value, cell)

    def test_what_occurs_in_the_tables_is_explained(self):
        terms = [term for term, _ in words.words_of([tables.Table("mAA@0.5deg", ["method", "ms"], self.TABLE.rows)])]
        self.assertEqual(terms, ["mAA@c", "ms", "[0.45, 0.57]", "bold", "paper"])
        self.assertEqual(words.words_of([]), [])

    def test_matches_are_right_wrong_and_missed(self):
        found, truth = np.array([1, 1, 0, 0], bool), np.array([1, 0, 1, 0], bool)
        self.assertEqual(list(match_pictures.kinds_of(found, truth)), [2, 3, 1, 0])
        self.assertEqual(list(match_pictures.kinds_of(found, None)), [2, 2, 0, 0])
        self.assertIn("1 right (green), 1 wrong (red), 1 missed (blue) of 4", match_pictures.counts_text(np.array([2, 3, 1, 0]), truth))

    def test_an_inlier_is_of_one_colour(self):
        with open(os.path.join(SOURCE, "scripts/report/page.css"), encoding="utf-8") as file:
            self.assertIn("--right: " + pictures.INLIER.lower(), file.read())

    def test_photographs_are_found_and_made_smaller(self):
        with tempfile.TemporaryDirectory() as folder:
            PIL.Image.new("RGB", (80, 60)).save(os.path.join(folder, "left.png"))
            example = examples.Example({"id": "s/left-right", "name": "", "scene": "scene", "folder": "", "condition": 0, "index": 0, "image1": "left",
                                        "image2": "right", "size1": [80, 60], "size2": [0, 0]}, np.array([[1.0, 2, 3, 4], [1, 2, 9.5, math.nan]]), None)
            folders = [{"scenes": "other", "folder": folder}, {"scenes": "sc*", "folder": folder}]
            self.assertEqual(examples.load_image(folders, example, 0, 40).size, (40, 30))
            self.assertIsNone(examples.load_image(folders, example, 1, 40))
            self.assertEqual((example.size(0), example.size(1)), ((80, 60), (4, 5)))

    def test_trainings(self):
        with tempfile.TemporaryDirectory() as folder:
            training_report.main(folder, True)
            self.assertIn("Nothing measured yet.", Page(folder).body)
            self.assertIn('http-equiv="refresh"', Page(folder).html)
            files.write_whole(os.path.join(folder, "config.yaml"), f"name: </pre>{NASTY}")
            for rows, drawn in (("10,,0.1,", False), ("10,-1,0.1,", False), ("10,,0.1,0.4", True), ("10,0.5,0.1,", True), ("10,0.5,0.1,\n30,0.25,0.1,0.6", True)):
                files.remove(os.path.join(folder, "training_curve.png"))
                files.write_whole(os.path.join(folder, "metrics.csv"), f"iteration,loss,learning_rate,mAA@0.5deg\n{rows}\n")
                training_report.main(folder, False)
                self.assertEqual(os.path.exists(os.path.join(folder, "training_curve.png")), drawn, rows)
            page = Page(folder)
            self.assertNotIn("<script>alert", page.html)
            self.assertNotIn('http-equiv="refresh"', page.html)
            self.assertIn('data-value="30">30</td>', page.body)
            self.assertIn("To iteration 30.", page.body)
            script = os.path.join(SOURCE, "scripts", "report", "to_tensorboard.py")
            made = subprocess.run([sys.executable, script, folder], capture_output=True, text=True)
            if importlib.util.find_spec("tensorboard"):
                self.assertTrue([name for name in os.listdir(folder) if name.startswith("events.out.tfevents.")], made.stderr)
            else:
                self.assertIn("pip install tensorboard", made.stderr)


class VerdictsTest(unittest.TestCase):
    PROBLEMS = (  # condition, status, angle_deg, failed, log10_nfa, pose_deg, degeneracy, has_ambiguous_pose
        "all,ok,1,0,-9,1,determined,0", "all,ok,2,0,-9,170,determined,0",  # The second's t has the wrong sign.
        "all,ok,3,0,-9,180,pure_rotation,0", "all,ok,4,0,-9,4,pure_rotation,0",  # Taken back; a turn that is one.
        "all,ok,5,0,2,180,static,0",  # Taken back, and flagged.
        "all,ok,7,0,-9,7,determined,1", "all,ok,30,0,-9,30,determined,0", "all,ok,40,0,1,40,determined,1", "all,no_model,180,1,,180,not_tested,0",
        "hard,ok,20,0,,20,not_tested,0", "hard,ok,,0,,,determined,0")  # The last one's truth is not known.

    def run_folder(self, folder, columns="degeneracy,has_ambiguous_pose"):
        facts = {"format": "diffsac run 1", "experiment": "made_up", "partial": False, "task": "essential", "methods": [{"name": "a", "label": "A"}], "configuration": {},
                 "conditions": [{"name": "all"}, {"name": "hard"}]}
        files.write_whole(os.path.join(folder, "run.json"), json.dumps(facts))
        lines = [f"p{i},s,a,{line}" for i, line in enumerate(self.PROBLEMS)]
        header = f"id,scene,method,condition,status,angle_deg,failed,log10_nfa,pose_deg,{columns}"
        files.write_whole(os.path.join(folder, "problems.csv"), "\n".join([header, *lines]) + "\n")
        return runs.Run(folder)

    def test_verdicts_beside_the_truth(self):
        with tempfile.TemporaryDirectory() as folder:
            cells = dict(zip(("all", "hard"), (cell for _, cell in verdicts.cells_of(self.run_folder(folder), []))))
            rows = {row.cells[0]: row.cells[1:] for row in verdicts.verdict_table(cells["all"]).rows}
            self.assertEqual(rows["determined"], ["2", "0", "1", "3", "1"])
            self.assertEqual(rows["pure rotation"], ["2", "0", "0", "2", "1"])
            self.assertEqual(rows["static"], ["0"] * 5)  # May be chance comes first.
            self.assertEqual(rows["may be chance"], ["1", "0", "1", "2", "0"])
            self.assertEqual(rows["ambiguous"], ["0", "1", "0", "1", "1"])
            self.assertEqual(rows["failed"], ["0", "0", "1", "1", "0"])
            self.assertEqual(rows["all"], ["5", "1", "3", "9", "3"])
            self.assertEqual(verdicts.shares(cells["all"]), ((2, 5), (2, 4)))
            self.assertEqual(verdicts.shares(cells["hard"]), ((0, 0), (1, 1)))
            page = os.path.join(folder, "pages", "verdicts.md")
            verdicts.main([folder], ["a"], page)
            with open(page, encoding="utf-8") as file:
                self.assertIn("2 of 5: 40.0 % [11.8, 76.9]", file.read())

    def test_runs_and_rows_that_cannot_be_told_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(files.BadInput, "has no row b, but: a"):
                list(verdicts.cells_of(self.run_folder(folder), ["b"]))
            with self.assertRaisesRegex(files.BadInput, "problems.csv has no degeneracy: not of two views, or of an earlier version"):
                list(verdicts.cells_of(self.run_folder(folder, "verdict,has_ambiguous_pose"), []))

    def test_wilson_intervals(self):
        for count, of, low, high in ((0, 10, 0.0, 0.2775), (5, 10, 0.2366, 0.7634), (10, 10, 0.7225, 1.0), (81, 263, 0.2553, 0.3662)):
            for end, expected in zip(verdicts.wilson(count, of), (low, high)):
                self.assertAlmostEqual(end, expected, places=4)


class PageDifferencesTest(unittest.TestCase):
    def test_tables_that_a_page_has_not_leave_it_valid(self):
        def page(*headings, value="0.5"):
            return types.SimpleNamespace(path="page", tables=[tables.Table(one, ["method", "all"], [tables.Row(["a", value])]) for one in headings])

        self.assertEqual(list(docs.differences(page("mAA"), page("mAA", "pose"))), [])
        self.assertEqual(list(docs.differences(page("mAA", "pose"), page("mAA"))), ["page: only the page has 'pose'"])
        self.assertEqual(len(list(docs.differences(page("mAA"), page("mAA", "pose", value="0.7")))), 1)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
