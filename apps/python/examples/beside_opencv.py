"""Two photographs: the relative pose by cv2.findEssentialMat and by diffsac, from the same SIFT matches; needs cv2.

    python beside_opencv.py first.jpg second.jpg FOCAL CX,CY
"""

import sys
import time

import cv2
import numpy as np

import diffsac


def match(first: str, second: str):
    """All nearest neighbours, with the ratio of their distance to that of the second-nearest."""
    sift = cv2.SIFT_create(8000)
    (k1, d1), (k2, d2) = (sift.detectAndCompute(cv2.imread(path, cv2.IMREAD_GRAYSCALE), None) for path in (first, second))
    nearest = cv2.BFMatcher().knnMatch(d1, d2, k=2)
    x1 = np.array([k1[a.queryIdx].pt for a, _ in nearest])
    x2 = np.array([k2[a.trainIdx].pt for a, _ in nearest])
    return x1, x2, np.array([a.distance / max(b.distance, 1e-12) for a, b in nearest])


def show(name: str, inliers: int, matches: int, rotation: np.ndarray, translation: np.ndarray, seconds: float) -> None:
    degrees = np.degrees(np.linalg.norm(cv2.Rodrigues(rotation)[0]))
    print(f"{name:8}: {inliers} of {matches} matches, turned by {degrees:.3f} degrees, "
          f"t = {np.round(translation.ravel(), 4)}, {1000 * seconds:.1f} ms")


def main(first: str, second: str, focal: str, center: str) -> None:
    cx, cy = (float(value) for value in center.split(","))
    K = np.array([[float(focal), 0, cx], [0, float(focal), cy], [0, 0, 1]])
    x1, x2, ratio = match(first, second)

    # OpenCV has no use for the ratios but a fixed limit on them.
    good = ratio < 0.85
    start = time.perf_counter()
    E, mask = cv2.findEssentialMat(x1[good], x2[good], K, method=cv2.USAC_ACCURATE, prob=0.999, threshold=1.0)
    count, R, t, _ = cv2.recoverPose(E, x1[good], x2[good], K, mask=mask)
    show("OpenCV", count, int(good.sum()), R, t, time.perf_counter() - start)

    diffsac.estimate_essential(x1[:8], x2[:8], K, K, ratio[:8])  # The network is read once.
    start = time.perf_counter()
    estimate = diffsac.estimate_essential(x1, x2, K, K, ratio)
    seconds = time.perf_counter() - start
    if estimate.pose is None:
        sys.exit(f"diffsac: {estimate.status.value}")
    show("diffsac", estimate.num_inliers, len(x1), estimate.pose.rotation, estimate.pose.translation, seconds)


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
