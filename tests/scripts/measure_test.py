"""What scripts/report makes of problems.csv, run.json and estimates.h5, by hand. measure_test.py BUILD SOURCE: status 4 where modules are missing."""
import contextlib
import io
import json
import math
import os
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(sys.argv[2], "scripts", "report"))
try:
    import h5py
    import numpy as np
    import pandas as pd

    import bootstrap
    import compare
    import files
    import labels
    import merge
    import metric_tables
    import metrics
    import reliability
    import runs
    import written
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(4)

NUMBERS = {"angle_deg": math.nan, "offset": math.nan, "rotation_deg": math.nan, "translation_deg": math.nan, "error_px": math.nan, "inliers": 5,
           "hypotheses": 10, "ms_features": 0.0, "ms_network": 0.0, "ms_consensus": 1.0, "ms_total": 1.0, "points": 20, "failed": 0,
           "unique_minimal_sets": 9, "all_inlier_sets": math.nan, "log10_nfa": -3.0, "inlier_share": math.nan}


def write_run(folder, lines, methods=("a", "b"), conditions=("all",), report=None, **facts):
    """lines: (condition, method, index, values) or with the scene before the values."""
    os.makedirs(folder, exist_ok=True)
    table = []
    for condition, method, index, *scene, values in lines:
        scene = scene[0] if scene else "s"
        table.append({"index": index, "id": f"p{index}", "scene": scene, "condition": condition, "method": method, "status": "ok", **NUMBERS, **values})
    pd.DataFrame(table).to_csv(os.path.join(folder, "problems.csv"), index=False, lineterminator="\n")
    of_condition = {name: max([line[2] for line in lines if line[0] == name], default=-1) + 1 for name in conditions}
    run = {"format": "diffsac run 1", "experiment": "e", "task": "line", "dataset": "d", "seed": 3, "threshold_deg": 0.5, "unit": "°", "two_view": False,
           "partial": False, "shard": None, "setup": {"checkpoint": "", "device": "cpu"}, "left_out": [], "git_revision": "g", "machine": "m",
           "conditions": [{"name": name, "label": name, "value": None, "problems": of_condition[name]} for name in conditions],
           "methods": [{"name": name, "label": name.upper(), "type": "oracle" if name == "oracle" else "ransac", "conditions": [], "max_problems": 0}
                       for name in methods],
           "learned": {}, "reliability": [], "configuration": {"conditions": [{"data": {}} for _ in conditions], "report": report or {}},
           "facts": {"run": {}, "seconds": 1.0, "peak_memory_mib": 2.0, "data_sha256": "x", "networks_sha256": {}}, **facts}
    with open(os.path.join(folder, "run.json"), "w", encoding="utf-8") as file:
        json.dump(run, file)
    with open(os.path.join(folder, "config.yaml"), "w", encoding="utf-8") as file:
        file.write("# program: diffsac_eval\n\nname: e\n")
    return folder


class FolderTest(unittest.TestCase):
    def setUp(self):
        work = tempfile.TemporaryDirectory()
        self.addCleanup(work.cleanup)
        self.folder = os.path.join(work.name, "run")

    def run_of(self, lines, **options):
        return runs.Run(write_run(self.folder, lines, **options))

    @staticmethod
    def cells(run):
        return {(cell["condition"], cell["method"]): cell for cell in run.results["results"]}


class BootstrapTest(unittest.TestCase):
    def test_random_numbers_are_those_of_the_library(self):
        self.assertEqual([int(x) for x in bootstrap.random_numbers(0, 0, 2)], [0xe169c58d6627e8d5, 0x9b00dbd8bc57ac4c])  # Random123's known answer.
        self.assertEqual(bootstrap.fork(1, "bootstrap"), 5299739776832470154)
        every = bootstrap.random_numbers(7, 0, 9)
        np.testing.assert_array_equal(bootstrap.random_numbers(7, 3, 5), every[3:8])

    def test_intervals_are_those_that_the_programs_printed(self):
        scenes = bootstrap.interval([0, 0.5, 1, 0.2, 0.4, 0.4, 0.9], [3, 4], 3)
        self.assertEqual(scenes, {"mean": 0.4875, "low": 0.23333333333333334, "high": 0.7416666666666667})
        several_blocks = bootstrap.interval((np.arange(2500) * 7 % 11) / 10, [2500], 1)
        self.assertEqual(several_blocks, {"mean": 0.4998, "low": 0.4885190000000007, "high": 0.51268099999999883})
        accuracies = np.array([9, 10, 10, 9, 8, 10, 6, 9, 6, 8, 8, 9, 9, 10, 8, 10, 9, 8, 10, 10]) / 10  # The line table, RANSAC 20 at 0.5.
        self.assertEqual(bootstrap.interval(accuracies, [20], 1), {"mean": 0.8800000000000001, "low": 0.8300000000000001, "high": 0.93})

    def test_scenes_weigh_the_same_and_nothing_has_no_interval(self):
        self.assertEqual(bootstrap.interval([1, 1, 1, 1, 0], [4, 1], 1), {"mean": 0.5, "low": 0.5, "high": 0.5})
        self.assertEqual(bootstrap.interval([], [], 1), bootstrap.UNKNOWN)


class MetricsTest(FolderTest):
    def test_lines_by_hand(self):
        errors = [0.45, 0.05, 0.1, math.inf, math.nan]
        run = self.run_of([("all", "a", i, {"angle_deg": error, "failed": int(error == math.inf), "ms_total": i, "log10_nfa": 1.0 if i == 4 else -1.0})
                           for i, error in enumerate(errors)], methods=("a",))
        found = self.cells(run)["all", "a"]["metrics"]["mean"]
        self.assertAlmostEqual(found["mAA@0.5deg"], (0.2 + 1.0 + 0.9 + 0.0) / 4)  # An error on a bar is accurate.
        self.assertAlmostEqual(found["AUC@0.5deg"], (0.05 * 0.25 / 2 + 0.05 * 0.75 / 2 + 0.35 * 1.25 / 2 + 0.05 * 0.75) / 0.5)
        self.assertEqual([found[name] for name in ("acc@0.5deg", "median_deg", "problems", "failures", "may_be_chance", "ms_total")],
                         [0.75, (0.1 + 0.45) / 2, 5, 1, 1, 2])
        self.assertNotIn("mAA_R@0.5deg", found)

    def test_a_failure_is_the_worst_error(self):
        run = self.run_of([("all", "a", i, {"angle_deg": error}) for i, error in enumerate([0.1, math.inf, math.inf])], methods=("a",))
        self.assertEqual(self.cells(run)["all", "a"]["metrics"]["mean"]["median_deg"], math.inf)
        self.assertEqual(run.tables[1].rows[0].cells[1], "inf")
        written.write_numbers(run)
        with open(run.path("results.json"), encoding="utf-8") as file:
            self.assertIsNone(json.load(file)["results"][0]["metrics"]["mean"]["median_deg"])  # JSON has no infinity.

    def test_pixels_have_logarithmic_bars(self):
        c = metrics.Tolerance(20.0, True)
        np.testing.assert_allclose(c.accuracies(np.array([1.0, 1.3, 20.0, 20.1, np.nan])), [1.0, 0.9, 0.1, 0.0, np.nan])
        self.assertEqual((c.named("mAA"), c.of_pose().named("mAA_pose"), metrics.Tolerance(0.25).named("AUC")), ("mAA@20px", "mAA_pose@10deg", "AUC@0.25deg"))

    def test_poses(self):
        lines = [{"angle_deg": 8, "rotation_deg": 2, "translation_deg": 8, "pose_deg": 172}, {"angle_deg": 4, "rotation_deg": 4, "pose_deg": 4},
                 {"angle_deg": math.nan}]  # The second's cameras are in one place; the third's truth is unknown.
        run = self.run_of([("all", "a", i, {"rotation_level": 0.5, **one}) for i, one in enumerate(lines)], methods=("a",), threshold_deg=10, two_view=True)
        found = self.cells(run)["all", "a"]["metrics"]["mean"]
        for name, value in (("mAA_R@10deg", (0.9 + 0.7) / 2), ("mAA_t@10deg", 0.3 / 2), ("mAA_pose@10deg", 0.35), ("median_t_deg", 8), ("held_R_68", 1),
                            ("AUC@5deg", (4 * 0.5 / 2 + 0.5) / 5)):
            self.assertAlmostEqual(found[name], value, msg=name)
        self.assertNotIn("median_focal_percent", found)
        self.assertTrue(math.isnan(found["held_t_68"] or math.nan))

    def test_several_structures(self):
        values = [{"misclassified": 10.0, "recall": 1.0, "structures": 2, "one_structure_sets": 0.5, "structures_in_sets": 1, "draws": 7, "structure_angles_deg": "1 3"},
                  {"misclassified": 30.0, "recall": 0.5, "structures": 1, "draws": 9, "structure_angles_deg": ""}]
        run = self.run_of([("all", "a", i, {"angle_deg": 1.0, **one}) for i, one in enumerate(values)], methods=("a",), threshold_deg=2)
        found, accuracy = self.cells(run)["all", "a"], run.results["accuracy"]
        self.assertEqual((accuracy["metric"], run.results["unit"], found["recall_ci95"]["mean"], found["one_structure_sets_ci95"]["mean"]), ("recall", "%", 0.75, 0.5))
        # CONSAC's area: from the first error on, at the limit the recall between those beside it, weighted by the errors.
        expected = {"misclassification": 20, "misclassification_median": 20, "recall": 0.75, "structures": 1.5, "draws": 8,
                    "recall_AUC@2deg": 0.5 * (2 - 1) * (0.5 + (1 * 0.5 + 3 * 1) / 4) / 2, "recall_AUC@1deg": 0, "structures_within@2deg": 0.5}
        for name, value in expected.items():
            self.assertAlmostEqual(found["metrics"]["mean"][name], value, msg=name)
        self.assertIn("misclassification error in %, mean, lower is better", [table.heading for table in run.tables])

    def test_means_over_scenes_and_groups_and_all_pairs(self):
        lines = [("all", "a", 0, "walk_1", {"angle_deg": 0.01}), ("all", "a", 1, "walk_2", {"angle_deg": 9}), ("all", "a", 2, "walk_2", {"angle_deg": 9}),
                 ("all", "a", 3, "house", {"angle_deg": 0.01, "failed": 1})]
        run = self.run_of(lines, methods=("a",), report={"scene_groups": {"walks": "walk_*"}})
        found = self.cells(run)["all", "a"]["metrics"]
        self.assertEqual([found[scene]["mAA@0.5deg"] for scene in ("walks", "house", "mean", "all_pairs")], [1 / 3, 1.0, 2 / 3, 0.5])
        self.assertEqual((found["mean"]["problems"], found["mean"]["failures"]), (4, 1))
        headings = [table.heading for table in run.tables]
        self.assertEqual(headings[:2] + headings[-1:], ["mAA@0.5deg, unweighted mean over 2 scenes, higher is better",
                                                       "mAA@0.5deg, mean over all pairs, higher is better", "mAA@0.5deg by scene"])


class ResultsTest(FolderTest):
    def lines(self, count=8):
        """b is right where a is, and on odd problems too; the oracle everywhere."""
        for i in range(count):
            share = {"inlier_share": 0.1 * i, "ms_total": 2.0}
            yield "all", "a", i, {**share, "angle_deg": 0.01 if i % 4 == 0 else 9.0}
            yield "all", "b", i, {**share, "angle_deg": 0.01 if i % 4 == 0 or i % 2 else 9.0, "ms_total": 4.0}
            yield "all", "oracle", i, {**share, "angle_deg": 0.0}

    def test_differences_and_what_a_run_has_not(self):
        lines, told = list(self.lines()), io.StringIO()
        with contextlib.redirect_stderr(told):
            run = self.run_of(lines, methods=("a", "b", "oracle"), report={"compare": {"b": ["a", "gone"]}, "reference": "b", "figures": {"bars": ["gone"]}})
            difference = run.results["differences"]
        self.assertEqual(told.getvalue().count("\n"), 1)
        self.assertIn("rows that this run has not: gone", told.getvalue())
        self.assertEqual([(one["a"], one["b"], one["mean"]) for one in difference], [("b", "a", 0.5)])
        self.assertLess(0.1, difference[0]["low"])
        self.assertEqual(self.cells(run)["all", "a"]["reference_minus_this"]["mean"], 0.5)
        self.assertIsNone(self.cells(run)["all", "b"]["reference_minus_this"])
        self.assertEqual([row.best[1] for row in run.tables[0].rows], [False, True, False])  # The oracle does not compete.
        for given in ([["b", "a"]], [{"a": "b", "b": "a"}], {"b": "a"}):
            self.assertEqual(self.run_of(lines, methods=("a", "b", "oracle"), report={"compare": given}).results["compare"], [["b", "a"]])

    def test_strata_have_their_lower_edge(self):
        run = self.run_of(self.lines(), methods=("a", "b", "oracle"), report={"strata": {"by": "inlier_share", "bins": [0.2, "0.7"]}, "compare": {"b": "a"}})
        strata, = run.results["strata"]
        self.assertEqual([(one["name"], one["label"], one["problems"]) for one in strata["bins"]],
                         [("inlier_share below 0.2", "< 0.2", [2]), ("inlier_share 0.2-0.7", "0.2–0.7", [5]), ("inlier_share from 0.7", "≥ 0.7", [1])])
        self.assertEqual([one["accuracies"][0]["mean"] for one in strata["bins"]], [0.5, 0.2, 0.0])
        self.assertEqual([one["accuracies"][0]["low"] is None for one in strata["bins"]], [True, False, True])  # Of fewer than five no interval is told.
        self.assertIsNone(strata["bins"][0]["differences"][0][0]["low"])
        self.assertEqual(strata["unknown"], [0])
        lines = [line for line in written.long_lines(run.results) if line[0] == "inlier_share below 0.2"]
        self.assertEqual(lines[:3], [("inlier_share below 0.2", "all", "a", "mAA@0.5deg", 0.5), ("inlier_share below 0.2", "all", "a", "problems", 2),
                                     ("inlier_share below 0.2", "all", "a", "failures", 0)])
        unknown = self.run_of([("all", "a", 0, {"angle_deg": 1, "inlier_share": 0.5}), ("all", "a", 1, {"angle_deg": 1})], methods=("a",),
                              report={"strata": [{"bins": [0.5]}, {"by": "scene"}]}).results["strata"]
        self.assertEqual((unknown[0]["unknown"], unknown[0]["bins"][1]["problems"], unknown[1]["bins"][0]["name"]), ([1], [1], "scene s"))

    def test_misspelt_keys_are_named(self):
        for report, why in (({"compares": {}}, "config.yaml: report: unknown key 'compares'; did you mean 'compare'"), ({"figures": {"bar": []}}, "figures: unknown key 'bar'"),
                            ({"strata": {"by": "point", "bins": [1]}}, "expected `by`, one of inlier_share, points"), ({"strata": {"bins": [2, 1]}}, "ascending edges")):
            with self.assertRaisesRegex(files.BadInput, why):
                self.run_of(self.lines(), methods=("a", "b", "oracle"), report=report).results

    def test_effects_are_of_the_same_problems_and_combinations(self):
        lines = []
        for i in range(6):
            for name, accuracy, ms in (("x_few", 0, 1), ("x_many", 1, 10), ("y_few", 1, 2), ("y_many", 1, 20)):
                lines.append(("all", name, i, {"angle_deg": 0.01 if accuracy else 9, "ms_total": ms}))
        names = ("x_few", "x_many", "y_few", "y_many")
        report = {"factors": {"order": ["x", "y"], "draws": ["few", "many"]}}
        order, draws = self.run_of(lines, methods=names, report=report).results["effects"]
        self.assertEqual([level["accuracy"][0]["mean"] for level in order["levels"]], [0.5, 0.5])
        self.assertEqual([round(level["milliseconds"][0]["mean"], 9) for level in draws["levels"]], [round(math.sqrt(2), 9), 10])
        order, draws = self.run_of([line for line in lines if line[1] != "y_many"], methods=names, report=report).results["effects"]
        self.assertEqual([level["combinations"] for level in order["levels"] + draws["levels"]], [[2], [1], [2], [1]])
        self.assertEqual(order["levels"][1]["accuracy"][0]["mean"], 1.0)

    def test_the_paper_beside_ours(self):
        paper = {"RANSAC": {"ours": "a", "all": [0.9, 0.03]}, "Other": {"same_data": True, "all": "0.123", "gone": 1}}
        run = self.run_of(self.lines(), methods=("a", "b", "oracle"), report={"paper": paper, "title": "T", "notes": "N"})
        self.assertEqual([(one["paper"], one["ours"]["mean"], one["problems"]) for one in run.results["beside_paper"]], [(0.9, 0.25, 8)])
        rows = {row.cells[0]: row.cells[1] for row in run.tables[0].rows if row.from_paper}
        self.assertEqual(rows, {"RANSAC (paper, other data)": "0.90", "Other (published)": "0.123"})
        self.assertEqual([row.cells[1] for row in run.tables[1].rows if row.from_paper], ["0.03"])
        self.assertEqual((run.title, run.results["experiment_notes"]), ("T", "N"))

    def test_rows_of_fewer_problems_have_their_number(self):
        lines = [line for line in self.lines() if line[1] != "b" or line[2] < 3]
        run = self.run_of(lines, methods=("a", "b", "oracle"))
        self.assertEqual([row.cells[-1] for row in run.tables[0].rows], ["8", "3", "8"])
        self.assertTrue(run.results["conditions"][0]["rows_share_problems"])
        other = self.run_of([line if line[1] != "b" else (*line[:2], line[2] + 4, line[3]) for line in self.lines()], methods=("a", "b", "oracle"))
        self.assertFalse(other.results["conditions"][0]["rows_share_problems"])
        self.assertTrue(any("none is marked as the best" in note for note in other.notes))

    def test_without_truth_inliers_and_chance_are_told(self):
        run = self.run_of([("all", "a", i, {"log10_nfa": 2.0 if i else -2.0}) for i in range(3)], methods=("a",), report={"strata": {"bins": [0.5]}})
        self.assertEqual(run.tables[0].heading, "median number of inliers (no ground truth)")
        self.assertIn("No more inliers than points of no structure would give: A 2 of 3.", run.notes)

    def test_files_that_are_none_are_named(self):
        with self.assertRaisesRegex(files.BadInput, "holds no whole run of diffsac_eval: no run.json"):
            runs.Run(self.folder)
        run = self.run_of(self.lines(), methods=("a", "b"))
        with self.assertRaisesRegex(files.BadInput, "problems.csv:4: run.json has no method 'oracle'"):
            run.problems

    def test_reliability_of_one_network_is_told_once(self):
        bins = [[0, 0, 0]] * 9 + [[4, 3.8, 3]]
        curves = [{"label": label, "condition": 0, "scenes": {"s": bins, "t": [[0, 0, 0]] * 8 + [[2, said, 2], [1, 1.0, 1]]}} for label, said in
                  (("A", 1.7), (reliability.RATIO, 1.8), ("B", 1.7), (reliability.RATIO, 1.9))]
        rows = reliability.table_of(self.run_of(self.lines(), methods=("a", "b", "oracle"), reliability=curves))
        self.assertEqual([row[0] for row in rows if row[2] == "calibration_error"], ["A", reliability.RATIO])
        self.assertIn(["A", "all", "mean", "0.9", "1.0", "5", "0.9750", "0.8750"], rows)
        self.assertEqual(rows[5], ["A", "all", "calibration_error", "", "", "", f"{(0.8 / 4 + 0.3 / 3) / 2:.4f}", ""])

    def test_runs_are_compared(self):
        one = self.run_of(self.lines(), methods=("a", "b", "oracle"))
        other = runs.Run(write_run(self.folder + "2", [(*line[:3], {**line[3], "angle_deg": 0.01}) for line in self.lines()], methods=("a", "b", "oracle")))
        tables, remarks, _ = compare.compare(one, other, "x", "y")
        self.assertEqual(tables[0].rows[0].cells[:4], ["A", "all", "0.250", "1.000"])
        self.assertEqual((tables[0].rows[0].best[4], remarks), (True, []))


class SeedsTest(FolderTest):
    def joined(self, ids_differ):
        for seed, errors in ((1, [0.01, 9.0]), (2, [0.01, 0.01])):
            shift = 10 * seed * ids_differ
            write_run(f"{self.folder}/seed_{seed}", [("all", "a", i + shift, {"angle_deg": error}) for i, error in enumerate(errors)], methods=("a",), seed=seed)
        with open(f"{self.folder}/run.json", "w", encoding="utf-8") as file:
            json.dump({"format": "diffsac runs 1", "experiment": "e", "task": "line", "seeds": [1, 2], "folders": ["seed_1", "seed_2"], "partial": False,
                       "configuration": {"conditions": [{"data": {}}], "report": {}}}, file)
        return runs.Run(self.folder)

    def test_a_problem_of_all_seeds_counts_once(self):
        run = self.joined(False)
        found = self.cells(run)["all", "a"]
        self.assertEqual((found["mAA@0.5deg_ci95"]["mean"], found["metrics"]["mean"]["mAA@0.5deg"], found["metrics"]["mean"]["problems"]), (0.75, 0.75, 4))
        self.assertAlmostEqual(found["metrics"]["mean_seed_deviation"]["mAA@0.5deg"], math.sqrt(2 * 0.25 ** 2))
        self.assertEqual(run.results["setting"], "4 problems, mean of seeds 1, 2")
        self.assertEqual(run.tables[2].heading, "standard deviation over 2 seeds of mAA@0.5deg")
        self.assertEqual(run.facts["facts"]["seconds"], 2.0)
        self.assertEqual([len(run.made.grids[0].index), len(self.joined(True).made.grids[0].index)], [2, 4])

    def test_seeds_of_other_conditions_are_refused(self):
        self.joined(False)
        write_run(f"{self.folder}/seed_2", [("other", "a", 0, {})], methods=("a",), conditions=("other",), seed=2)
        with self.assertRaisesRegex(files.BadInput, "seeds: 1 and 2 have different conditions"):
            runs.Run(self.folder)


class MergeTest(FolderTest):
    def shard(self, number, count=2, **changes):
        """Every count-th of eight problems; estimates of those."""
        folder, own = f"{self.folder}-{number}", range(number - 1, 8, count)
        write_run(folder, [("all", "a", i, {"angle_deg": 0.125 * i, "structures": 1}) for i in own], methods=("a",),
                  **{"shard": {"index": number, "count": count}, "reliability": [{"label": "A", "condition": 0, "scenes": {"s": [[number, 0.5, 1]] * 10}}], **changes})
        with open(folder + "/run.json", encoding="utf-8") as file:
            facts = json.load(file)
        facts["conditions"][0]["problems"] = 8
        with open(folder + "/run.json", "w", encoding="utf-8") as file:
            json.dump(facts, file)
        with h5py.File(folder + "/estimates.h5", "w") as file:
            file.attrs["format"] = "diffsac estimates 1"
            group = file.create_group("a/all")
            group.attrs.update(method="a", condition="all")
            group["index"], group["model"] = np.array(own, np.uint64), np.array([[i, number] for i in own], float)[:, :number]
            group["id"] = [f"p{i}" for i in own]
            group["inliers"], group["inliers_end"] = np.repeat(own, own).astype(np.int32), np.cumsum(own)
            if number == 2:
                group["rows"], group["rows_end"] = np.array([9], np.int32), np.array([0, 1, 1, 1])
            examples = {"examples": [{"condition": 0, "index": i} for i in own][:1], "traces": [{"condition": 0, "index": own[0], "example": 0}]}
            file["examples/json"] = np.frombuffer(json.dumps(examples).encode(), np.int8)
            file["examples/points-0"] = np.full((2, 2), own[0], float)
        return folder

    def test_shards_joined_are_the_whole(self):
        merge.merge([self.shard(2), self.shard(1)], self.folder)
        run = runs.Run(self.folder)
        self.assertEqual(run.problems["index"].tolist(), list(range(8)))
        self.assertEqual(run.problems["angle_deg"].tolist(), [0.125 * i for i in range(8)])
        self.assertEqual((run.facts["shard"], run.facts["machine"], run.facts["facts"]["seconds"]), (None, "m (2 shards)", 2.0))
        self.assertEqual(run.facts["reliability"][0]["scenes"]["s"][0], [3, 1.0, 2])
        estimates = run.estimates[0, 0]
        self.assertEqual([len(estimates.inliers(i)) for i in range(8)], list(range(8)))
        self.assertEqual([estimates.model(i).tolist() for i in (2, 3)], [[2.0], [3.0, 2.0]])
        self.assertEqual([estimates.rows(i).tolist() for i in range(4)], [[], [], [], [9]])
        self.assertEqual((estimates.text("id", 5), run.examples.at.__self__.json["traces"][1]["example"]), ("p5", 1))
        np.testing.assert_array_equal(run.examples.source(1), np.ones((2, 2)))

    def test_shards_that_do_not_belong_together_are_refused(self):
        first = self.shard(1)
        for shards, why in ((lambda: [first], "shard 2/2 is missing; given are 1 of 2"), (lambda: [first, first], "are both shard 1/2"),
                            (lambda: [first, self.shard(2, partial=True)], r"-2 \(shard 2/2\) was interrupted"),
                            (lambda: [first, self.shard(2, 3)], "are parts of different splits"),
                            (lambda: [first, self.shard(2, configuration={"conditions": [{"data": {"n": 1}}]})], "have different configurations: configuration.conditions.0.data.n: None and 1"),
                            (lambda: [first, self.shard(2, setup={"checkpoint": "x", "device": "cpu"})], "were run differently: setup.checkpoint"),
                            (lambda: [first, self.shard(2, dataset="other")], "saw different data"),
                            (lambda: [first, write_run(self.folder + "-2", [])], "is no shard")):
            with self.assertRaisesRegex(files.BadInput, why):
                merge.merge(shards(), self.folder)
        lost = self.shard(2)
        with open(lost + "/problems.csv", encoding="utf-8") as file:
            text = file.read()
        with open(lost + "/problems.csv", "w", encoding="utf-8") as file:
            file.write(text[:text.rindex("\n", 0, -1) + 1])
        with self.assertRaisesRegex(files.BadInput, "method 'a', condition 'all': the shards' records are not the 8 problems, each once"):
            merge.merge([first, lost], self.folder)
        self.assertFalse(os.path.exists(self.folder))


class PointsTest(unittest.TestCase):
    class Estimates:
        """Two planes, z = 0 and x = 0, found in the first two of three points."""

        def rows(self, i):
            return np.array([0, 1])

        def labels(self, i):
            return np.array([1, 0])

        def structures(self, i):
            return np.array([[0, 0, 1.0, 0], [1.0, 0, 0, 0]])

        def value(self, name, i):
            return {"inlier_threshold": 0.1, "points": 2}[name]

    POINTS = np.array([[5, 0, 0.01], [3, 0, 3.0], [0.05, 1, 2], [7, 7, 7], [np.nan, 0, 0]])

    def test_points_that_were_left_out_get_the_nearest_plane(self):
        self.assertEqual(labels.labels_of(self.Estimates(), 0, "ok", self.POINTS, 1.0).tolist(), [1, 0, 2, 0, 0])
        self.assertEqual(labels.labels_of(self.Estimates(), 0, "no_model", self.POINTS, 1.0).tolist(), [0] * 5)

    def test_files_of_labels(self):
        methods = {"a-b": np.array([1, 0, 2, 0, 0], np.int32)}
        used = np.array([1, 1, 0, 0, 0], bool)
        self.assertEqual(labels.labels_csv(self.POINTS[:2], {"a": np.array([1, 0])}, None), "x,y,z,a\n5,0,0.01,1\n3,0,3,0\n")
        header, body = labels.labels_ply(self.POINTS, methods, "a-b", used).split(b"end_header\n")
        self.assertIn(b"element vertex 5\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
                      b"property int label_a_b\nproperty uchar used\n", header)
        self.assertEqual(len(body), 5 * (3 * 8 + 3 + 4 + 1))
        self.assertEqual(body[24:27], bytes.fromhex("0072B2"))
        self.assertEqual(body[32 * 1 + 24:32 * 1 + 27], bytes.fromhex("9AA2AB"))

    def test_digits_follow_the_noise(self):
        one = {"sigma": 0.005, "threshold": 0.02, "largest_coordinate": 500000.0, "models": [np.array([0.6, 0.8, 0.0, -300000.25])], "counts": [7], "points": 9}
        cells, = metric_tables._model_rows(one, ["p"], "A", False, 3)
        self.assertEqual(cells, ["A", "p", "0.6000000000", "0.8000000000", "0.0000000000", "-300000.25", "7", "9", "0.005"])
        cells, = metric_tables._model_rows({**one, "models": [np.zeros(0)], "sigma": math.nan}, ["p"], "A", True, 3)
        self.assertEqual(cells[2:], ["–"] * 6 + ["9", "–"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
