"""Metrics of groups of problems (docs/metrics.md). Sums follow the order of problems.csv, so that values halfway between two printed digits
always round alike."""
import math

import numpy as np
import pandas as pd

COUNTS = ("problems", "failures", "may_be_chance")
MEDIANS = ("inliers", "hypotheses", "unique_minimal_sets", "ms_features", "ms_network", "ms_consensus", "ms_total")
SETS = "one_structure_sets"  # The share of minimal sets that are of one true structure.


class Tolerance:
    """Threshold c of mAA@c and its unit."""

    def __init__(self, value, pixels=False):
        self.value, self.pixels = value, pixels
        # In pixels evenly spread in their logarithms (Jin et al., IJCV 2021).
        self.bars = np.array([math.pow(value, k / 9) if pixels else (k + 1) * value / 10 for k in range(10)])

    def named(self, metric):
        return f"{metric}@{self.value:g}{'px' if self.pixels else 'deg'}"

    def main_error(self, problems):
        return problems["error_px" if self.pixels else "angle_deg"].to_numpy(float)

    def of_pose(self):
        return Tolerance(10.0) if self.pixels else self

    def shares(self, errors):
        """Returns each error's share of the ten thresholds that it does not exceed; 0 for NaN."""
        return (errors[:, None] <= self.bars).sum(axis=1) / 10

    def accuracies(self, errors):
        return np.where(np.isnan(errors), np.nan, self.shares(errors))


def accuracy_of(problems, tolerance):
    """Returns each problem's accuracy for tables, intervals and differences: the recall with several structures, else its share in mAA."""
    accuracy = tolerance.accuracies(tolerance.main_error(problems))
    recall = column(problems, "recall")
    return np.where(np.isnan(recall), accuracy, recall)


def column(problems, name):
    """Returns a column of numbers, NaN if the file lacks it."""
    return problems[name].to_numpy(float) if name in problems else np.full(len(problems), np.nan)


class Groups:
    """Statistics per group. `codes` holds the group of each value."""

    def __init__(self, codes, count):
        self.codes, self.count = np.asarray(codes), count

    def sizes(self, listed):
        return np.bincount(self.codes[listed], minlength=self.count)

    def sums(self, values, listed):
        return np.bincount(self.codes[listed], values[listed], self.count)

    def means(self, values, listed=None):
        """Means of the known values, or of the values selected by `listed`."""
        listed = ~np.isnan(values) if listed is None else listed
        with np.errstate(invalid="ignore"):
            return self.sums(values, listed) / self.sizes(listed)

    def medians(self, values):
        return pd.Series(values).groupby(self.codes).median().reindex(range(self.count)).to_numpy()

    def areas(self, errors, listed, limit):
        """Exact AUC: area under the recall curve of the sorted errors, trapezoids from (0, 0), clipped at `limit` (Sarlin et al., CVPR 2020)."""
        below = np.flatnonzero(listed & (errors < limit))
        below = below[np.lexsort((errors[below], self.codes[below]))]
        group, error, total = self.codes[below], errors[below], self.sizes(listed).astype(float)
        starts = np.concatenate([[True], group[1:] != group[:-1]]) if len(group) else np.zeros(0, bool)
        rank = np.arange(len(group)) - np.maximum.accumulate(np.where(starts, np.arange(len(group)), 0))
        recall, before = (rank + 1) / total[group], rank / total[group]
        widths = error - np.where(starts, 0.0, np.roll(error, 1))
        area = np.bincount(group, widths * (recall + before) / 2, self.count)
        last_error, last_recall = np.zeros(self.count), np.zeros(self.count)
        last_error[group], last_recall[group] = error, recall  # The last assignment stays.
        return np.where(total > 0, (area + (limit - last_error) * last_recall) / limit, np.nan)


def recall_area(errors, limit):
    """recall_AUC as CONSAC's program computes it for vanishing points (Kluger et al., CVPR 2020): starts at the smallest error, and interpolates
    the recall at the limit from its two neighbours, weighted by their errors."""
    if len(errors) == 0:
        return math.nan
    errors = np.sort(errors)
    recall, below = np.arange(1, len(errors) + 1) / len(errors), int(np.searchsorted(errors, limit))
    if below == 0:
        return 0.0
    area = (0.5 * np.diff(errors[:below]) * (recall[1:below] + recall[:below - 1])).sum()
    last, at_limit = errors[below - 1], 1.0
    if below < len(errors):
        following = errors[below]
        at_limit = (last * recall[below - 1] + following * recall[below]) / (last + following) if following > limit else recall[below]
    return float((area + 0.5 * (limit - last) * (recall[below - 1] + at_limit)) / limit)


def _angles(problems):
    """Returns the structures' angles of each problem, or None if no problem has any."""
    texts = problems["structure_angles_deg"] if "structure_angles_deg" in problems else ()
    return [np.array(text.split(), float) for text in texts] if any(texts) else None


# The metric that a kind is judged by where it is known.
JUDGED = {"poses": "median_R_deg", "focal": "median_focal_percent", "given": "mAA_pose", "instances": "recall", "angles": "structures_within"}


def metrics_by(problems, groups, c):
    """Yields (kind, name, values by group) of every metric, in the order of the output files."""
    errors, every = c.main_error(problems), np.ones(len(problems), bool)
    judged = ~np.isnan(errors)
    failed, chance = problems["failed"].to_numpy(float), column(problems, "log10_nfa") > 0

    def values(name):
        return column(problems, name)

    yield "", c.named("mAA"), groups.means(c.accuracies(errors))
    yield "", c.named("AUC"), groups.areas(errors, judged, c.value)
    yield "", c.named("acc"), groups.means((errors <= c.value).astype(float), judged)
    yield "", "median_px" if c.pixels else "median_deg", groups.medians(errors)
    yield "", "median_offset", groups.medians(np.where(judged, values("offset"), np.nan))
    yield "", "problems", groups.sizes(every).astype(float)
    yield "", "failures", groups.sums(failed, every)
    yield "", "may_be_chance", groups.sums(chance.astype(float), every)
    for name in MEDIANS[:3]:
        yield "", name, groups.medians(values(name))
    yield "", "all_inlier_sets", groups.means(values("all_inlier_sets"))
    for name in MEDIANS[3:]:
        yield "", name, groups.medians(values(name))
    rotation, translation = values("rotation_deg"), values("translation_deg")
    posed = ~np.isnan(rotation) & (not c.pixels)
    yield "poses", c.named("mAA_R"), groups.means(c.shares(rotation), posed)
    yield "poses", c.named("mAA_t"), groups.means(c.shares(translation), posed)
    for degrees in (5.0, 10.0, 20.0):
        if degrees != c.value:
            yield "poses", Tolerance(degrees).named("AUC"), groups.areas(values("angle_deg"), posed, degrees)
    yield "poses", "median_R_deg", groups.medians(np.where(posed, rotation, np.nan))
    yield "poses", "median_t_deg", groups.medians(np.where(posed, translation, np.nan))
    for percent in (68, 95):  # Shares of the pairs whose covariance's region of that confidence holds the truth.
        for letter, levels in (("R", values("rotation_level")), ("t", values("translation_level"))):
            yield "poses", f"held_{letter}_{percent}", groups.means((levels <= 0.01 * percent).astype(float), posed & ~np.isnan(levels))
    yield "focal", "median_focal_percent", 100.0 * groups.medians(np.where(posed, values("focal_error"), np.nan))
    given = values("pose_deg")
    yield "given", c.of_pose().named("mAA_pose"), groups.means(c.of_pose().shares(given), ~np.isnan(given))
    yield "instances", "misclassification", groups.means(values("misclassified"))
    yield "instances", "misclassification_median", groups.medians(values("misclassified"))
    for name in ("recall", "structures", SETS, "structures_in_sets"):
        yield "instances", name, groups.means(values(name))
    angles = _angles(problems)
    if angles is not None:
        pooled = [np.concatenate([np.zeros(0), *(angles[i] for i in np.flatnonzero(groups.codes == g))]) for g in range(groups.count)]
        for part in (0.5 * c.value, c.value):
            yield "angles", Tolerance(part, c.pixels).named("recall_AUC"), np.array([recall_area(one, part) for one in pooled])
        yield "angles", c.named("structures_within"), np.array([(one <= c.value).mean() if len(one) else np.nan for one in pooled])
    yield "instances", "draws", groups.medians(values("draws"))


def cell_metrics(problems, c):
    """Returns scene -> metric -> value for each cell (column `cell`: 0, 1, ... without gaps). `mean` is the unweighted mean over scenes, with
    counts summed. `all_pairs` pools all problems; it exists with several scenes only."""
    problems, cells = problems.reset_index(drop=True), int(problems["cell"].max()) + 1
    scene, names = pd.factorize(problems["scene"])
    codes, places = pd.factorize(problems["cell"].to_numpy() * len(names) + scene)
    cell_of = places // len(names)
    parts = Groups(cell_of, cells)
    by_scene = list(metrics_by(problems, Groups(codes, len(places)), c))
    whole, found = list(metrics_by(problems, Groups(problems["cell"], cells), c)), []
    kinds = {kind: ~np.isnan(values) for kind, name, values in whole if kind and name.split("@")[0] == JUDGED[kind]}
    for cell in range(cells):
        own = np.flatnonzero(cell_of == cell)
        rows = [(names[places[g] % len(names)], by_scene, g) for g in own] + [("mean", None, cell)] + ([("all_pairs", whole, cell)] if len(own) > 1 else [])
        found.append({scene: {} for scene, _, _ in rows})
        for scene, source, at in rows:
            for kind, name, values in source or ():
                if not kind or kinds[kind][cell]:
                    found[-1][scene][name] = values[at]
    for kind, name, values in by_scene:
        over = parts.sums(values, ~np.isnan(values)) if name in COUNTS else parts.means(values)
        for cell in range(cells):
            if not kind or kinds[kind][cell]:
                found[cell]["mean"][name] = over[cell]
    return found


def add_deviations(metrics, problems, c):
    """Adds the sample standard deviations over seeds as scenes mean_seed_deviation and all_pairs_seed_deviation."""
    runs = problems.groupby(["cell", "run"], sort=True)
    of_runs = cell_metrics(problems.assign(cell=runs.ngroup()), c)
    cell_of = [cell for cell, _ in runs.groups]
    for cell, known in enumerate(metrics):
        own = [one for of, one in zip(cell_of, of_runs) if of == cell]
        for scene in ("mean", "all_pairs") if len(own) > 1 else ():
            for name in own[0].get(scene, ()):
                values = np.array([one.get(scene, {}).get(name, np.nan) for one in own])
                deviation = math.sqrt(((values - values.mean()) ** 2).sum() / (len(values) - 1)) if np.isfinite(values).all() else math.nan
                known.setdefault(scene + "_seed_deviation", {})[name] = deviation
