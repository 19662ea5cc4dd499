"""diffsac.cv2, poselib, kornia, hloc and the glue-factory example (docs/drop_ins.md): each gives what the call of diffsac itself gives, in
the other library's shapes. Torch, pycolmap, PoseLib and glue-factory are replaced by fakes of what is called where they are not
installed; cv2 is OpenCV's own, without which its tests are skipped."""

import importlib.util
import inspect
import pathlib
import re
import sys
import tempfile
import types
import unittest
import warnings
from unittest import mock

import numpy as np

import diffsac
import diffsac.hloc
import diffsac.kornia
import diffsac.poselib
from test_diffsac import ROOT, ROTATION, SIZE, TRANSLATION, K, Scene, angle_deg

try:
    import cv2

    import diffsac.cv2 as ours
except ImportError:
    cv2 = None
CAMERA = {"model": "PINHOLE", "width": 640, "height": 480, "params": [600.0, 600.0, 320.0, 240.0]}
LENS = {"model": "OPENCV", "width": 640, "height": 480, "params": [600.0, 600.0, 320.0, 240.0, -0.1, 0.02, 0.001, -0.002]}


def bent(points):
    """Pixels as LENS shows them."""
    x, y = ((points - K[:2, 2]) / 600.0).T
    k1, k2, p1, p2 = LENS["params"][4:]
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2 * r2
    seen = np.c_[x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y]
    return 600.0 * seen + K[:2, 2]


class DropIns(unittest.TestCase):
    def setUp(self):
        self.scene = Scene()
        random = np.random.default_rng(7)
        self.scores = np.where(self.scene.wrong, random.uniform(0, 0.5, 200), random.uniform(0.2, 1, 200))


@unittest.skipIf(cv2 is None, "OpenCV is not installed")
class TestCv2(DropIns):
    def test_essential_of_all_shapes_types_and_overloads(self):
        s = self.scene
        expected = diffsac.estimate_essential(s.x1, s.x2, K, K, max_residual=1.0)
        for shape in (lambda x: x, lambda x: x[:, None], lambda x: x[None]):
            E, mask = ours.findEssentialMat(shape(s.x1), shape(s.x2), K, cv2.RANSAC, 0.999, 1.0)
            np.testing.assert_array_equal(E, expected.model)
            self.assertEqual((mask.shape, mask.dtype, E.dtype), ((200, 1), np.uint8, np.float64))
        zero = np.zeros(5)
        for call in (
            lambda: ours.findEssentialMat(s.x1, s.x2, cameraMatrix=K, method=cv2.USAC_MAGSAC, threshold=1.0, maxIters=10000),
            lambda: ours.findEssentialMat(s.x1, s.x2, focal=600.0, pp=(320, 240), threshold=1.0),
            lambda: ours.findEssentialMat(s.x1, s.x2, 600.0, (320, 240), cv2.RANSAC, 0.999, 1.0),
            lambda: ours.findEssentialMat(s.x1, s.x2, K, zero, K, zero, cv2.RANSAC, 0.999, 1.0),
            lambda: ours.findEssentialMat(s.x1, s.x2, K, None, K, None, threshold=1.0),
        ):
            np.testing.assert_array_equal(call()[0], expected.model)
        single = ours.findEssentialMat(s.x1.astype(np.float32), s.x2.astype(np.float32), K)[0]
        self.assertEqual(single.dtype, np.float64)

    def test_recover_pose_takes_it_and_lenses_are_straightened(self):
        s, lens = self.scene, np.array(LENS["params"][4:])
        for points, given in (((s.x1, s.x2), (K,)), ((bent(s.x1), bent(s.x2)), (K, lens, K, lens))):
            E, mask = ours.findEssentialMat(*points, *given, scores=self.scores)
            count, R, t, _ = ours.recoverPose(E, s.x1, s.x2, K, mask=mask.copy())
            self.assertGreater(count, 120)
            self.assertLess(angle_deg(R, ROTATION), 0.5)
            self.assertGreater(t[:, 0] @ TRANSLATION, 0.999)

    def test_fundamental_homography_and_pnp(self):
        s, flat = self.scene, slice(0, 100)
        F, mask = ours.findFundamentalMat(s.x1, s.x2, cv2.FM_RANSAC, 1.0, 0.99, 2000)
        expected = diffsac.estimate_fundamental(s.x1, s.x2, max_residual=1.0)
        np.testing.assert_allclose(F, expected.model / expected.model[2, 2])
        np.testing.assert_array_equal(mask[:, 0] > 0, expected.inliers)
        H, mask = ours.findHomography(s.x1[flat], s.x2[flat], cv2.RANSAC, 3.0, maxIters=200)
        expected = diffsac.estimate_homography(s.x1[flat], s.x2[flat], max_residual=3.0, max_iterations=200)
        np.testing.assert_allclose(H, expected.model / expected.model[2, 2])
        found, rvec, tvec, inliers = ours.solvePnPRansac(s.points3d, bent(s.x2), K, np.array(LENS["params"][4:]), reprojectionError=4.0)
        self.assertTrue(found)
        self.assertEqual((rvec.shape, tvec.shape, inliers.shape[1], inliers.dtype), ((3, 1), (3, 1), 1, np.int32))
        self.assertLess(angle_deg(cv2.Rodrigues(rvec)[0], ROTATION), 0.5)
        self.assertFalse(np.intersect1d(inliers, np.flatnonzero(s.wrong)).size > 5)

    def test_what_is_left_to_opencv(self):
        s = self.scene
        H, _ = cv2.findHomography(s.x1, s.x2)
        np.testing.assert_array_equal(ours.findHomography(s.x1, s.x2)[0], H)
        F, _ = cv2.findFundamentalMat(s.x1, s.x2, cv2.FM_8POINT)
        np.testing.assert_array_equal(ours.findFundamentalMat(s.x1, s.x2, cv2.FM_8POINT)[0], F)
        self.assertIs(ours.imread, cv2.imread)

    def test_what_is_given_to_be_filled_is_filled(self):
        s, n = self.scene, 200
        for shape in ((n, 1), (n,), (1, n), (n + 1, 1)):
            for call in (
                lambda cv, mask: cv.findEssentialMat(s.x1, s.x2, K, cv2.RANSAC, 0.999, 1.0, 1000, mask),
                lambda cv, mask: cv.findEssentialMat(s.x1, s.x2, K, None, K, None, mask=mask),
                lambda cv, mask: cv.findFundamentalMat(s.x1, s.x2, cv2.FM_RANSAC, 1.0, 0.99, mask),
                lambda cv, mask: cv.findFundamentalMat(s.x1, s.x2, cv2.FM_RANSAC, 1.0, 0.99, 2000, mask),
                lambda cv, mask: cv.findHomography(s.x1, s.x2, cv2.RANSAC, 3.0, mask),
            ):
                theirs, mine = np.zeros(shape, np.uint8), np.zeros(shape, np.uint8)
                call(cv2, theirs)
                _, mask = call(ours, mine)
                self.assertEqual(mask.size, n)
                if theirs.any():
                    self.assertIs(mask, mine)
                if mask is mine:
                    self.assertGreater(mine.sum(), 80)
        rvec, tvec = np.full((3, 1), 0.5), np.full((3, 1), 0.5)
        found = ours.solvePnPRansac(s.points3d, s.x2, K, None, rvec, tvec, True, 200, 4.0)
        self.assertIs(found[1], rvec)
        self.assertIs(found[2], tvec)
        self.assertLess(angle_deg(cv2.Rodrigues(rvec)[0], ROTATION), 0.5)
        inliers = np.zeros_like(found[3])
        self.assertIs(ours.solvePnPRansac(s.points3d, s.x2, K, None, reprojectionError=4.0, inliers=inliers)[3], inliers)
        np.testing.assert_array_equal(inliers, found[3])

    @unittest.skipUnless(hasattr(cv2, "UsacParams"), "OpenCV is older than UsacParams")
    def test_usac_params_in_the_place_of_a_method(self):
        s, params, wide = self.scene, cv2.UsacParams(), np.diag([0.9, 0.9, 1]) @ K
        params.threshold, params.maxIterations, params.randomGeneratorState = 0.5, 200, 3
        options = {"max_residual": 0.5, "max_iterations": 200, "seed": 3}
        mask = np.zeros((200, 1), np.uint8)
        F = diffsac.estimate_fundamental(s.x1, s.x2, **options)
        np.testing.assert_allclose(ours.findFundamentalMat(s.x1, s.x2, params, mask)[0], F.model / F.model[2, 2])
        np.testing.assert_array_equal(mask[:, 0] > 0, F.inliers)
        H = diffsac.estimate_homography(s.x1, s.x2, **options)
        np.testing.assert_allclose(ours.findHomography(s.x1, s.x2, params=params)[0], H.model / H.model[2, 2])
        E = diffsac.estimate_essential(s.x1, s.x2, K, wide, **options)
        for lens in (None, np.zeros(5)):
            np.testing.assert_array_equal(ours.findEssentialMat(s.x1, s.x2, K, wide, lens, lens, params)[0], E.model)
        theirs = cv2.solvePnPRansac(s.points3d, s.x2, K, None, params=params)
        for mine in (
            ours.solvePnPRansac(s.points3d, s.x2, K, None, params=params),
            ours.solvePnPRansac(s.points3d, s.x2, K, None, None, None, None, params),
        ):
            self.assertEqual([np.shape(one) for one in mine[:4]], [np.shape(one) for one in theirs[:4]])

    def test_too_few_points_and_noise_are_answered_as_cv2_does(self):
        def answer(call, *arguments):
            try:
                return type(call(*arguments)[0])
            except cv2.error as error:
                return error.code

        s = self.scene
        for n in (0, 1, 3, 4):
            for name, arguments in (
                ("findEssentialMat", (s.x1[:n], s.x2[:n], K)),
                ("findEssentialMat", (s.x1[:n], s.x2[:n], K, cv2.RANSAC, 0.999, 1.0)),
                ("findFundamentalMat", (s.x1[:n], s.x2[:n], cv2.FM_RANSAC)),
                ("findHomography", (s.x1[:n], s.x2[:n], cv2.RANSAC)),
                ("solvePnPRansac", (s.points3d[1 : 1 + n], s.x2[1 : 1 + n], K, None)),
                ("findEssentialMat", (s.x1, s.x2[:n], K)),
                ("findHomography", (s.x1, s.x2[:n], cv2.RANSAC)),
            ):
                self.assertEqual(answer(getattr(ours, name), *arguments), answer(getattr(cv2, name), *arguments), (name, n))
        noise = np.random.default_rng(4).uniform((0, 0), SIZE, (12, 2))
        found, _, _, inliers = ours.solvePnPRansac(s.points3d[:12], noise, K, None, reprojectionError=3.0)
        self.assertEqual((found, inliers), (False, None))

    def test_help_has_the_orders_of_cv2_and_every_argument(self):
        for name in ("findEssentialMat", "findFundamentalMat", "findHomography", "solvePnPRansac"):
            function, theirs = getattr(ours, name), re.findall(rf"^{name}\((.*)\) ->", getattr(cv2, name).__doc__, re.M)
            orders = re.findall(rf"^    {name}\((.*)\)", function.__doc__, re.M)
            mine = [[argument.split("=")[0] for argument in re.split(r", (?=[a-z])", order, flags=re.I)] for order in orders]
            for order in theirs:
                self.assertIn(re.findall(r"\w+", order), mine)
            parameters = inspect.signature(function).parameters
            self.assertEqual([key for key, one in parameters.items() if one.kind is one.POSITIONAL_OR_KEYWORD], mine[0])
            for key in parameters:
                self.assertTrue(key in mine[0] or f"\n{key}: " in function.__doc__, key)

    def test_trouble(self):
        s = self.scene
        with self.assertRaisesRegex(TypeError, r"findHomography: expected \(srcPoints, dstPoints, method=0"):
            ours.findHomography(s.x1, s.x2, "RANSAC")
        with self.assertRaisesRegex(ValueError, "points: expected N x 2"):
            ours.findHomography(None, s.x2, cv2.RANSAC)
        with self.assertRaisesRegex(ValueError, "K1: expected"):
            ours.findEssentialMat(s.x1, s.x2, K[:2])
        with self.assertRaisesRegex(ValueError, "scores: expected"):
            ours.findEssentialMat(s.x1, s.x2, K, scores=20 * self.scores)
        with self.assertRaisesRegex(TypeError, "no argument 'treshold'"):
            ours.findEssentialMat(s.x1, s.x2, K, treshold=1.0)
        with self.assertRaisesRegex(ValueError, "points: expected N x 2"):
            ours.findEssentialMat(s.x1.T, s.x2.T, K)


class TestPoselib(DropIns):
    def test_both_signatures_give_the_same(self):
        s = self.scene
        expected = diffsac.estimate_essential(s.x1, s.x2, K, K, scores=self.scores, max_residual=1.5)
        for pose, info in (
            diffsac.poselib.estimate_relative_pose(s.x1, s.x2, CAMERA, CAMERA, {"max_epipolar_error": 1.5}, {"loss": "CAUCHY"}, scores=self.scores),
            diffsac.poselib.estimate_relative_pose(
                s.x1, s.x2, CAMERA, CAMERA, {"max_error": 1.5, "ransac": {"max_iterations": 100000}}, None, scores=self.scores
            ),
            diffsac.poselib.estimate_relative_pose(
                s.x1, s.x2, CAMERA, CAMERA, ransac_opt={"max_epipolar_error": 1.5}, bundle_opt={}, scores=self.scores
            ),
        ):
            np.testing.assert_allclose(pose.R, expected.pose.rotation, atol=1e-12)
            np.testing.assert_allclose(pose.t, expected.pose.translation, atol=1e-12)
            self.assertEqual(info["inliers"], expected.inliers.tolist())
            self.assertEqual(info["num_inliers"], expected.num_inliers)

    def test_others_and_lenses(self):
        s = self.scene
        pose, _ = diffsac.poselib.estimate_relative_pose(bent(s.x1), bent(s.x2), LENS, LENS)
        self.assertLess(angle_deg(np.asarray(pose.R), ROTATION), 0.5)
        pose, info = diffsac.poselib.estimate_absolute_pose(bent(s.x2), s.points3d, LENS, {"max_reproj_error": 4.0})
        self.assertLess(angle_deg(np.asarray(pose.R), ROTATION), 0.5)
        self.assertGreater(info["inlier_ratio"], 0.7)
        F, _ = diffsac.poselib.estimate_fundamental(s.x1, s.x2, {"seed": 3})
        np.testing.assert_array_equal(F, diffsac.estimate_fundamental(s.x1, s.x2, seed=3).model)
        H, _ = diffsac.poselib.estimate_homography(s.x1[:100], s.x2[:100], {})
        np.testing.assert_array_equal(H, diffsac.estimate_homography(s.x1[:100], s.x2[:100]).model)
        _, info = diffsac.poselib.estimate_relative_pose(s.x1[:3], s.x2[:3], CAMERA, CAMERA)
        self.assertEqual(info["num_inliers"], 0)
        self.assertLessEqual({"refinements", "iterations", "num_inliers", "inlier_ratio", "model_score", "inliers"}, set(info))
        with self.assertRaisesRegex(ValueError, "camera: expected SIMPLE_PINHOLE"):
            diffsac.poselib.estimate_relative_pose(s.x1, s.x2, {"model": "FOV", "params": [1, 2, 3, 4, 5]}, CAMERA)

    def test_cameras_of_another_number_of_parameters(self):
        s = self.scene
        for model, right in {"SIMPLE_PINHOLE": 3, "PINHOLE": 4, "SIMPLE_RADIAL": 4, "RADIAL": 5, "OPENCV": 8}.items():
            for n in (0, right - 1, right + 1):
                with self.assertRaisesRegex(ValueError, f"^camera: {model} has {right} parameters, got {n}$"):
                    diffsac.poselib.estimate_absolute_pose(s.x2, s.points3d, {"model": model, "params": [600.0] * n})

    def test_what_is_poselib_own_says_so(self):
        theirs = types.SimpleNamespace(estimate_hybrid_pose=lambda: 7, RansacOptions=dict)
        with mock.patch.dict(sys.modules, poselib=theirs):
            with self.assertWarnsRegex(UserWarning, "estimate_hybrid_pose is PoseLib's own"):
                self.assertEqual(diffsac.poselib.estimate_hybrid_pose(), 7)
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                self.assertIs(diffsac.poselib.RansacOptions, dict)
        with mock.patch.dict(sys.modules, poselib=None), self.assertRaisesRegex(AttributeError, "PoseLib is not installed"):
            diffsac.poselib.estimate_hybrid_pose


class Tensor:
    """As much of torch's as is asked for."""

    def __init__(self, array):
        self.array, self.device = array, "cpu"

    dtype = property(lambda self: self.array.dtype)

    def to(self, what):
        return Tensor(self.array.astype(what)) if isinstance(what, np.dtype) else self

    detach = cpu = lambda self: self

    def double(self):
        return Tensor(self.array.astype(np.float64))

    def numpy(self):
        return self.array


FAKE_TORCH = types.SimpleNamespace(from_numpy=Tensor, tensor=lambda values: Tensor(np.asarray(values)), eye=lambda n: Tensor(np.eye(n)))


class TestKornia(DropIns):
    def test_tensors_in_tensors_out(self):
        s = self.scene
        with mock.patch.dict(sys.modules, torch=FAKE_TORCH):
            for kind, x1, x2, native in (
                ("fundamental", s.x1, s.x2, lambda **o: diffsac.estimate_fundamental(s.x1, s.x2, **o)),
                ("essential", (s.x1 - K[:2, 2]) / 600, (s.x2 - K[:2, 2]) / 600, None),
                ("homography", s.x1[:100], s.x2[:100], lambda **o: diffsac.estimate_homography(s.x1[:100], s.x2[:100], **o)),
            ):
                scores = self.scores[: len(x1)]
                model, inliers = diffsac.kornia.RANSAC(kind, batch_size=512, seed=2)(Tensor(x1), Tensor(x2), Tensor(scores))
                self.assertEqual((model.array.shape, inliers.array.dtype), ((3, 3), np.bool_))
                if native:
                    np.testing.assert_array_equal(model.array, native(scores=scores, seed=2).model)
                self.assertLess(inliers.array[s.wrong[: len(x1)]].sum(), 5)
            single, _ = diffsac.kornia.RANSAC("fundamental")(Tensor(s.x1.astype(np.float32)), Tensor(s.x2.astype(np.float32)))
            self.assertEqual(single.dtype, np.float32)
            none, inliers = diffsac.kornia.RANSAC("fundamental")(Tensor(s.x1[:3]), Tensor(s.x2[:3]))
            self.assertFalse(none.array.any() or inliers.array.any())
        with self.assertRaisesRegex(NotImplementedError, "model_type: expected one of"):
            diffsac.kornia.RANSAC("affine")


class TestGlueFactory(DropIns):
    def estimator(self, conf):
        """The example, as a module of a package that has what glue-factory has."""
        pose = types.SimpleNamespace(from_Rt=lambda R, t: Tensor(np.c_[R.array, t.array]), from_4x4mat=lambda m: m)
        base = type("BaseEstimator", (), {"__call__": lambda self, data: self._forward(data)})
        modules = {
            "torch": FAKE_TORCH,
            "omegaconf": types.SimpleNamespace(OmegaConf=types.SimpleNamespace(to_container=dict)),
            "gluefactory.geometry.wrappers": types.SimpleNamespace(Pose=pose),
            "gluefactory.robust_estimators.base_estimator": types.SimpleNamespace(BaseEstimator=base),
        }
        for package in ("gluefactory", "gluefactory.geometry", "gluefactory.robust_estimators", "gluefactory.robust_estimators.relative_pose"):
            modules[package] = types.ModuleType(package)
            modules[package].__path__ = []
        name = "gluefactory.robust_estimators.relative_pose.diffsac"
        spec = importlib.util.spec_from_file_location(name, ROOT / "apps/python/examples/glue_factory_diffsac.py")
        module = importlib.util.module_from_spec(spec)
        with mock.patch.dict(sys.modules, modules):
            spec.loader.exec_module(module)
        made = module.DiffsacRelativePoseEstimator()
        made.conf = types.SimpleNamespace(**{**made.default_conf, **conf})
        return made

    def test_keys_and_scores(self):
        s = self.scene
        camera = types.SimpleNamespace(to_cameradict=lambda: CAMERA)
        data = {"m_kpts0": Tensor(s.x1), "m_kpts1": Tensor(s.x2), "camera0": camera, "camera1": camera, "m_scores": Tensor(self.scores)}
        found = self.estimator({"ransac_th": 1.0})(data)
        expected = diffsac.estimate_essential(s.x1, s.x2, K, K, scores=self.scores, max_residual=1.0)
        self.assertTrue(found["success"])
        np.testing.assert_allclose(found["M_0to1"].array, np.c_[expected.pose.rotation, expected.pose.translation], atol=1e-12)
        np.testing.assert_array_equal(found["inliers"].array, expected.inliers)
        self.assertFalse(self.estimator({})({**data, "m_kpts0": Tensor(s.x1[:3]), "m_kpts1": Tensor(s.x2[:3]), "m_scores": None})["success"])


class FakePycolmap(types.SimpleNamespace):
    """A database in memory, and plain values."""

    def __init__(self, scene, prior):
        kinds = ("DEGENERATE", "CALIBRATED", "UNCALIBRATED", "PLANAR_OR_PANORAMIC")
        super().__init__(
            Database=types.SimpleNamespace(open=lambda path: self),
            TwoViewGeometry=lambda: types.SimpleNamespace(E=None, F=None, inlier_matches=[], cam2_from_cam1=None),
            TwoViewGeometryConfiguration=types.SimpleNamespace(**{kind: kind for kind in kinds}),
            Rigid3d=lambda rotation, translation: (rotation, translation),
            Rotation3d=lambda matrix: matrix,
            written={},
            closed=False,
        )
        camera = {"camera_id": 1, "model_name": "PINHOLE", "params": CAMERA["params"], "width": 640, "height": 480}
        self.cameras = [types.SimpleNamespace(has_prior_focal_length=prior, **camera)]
        self.images = [types.SimpleNamespace(name=f"a/{i}.jpg", image_id=i, camera_id=1) for i in (1, 2, 3)]
        random = np.random.default_rng(3)
        self.keypoints = {1: np.r_[scene.x1, [[0, 0]]], 2: scene.x2[::-1], 3: random.uniform((0, 0), SIZE, (200, 2))}
        self.rows = np.c_[np.arange(200), 199 - np.arange(200)]
        self.read_all_images, self.read_all_cameras = (lambda: self.images), (lambda: self.cameras)
        self.read_keypoints = lambda image: self.keypoints[image].astype(np.float32)
        self.read_matches = lambda first, second: self.rows if {first, second} != {1, 4} else np.zeros((0, 2), int)
        self.exists_two_view_geometry = lambda first, second: (first, second) in self.written
        self.write_two_view_geometry = lambda first, second, geometry: self.written.update({(first, second): geometry})
        self.close = lambda: setattr(self, "closed", True)


class TestHloc(DropIns):
    def verified(self, prior, with_scores):
        fake = FakePycolmap(self.scene, prior)
        with tempfile.TemporaryDirectory() as folder, mock.patch.dict(sys.modules, pycolmap=fake):
            pairs, matches = pathlib.Path(folder) / "pairs.txt", None
            pairs.write_text("a/1.jpg a/2.jpg\na/1.jpg a/3.jpg\n\n")
            if with_scores:
                h5py = importlib.import_module("h5py")
                matches = pathlib.Path(folder) / "matches.h5"
                with h5py.File(matches, "w") as file:  # The other way round, of all keypoints of image 2.
                    file["a-2.jpg/a-1.jpg/matching_scores0"] = self.scores[::-1].astype(np.float16)
            diffsac.hloc.verification(matches)("database.db", pairs, verbose=False)
        self.assertTrue(fake.closed)
        return fake

    def test_pairs_are_verified_with_scores(self):
        s = self.scene
        x1, x2 = (x.astype(np.float32).astype(float) for x in (s.x1, s.x2))
        sizes = {"size1": SIZE, "size2": SIZE, "guidance": "none"}
        has_h5py = importlib.util.find_spec("h5py") is not None
        for prior in (True, False):
            for scores in [None] + [self.scores.astype(np.float16).astype(float)] * has_h5py:
                fake = self.verified(prior, scores is not None)
                geometry = fake.written[1, 2]
                if prior:
                    expected = diffsac.estimate_essential(x1, x2, K, K, scores=scores, **sizes)
                    np.testing.assert_allclose(geometry.E, expected.model, atol=1e-12)
                    np.testing.assert_allclose(geometry.cam2_from_cam1[0], expected.pose.rotation, atol=1e-12)
                else:
                    expected = diffsac.estimate_fundamental(x1, x2, scores=scores, **sizes)
                    np.testing.assert_array_equal(geometry.F, expected.model)
                self.assertEqual(geometry.config, "CALIBRATED" if prior else "UNCALIBRATED")
                np.testing.assert_array_equal(geometry.inlier_matches, fake.rows[expected.inliers])
                self.assertEqual(fake.written[1, 3].config, "DEGENERATE")
                self.assertEqual(len(fake.written[1, 3].inlier_matches), 0)

    def test_names_that_the_database_does_not_have(self):
        fake = FakePycolmap(self.scene, True)
        with tempfile.TemporaryDirectory() as folder, mock.patch.dict(sys.modules, pycolmap=fake):
            pairs = pathlib.Path(folder) / "pairs.txt"
            pairs.write_text("a/1.jpg a/2.jpg\na/1.jpg b/9.jpg\n1.jpg a/2.jpg\n")
            with self.assertRaisesRegex(ValueError, r"pairs.txt: the database has no image 1.jpg \(2 such names\)$"):
                diffsac.hloc.verification()("database.db", pairs)
        self.assertEqual(fake.written, {})
        self.assertTrue(fake.closed)

    def test_query_localizer(self):
        s = self.scene
        points = {j + 10: types.SimpleNamespace(xyz=s.points3d[j]) for j in range(200)}
        localizer = diffsac.hloc.QueryLocalizer(
            types.SimpleNamespace(points3D=points), {"estimation": {"ransac": {"max_error": 4.0}}, "refinement": {}}
        )
        all_points = np.r_[np.zeros((7, 2)), s.x2]
        with mock.patch.dict(sys.modules, pycolmap=FakePycolmap(s, True)):
            found = localizer.localize(all_points, np.arange(200) + 7, list(points), CAMERA)
            self.assertIsNone(localizer.localize(all_points, [7, 8], [10, 11], CAMERA))
        expected = diffsac.estimate_absolute_pose(s.points3d, s.x2, K, max_residual=4.0)
        np.testing.assert_allclose(found["cam_from_world"][0], expected.pose.rotation, atol=1e-12)
        self.assertEqual(found["num_inliers"], expected.num_inliers)


if __name__ == "__main__":
    unittest.main()
