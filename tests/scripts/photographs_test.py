"""scripts/report/photographs.py over what diffsac_pair leaves. photographs_test.py BUILD SOURCE: status 4 where modules are missing."""
import json
import os
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(sys.argv[2], "scripts", "report"))
try:
    import h5py
    import numpy as np

    import html_page
    import photographs
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(4)


def pair_of(name1, name2, focal=None, **facts):
    """focal: of either image px, low, high, source."""
    pair = {"pair": f"{name1}-{name2}", "image1": name1, "image2": name2, "names": [name1, name2], "status": "ok", "may_be_chance": False,
            "sure": True, "degeneracy": "determined", "task": "two_focals", "matches": 4, "inliers": [0, 2], "size1": [40, 30],
            "size2": None, "camera1": 1, "camera2": 2, "focal": None, "focal_conflict": None, "model": [1.0] * 9,
            "pose": {"q": [1.0, 0.0, 0.0, 0.0], "t": None}, "sigma_px": 0.5, "hypotheses": 9, "ms": {"estimate": 1.5}}
    if focal:
        pair["focal"] = {key: [one[i] for one in focal] for i, key in enumerate(("px", "low_px", "high_px", "source"))}
    return {**pair, **facts}


class PhotographsTest(unittest.TestCase):
    def test_pairs_by_verdict_and_cameras_with_intervals(self):
        guess = [(900, 600, 1300, "prior")] * 2
        pairs = [pair_of("b", "c", [(800, 780, 822, "pairs"), (650.4, 600, 700, "matches")], degeneracy="plane", inliers=list(range(70))),
                 pair_of("a", "b", guess, may_be_chance=True, sure=False, camera2=1),
                 pair_of("a", "c", status="no_model", sure=False)]
        table = photographs.pairs_table(pairs)
        self.assertEqual([row.cells[2] for row in table.rows], ["sure", "may be chance", "no model"])
        self.assertEqual(table.rows[0].cells[3:], ["no: one plane", "70", "4", "1", "800 [780, 822]", "pairs", "2", "650 [600, 700]", "matches"])
        cameras = photographs.cameras_table(pairs)
        self.assertEqual([row.cells for row in cameras.rows],
                         [["1", "2", "800 [780, 822]", "pairs", "1", "a, b"], ["2", "1", "650 [600, 700]", "matches", "1", "c"]])
        self.assertTrue(all(html_page.number_of(row.cells[2]) for row in cameras.rows))  # So that the page sorts by them.

    def test_a_calibration_has_no_cameras_to_find(self):
        pairs = [pair_of("a", "b", camera1=None, camera2=None)]
        pairs[0]["focal"] = {"px": [300, 300], "source": ["given", "given"]}
        self.assertIsNone(photographs.cameras_table(pairs))
        self.assertEqual(photographs.pairs_table(pairs).rows[0].cells[-2:], ["300", "300"])

    def test_a_page_has_every_pair_with_its_matches(self):
        with tempfile.TemporaryDirectory() as folder:
            os.makedirs(os.path.join(folder, "matches", "photos"))
            with h5py.File(os.path.join(folder, "matches", "photos", "matches.h5"), "w") as file:
                for name in ("a-b", "b-c"):
                    file[name] = np.arange(16.0).reshape(4, 4)
            run = {"name": "photos</script>", "task": "two_focals", "method": "none", "seed": 3, "partial": True, "version": "v", "machine": "m",
                   "matches": "matches/photos", "pairs": [pair_of("a", "b"), pair_of("b", "c", may_be_chance=True, sure=False)]}
            with open(os.path.join(folder, "pairs.json"), "w", encoding="utf-8") as file:
                json.dump(run, file)
            photographs.write_page(folder)
            with open(os.path.join(folder, "report.html"), encoding="utf-8") as file:
                html = file.read()
        for text in ("Cameras and verdicts", "Partial results", 'id="points-1"', 'id="masks-1"', '"ok, may be chance"', "guidance none, seed 3"):
            self.assertIn(text, html)
        self.assertNotIn("photos</script>", html)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
