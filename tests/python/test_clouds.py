"""diffsac.open3d and diffsac.register (docs/open3d.md, docs/registration.md). Of Open3D the tests take what is installed: without it those of
clouds are skipped, and classes of the same names and fields stand for its checkers, criteria and options."""

import contextlib
import importlib.util
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
from types import SimpleNamespace

import numpy as np

import diffsac
import diffsac.open3d as registration
from diffsac import register
from test_diffsac import ROTATION, angle_deg

HAS_OPEN3D = importlib.util.find_spec("open3d") is not None
TRANSLATION = np.array([1.0, -2.0, 3.0])


def named(name, **fields):
    """An object of a class that is called so, as Open3D's is."""
    return type(name, (SimpleNamespace,), {})(**fields)


def matches(scale=1.0):
    """300 points of two clouds, of which row i matches row i in 200."""
    random = np.random.default_rng(5)
    first = random.uniform(-3, 3, (300, 3))
    second = scale * first @ ROTATION.T + TRANSLATION + random.normal(0, 0.01, (300, 3))
    second[200:] = random.uniform(-4, 6, (100, 3))
    return first, second


FIRST, SECOND = matches()
SAME = np.repeat(np.arange(300, dtype=np.int32)[:, None], 2, 1)
FEATURES = np.random.default_rng(6).normal(size=(33, 300))
OTHERS = FEATURES + np.random.default_rng(7).normal(0, 0.05, (33, 300))
ABSOLUTE = SimpleNamespace(maximum_correspondence_distance=0.1, use_absolute_scale=True)
FOUR = (
    lambda **more: registration.registration_ransac_based_on_correspondence(FIRST, SECOND, SAME, 0.1, **more),
    lambda **more: registration.registration_ransac_based_on_feature_matching(FIRST, SECOND, FEATURES, OTHERS, True, 0.1, **more),
    lambda **more: registration.registration_fgr_based_on_correspondence(FIRST, SECOND, SAME, ABSOLUTE, **more),
    lambda **more: registration.registration_fgr_based_on_feature_matching(FIRST, SECOND, FEATURES, OTHERS, ABSOLUTE, **more),
)


def digits(result):
    values = (result.transformation, result.fitness, result.inlier_rmse, result.correspondence_set, result.covariance)
    return b"".join(np.asarray(value).tobytes() for value in values).hex()


class TestOpen3D(unittest.TestCase):
    def test_the_four_calls(self):
        for call in FOUR:
            result = call(seed=3)
            self.assertLess(angle_deg(result.transformation[:3, :3], ROTATION), 0.2)
            np.testing.assert_allclose(result.transformation[:, 3], [*TRANSLATION, 1], atol=0.02)
            self.assertGreaterEqual(result.fitness, 200 / 300)
            self.assertEqual(len(np.asarray(result.correspondence_set)), round(300 * result.fitness))
            self.assertLess(result.inlier_rmse, 0.04)
            self.assertIs(result.verdict, diffsac.Verdict.RELIABLE)
            self.assertEqual(result.covariance.shape, (6, 6))
            self.assertIsNone(result.ambiguous_transformation)
        ours = diffsac.estimate_rigid_motion(FIRST, SECOND, max_residual=0.1, confidence=0.999, seed=3)
        np.testing.assert_array_equal(FOUR[0](seed=3).transformation[:3], ours.model)

    def test_the_same_digits_with_1_2_and_8_threads(self):
        for call in FOUR:
            self.assertEqual(len({digits(call(num_threads=count)) for count in (1, 2, 8)}), 1)
        code = "import test_clouds as t; print([t.digits(call()) for call in t.FOUR])"
        outputs = set()
        for count in "128":
            variables = {name: count for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
            path = os.pathsep.join([str(pathlib.Path(__file__).parent), *sys.path])
            outputs.add(subprocess.check_output([sys.executable, "-c", code], env={**os.environ, **variables, "PYTHONPATH": path}))
        self.assertEqual(len(outputs), 1)

    def test_checkers_criteria_and_methods_are_honoured_or_refused_by_name(self):
        edges = named("CorrespondenceCheckerBasedOnEdgeLength", similarity_threshold=0.9)
        near = named("CorrespondenceCheckerBasedOnDistance", distance_threshold=0.05)
        criteria = SimpleNamespace(max_iteration=70, confidence=1.0)
        result = FOUR[0](checkers=[edges, near], criteria=criteria)
        self.assertEqual(result.estimate.stats.iterations, 70)
        self.assertLessEqual(result.estimate.inlier_threshold, 0.05)
        for wrong, name in (
            ({"checkers": [named("CorrespondenceCheckerBasedOnNormal", normal_angle_threshold=0.1)]}, "checkers.*CheckerBasedOnNormal"),
            ({"estimation_method": named("TransformationEstimationPointToPlane")}, "estimation_method.*PointToPlane"),
        ):
            with self.assertRaisesRegex(NotImplementedError, name):
                FOUR[0](**wrong)
        for wrong, name in (({"ransac_n": 2}, "ransac_n"), ({"seed": -1}, "seed"), ({"criteria": SimpleNamespace(max_iteration=0, confidence=0.9)}, "iteration")):
            with self.assertRaisesRegex(ValueError, name):
                FOUR[0](**wrong)
        with self.assertRaisesRegex(ValueError, "corres"):
            registration.registration_ransac_based_on_correspondence(FIRST, SECOND[:9], SAME, 0.1)

    def test_with_scaling_the_motion_is_a_similarity_unless_edges_keep_their_lengths(self):
        scaled = named("TransformationEstimationPointToPoint", with_scaling=True)
        first, second = matches(2.0)
        found = registration.registration_ransac_based_on_correspondence(first, second, SAME, 0.1, scaled)
        self.assertAlmostEqual(np.cbrt(np.linalg.det(found.transformation[:3, :3])), 2.0, places=2)
        edges = named("CorrespondenceCheckerBasedOnEdgeLength", similarity_threshold=0.9)
        none = registration.registration_ransac_based_on_correspondence(first, second, SAME, 0.1, scaled, 3, [edges])
        np.testing.assert_array_equal(none.transformation, np.eye(4))
        self.assertEqual((none.fitness, none.verdict), (0.0, diffsac.Verdict.FAILED))

    def test_fast_global_registration_measures_by_the_clouds_radius_as_its_default(self):
        relative = SimpleNamespace(maximum_correspondence_distance=0.02, use_absolute_scale=False)
        radius = max(np.linalg.norm(side - side.mean(0), axis=1).max() for side in (FIRST, SECOND))
        found = registration.registration_fgr_based_on_correspondence(FIRST, SECOND, SAME, relative)
        ours = diffsac.estimate_rigid_motion(FIRST, SECOND, max_residual=0.02 * radius)
        np.testing.assert_array_equal(found.transformation[:3], ours.model)

    def test_nothing_to_find_is_a_result_of_no_fitness(self):
        for first, second, pairs in ((FIRST, SECOND, SAME[:2]), (FIRST[:0], SECOND[:0], SAME[:0])):
            result = registration.registration_ransac_based_on_correspondence(first, second, pairs, 0.1)
            self.assertEqual((result.fitness, len(np.asarray(result.correspondence_set)), result.verdict.value), (0.0, 0, "failed"))

    def test_matches_of_features_are_the_nearest_and_mutual_where_enough_are(self):
        pairs, ratios = registration.matched(FEATURES, OTHERS[:, :250], False)
        distances = np.linalg.norm(FEATURES.T[:, None] - OTHERS.T[None, :250], axis=2)
        np.testing.assert_array_equal(pairs[:, 1], distances.argmin(1))
        two = np.sort(distances, 1)[:, :2]
        np.testing.assert_allclose(ratios, two[:, 0] / two[:, 1])
        np.testing.assert_array_equal(registration.matched(FEATURES, OTHERS[:, :250], True)[0], SAME[:250])
        self.assertEqual(len(registration.matched(FEATURES, OTHERS[:, :20], True)[0]), 300)

    def test_kiss_matcher_solves_given_matches_and_says_how_sure_it_is(self):
        matcher = registration.KISSMatcher(SimpleNamespace(voxel_size=0.05))
        solution = matcher.prune_and_solve(list(FIRST), list(SECOND))
        self.assertTrue(solution.valid and solution.estimate.reliable)
        self.assertLess(angle_deg(solution.rotation, ROTATION), 0.2)
        self.assertGreaterEqual(matcher.get_num_final_inliers(), 190)
        self.assertFalse(matcher.prune_and_solve(FIRST, np.random.default_rng(1).uniform(-4, 6, (300, 3))).valid)
        with self.assertRaisesRegex(NotImplementedError, "use_quatro"):
            registration.KISSMatcher(SimpleNamespace(voxel_size=0.1, use_quatro=True))

    @unittest.skipUnless(HAS_OPEN3D, "Open3D is not installed")
    def test_results_of_open3d_clouds_are_of_its_class(self):
        import open3d

        theirs, clouds = open3d.pipelines.registration, [registration.as_cloud(side) for side in (FIRST, SECOND)]
        result = registration.registration_ransac_based_on_correspondence(*clouds, open3d.utility.Vector2iVector(SAME), 0.1)
        self.assertIsInstance(result, theirs.RegistrationResult)
        evaluated = theirs.evaluate_registration(*clouds, 0.1, result.transformation)
        self.assertEqual((result.fitness, len(result.correspondence_set)), (evaluated.fitness, len(evaluated.correspondence_set)))
        self.assertAlmostEqual(result.inlier_rmse, evaluated.inlier_rmse)
        self.assertEqual(digits(result), digits(FOUR[0]()))
        self.assertIs(registration.RANSACConvergenceCriteria, theirs.RANSACConvergenceCriteria)


class Program(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)

    def run_it(self, expected, *arguments):
        """What it says on both streams."""
        with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(out):
            try:
                status = register.main([str(one) for one in arguments])
            except SystemExit as error:
                status = error.code
        self.assertEqual(status, expected, out.getvalue())
        return out.getvalue()


class TestMatches(Program):
    def save(self, name, rows, **style):
        np.savetxt(name, rows, fmt="%.17g", **style)
        return name

    def test_each_format_gives_the_same_digits(self):
        rows = np.hstack([FIRST, SECOND])
        np.save("m.npy", rows)
        self.save("m.txt", rows)
        self.save("m.csv", np.roll(rows, 3, axis=1), delimiter=",", header="X2,y2,z2,x1,y1,z1", comments="")
        said = []
        for name in ("m.npy", "m.txt", "m.csv"):
            text = self.run_it(0, "--from-matches", name, "--json", "m.json")
            self.assertRegex(text, r"(?s)rigid motion: 20\d inliers \(67 %\), noise 0.0.*standard deviations.*middle of the inliers")
            told = json.loads(pathlib.Path("m.json").read_text())
            said.append({**told, "file": ""})
        self.assertEqual(said[0], said[1])
        self.assertEqual(said[0], said[2])
        np.testing.assert_allclose(told["rotation"], ROTATION, atol=0.003)
        self.assertEqual((len(told["covariance"]), len(told["inlier_rows"]), told["may_be_chance"]), (6, told["inliers"], False))

    def test_similarities_and_several_motions(self):
        text = self.run_it(0, "--from-matches", self.save("s.txt", np.hstack(matches(2.5))), "--task", "similarity")
        self.assertRegex(text, r"  s = 2\.(49|50)\d*, within")
        rows = np.hstack([FIRST, SECOND])
        rows[200:280, 3:] = rows[200:280, :3] @ ROTATION
        text = self.run_it(0, "--from-matches", self.save("two.txt", rows), "--several", "--json", "two.json")
        self.assertIn("rigid motion 2: 80 matches", text)
        self.assertEqual(len(json.loads(pathlib.Path("two.json").read_text())["motions"]), 2)

    def test_scores_and_ratios_are_told_apart_by_name(self):
        self.save("m.csv", np.c_[np.full(300, 0.25), SECOND, FIRST], delimiter=";", header="score;x2;y2;z2;x1;y1;z1", comments="")
        x, y, quality = register.read_matches("m.csv")
        np.testing.assert_array_equal(x, FIRST)
        self.assertEqual(list(quality), ["scores"])
        self.assertEqual(list(register.read_matches(self.save("r.txt", np.c_[FIRST, SECOND, np.ones(300)]))[2]), ["snn_ratio"])

    def test_the_covariance_told_is_of_the_t_told(self):
        far = np.array([331250.0, 5712480.0, 105.0])
        near = register.estimated(FIRST, SECOND, False, {"max_residual": 0.05}, far)
        there = register.estimated(FIRST + far, SECOND, False, {"max_residual": 0.05})
        near.motion = there.motion
        for one, other in ((near.covariance(far), there.covariance(np.zeros(3))), (near.covariance(-near.middle), there.covariance(-there.middle))):
            self.assertLess(np.linalg.norm(one - other), 0.01 * np.linalg.norm(other))

    def test_no_motion_is_a_status(self):
        for rows in (np.ones((50, 6)), np.full((9, 6), np.nan), np.outer(np.arange(50), np.ones(6)), np.hstack([FIRST, SECOND])[:1]):
            self.assertIn("no motion: ", self.run_it(1, "--from-matches", self.save("none.txt", rows), "--json", "none.json"))
            self.assertNotIn("NaN", pathlib.Path("none.json").read_text())

    def test_mistakes_name_the_file_or_option(self):
        pathlib.Path("empty.txt").write_text("")
        pathlib.Path("word.txt").write_text("1 2 3 four 5 6\n")
        pathlib.Path("broken.npy").write_text("text")
        self.save("five.txt", np.ones((9, 5)))
        self.save("ratio.txt", np.full((9, 7), 1.5))
        self.save("m.txt", np.ones((9, 6)))
        for said, arguments in (
            ("empty.txt: expected rows", ["empty.txt"]), ("word.txt: .*'four'", ["word.txt"]), ("five.txt: expected rows", ["five.txt"]),
            ("broken.npy: ", ["broken.npy"]), ("none.txt", ["none.txt"]), ("ratio", ["ratio.txt"]), ("m.txt: is an input", ["m.txt", "--json", "m.txt"]),
            ("voxel: is not for", ["m.txt", "--voxel", "1"]), ("several", ["m.txt", "--several", "--task", "similarity"]),
            ("max_distance: expected a number above 0", ["m.txt", "--max-distance", "0"]),
        ):
            self.assertRegex(self.run_it(2, "--from-matches", *arguments), said)
        self.assertIn("two scans", self.run_it(2))

    def test_a_pose_graph_fits_its_edges_and_has_a_group_for_each_scan_that_none_connects(self):
        def motion(degrees, translation):
            angle = np.radians(degrees)
            turned = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
            return registration.matrix(np.column_stack([turned, translation]))

        poses = [motion(20 * i, [i, 2 * i, 3]) for i in range(4)]
        scans = [SimpleNamespace(name=f"scan{i}.ply") for i in range(4)]

        def pair(i, j, inliers, chance=False):
            estimate = SimpleNamespace(pose_covariance=np.diag([1.0, 2, 3, 4, 5, 6]), may_be_chance=chance, num_inliers=inliers)
            return i, j, register.Found(9, estimate, np.linalg.inv(poses[j]) @ poses[i], np.zeros(3), np.zeros(3))

        pairs = [pair(0, 1, 5), pair(0, 2, 50), pair(1, 2, 40), pair(0, 3, 60, True)]
        lines = [line.split() for line in register.pose_graph(scans, pairs).splitlines()]
        kinds = [line[0] for line in lines]
        self.assertEqual([kinds.count(kind) for kind in ("VERTEX_SE3:QUAT", "EDGE_SE3:QUAT", "FIX")], [4, 3, 2])
        vertices = [np.array(line[2:], float) for line in lines if line[0].startswith("VERTEX")]
        np.testing.assert_allclose(vertices[2][:3], (np.linalg.inv(poses[0]) @ poses[2])[:3, 3], atol=1e-9)
        edge = np.array(next(line for line in lines if line[0].startswith("EDGE"))[3:], float)
        # About the origin errors of g2o's are (t, half a turn) in the first scan's frame.
        R, upper = pairs[0][2].motion[:3, :3], np.zeros((6, 6))
        upper[np.triu_indices(6)] = edge[7:]
        np.testing.assert_allclose(upper[:3, :3], np.triu(R.T @ np.diag([1 / 4, 1 / 5, 1 / 6]) @ R), atol=1e-9)
        np.testing.assert_allclose(upper[3:, 3:], np.triu(4 * R.T @ np.diag([1, 1 / 2, 1 / 3]) @ R), atol=1e-9)


@unittest.skipUnless(HAS_OPEN3D, "Open3D is not installed")
class TestClouds(Program):
    def room(self, name, seed, scanner, low, high, turn=np.eye(3)):
        """What a scanner sees of twenty boxes around it, in its frame; other seeds draw other points of them."""
        boxes, places, points = np.random.default_rng(1), np.random.default_rng(seed), []
        for _ in range(20):
            centre, half = boxes.normal(size=3), boxes.uniform(0.2, 0.6, 3)
            centre *= boxes.uniform(2, 3) / np.linalg.norm(centre)
            axes = np.linalg.qr(boxes.normal(size=(3, 3)))[0]
            on, face = places.uniform(-1, 1, (2000, 3)), places.integers(0, 3, 2000)
            rows = np.arange(2000)
            on[rows, face] = np.sign(on[rows, face])
            at = centre + (on * half) @ axes.T
            seen = on[rows, face] * (axes.T[face] * (scanner - at)).sum(1) > 0
            points.append(at[seen & (at[:, 0] > low) & (at[:, 0] < high)])
        np.savetxt(name, (np.vstack(points) - scanner) @ turn.T)
        return name

    def test_two_scans_and_a_folder_of_them(self):
        os.mkdir("scans")
        scanners = [np.array([0.3, 0.1, 0]), np.array([-0.3, 0, 0.1]), np.array([0, 0.3, 0])]
        a = self.room("scans/a.xyz", 1, scanners[0], -9, 1.5)
        b = self.room("scans/b.xyz", 2, scanners[1], -1.5, 9, ROTATION)
        self.room("scans/c.xyz", 3, scanners[2], -2.5, 2, ROTATION.T)
        text = self.run_it(0, a, b, "--voxel", 0.08, "--json", "ab.json", "--output", "ab.ply")
        self.assertRegex(text, r"(?s)voxel: 0.08\na.xyz: .*rigid motion: .*overlap: .*moved: ab.ply")
        self.assertNotIn("warning", text)
        told = json.loads(pathlib.Path("ab.json").read_text())
        self.assertLess(angle_deg(np.array(told["rotation"]), ROTATION), 1)
        np.testing.assert_allclose(told["translation"], ROTATION @ (scanners[0] - scanners[1]), atol=0.05)
        self.run_it(0, "ab.ply", b, "--voxel", 0.08, "--json", "moved.json", "--output", "")
        self.assertLess(np.abs(json.loads(pathlib.Path("moved.json").read_text())["translation"]).max(), 0.05)
        self.assertIn("3 of 3 pairs are edges", self.run_it(0, "scans", "--voxel", 0.08, "--output", "graph"))
        self.assertEqual(len(pathlib.Path("graph/registrations.csv").read_text().splitlines()), 4)
        self.assertIn("is there already", self.run_it(2, "scans", "--output", "graph"))

    def test_clouds_without_a_motion_and_files_that_are_none(self):
        b = self.room("b.xyz", 2, np.zeros(3), -1.5, 9)
        np.savetxt("line.xyz", np.outer(np.arange(200), [1, 0, 0]))
        self.assertIn("no motion: ", self.run_it(1, "line.xyz", b, "--voxel", 0.08, "--output", "none.ply"))
        self.assertFalse(os.path.exists("none.ply"))
        open3d = registration.open3d()
        open3d.io.write_point_cloud("whole.ply", registration.as_cloud(FIRST))
        pathlib.Path("cut.ply").write_bytes(pathlib.Path("whole.ply").read_bytes()[:3000])
        pathlib.Path("text.txt").write_text("text")
        os.mkdir("few")
        for said, arguments in (("no.ply", ["no.ply", b]), ("cut.ply: no points", ["cut.ply", b]), ("text.txt: no points", ["text.txt", b]),
                                ("too small", [b, b, "--voxel", "1e-12"]), ("two clouds or more", ["few"]), ("nowhere", ["nowhere"])):
            self.assertIn(said, self.run_it(2, *arguments, *(["--output", "out"] if len(arguments) == 1 else ["--output", ""])))


if __name__ == "__main__":
    unittest.main()
