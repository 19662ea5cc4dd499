"""Names of diffsac 0.2 in the installed module."""

import unittest

import numpy as np

import diffsac

K = np.array([[600.0, 0, 320], [0, 600, 240], [0, 0, 1]])


def matches():
    """Of a camera that moved to the side; every fourth is wrong."""
    random = np.random.default_rng(1)
    points = np.c_[random.uniform(-2, 2, 200), random.uniform(-1.5, 1.5, 200), random.uniform(4, 8, 200)]
    x1, x2 = (x[:, :2] / x[:, 2:] * 600 + [320, 240] + random.normal(0, 0.3, (200, 2)) for x in (points, points - [1, 0.1, 0.2]))
    x2[::4] = random.uniform(0, 480, (50, 2))
    return x1, x2, np.where(np.arange(200) % 4, 0.5, 0.9)


class TestFormerNames(unittest.TestCase):
    def test_names_of_the_last_version_warn(self):
        x1, x2, ratio = matches()
        with self.assertWarnsRegex(DeprecationWarning, "ratio is snn_ratio"):
            old = diffsac.estimate_essential(x1, x2, K, K, ratio=ratio)
        new = diffsac.estimate_essential(x1, x2, K, K, ratio)
        np.testing.assert_array_equal(old.model, new.model)
        with self.assertWarns(DeprecationWarning):
            plain = diffsac.estimate_essential(x1, x2, K, K, ratio, use_network=False, max_residual_px=0)
        np.testing.assert_array_equal(plain.model, diffsac.estimate_essential(x1, x2, K, K, ratio, guidance="none").model)
        with self.assertWarnsRegex(DeprecationWarning, "noise_scale is sigma"):
            self.assertEqual(new.noise_scale, new.sigma)
        with self.assertWarns(DeprecationWarning):
            self.assertEqual(new.share_behind, new.diagnostics.cheirality_failure_ratio)
        with self.assertWarns(DeprecationWarning):
            self.assertEqual(new.cost.draws, new.stats.iterations)
        with self.assertWarns(DeprecationWarning):
            lines = diffsac.estimate_lines(x1, max_distance=1.0)
        with self.assertWarns(DeprecationWarning):
            self.assertEqual(lines.rows_left_out, 0)
        with self.assertWarns(DeprecationWarning):
            self.assertIs(diffsac.Translation, diffsac.Degeneracy)
        with self.assertWarns(DeprecationWarning):
            self.assertIs(new.translation, new.diagnostics.degeneracy)
        with self.assertRaises(AttributeError):
            new.no_such_field
        self.assertFalse(new.may_be_wrong)


if __name__ == "__main__":
    unittest.main()
