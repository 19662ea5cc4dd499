#!/usr/bin/env python3
"""What a matcher's scores are worth to estimators of essential and fundamental matrices: ours with scores, with 1 - score as a ratio and
without either, and PoseLib, on pairs with match_scores.h5 and truth, as learned_matches.py --model writes them.

  PYTHON scripts/peers/matcher_scores.py --scenes SCENE... [--seeds 3] [--maps | --posteriors | --chance]

PYTHON has diffsac (pip install .), numpy, h5py, opencv-python-headless and poselib. It prints mAA@10deg as docs/metrics.md has it (F
decomposed with the true cameras), over all pairs and seeds alike, with the interval of 95 % of the difference to ours with scores by
bootstrap over pairs; and what share of the matches of a score is right (within 1.5 px of the truth). --maps: other maps from score to
probability than the library's, .05 + .9 score, which keep the order: for scenes that settings are chosen on alone. --posteriors: how far
`posteriors` of the estimates are from the share that is right, on average over matches (expected calibration error, ten bins); right is
within 1.5 px of the photographs as the matcher saw them, 1024 wide or high. --chance: of the estimates whose pose is within 10 degrees
of the truth, and of those beyond 30, what share the verdict `unsupported` flags (learned_matches.py --turn makes pairs that are mostly wrong).
"""
import argparse
import os

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"
import h5py
import numpy as np

from peer_pairs import accuracy, errors_of_matrix, essential_matrix, fail, matrix_of, read_pair, sampson

FEWEST_POINTS, RIGHT_PX, MATCHED_SIDE = 8, 1.5, 1024


def estimate(task, pair, kept, seed, **options):
    import diffsac
    cameras = (pair.k1, pair.k2) if task == "essential" else ()
    return getattr(diffsac, "estimate_" + task)(pair.matches[kept, :2], pair.matches[kept, 2:], *cameras, seed=seed, size1=[int(v) for v in pair.sizes[:2]],
                                                size2=[int(v) for v in pair.sizes[2:]], **options)


def ours(keep=0.0, **options):
    named = {"scores": lambda s: {"scores": s}, "ratio": lambda s: {"snn_ratio": 1 - s}, "none": lambda s: {}}
    give = named.get(options.pop("give"), options.get("map"))
    options.pop("map", None)

    def run(task, pair, scores, seed):
        kept = scores >= keep
        if kept.sum() < FEWEST_POINTS:
            return None
        found = estimate(task, pair, kept, seed, **give(scores[kept]), **options)
        return found.model if found.ok else None
    return run


def poselib(threshold, keep=0.0):
    import poselib as library

    def run(task, pair, scores, seed):
        order = np.argsort(-scores, kind="stable")
        order = order[scores[order] >= keep]
        if len(order) < FEWEST_POINTS:
            return None
        x1, x2 = np.ascontiguousarray(pair.matches[order, :2]), np.ascontiguousarray(pair.matches[order, 2:])
        options = {"max_epipolar_error": threshold, "max_iterations": 1000, "min_iterations": 100, "success_prob": 0.9999,
                   "progressive_sampling": True, "seed": seed}
        if task == "fundamental":
            matrix, info = library.estimate_fundamental(x1, x2, options, {})
            return matrix if info["num_inliers"] >= 7 else None
        cameras = [{"model": "PINHOLE", "width": int(w), "height": int(h), "params": [k[0, 0], k[1, 1], k[0, 2], k[1, 2]]}
                   for k, (w, h) in ((pair.k1, pair.sizes[:2]), (pair.k2, pair.sizes[2:]))]
        pose, info = library.estimate_relative_pose(x1, x2, *cameras, options, {})
        return matrix_of(pose) if info["num_inliers"] >= 5 else None
    return run


ROWS = {"scores": ours(give="scores"), "1 - score as ratio, no network": ours(give="ratio", guidance="none"),
        "1 - score as ratio, its network": ours(give="ratio"), "no scores, no network": ours(give="none", guidance="none"),
        "scores, only >= .1": ours(0.1, give="scores"), "no scores, no network, only >= .1": ours(0.1, give="none", guidance="none"),
        **{f"PoseLib, {t} px{', only >= .1' * (keep > 0)}": poselib(t, keep) for keep in (0.0, 0.1) for t in (0.5, 1.0, 2.0)}}


def mapped(probability):
    """What `scores` must be for the library to take this probability."""
    return ours(give="map", map=lambda s: {"scores": np.clip((probability(s) - 0.05) / 0.9, 0, 1)})


MAPS = {"p = .05 + .9 score": ours(give="scores"), "p = score, from .05 to .95": mapped(lambda s: s),
        "p = .25 + .7 score": mapped(lambda s: 0.25 + 0.7 * s), "p = .05 + .9 sqrt(score)": mapped(lambda s: 0.05 + 0.9 * np.sqrt(s)),
        "p alike": mapped(lambda s: 0.5 + 1e-6 * s)}


def pairs_of(scenes):
    for scene in scenes:
        with h5py.File(os.path.join(scene, "match_scores.h5")) as file:
            for name in file:
                pair = read_pair(scene, name)
                yield pair, 1.0 - pair.ratios


def right_matches(pair, px=RIGHT_PX):
    essential = essential_matrix(pair.turn, pair.shift)
    return np.sqrt(sampson(np.linalg.inv(pair.k2).T @ essential @ np.linalg.inv(pair.k1), pair.matches)) <= px


def calibration(pairs, seeds):
    for task in ("essential", "fundamental"):
        said, right = [], []
        for pair, scores in pairs:
            for seed in range(seeds):
                said.append(estimate(task, pair, np.ones(len(scores), bool), seed, scores=scores).posteriors)
                # Keypoints are as exact as the photographs that the matcher saw, of this longest side (learned_matches.py).
                right.append(right_matches(pair, RIGHT_PX * max(1.0, max(pair.sizes) / MATCHED_SIDE)))
        said, right = np.concatenate(said), np.concatenate(right)
        bins = np.minimum((10 * said).astype(int), 9)
        means = [(said[bins == k].mean(), right[bins == k].mean(), (bins == k).sum()) for k in range(10) if (bins == k).any()]
        error = sum(abs(p - share) * count for p, share, count in means) / len(said)
        print(f"{task}: posteriors of {len(said)} matches are off by {error:.3f}; "
              + ", ".join(f"{p:.2f}: {share:.2f} right" for p, share, _ in means))


def chance(pairs, seeds):
    for task in ("essential", "fundamental"):
        errors, flagged = [], []
        for pair, scores in pairs:
            for seed in range(seeds):
                found = estimate(task, pair, np.ones(len(scores), bool), seed, scores=scores)
                if found.ok:
                    errors.append(max(errors_of_matrix(found.model, pair, task)))
                    flagged.append(found.verdict == "unsupported")
        errors, flagged = np.array(errors), np.array(flagged)
        print(f"{task}: flagged are " + ", ".join(f"{flagged[which].sum()} of {which.sum()} {what}" for what, which in (
            ("within 10 degrees", errors <= 10), ("beyond 30", errors > 30))))


def reliability(pairs):
    """Of a score, how many are right."""
    scores, right = [], []
    for pair, score in pairs:
        scores.append(score)
        right.append(right_matches(pair))
    scores, right = np.concatenate(scores), np.concatenate(right)
    print(f"{len(scores)} matches, {100 * right.mean():.0f} % right")
    for low in np.arange(0, 1, 0.1):
        chosen = (scores >= low) & (scores <= low + 0.1)
        if chosen.any():
            print(f"  score {low:.1f} to {low + 0.1:.1f}: {chosen.sum()} matches, mean score {scores[chosen].mean():.2f}, right {right[chosen].mean():.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", required=True)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--maps", action="store_true")
    parser.add_argument("--posteriors", action="store_true")
    parser.add_argument("--chance", action="store_true")
    arguments = parser.parse_args()
    pairs = list(pairs_of(arguments.scenes)) or fail("no pairs")
    if arguments.posteriors:
        return calibration(pairs, arguments.seeds)
    if arguments.chance:
        return chance(pairs, arguments.seeds)
    reliability(pairs)
    random = np.random.default_rng(1)
    resampled = random.integers(0, len(pairs), (2000, len(pairs)))
    for task in ("essential", "fundamental"):
        print(f"{task}: {len(pairs)} pairs, {arguments.seeds} seeds: mAA@10, beside the first row")
        base = None
        for name, run in (MAPS if arguments.maps else ROWS).items():
            found = np.array([[accuracy([max(errors_of_matrix(run(task, pair, scores, seed), pair, task))])
                               for seed in range(arguments.seeds)] for pair, scores in pairs]).mean(1)
            base = found if base is None else base
            low, high = np.percentile((found - base)[resampled].mean(1), (2.5, 97.5))
            print(f"  {name}: {found.mean():.3f}, {(found - base).mean():+.3f} [{low:+.3f}, {high:+.3f}]", flush=True)


if __name__ == "__main__":
    main()
