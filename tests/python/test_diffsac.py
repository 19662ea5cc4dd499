"""The installed module diffsac. DIFFSAC_CPP_ESTIMATES: estimates.cpp of tests/integration/consumer, built; scripts/test_python.sh makes both."""

import contextlib
import importlib.metadata
import importlib.util
import inspect
import io
import os
import pathlib
import pickle
import re
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import diffsac
from diffsac._calls import ARGUMENTS

K = np.array([[600.0, 0, 320], [0, 600, 240], [0, 0, 1]])
ANGLE = 0.1
ROTATION = np.array([[np.cos(ANGLE), 0, np.sin(ANGLE)], [0, 1, 0], [-np.sin(ANGLE), 0, np.cos(ANGLE)]])
TRANSLATION = np.array([1.0, 0.1, 0.2]) / np.linalg.norm([1.0, 0.1, 0.2])
SIZE = (640, 480)
ROOT = pathlib.Path(__file__).resolve().parents[2]


def project(points):
    image = points @ K.T
    return image[:, :2] / image[:, 2:]


class Scene:
    """200 points, half of them on a plane, before two cameras; every fourth match is wrong."""

    def __init__(self, noise=0.3):
        random = np.random.default_rng(1)
        n = 200
        self.points3d = np.c_[random.uniform(-2, 2, n), random.uniform(-1.5, 1.5, n), random.uniform(4, 8, n)]
        self.points3d[: n // 2, 2] = 5.0 + 0.3 * self.points3d[: n // 2, 0]
        self.wrong = np.arange(n) % 4 == 0
        self.x1 = project(self.points3d) + noise * random.normal(size=(n, 2))
        self.x2 = project(self.points3d @ ROTATION.T + TRANSLATION) + noise * random.normal(size=(n, 2))
        self.x2[self.wrong] = random.uniform((0, 0), SIZE, (self.wrong.sum(), 2))
        self.ratio = np.where(self.wrong, 0.9, 0.5)


# A room seen by a camera that is turned and looks up by 8 degrees: columns are its directions in the camera's frame.
TURN, PITCH = np.radians(40), np.radians(8)
ROOM = np.array([[1, 0, 0], [0, np.cos(PITCH), np.sin(PITCH)], [0, -np.sin(PITCH), np.cos(PITCH)]]) @ np.array(
    [[np.cos(TURN), 0, np.sin(TURN)], [0, 1, 0], [-np.sin(TURN), 0, np.cos(TURN)]]
)


def room_segments():
    """40 segments of each direction, and 40 of none."""
    random = np.random.default_rng(5)
    start = np.c_[random.uniform(-2, 2, 160), random.uniform(-1.5, 1.5, 160), random.uniform(4, 7, 160)]
    along = np.repeat(ROOM.T, 40, axis=0) * random.uniform(0.5, 1.5, (120, 1))
    ends = start + np.r_[along, np.c_[0.4 * random.normal(size=(40, 2)), np.zeros(40)]]
    return np.c_[project(start), project(ends)] + 0.2 * random.normal(size=(160, 4))


def angle_deg(a, b):
    return np.degrees(np.arccos(np.clip((np.trace(a @ b.T) - 1) / 2, -1, 1)))


class TestEstimates(unittest.TestCase):
    def setUp(self):
        self.scene = Scene()

    def essential(self, **options):
        s = self.scene
        return diffsac.estimate_essential(s.x1, s.x2, K, K, s.ratio, **options)

    def test_essential_finds_pose_and_inliers(self):
        for guidance in ("diffusion", "network", "none"):
            estimate = self.essential(guidance=guidance)
            self.assertTrue(estimate.ok)
            self.assertIs(estimate.status, diffsac.Status.OK)
            self.assertEqual(estimate.status, "ok")
            self.assertIs(estimate.verdict, diffsac.Verdict.RELIABLE)
            self.assertLess(angle_deg(estimate.pose.rotation, ROTATION), 0.3)
            self.assertGreater(estimate.pose.translation @ TRANSLATION, 0.999)
            self.assertEqual(estimate.inliers.dtype, np.bool_)
            self.assertEqual(estimate.num_inliers, estimate.inliers.sum())
            self.assertGreater(estimate.inliers[~self.scene.wrong].mean(), 0.9)
            self.assertEqual(estimate.pose_covariance.shape, (6, 6))
            self.assertLess(estimate.diagnostics.cheirality_failure_ratio, 0.05)
            self.assertGreater(estimate.stats.hypotheses, 0)
        self.assertIsNone(estimate.inlier_probabilities)

    def test_translation_that_is_not_determined(self):
        """σ of t was a few degrees where the camera only turned."""
        s = self.scene
        self.assertIs(self.essential().diagnostics.degeneracy, diffsac.Degeneracy.DETERMINED)
        turned = np.c_[s.x1, np.ones(len(s.x1))] @ np.linalg.inv(K).T @ ROTATION.T @ K.T
        turned = turned[:, :2] / turned[:, 2:] + np.random.default_rng(1).normal(0, 0.5, s.x1.shape)
        estimate = diffsac.estimate_essential(s.x1, turned, K, K)
        self.assertIs(estimate.diagnostics.degeneracy, diffsac.Degeneracy.PURE_ROTATION)
        self.assertEqual(estimate.diagnostics.degeneracy, "pure_rotation")
        self.assertEqual(estimate.verdict, "rotation_only")
        self.assertIsNone(estimate.pose_covariance)
        np.testing.assert_array_equal(estimate.pose.translation, np.zeros(3))
        self.assertLess(angle_deg(estimate.pose.rotation, ROTATION), 0.2)
        self.assertIs(diffsac.estimate_essential(s.x1, s.x1, K, K).diagnostics.degeneracy, diffsac.Degeneracy.STATIC)
        self.assertIs(diffsac.estimate_fundamental(s.x1, turned).diagnostics.degeneracy, diffsac.Degeneracy.PLANE)

    def test_model_is_row_by_row(self):
        estimate = self.essential()
        t = estimate.pose.translation
        cross = np.array([[0, -t[2], t[1]], [t[2], 0, -t[0]], [-t[1], t[0], 0]])
        expected, model = cross @ estimate.pose.rotation, estimate.model
        model = model * np.sign((model * expected).sum()) * np.linalg.norm(expected) / np.linalg.norm(model)
        np.testing.assert_allclose(model, expected, atol=1e-9)

    def test_absolute_pose(self):
        s = self.scene
        estimate = diffsac.estimate_absolute_pose(s.points3d, s.x2, K)
        self.assertLess(angle_deg(estimate.pose.rotation, ROTATION), 0.3)
        np.testing.assert_array_equal(estimate.model, np.c_[estimate.pose.rotation, estimate.pose.translation])
        self.assertEqual(estimate.diagnostics.cheirality_failure_ratio, 0.0)
        self.assertIsNone(estimate.ambiguous_pose)
        self.assertTrue(estimate.reliable)
        self.assertIsNone(diffsac.estimate_absolute_pose(s.points3d[:2], s.x2[:2], K).pose)

    def test_planar_target_far_away_has_two_poses(self):
        x, y = np.meshgrid(np.linspace(-0.5, 0.5, 6), np.linspace(-0.5, 0.5, 6))
        target = np.c_[x.ravel(), y.ravel(), np.zeros(36)]
        c, s = np.cos(0.6), np.sin(0.6)
        seen = target @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).T + [0, 0, 50]
        image = seen[:, :2] / seen[:, 2:] * 600 + [320, 240] + np.random.default_rng(0).normal(0, 0.3, (36, 2))
        estimate = diffsac.estimate_absolute_pose(target, image, K)
        self.assertIs(estimate.verdict, diffsac.Verdict.AMBIGUOUS)
        self.assertGreater(angle_deg(estimate.pose.rotation, estimate.ambiguous_pose.rotation), 20)
        self.assertIsNone(estimate.pose_covariance)

    def test_motions_between_clouds(self):
        x = self.scene.points3d
        noise = np.random.default_rng(3).normal(0, 0.01, x.shape)
        y = x @ ROTATION.T + [1, 2, 3] + noise
        y[::4] = np.roll(x, 7, axis=0)[::4]
        rigid = diffsac.estimate_rigid_motion(x, y, max_residual=0.05)
        self.assertLess(angle_deg(rigid.pose.rotation, ROTATION), 0.1)
        np.testing.assert_array_equal(rigid.model, np.c_[rigid.pose.rotation, rigid.pose.translation])
        self.assertEqual(rigid.pose_covariance.shape, (6, 6))
        self.assertTrue(rigid.reliable)
        similar = diffsac.estimate_similarity(x, 2.5 * y, max_residual=0.125)
        self.assertLess(abs(similar.scale - 2.5), 0.01)
        self.assertEqual(similar.pose_covariance.shape, (7, 7))
        self.assertLess(np.abs(similar.pose.translation - 2.5 * rigid.pose.translation).max(), 0.05)
        # None given: twice the resolution.
        self.assertLess(angle_deg(diffsac.estimate_rigid_motion(x, y).pose.rotation, ROTATION), 1.0)

    def test_focal_lengths(self):
        s = self.scene
        shared = diffsac.estimate_shared_focal(s.x1, s.x2, s.ratio, size1=SIZE, size2=SIZE)
        self.assertLess(abs(shared.focal.focal_px[0] / 600 - 1), 0.1)
        self.assertEqual(shared.K1[0, 0], shared.focal.focal_px[0])
        self.assertIsNone(shared.pose_covariance)
        one = diffsac.estimate_one_focal(
            s.x1, s.x2, K, s.ratio, principal_point1=(320, 240), principal_point2=(320, 240), prior=(650, 0.2)
        )
        self.assertEqual(one.focal.prior_focal_px[1], 650)
        self.assertLess(abs(one.focal.focal_px[1] / 600 - 1), 0.1)
        two = diffsac.estimate_two_focals(s.x1, s.x2, s.ratio, size1=SIZE, size2=SIZE, prior=(620, 0.1), prior2=(580, 0.1))
        self.assertEqual(two.focal.prior_focal_px, (620, 580))
        self.assertEqual((two.K1[0, 0], two.K2[0, 0]), two.focal.focal_px)

    def test_several(self):
        t = np.arange(40.0)
        lines = diffsac.estimate_multiple_lines(np.r_[np.c_[t, 0.5 * t + 1], np.c_[t, 30 - t]], 0.1)
        self.assertTrue(lines.ok)
        self.assertEqual(lines.models.shape, (2, 3))
        self.assertEqual(set(lines.assignment), {1, 2})
        grid = np.stack(np.meshgrid(np.arange(9.0), np.arange(9.0)), -1).reshape(-1, 2)
        planes = diffsac.estimate_multiple_planes(np.r_[np.c_[grid, 0 * grid[:, 0]], np.c_[0 * grid[:, 0] - 3, grid]], 0.1)
        self.assertEqual(planes.models.shape, (2, 4))
        nothing = diffsac.estimate_multiple_homographies(self.scene.x1[:6], self.scene.x2[:6])
        self.assertFalse(nothing.ok)
        self.assertEqual(nothing.models.shape, (0, 3, 3))

    def test_vanishing_points(self):
        segments = room_segments()
        estimate = diffsac.estimate_vanishing_points(segments, K)
        self.assertTrue(estimate.ok)
        self.assertEqual(estimate.points.shape, (3, 3))
        self.assertEqual(estimate.values.shape, (3,))
        self.assertEqual(estimate.assignment.shape, (len(segments),))
        np.testing.assert_allclose(np.abs(estimate.directions @ ROOM).max(axis=0), 1, atol=1e-3)
        self.assertIsNone(estimate.focal)
        self.assertAlmostEqual(estimate.horizon.pitch_deg, 8, delta=0.5)
        self.assertEqual(len(estimate.horizon.horizontal), 2)
        unknown = diffsac.estimate_vanishing_points(segments, size=SIZE)
        self.assertLess(abs(unknown.focal.focal_px / 600 - 1), 0.05)
        self.assertEqual(unknown.K[0, 0], unknown.focal.focal_px)
        self.assertEqual(unknown.focal.orthogonal, (0, 1, 2))
        plain = diffsac.estimate_vanishing_points(segments, K, guidance="none")
        self.assertIsNone(plain.values)
        few = diffsac.estimate_vanishing_points(segments[:1], size=SIZE)
        self.assertIs(few.status, diffsac.Status.TOO_FEW_POINTS)
        self.assertEqual(few.points.shape, (0, 3))
        self.assertIsNone(few.directions)
        self.assertIsNone(few.horizon)

    def test_inputs_of_any_layout_and_type_are_the_same(self):
        s = self.scene
        x1, x2 = np.round(s.x1), np.round(s.x2)
        expected = diffsac.estimate_fundamental(x1, x2, s.ratio)
        both = np.hstack([x1, x2])
        for a, b in (
            (x1.tolist(), x2.tolist()),
            (both[:, :2], both[:, 2:]),
            (np.asfortranarray(x1), np.asfortranarray(x2)),
            (x1.astype(np.float32), x2.astype(np.int32)),
            (x1.astype(">f8"), x2.astype(np.float32)),
        ):
            np.testing.assert_array_equal(diffsac.estimate_fundamental(a, b, s.ratio).model, expected.model)

    def test_arrays_of_float64_are_not_copied(self):
        """Resident memory would grow by that of a copy: rows of the arrays, 1.6 GB, are read in place."""
        script = """
import resource, numpy, diffsac
points = numpy.zeros((20_000_000, 10))[:, 2:4]  # Not touched, so of no memory yet.
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    diffsac.estimate_homography(points, points, numpy.full(3, 0.5))
except ValueError:
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
        self.assertLess(int(done.stdout), 100_000)

    def test_initial_model_and_budget(self):
        s = self.scene
        truth = self.essential().model
        for x in (s.x1, np.asfortranarray(s.x1)):
            estimate = diffsac.estimate_essential(x, s.x2, K, K, max_iterations=1, initial_model=truth, guidance="none")
            self.assertGreater(estimate.num_inliers, 130)
        self.assertGreaterEqual(self.essential(min_iterations=900).stats.iterations, 900)
        loose = self.essential(min_iterations=1, confidence=0.5, guidance="none").stats.iterations
        self.assertLess(loose, self.essential(min_iterations=1, confidence=1 - 1e-8, guidance="none").stats.iterations)

    def test_same_seed_same_result(self):
        first, again, other = self.essential(seed=5), self.essential(seed=5), self.essential(seed=6)
        np.testing.assert_array_equal(first.model, again.model)
        self.assertFalse(np.array_equal(first.model, other.model))

    def test_results_can_be_pickled(self):
        estimate = self.essential()
        copy = pickle.loads(pickle.dumps(estimate))
        np.testing.assert_array_equal(copy.inliers, estimate.inliers)
        self.assertIs(copy.status, diffsac.Status.OK)
        self.assertTrue(copy.ok)

    def test_other_threads_run_during_an_estimate(self):
        points = np.random.default_rng(3).uniform(0, 1, (20000, 2))
        started, finished = threading.Event(), threading.Event()

        def estimate():
            started.set()
            diffsac.estimate_multiple_lines(points, 0.001, max_iterations=20000)
            finished.set()

        # With the GIL held, nothing of this thread would run between the start of the estimate and its end, once it is
        # switched away from; sleeping gives it every chance to be.
        thread = threading.Thread(target=estimate)
        thread.start()
        started.wait()
        ran = 0
        while not finished.is_set():
            time.sleep(0.001)
            ran += not finished.is_set()
        thread.join()
        self.assertGreater(ran, 3)

    @unittest.skipUnless(hasattr(os, "fork"), "there is no fork here")
    def test_a_forked_process_estimates(self):
        expected = self.essential().num_inliers
        child = os.fork()
        if child == 0:
            os._exit(0 if self.essential().num_inliers == expected else 1)
        self.assertEqual(os.waitpid(child, 0)[1], 0)

    def test_version_is_the_packages(self):
        self.assertEqual(diffsac.__version__, importlib.metadata.version("diffsac"))


class TestMistakes(unittest.TestCase):
    def setUp(self):
        self.scene = Scene()

    def refused(self, text, call, *arguments, **options):
        with self.assertRaises(ValueError) as context:
            call(*arguments, **options)
        self.assertIn(text, str(context.exception))

    def test_shapes(self):
        s, essential = self.scene, diffsac.estimate_essential
        self.refused("x1: expected shape (N, 2), got (200, 3)", essential, s.points3d, s.x2, K, K)
        self.refused("x1: expected shape (N, 2), got (200,)", essential, s.ratio, s.x2, K, K)
        self.refused("x2: expected shape (200, 2), got (7, 2)", essential, s.x1, s.x2[:7], K, K)
        self.refused("K1: expected shape (3, 3), got (2, 3)", essential, s.x1, s.x2, K[:2], K)
        self.refused("K2: expected shape (3, 3), got (3, 2)", essential, s.x1, s.x2, K, K[:, :2])
        self.refused("snn_ratio: expected shape (200,), got (5,)", essential, s.x1, s.x2, K, K, s.ratio[:5])
        self.refused("points2d: expected shape (200, 2)", diffsac.estimate_absolute_pose, s.points3d, s.x2[1:], K)
        self.refused("points: expected shape (N, 3), got (200, 2)", diffsac.estimate_plane, s.x1, 1.0)
        self.refused("points: expected shape (N, 2), got ()", diffsac.estimate_line, 5.0, 1.0)

    def test_types(self):
        s = self.scene
        for array, dtype in (
            (s.x1.astype(complex), "complex128"),
            (s.x1.astype(str), "<U"),
            (s.x1.astype(object), "object"),
            (s.x1 > 100, "bool"),
        ):
            self.refused("x1: expected real numbers, got dtype " + dtype, diffsac.estimate_fundamental, array, s.x2)

    def test_options(self):
        s = self.scene
        self.refused("max_residual: expected", diffsac.estimate_line, s.x1, 0.0)
        self.refused("max_iterations: expected", diffsac.estimate_fundamental, s.x1, s.x2, max_iterations=-1)
        self.refused("max_residual: expected", diffsac.estimate_fundamental, s.x1, s.x2, max_residual=np.nan)
        self.refused("confidence: expected", diffsac.estimate_fundamental, s.x1, s.x2, confidence=1.0)
        self.refused("initial_model: expected 3 x 3", diffsac.estimate_fundamental, s.x1, s.x2, initial_model=np.eye(4))
        self.refused("size: expected the image's size, or K", diffsac.estimate_vanishing_points, room_segments())
        self.refused("segments: expected shape (N, 4), got (200, 2)", diffsac.estimate_vanishing_points, s.x1, K)
        self.refused("least_value: expected", diffsac.estimate_vanishing_points, room_segments(), K, least_value=2)
        self.refused("size1: expected", diffsac.estimate_shared_focal, s.x1, s.x2)
        self.refused("size2: expected (width, height) of the image", diffsac.estimate_fundamental, s.x1, s.x2, size2=(320, 240))

    def test_bad_data_is_a_status(self):
        s = self.scene
        few = diffsac.estimate_fundamental(s.x1[:3], s.x2[:3], s.ratio[:3])
        self.assertIs(few.status, diffsac.Status.TOO_FEW_POINTS)
        np.testing.assert_array_equal(few.model, np.zeros((3, 3)))
        self.assertIs(diffsac.estimate_line(np.empty((0, 2)), 1.0).status, diffsac.Status.TOO_FEW_POINTS)
        flat = diffsac.estimate_essential(s.x1, np.zeros((200, 2)), K, K, s.ratio)
        self.assertIs(flat.status, diffsac.Status.DEGENERATE)
        self.assertIsNone(flat.pose)

    def test_trouble_mask_of_length_0(self):
        x = np.zeros((8, 2))
        several, vanishing = diffsac.estimate_multiple_homographies(x, x), diffsac.estimate_vanishing_points(np.zeros((8, 4)), K)
        for estimate, labels in (
            (one := diffsac.estimate_fundamental(x, x), one.inliers),
            (several, several.assignment),
            (vanishing, vanishing.assignment),
        ):
            self.assertIs(estimate.status, diffsac.Status.DEGENERATE)
            self.assertEqual(labels.shape, (8,))
            self.assertFalse(labels.any())
            self.assertEqual(getattr(estimate, "diagnostics", estimate).num_duplicates, 7)

    def test_trouble_repeated_rows_are_one(self):
        s = self.scene
        once = diffsac.estimate_essential(s.x1, s.x2, K, K, s.ratio)
        thrice = diffsac.estimate_essential(*(np.repeat(x, 3, 0) for x in (s.x1, s.x2)), K, K, np.repeat(s.ratio, 3))
        np.testing.assert_array_equal(thrice.model, once.model)
        np.testing.assert_array_equal(thrice.pose_covariance, once.pose_covariance)
        np.testing.assert_array_equal(thrice.inliers, np.repeat(once.inliers, 3))
        self.assertEqual(thrice.diagnostics.log10_nfa, once.diagnostics.log10_nfa)
        self.assertEqual((once.diagnostics.num_duplicates, thrice.diagnostics.num_duplicates), (0, 400))

    def test_trouble_masked_rows_are_left_out(self):
        points = np.ma.array([[0, 0], [1, 0], [2, 0], [3, 0], [0, 9], [1, 8], [2, 7], [3, 6], [4, 5], [5, 4]])
        points[4:] = np.ma.masked
        estimate = diffsac.estimate_line(points, 0.1)
        np.testing.assert_allclose(np.abs(estimate.model), [0, 1, 0], atol=1e-9)
        np.testing.assert_array_equal(estimate.inliers, np.arange(10) < 4)
        self.assertEqual(estimate.diagnostics.num_nonfinite, 6)

    def test_what_is_masked_or_not_finite_anywhere_is_left_out_alike(self):
        s = self.scene
        rows = np.array([3, 50, 51])
        broken = s.x2.copy()
        broken[rows, 1] = np.nan
        expected = diffsac.estimate_essential(s.x1, broken, K, K, s.ratio)
        self.assertEqual(expected.diagnostics.num_nonfinite, 3)
        self.assertFalse(expected.inliers[rows].any())

        def masked(array):
            result = np.ma.array(array)
            result[rows] = np.ma.masked
            return result

        for x1, x2, ratio, options in (
            (masked(s.x1), s.x2, s.ratio, {}),
            (s.x1, masked(s.x2), s.ratio, {}),
            (s.x1, s.x2, masked(s.ratio), {}),
        ):
            estimate = diffsac.estimate_essential(x1, x2, K, K, ratio, **options)
            np.testing.assert_array_equal(estimate.model, expected.model)
            np.testing.assert_array_equal(estimate.inliers, expected.inliers)
            self.assertEqual(estimate.diagnostics.num_nonfinite, 3)
        pose = diffsac.estimate_absolute_pose(s.points3d, s.x2, K, masked(s.ratio))
        self.assertEqual(pose.diagnostics.num_nonfinite, 3)

    def test_trouble_calibrations(self):
        s = self.scene
        one = diffsac.estimate_essential(s.x1, s.x2, K, K)
        twice = diffsac.estimate_essential(s.x1, s.x2, 2 * K, 2 * K)
        np.testing.assert_array_equal(twice.model, one.model)
        np.testing.assert_array_equal(twice.inliers, one.inliers)
        refused = ": expected a calibration matrix (fx s cx, 0 fy cy, 0 0 1), but "
        self.refused("K1" + refused + "its last column is 0 0 1: it is transposed",
                     diffsac.estimate_essential, s.x1, s.x2, K.T, K.T)  # fmt: skip
        self.refused("K2" + refused + "a value of it is not finite",
                     diffsac.estimate_multiple_essentials, s.x1, s.x2, K, np.nan * K)  # fmt: skip
        self.refused("K" + refused + "its fy is below 0", diffsac.estimate_absolute_pose, s.points3d, s.x2,
                     K * [[1], [-1], [1]])  # fmt: skip

    def test_trouble_ratios(self):
        s = self.scene
        for wrong in (-s.ratio, 300 * s.ratio, np.nan * s.ratio):
            self.refused("snn_ratio: expected the nearest distance over the second-nearest, from 0 to 1, lower is better, got",
                         diffsac.estimate_fundamental, s.x1, s.x2, wrong)  # fmt: skip

    def test_scores(self):
        s = self.scene
        scores = 1 - s.ratio
        for estimate in (
            diffsac.estimate_essential(s.x1, s.x2, K, K, scores=scores, models_folder="/none"),  # Which no network is read from.
            diffsac.estimate_essential(s.x1, s.x2, K, K, scores=list(scores.astype(np.float32))),
            diffsac.estimate_absolute_pose(s.points3d, s.x2, K, scores=scores),
        ):
            self.assertLess(angle_deg(estimate.pose.rotation, ROTATION), 0.5)
            self.assertIsNone(estimate.inlier_probabilities)
            self.assertFalse(estimate.diagnostics.scores_ignored)
        for costs in ({"scores": s.ratio}, {"snn_ratio": scores}):
            estimate = diffsac.estimate_essential(s.x1, s.x2, K, K, **costs)
            self.assertLess(angle_deg(estimate.pose.rotation, ROTATION), 0.5)
            self.assertTrue(estimate.diagnostics.scores_ignored)
        masked = diffsac.estimate_essential(s.x1, s.x2, K, K, scores=np.ma.masked_array(scores, np.arange(200) < 7))
        self.assertEqual(masked.diagnostics.num_nonfinite, 7)
        for wrong in (-scores, 30 * scores, np.nan * scores):
            self.refused("scores: expected a matcher's confidences, from 0 to 1, higher is better, got",
                         diffsac.estimate_two_focals, s.x1, s.x2, scores=wrong, size1=SIZE, size2=SIZE)  # fmt: skip
        self.refused("scores: expected shape (200,), got (5,)", diffsac.estimate_fundamental, s.x1, s.x2, scores=scores[:5])
        self.refused("scores: expected none beside snn_ratio", diffsac.estimate_fundamental, s.x1, s.x2, s.ratio, scores=scores)

    def test_trouble_messages_are_one_line_that_names_the_option(self):
        s = self.scene
        for options, text in (
            (dict(seed=-1), "seed: expected a whole number from 0 to 18446744073709551615, got -1"),
            (dict(seed="one"), "got 'one'"),
            (dict(seed=None), "seed: expected a value, got None"),
            (dict(max_iterations=1.5), "max_iterations: expected a whole number from 0 to 10000000, got 1.5"),
            (dict(max_residual="1"), "max_residual: expected a number, got '1'"),
            (dict(guidance="no"), "guidance: expected 'none', 'network' or 'diffusion', got 'no'"),
            (dict(models_folder=5), "models_folder: expected a path, got 5"),
            (dict(size1=(480, 640, 3)), "size1: expected (width, height) in whole pixels, got (480, 640, 3)"),
            (dict(size2=(640.5, 480)), "size2: expected (width, height) in whole pixels, got (640.5, 480)"),
            (dict(snn_ratio=[[1, 2], [3]]), "snn_ratio: expected real numbers, got [[1, 2], [3]]"),
        ):
            with self.assertRaises(ValueError) as context:
                diffsac.estimate_fundamental(s.x1, s.x2, **options)
            self.assertIn(text, str(context.exception))
            self.assertNotIn("\n", str(context.exception))
        for arguments, options, text in (
            ((s.x1,), {}, "estimate_fundamental: missing a required argument: 'x2'"),
            ((s.x1, s.x2), dict(sead=1), "estimate_fundamental: no argument 'sead'; did you mean 'seed'?"),
            ((s.x1, s.x2), dict(zzz=1), "no argument 'zzz'; there are x1, x2, snn_ratio, scores, size1"),
            ((s.x1, s.x2, s.ratio, 1), {}, "too many positional arguments: x1, x2, snn_ratio, and all others by name"),
        ):
            with self.assertRaises(TypeError) as context:
                diffsac.estimate_fundamental(*arguments, **options)
            self.assertIn(text, str(context.exception))
            self.assertNotIn("\n", str(context.exception))
        self.refused("x1: expected a value, got None", diffsac.estimate_fundamental, None, s.x2)

    def test_numbers_of_any_type_are_options(self):
        s = self.scene
        expected = diffsac.estimate_fundamental(s.x1, s.x2, size1=SIZE, size2=SIZE, max_iterations=200, seed=3, max_residual=1.0)
        other = diffsac.estimate_fundamental(
            s.x1, s.x2, size1=np.array(SIZE), size2=[640.0, 480.0], max_iterations=2e2, seed=np.uint8(3), max_residual=np.float32(1),
            num_threads=2.0,
        )  # fmt: skip
        np.testing.assert_array_equal(other.model, expected.model)

    def test_signatures_and_pickles_of_functions(self):
        signature = inspect.signature(diffsac.estimate_line)
        self.assertEqual(list(signature.parameters), ["points", "max_residual", "max_iterations", "min_iterations", "confidence", "num_threads", "initial_model", "guidance", "models_folder", "seed"])
        self.assertEqual(signature.parameters["seed"].default, 0)
        self.assertIs(pickle.loads(pickle.dumps(diffsac.estimate_line)), diffsac.estimate_line)

    def test_help_explains_every_argument(self):
        told = set()
        for name in (name for name in diffsac.__all__ if name.startswith("estimate_")):
            function = getattr(diffsac, name)
            for argument in inspect.signature(function).parameters:
                self.assertRegex(function.__doc__, rf"(?m)^{argument}: .{{10}}", name)
                told.add(argument)
        self.assertEqual(told, set(ARGUMENTS))

    def test_models_folder(self):
        s = self.scene
        self.refused(
            "/none/fundamental/model.safetensors: no such checkpoint",
            diffsac.estimate_fundamental, s.x1, s.x2, s.ratio, models_folder=pathlib.Path("/none"),
        )  # fmt: skip
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "fundamental", "model.safetensors")
            path.parent.mkdir()
            path.write_text("no network")
            self.refused(
                f"{path}: not a safetensors file", diffsac.estimate_fundamental, s.x1, s.x2, s.ratio, models_folder=folder
            )


class TestExamples(unittest.TestCase):
    """What README.md and docs/python.md show, and the programs of apps/python/examples."""

    def test_documents(self):
        s = Scene()
        for name in ("README.md", "docs/python.md"):
            blocks = re.findall("```python\n(.*?)```", (ROOT / name).read_text(), re.DOTALL)
            self.assertTrue(blocks, name)
            for block in blocks:
                with contextlib.redirect_stdout(io.StringIO()) as out:
                    exec(block, {"x1": s.x1, "x2": s.x2, "K1": K, "K2": K, "snn_ratio": s.ratio})
                self.assertRegex(out.getvalue(), r"\]\] 1[0-9]{2}\b", block)

    def run_example(self, name, *arguments):
        program = ROOT / "apps/python/examples" / name
        done = subprocess.run([sys.executable, program, *arguments, "600", "320,240"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    @unittest.skipUnless(importlib.util.find_spec("h5py"), "there is no h5py")
    def test_hloc_matches(self):
        import h5py

        s = Scene()
        with tempfile.TemporaryDirectory() as folder:
            features, matches = folder + "/features.h5", folder + "/matches.h5"
            with h5py.File(features, "w") as file:
                file["a.jpg/keypoints"], file["b.jpg/keypoints"] = s.x1, s.x2[::-1]
            with h5py.File(matches, "w") as file:
                file["a.jpg/b.jpg/matches0"] = np.where(np.arange(200) < 190, np.arange(200)[::-1], -1)
            out = self.run_example("hloc_matches.py", features, matches)
        self.assertRegex(out, r"^a.jpg b.jpg: 190 matches, ok, 1[0-9]{2} inliers, t = \[")

    @unittest.skipUnless(importlib.util.find_spec("cv2"), "there is no cv2")
    def test_beside_opencv(self):
        import cv2

        texture = cv2.GaussianBlur(np.random.default_rng(1).integers(0, 255, (480, 900)).astype(np.uint8), (0, 0), 2)
        texture = cv2.normalize(texture, None, 0, 255, cv2.NORM_MINMAX)
        with tempfile.TemporaryDirectory() as folder:
            first, second = folder + "/first.png", folder + "/second.png"
            cv2.imwrite(first, texture[:, 100:740])
            # Two walls, the right one nearer: the camera moves to the right.
            cv2.imwrite(second, np.hstack([texture[:, 110:440], texture[:, 450:760]]))
            out = self.run_example("beside_opencv.py", first, second)
        self.assertRegex(out, r"OpenCV  : \d+ of \d+ matches.*\ndiffsac : \d{2,} of \d+ matches")


@unittest.skipUnless("DIFFSAC_CPP_ESTIMATES" in os.environ, "DIFFSAC_CPP_ESTIMATES names no program")
class TestDigits(unittest.TestCase):
    """The digits of the C++ library, of the networks as the checkout has them."""

    def setUp(self):
        s = self.scene = Scene()
        rows = np.column_stack([s.points3d, s.x1, s.x2, s.ratio])
        text = "\n".join(" ".join(repr(float(value)) for value in row) for row in rows)
        done = subprocess.run([os.environ["DIFFSAC_CPP_ESTIMATES"]], input=text, capture_output=True, text=True, check=True)
        self.cpp = {}
        for line in done.stdout.splitlines():
            name, *numbers = line.split()
            self.cpp.setdefault(name, []).append([float(number) for number in numbers])

    def same(self, name, array):
        np.testing.assert_allclose(np.ravel(array), np.concatenate(self.cpp[name]), rtol=0, atol=1e-12, err_msg=name)

    def same_estimate(self, name, estimate):
        self.assertTrue(estimate.ok)
        self.same(name + ".model", estimate.model)
        self.same(name + ".inliers", estimate.inliers)
        probabilities = estimate.inlier_probabilities
        self.same(name + ".inlier_probabilities", [] if probabilities is None else probabilities)
        self.same(name + ".numbers", [estimate.inlier_threshold, estimate.sigma, estimate.diagnostics.log10_nfa])
        if getattr(estimate, "pose_covariance", None) is not None:
            self.same(name + ".pose_covariance", estimate.pose_covariance)
        if getattr(estimate, "focal", None) is not None:
            self.same(name + ".focal", estimate.focal.focal_px)

    def test_one_model(self):
        s, sizes = self.scene, dict(size1=SIZE, size2=SIZE)
        matches = (s.x1, s.x2)
        self.same_estimate("essential", diffsac.estimate_essential(*matches, K, K, s.ratio))
        self.same_estimate("fundamental", diffsac.estimate_fundamental(*matches, s.ratio))
        self.same_estimate("homography", diffsac.estimate_homography(*matches, s.ratio))
        self.same_estimate("absolute_pose", diffsac.estimate_absolute_pose(s.points3d, s.x2, K, s.ratio))
        self.same_estimate("shared_focal", diffsac.estimate_shared_focal(*matches, s.ratio, **sizes))
        self.same_estimate("one_focal", diffsac.estimate_one_focal(*matches, K, s.ratio, **sizes))
        self.same_estimate("two_focals", diffsac.estimate_two_focals(*matches, s.ratio, **sizes))
        self.same_estimate("line", diffsac.estimate_line(s.x2, 9.0))
        self.same_estimate("plane", diffsac.estimate_plane(s.points3d, 0.3))

    def test_several_models(self):
        s = self.scene
        matches = (s.x1, s.x2)
        for name, estimate in (
            ("essentials", diffsac.estimate_multiple_essentials(*matches, K, K, s.ratio)),
            ("fundamentals", diffsac.estimate_multiple_fundamentals(*matches, s.ratio)),
            ("homographies", diffsac.estimate_multiple_homographies(*matches, s.ratio)),
            ("absolute_poses", diffsac.estimate_multiple_absolute_poses(s.points3d, s.x2, K, s.ratio)),
            ("lines", diffsac.estimate_multiple_lines(s.x2, 9.0)),
            ("planes", diffsac.estimate_multiple_planes(s.points3d, 0.3)),
        ):
            if estimate.ok:
                self.same(name + ".models", estimate.models)
            else:
                self.assertNotIn(name + ".models", self.cpp)
            self.same(name + ".assignment", estimate.assignment)

    def test_vanishing_points(self):
        estimate = diffsac.estimate_vanishing_points(np.hstack([self.scene.x1, self.scene.x2]), K, least_value=0.35)
        self.assertTrue(estimate.ok)
        self.same("vanishing.models", estimate.points)
        self.same("vanishing.assignment", estimate.assignment)


if __name__ == "__main__":
    unittest.main()
