"""The motion between two point clouds, by matches of them, or between every two scans of a folder.

    python -m diffsac.register a.ply b.ply                             R and t with y = R x + t; aligned.ply
    python -m diffsac.register scans --output graph                    all pairs of a folder: registrations.csv, pose_graph.g2o
    python -m diffsac.register --from-matches m.csv --task similarity  your own matches: x1 y1 z1 x2 y2 z2 [ratio]

Exit status: 0 a motion (of a folder, one that may not be chance), 1 none, 2 bad input, 130 interrupted. More: docs/registration.md.
"""

import argparse
import contextlib
import csv
import io
import itertools
import json
import math
import os
import pathlib
import re
import signal
import sys
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

import diffsac

from ._results import Floats, PoseEstimate
from .open3d import as_cloud, describe, matched, matrix, open3d

COLUMNS = ["x1", "y1", "z1", "x2", "y2", "z2", "ratio", "score"]
ENDINGS = (".ply", ".pcd", ".xyz", ".xyzn", ".xyzrgb", ".pts")
TABLE = "first second status matches inliers may_be_chance ambiguous edge hold overlap_first overlap_second rmse x y z qx qy qz qw"
WARNINGS = (
    "the surfaces that overlap slide on each other, as planes, spheres and pipes do: they leave the motion open",
    "another motion explains hardly fewer matches: the thing may be symmetric, or repeat itself",
    "no more inliers than matches of unlike clouds would give: they may share nothing",
)
MOST_POINTS, LEAST_HOLD = 10000, 0.1  # Of a cloud that is thinned out without --voxel; below, surfaces slide on each other.


@dataclass
class Found:
    """What matches say of the motion between two clouds; of scans `motion` is between the files' frames, after ICP."""

    matches: int
    estimate: PoseEstimate  # Between points about `origin` of the first file and the second scan's middle.
    motion: Floats  # 4 x 4, without a scale.
    middle: Floats  # Of the inliers, in the first cloud.
    origin: Floats
    scale: Optional[float] = None
    overlap: Tuple[float, float, float] = (0.0, 0.0, 0.0)  # Of the first, of the second, and of the first before ICP.
    rmse: float = 0.0
    hold: float = 1.0  # How firmly the surfaces that overlap hold each other, from 0 to 1 (Gelfand et al., 3DIM 2003).

    @property
    def is_edge(self) -> bool:
        """Found, not by chance, of surfaces that hold, with a covariance and so without a rival."""
        return self.estimate.pose_covariance is not None and not self.estimate.may_be_chance and self.hold >= LEAST_HOLD

    def covariance(self, lever: Floats) -> Floats:
        """Of (ω, t) or (ω, t, log s) of the same motion of points whose origin is elsewhere by the lever."""
        given, (x, y, z) = np.asarray(self.estimate.pose_covariance), (self.scale or 1.0) * self.motion[:3, :3] @ lever
        change = np.eye(len(given))
        change[3:6, :3], change[3:6, 6:] = [[0, -z, y], [z, 0, -x], [-y, x, 0]], [[-x], [-y], [-z]]
        return np.asarray(change @ given @ change.T)


def estimated(x: Floats, y: Floats, scaled: bool, options: Dict[str, Any], origin: Optional[Floats] = None) -> Found:
    found = (diffsac.estimate_similarity if scaled else diffsac.estimate_rigid_motion)(x, y, **options)
    motion = np.column_stack([found.pose.rotation, found.pose.translation]) if found.pose else np.eye(3, 4)
    middle = (x[found.inliers] / max(1, found.num_inliers)).sum(0)
    return Found(len(x), found, matrix(motion), middle, np.zeros(3) if origin is None else origin, getattr(found, "scale", None))


def read_matches(path: str) -> Tuple[Floats, Floats, Dict[str, Any]]:
    """Numbers separated by blanks, tabs, commas or semicolons, `#` starting a comment; the first line may name the columns. Or one array."""
    try:
        if path.endswith(".npy"):
            values = np.load(path, allow_pickle=False)
            names = COLUMNS[: values.shape[-1]]
        else:
            lines = [one for one in (line.split("#")[0].strip() for line in pathlib.Path(path).read_text(encoding="utf-8-sig").splitlines()) if one]
            separator = next((one for one in ";,\t" if one in "".join(lines[:1])), None)
            cells = [cell.strip(" \"'").lower() for cell in "".join(lines[:1]).split(separator)]
            named = not any(re.match(r"[-+]?\.?\d|[-+]?(nan|inf)$", cell) for cell in cells)
            names = [cell for cell in cells if cell in COLUMNS] if named else COLUMNS[: len(cells)]
            wanted = [cells.index(name) for name in names] if named else None
            values = np.loadtxt(lines[named:], delimiter=separator, usecols=wanted, ndmin=2) if lines[named:] else np.zeros((0, 0))
        if values.ndim != 2 or values.shape[1] != len(names) or any(names.count(name) != 1 for name in COLUMNS[:6]):
            raise ValueError(f"expected rows of {' '.join(COLUMNS[:6])} and what there is of ratio or score, found {values.shape}")
    except (ValueError, EOFError, OSError) as error:
        raise ValueError(f"{path}: {error}") from None
    x, y = (values[:, [names.index(name) for name in side]] for side in (COLUMNS[:3], COLUMNS[3:6]))
    return x, y, dict([(ours, values[:, names.index(name)]) for name, ours in (("score", "scores"), ("ratio", "snn_ratio")) if name in names][-1:])


def read_cloud(path: str) -> Tuple[Any, int]:
    """A cloud, and how many points without finite coordinates it has besides."""
    pathlib.Path(path).stat()  # An error that names the file.
    with contextlib.redirect_stdout(io.StringIO()) as said, open3d().utility.VerbosityContextManager(open3d().utility.VerbosityLevel.Warning):
        cloud = open3d().io.read_point_cloud(path)  # Of a file that ends too early it has points, and says so.
    count = len(cloud.points)
    cloud.remove_non_finite_points()
    if said.getvalue() or cloud.is_empty() or not np.isfinite(np.ptp(np.asarray(cloud.points)) ** 2):
        raise ValueError(f"{path}: no points with finite coordinates that can be read, of a file whose name ends as one of {', '.join(ENDINGS)}")
    return cloud, count - len(cloud.points)


def suitable_voxel(cloud: Any) -> float:
    """Twice the median distance of a point to the nearest other one, or as much as leaves 10 000 points; 0 where all are at one place."""
    points = np.unique(np.asarray(cloud.points), axis=0)
    cloud, tree = as_cloud(points), open3d().geometry.KDTreeFlann(as_cloud(points))
    near = [tree.search_knn_vector_3d(point, 2) for point in points[:: max(1, len(points) // 1000)]]
    distances = sorted(math.sqrt(squares[1]) for count, _, squares in near if count == 2)
    # Voxels are counted by integers.
    voxel = max(2.0 * distances[len(distances) // 2], 1e-6 * float(np.ptp(points, axis=0).max())) if distances else 0.0
    while voxel > 0.0 and (left := len(cloud.voxel_down_sample(voxel).points)) > MOST_POINTS:
        voxel *= max(1.05, math.sqrt(left / MOST_POINTS))
    return voxel


def read_scans(paths: List[str], options: argparse.Namespace) -> List[SimpleNamespace]:
    """All are thinned out to cubes that suit each. Normals that a file lacks look at its frame's origin, where the scanner was, unless a cloud
    lies far from there. Sets the greatest distance of an inlier, where none is given."""
    voxel, scanner, scans = options.voxel or 0.0, True, []
    clouds = [read_cloud(path) for path in paths]
    for cloud, _ in clouds:
        low, high = cloud.get_min_bound(), cloud.get_max_bound()
        scanner = scanner and bool(np.maximum(low, -high).max() <= 0.5 * np.linalg.norm(high - low))
        voxel = voxel if options.voxel is not None else max(voxel, suitable_voxel(cloud))
    options.max_distance = 2.0 * voxel or 1.0 if options.max_distance is None else options.max_distance
    for path, (cloud, left_out) in zip(paths, clouds):
        if options.voxel is not None and not 1e-9 * np.ptp(np.asarray(cloud.points), axis=0).max() <= voxel < math.inf:
            raise ValueError(f"{path}: a voxel of {voxel} is too small, or too large, for its extent")
        name, middle = pathlib.Path(path).name, cloud.get_center()
        text = f"{name}: {len(cloud.points)} points" + (f", {left_out} more are not finite" if left_out else "")
        cloud.translate(-middle)  # Clouds far from the origin would lose digits.
        viewpoint, empty = -middle if scanner else None, (as_cloud(np.zeros((0, 3))), np.zeros((33, 0)))
        thinned, features = describe(cloud, voxel, viewpoint=viewpoint) if voxel > 0.0 else empty
        scans.append(SimpleNamespace(voxel=voxel, name=name, text=f"{text}, described {features.shape[1]}\n", middle=middle, cloud=thinned, features=features))
    return scans


def register(first: SimpleNamespace, second: SimpleNamespace, reach: float, seed: int) -> Found:
    """By mutual matches of the descriptors; then point-to-plane ICP of the thinned clouds, where that brings no fewer points together."""
    pairs, ratios = matched(first.features, second.features, True, 0.0)
    x, y = (np.asarray(scan.cloud.points)[rows] for scan, rows in zip((first, second), pairs.T))
    found = estimated(x, y, False, {"snn_ratio": ratios, "max_residual": reach, "seed": seed}, first.middle)
    if not found.estimate.ok:
        return found
    o3d, ours = open3d(), open3d().pipelines.registration
    # Threads add in the order in which they end; one adds in order. Before Open3D 0.20 OMP_NUM_THREADS says so.
    threads, limit = getattr(o3d.utility, "get_max_threads", int)(), getattr(o3d.utility, "set_max_threads", int)
    limit(1)
    before = best = ours.evaluate_registration(first.cloud, second.cloud, reach, found.motion)
    refined = ours.registration_icp(first.cloud, second.cloud, reach, found.motion, ours.TransformationEstimationPointToPlane())
    if refined.fitness >= before.fitness and np.isfinite(refined.transformation).all():
        best = refined
    back = ours.evaluate_registration(second.cloud, first.cloud, reach, np.linalg.inv(best.transformation))
    limit(threads)
    found.overlap, found.rmse, found.motion = (best.fitness, back.fitness, before.fitness), best.inlier_rmse, np.array(best.transformation)
    found.motion[:3, 3] += second.middle - found.motion[:3, :3] @ first.middle
    rows = np.asarray(best.correspondence_set).reshape(-1, 2)[:, 1]
    points, normals = np.asarray(second.cloud.points)[rows], np.asarray(second.cloud.normals)[rows]
    arms = points - points.mean(0) if len(rows) else points
    # By how much distances between the surfaces change as they turn (at their root mean square radius) and move.
    changes = np.hstack([np.cross(arms, normals) / math.sqrt((arms**2).sum() / max(1, len(rows)) or 1.0), normals])
    found.hold = math.sqrt(max(0.0, np.linalg.eigvalsh(changes.T @ changes / max(1, len(rows)))[0]))
    return found


def numbers(values: Any, between: str = " ") -> str:
    """As short as they read back to the same."""
    return between.join(repr(float(value)).removesuffix(".0") for value in values)


def pose_of(motion: Floats) -> Floats:
    """x y z, and the quaternion x y z w, of which w is not negative: a row of four times the products of each two."""
    (a, b, c), (d, e, f), (g, h, i) = motion[:3, :3]
    products = [1 + a - e - i, b + d, c + g, h - f, b + d, 1 - a + e - i, f + h, c - g, c + g, f + h, 1 - a - e + i, d - b, h - f, c - g, d - b, 1 + a + e + i]
    row = np.reshape(products, (4, 4))[np.argmax(products[::5])]
    return np.append(motion[:3, 3], row / math.copysign(float(np.linalg.norm(row)), row[3]) + 0.0)


def transform_text(motion: Floats, scale: str = "") -> str:
    rows, q = ["".join(f" {one:14.7g}" for one in row) for row in motion[:3, :3]], pose_of(motion)[3:]
    sine = float(np.linalg.norm(q[:3]))
    axis = ", ".join(f"{one:.4f}" for one in (q[:3] / sine if sine > 0.0 else np.eye(3)[0]))
    turned = f"  turned by {math.degrees(2.0 * math.atan2(sine, q[3])):.3f} degrees about ({axis})"
    return "  R = " + "\n      ".join(rows) + f"\n{turned}\n  t =  ({numbers(motion[:3, 3], ', ')}); y = {scale}R x + t\n"


def counts_text(matches: int, counted: Any, ignored: bool = False) -> str:
    unused = (counted.num_duplicates, " repeated"), (counted.num_nonfinite, " not finite"), (ignored or "", "their ratios or scores not used")
    return f"matches: {matches}" + "".join(f", {'' if one is True else one}{word}" for one, word in unused if one) + "\n"


def told(found: Found) -> Tuple[str, Dict[str, Any]]:
    """For people, and for programs; with warnings."""
    e, (scaled, kind) = found.estimate, (True, "similarity") if found.scale is not None else (False, "rigid motion")
    text = counts_text(found.matches, e.diagnostics, e.diagnostics.scores_ignored)
    values: Dict[str, Any] = {"status": e.status.value, "matches": found.matches, "inliers": e.num_inliers}
    if not e.ok:
        return f"{text}no motion: {e.status.value}\n", values
    text += f"{kind}: {e.num_inliers} inliers ({100.0 * e.num_inliers / found.matches:.0f} %), noise {e.sigma:.2g}\n"
    text += transform_text(found.motion, "s " if scaled else "") + (f"  s = {numbers([found.scale])}" if scaled else "")
    values.update(rotation=found.motion[:3, :3], translation=found.motion[:3, 3], **({"scale": found.scale} if scaled else {}), covariance=None)
    if e.pose_covariance is not None:
        (x, y, z), own, moved = found.middle + found.origin, found.covariance(found.origin), found.covariance(-found.middle)
        R, t, place = (math.sqrt(max(0.0, np.linalg.eigvalsh(part)[2])) for part in (own[:3, :3], own[3:6, 3:6], moved[3:6, 3:6]))
        text += f", within {100.0 * math.sqrt(own[6, 6]):.2g} %" if scaled else ""
        text += "\n" * scaled + f"  standard deviations by noise alone: R {math.degrees(R):.2g} degrees, t {t:.2g}\n"
        text += f"  where the middle of the inliers, ({x:.7g}, {y:.7g}, {z:.7g}), moves to: within {place:.2g}\n"
        values.update(covariance=own, middle=[x, y, z], covariance_at_middle=moved)
    values.update(sigma=e.sigma, log10_nfa=e.diagnostics.log10_nfa, may_be_chance=e.may_be_chance)
    values.update(scores_ignored=e.diagnostics.scores_ignored, ambiguous=e.ambiguous_pose is not None)
    for says in (says for says, holds in zip(WARNINGS, (found.hold < LEAST_HOLD, e.ambiguous, e.may_be_chance)) if holds):
        print(f"warning: {says}", file=sys.stderr)
    return text, values


def write(path: str, text: str) -> None:
    pathlib.Path(f"{path}.part").write_text(text, encoding="utf-8")
    os.replace(f"{path}.part", path)


def run_matches(options: argparse.Namespace) -> Tuple[str, Dict[str, Any]]:
    x, y, quality = read_matches(options.from_matches)
    given = {**quality, "seed": options.seed, "max_residual": options.max_distance}
    if not options.several:
        found = estimated(x, y, options.task == "similarity", given)
        e, (text, values) = found.estimate, told(found)
        other = {} if e.ambiguous_pose is None else {"ambiguous_motion": vars(e.ambiguous_pose)}
        values = {"file": options.from_matches, "task": options.task or "rigid", **values, **other, "inlier_threshold": e.inlier_threshold}
        return text, {**values, "inlier_rows": np.flatnonzero(e.inliers), "posteriors": e.posteriors}
    several = diffsac.estimate_multiple_rigid_motions(x, y, **given)
    counts, motions = np.bincount(several.assignment, minlength=len(several.models) + 1), [matrix(model) for model in several.models]
    text = "".join(f"rigid motion {k + 1}: {counts[k + 1]} matches\n{transform_text(motion)}" for k, motion in enumerate(motions))
    each = [{"rotation": motion[:3, :3], "translation": motion[:3, 3]} for motion in motions]
    values = {"file": options.from_matches, "status": several.status.value, "motions": each, "assignment": several.assignment}
    return counts_text(len(x), several) + (text if several.ok else f"no motion: {several.status.value}\n"), values


def run_two(options: argparse.Namespace) -> Tuple[str, Dict[str, Any]]:
    output = "aligned.ply" if options.output is None else options.output
    first, second = read_scans(options.scans, options)
    found = register(first, second, options.max_distance, options.seed)
    (text, values), (one, two, before) = told(found), found.overlap
    text = f"voxel: {numbers([first.voxel])}\n{first.text}{second.text}{text}"
    if found.estimate.ok:
        text += f"overlap: {100 * one:.0f} % of the first, {100 * two:.0f} % of the second; RMSE {found.rmse:.2g} "
        text += f"(before ICP {100 * before:.0f} % of the first)\n"
        values.update(overlap=[one, two], rmse=found.rmse, hold=found.hold)
    if found.estimate.ok and output:
        part = f"{output}.part{pathlib.Path(output).suffix}"
        if not open3d().io.write_point_cloud(part, read_cloud(options.scans[0])[0].transform(found.motion)):
            raise ValueError(f"{output}: cannot be written; expected a name that ends as one of {', '.join(ENDINGS)}")
        os.replace(part, output)
        text += f"moved: {output}\n"
    return text, {"first": options.scans[0], "second": options.scans[1], **values}


def pose_graph(scans: List[SimpleNamespace], pairs: List[Tuple[int, int, Found]]) -> str:
    """As g2o reads it: a VERTEX_SE3:QUAT for each scan, its pose by the edges of most inliers from the first scan of its group, which has a
    FIX; an EDGE_SE3:QUAT for each pair that is an edge, with the inverse of the matches' covariance."""
    edges = sorted((pair for pair in pairs if pair[2].is_edge), key=lambda pair: -pair[2].estimate.num_inliers)
    poses, lines = {}, []
    for first, scan in enumerate(scans):
        if first not in poses:
            lines.append(f"FIX {first}")
            poses[first] = np.eye(4)
        while edge := next((pair for pair in edges if (pair[0] in poses) != (pair[1] in poses)), None):
            i, j, found = edge
            poses.update({j: poses[i] @ np.linalg.inv(found.motion)} if i in poses else {i: poses[j] @ found.motion})
    vertices = [f"# {i}: {scan.name}\nVERTEX_SE3:QUAT {i} {numbers(pose_of(poses[i]))}" for i, scan in enumerate(scans)]
    for i, j, found in (pair for pair in pairs if pair[2].is_edge):
        # An error of g2o's, (translation, half a turn) in the first frame, turns by twice R of the one and moves t by R of the other.
        R, zero = found.motion[:3, :3], np.zeros((3, 3))
        change = np.block([[zero, R.T], [0.5 * R.T, zero]])
        information = np.linalg.inv(change @ found.covariance(found.origin) @ change.T)
        upper = (0.5 * (information + information.T))[np.triu_indices(6)]
        lines.append(f"EDGE_SE3:QUAT {j} {i} {numbers([*pose_of(found.motion), *upper])}")
    return "\n".join(vertices + lines) + "\n"


def run_folder(options: argparse.Namespace) -> int:
    folder, output = pathlib.Path(options.scans[0]), pathlib.Path(options.output or "registered")
    graph, listed = str(output / "pose_graph.g2o"), str(output / "registrations.csv")
    for file in (file for file in (graph, listed) if os.path.exists(file) and not options.overwrite):
        raise ValueError(f"{file}: is there already; --overwrite replaces it")
    paths = sorted(str(path) for path in folder.iterdir() if str(path).lower().endswith(ENDINGS) and path.is_file())
    if len(paths) < 2:
        raise ValueError(f"{folder}: expected a folder with two clouds or more")
    scans, pairs, stopped, table = read_scans(paths, options), [], [], io.StringIO()
    output.mkdir(parents=True, exist_ok=True)
    for one in (signal.SIGINT, signal.SIGTERM):
        signal.signal(one, lambda number, frame: stopped.append(number))
    writer = csv.writer(table, lineterminator="\n")
    writer.writerow(TABLE.split())
    for i, j in itertools.combinations(range(len(scans)), 2):
        if stopped:
            break
        found = register(scans[i], scans[j], options.max_distance, options.seed)
        e, names, (share, other, _) = found.estimate, (scans[i].name, scans[j].name), found.overlap
        pairs.append((i, j, found))
        signs = [int(sign) for sign in (e.may_be_chance, e.ambiguous, found.is_edge)]
        fit = [f"{found.hold:.3f}", f"{share:.4f}", f"{other:.4f}", f"{found.rmse:.6g}", *numbers(pose_of(found.motion)).split()] if e.ok else [""] * 11
        writer.writerow([*names, e.status.value, found.matches, e.num_inliers, *signs, *fit])
        said = ", may be chance" * signs[0] + ", ambiguous" * signs[1] + ", slides" * (found.hold < LEAST_HOLD)
        text = f"{e.num_inliers} of {found.matches} matches, overlap {100 * share:.0f} %{said}" if e.ok else f"no motion: {e.status.value}"
        print(f"{' - '.join(names)}: {text}", flush=True)
    write(listed, table.getvalue())
    write(graph, pose_graph(scans, pairs))
    edges = sum(pair[2].is_edge for pair in pairs)
    print(f"{edges} of {len(pairs)} pairs are edges of {graph}")
    return 130 if stopped else 0 if edges else 1


def parsed(arguments: Optional[Sequence[str]]) -> argparse.Namespace:
    parser = argparse.ArgumentParser("diffsac.register", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("--version", action="version", version=f"diffsac.register {diffsac.__version__}")
    add("scans", nargs="*", help="two clouds (PLY, PCD, XYZ, PTS), or a folder of them")
    add("--from-matches", help="instead: a file of matches, a line each: x1 y1 z1 x2 y2 z2 [ratio or score]; with a header in any order; or .npy, .npz, .h5")
    add("--task", choices=["rigid", "similarity"], help="of --from-matches: rigid (the default), or similarity, with a scale")
    add("--several", action="store_true", default=None, help="of --from-matches: all rigid motions of things that move by themselves")
    add("--voxel", type=float, help="clouds are thinned out to a point a cube of this side (default: twice their resolution, or what leaves 10 000)")
    add("--max-distance", type=float, help="the greatest distance of an inlier (default: two voxels; of matches two resolutions of the second cloud)")
    add("--output", help="two clouds: the first one, moved onto the second (default: aligned.ply; empty: none). A folder: a folder (default: registered)")
    add("--json", help="two clouds, or matches: also everything as JSON in this file")
    add("--overwrite", action="store_true", default=None, help="a folder: replaces results that are there")
    add("--seed", type=int, default=0, help="of the search; every pair has the same (default: 0)")
    given = parser.parse_args(arguments)
    kind = 0 if given.from_matches is not None else len(given.scans)
    if kind > 2 or (kind == 0 and given.from_matches is None):
        parser.error("expected two scans, a folder of them, or --from-matches")
    unread = (("scans", "voxel", "output", "overwrite"), ("task", "several", "json"), ("task", "several", "overwrite"))[kind]
    for name in (name for name in unread if getattr(given, name) not in (None, [])):
        parser.error(f"{name}: is not for {('--from-matches', 'a folder', 'two clouds')[kind]}")
    if given.several and given.task == "similarity":
        parser.error("several: is for --task rigid")
    for path in (path for path in (given.json, given.output) if path and kind != 1):
        if os.path.realpath(path) in map(os.path.realpath, [*given.scans, given.from_matches or ""]):
            parser.error(f"{path}: is an input")
    return given


def main(arguments: Optional[Sequence[str]] = None) -> int:
    os.environ["OMP_NUM_THREADS"] = "1"
    options = parsed(arguments)
    try:
        if len(options.scans) == 1:
            return run_folder(options)
        text, values = (run_two if options.scans else run_matches)(options)
        print(text, end="", flush=True)
        if options.json:
            values = {key: None if isinstance(one, float) and not math.isfinite(one) else one for key, one in values.items()}
            write(options.json, json.dumps(values, indent=2, ensure_ascii=False, default=np.ndarray.tolist) + "\n")
        return 0 if values["status"] == "ok" else 1
    except (ValueError, OSError, ImportError) as error:
        print(f"diffsac.register: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
