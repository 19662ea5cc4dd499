"""AdelaideRMF's tentative matches as problems of one homography, that of the plane of whose labelled matches most tentative ones are."""

import numpy as np

NEAR_PX, FEWEST_LABELS, MOST_OF_ANOTHER, LARGEST_DISAGREEMENT_PX, GRID_STEP = 3.0, 8, 2 / 3, 4.0, 4


def homogeneous(points):
    return np.column_stack([points, np.ones(len(points))])


def transferred(H, points):
    with np.errstate(divide="ignore", invalid="ignore"):
        moved = homogeneous(points) @ H.T
        return moved[:, :2] / moved[:, 2:]


def sampson(H, matches):
    """The signed first-order distances of Chum, Pajdla and Sturm (CVIU 2005), two a match, so scaled that they are |H x1 - x2| where H
    keeps lengths."""
    x2, moved = matches[:, 2:], homogeneous(matches[:, :2]) @ H.T
    w = moved[:, 2]
    e = x2 * w[:, None] - moved[:, :2]
    J = np.zeros((len(matches), 2, 4))
    J[:, :, :2] = x2[:, :, None] * H[2, :2] - H[:2, :2]
    J[:, [0, 1], [2, 3]] = w[:, None]
    return np.sqrt(2) * np.linalg.solve(np.linalg.cholesky(J @ J.transpose(0, 2, 1)), e[:, :, None])[:, :, 0]


def linear(matches):
    """The direct linear transformation in normalised coordinates; None where it is not determined."""
    sides, normal = [], []
    for points in (matches[:, :2], matches[:, 2:]):
        centre = points.mean(0)
        spread = np.linalg.norm(points - centre, axis=1).mean()
        if not spread > 0:
            return None
        s = np.sqrt(2) / spread
        normal.append(np.array([[s, 0, -s * centre[0]], [0, s, -s * centre[1]], [0, 0, 1]]))
        sides.append((points - centre) * s)
    a, (u, v), zero = homogeneous(sides[0]), sides[1].T, np.zeros((len(matches), 3))
    rows = np.vstack([np.hstack([a, zero, -u[:, None] * a]), np.hstack([zero, a, -v[:, None] * a])])
    _, values, vectors = np.linalg.svd(rows)
    if not values[7] > 1e-9 * values[0]:
        return None
    return np.linalg.inv(normal[1]) @ vectors[8].reshape(3, 3) @ normal[0]


def fit(matches):
    """Least squares of Sampson distances truncated at 3 px, since some labels are wrong."""
    from scipy.optimize import least_squares

    H = linear(matches) if len(matches) >= FEWEST_LABELS else None
    if H is None:
        return None
    for _ in range(50):
        near = np.linalg.norm(sampson(H, matches), axis=1) <= NEAR_PX
        if near.sum() < 4:
            break
        scale = np.linalg.norm(H)
        found = least_squares(lambda h: sampson(h.reshape(3, 3), matches[near]).ravel(), (H / scale).ravel(), xtol=1e-14, ftol=1e-14, gtol=1e-14)
        before, H = H / scale, found.x.reshape(3, 3)
        if (np.linalg.norm(sampson(H, matches), axis=1) <= NEAR_PX).tolist() == near.tolist() or np.allclose(before, H, atol=1e-14):
            break
    H = H / np.linalg.norm(H)
    return H if H.flat[abs(H).argmax()] > 0 else -H


def mean_distance(found, truth, matches, sizes):
    """Over the pixels that both images show by the truth."""
    height1, width1, height2, width2 = sizes
    y, x = np.mgrid[GRID_STEP // 2:height1:GRID_STEP, GRID_STEP // 2:width1:GRID_STEP]
    grid = np.column_stack([x.ravel(), y.ravel()]).astype(float)
    front = -1 if np.sign(homogeneous(matches[:, :2]) @ truth[2]).sum() < 0 else 1
    there = transferred(truth, grid)
    seen = (front * (homogeneous(grid) @ truth[2]) > 0) & (there >= 0).all(1) & (there <= [width2 - 1, height2 - 1]).all(1)
    return np.linalg.norm(transferred(found, grid[seen]) - there[seen], axis=1).mean() if seen.any() else np.inf


def halves_agree(labelled, tentative, sizes):
    if len(labelled) < 2 * FEWEST_LABELS:
        return False
    even, odd = fit(labelled[::2]), fit(labelled[1::2])
    return even is not None and odd is not None and mean_distance(even, odd, tentative, sizes) <= LARGEST_DISAGREEMENT_PX


def dominant_plane(labelled, labels, tentative, sizes):
    """Its homography; or why its truth is not sure."""
    planes = []
    for label in range(1, labels.max() + 1):
        matches = labelled[labels == label]
        H = fit(matches)
        if H is not None:
            near = np.linalg.norm(transferred(H, tentative[:, :2]) - tentative[:, 2:], axis=1) <= NEAR_PX
            planes.append((near.sum(), H, matches))
    planes.sort(key=lambda plane: -plane[0])
    if not planes:
        return None, "no plane has labels enough"
    if len(planes) > 1 and planes[1][0] > MOST_OF_ANOTHER * planes[0][0]:
        return None, "two planes have about as many matches"
    if not halves_agree(planes[0][2], tentative, sizes):
        return None, "its plane's labels do not determine a homography well"
    return planes[0][1], ""
