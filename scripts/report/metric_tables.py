"""Tables of metrics, one row per method: accuracy with costs, errors, poses, areas, structures, scenes. For a user's own points the table of
models. told_tables.py makes the other tables."""
import dataclasses
import math


from metrics import SETS, Tolerance
from tables import UNKNOWN, Row, Table
from values import fixed, known, range_text

TOGETHER = 3  # So many conditions stand in one table of several metrics.
MOST_MODELS = 50  # More are for files.


@dataclasses.dataclass
class Column:
    heading: str
    metric: str
    digits: int = 3
    higher: bool = True
    paper: str = ""  # What the paper's value is called in configurations; none: it has none.
    scene: str = "mean"
    scale: float = 1.0
    condition: int = 0


class MetricTables:
    def __init__(self, run):
        self.run, self.results = run, run.results
        results, pixels = self.results, "threshold_px" in self.results
        self.c = Tolerance(results["threshold_px" if pixels else "threshold_deg"], pixels)
        self.conditions, self.structures = results["conditions"], results["structures"]
        self.truth = any(known(cell[results["accuracy"]["metric"] + "_ci95"]["mean"]) for cell in results["results"])
        self.scenes = max((len(self._scenes(c)) for c in range(len(self.conditions))), default=0)
        self.over = f", unweighted mean over {self.scenes} scenes" if self.scenes > 1 else ""
        counts = [self._count(cell) for cell in results["results"]]
        self.counts_differ = len(set(counts)) > 1

    def _scenes(self, condition):
        return list(dict.fromkeys(scene for (c, _), cell in self.run.cells.items() if c == condition
                                  for scene in list(cell["metrics"])[:list(cell["metrics"]).index("mean")]))

    @staticmethod
    def _count(cell):
        return int(cell["metrics"]["mean"]["problems"])

    def _any(self, metric):
        return any(known(cell["metrics"]["mean"].get(metric)) for cell in self.results["results"])

    def _named(self, metric):
        return any(metric in cell["metrics"]["mean"] for cell in self.results["results"])

    def over_conditions(self, column, unit=""):
        """Repeats the column for each condition, with the condition's label as heading ("0.5", or "0.5: unit")."""
        return [dataclasses.replace(column, condition=c, heading=one["label"] + (f": {unit}" if unit else "")) for c, one in enumerate(self.conditions)]

    def _costs(self, method):
        medians, oracle = method["medians"], method["type"] == "oracle"
        draws = [] if not self.structures else [UNKNOWN if oracle or not medians["draws"] else fixed(medians["draws"], 0)]
        costs = [UNKNOWN, UNKNOWN] if oracle else [fixed(medians["hypotheses"], 0), f"{medians['ms_total']:.3g}"]
        counts = [self._count(cell) for cell in self.results["results"] if cell["method"] == method["name"]]
        several = str(max(counts)) if min(counts) == max(counts) else f"{min(counts)}{UNKNOWN}{max(counts)}"
        return draws + costs + ([several] if self.counts_differ else [])

    def _range(self, column, method):
        """Returns the text of the 95 % interval, which exists for accuracy and sets as means over scenes."""
        of_interval = column.scene == "mean" and column.metric in (self.results["accuracy"]["metric"], SETS)
        interval = self.run.cells.get((column.condition, method), {}).get(column.metric + "_ci95") if of_interval else None
        return range_text(interval, column.digits)

    def table(self, heading, columns, costs=False, inside=False, best=True):
        """Makes a table: methods that ran, then the paper's rows. The best competing value of a column is bold if its methods share their problems.
        `inside` prints intervals in the cells."""
        titles = (["draws"] if self.structures else []) + ["hypotheses", "ms"] + (["n"] if self.counts_differ else []) if costs else []
        table, competing = Table(heading, ["method"] + [column.heading for column in columns] + titles), []
        for m, method in enumerate(self.results["methods"]):
            if not any(key[1] == m for key in self.run.cells):
                continue
            values = [self.run.metric(column.condition, m, column.metric, column.scene) for column in columns]
            values = [value * column.scale if known(value) else None for value, column in zip(values, columns)]
            ranges = [self._range(column, m) for column in columns]
            cells = [fixed(value, column.digits) + (f" {one}" if inside and one else "") for value, column, one in zip(values, columns, ranges)]
            cells = [method["label"]] + cells + (self._costs(method) if costs else [])
            intervals = [""] + (["" for _ in ranges] if inside else ranges)
            table.rows.append(Row(cells, [False] * len(cells), intervals + [""] * (len(cells) - len(intervals))))
            competing.append(values if method["competes"] else [None] * len(values))
        for i, column in enumerate(columns):
            if best and self.conditions[column.condition]["rows_share_problems"]:
                table.mark_best(i + 1, [row[i] for row in competing], column.higher)
        table.rows += self._paper_rows(columns, len(table.columns))
        return table

    def _paper_rows(self, columns, width):
        for label, values in self.results["paper"].items():
            own = [values.get(self.conditions[column.condition]["name"], {}).get(column.paper) for column in columns]
            if any(value is not None for value in own):
                same = label in self.results["paper_of_same_data"]
                cells = [label + (" (published)" if same else " (paper, other data)")] + [paper_text(value) for value in own]
                yield Row(cells + [""] * (width - len(cells)), [False] * width, [], True)

    def together(self, heading, apart, columns):
        """Makes one table of several metrics, or one per metric if there are many conditions."""
        if len(self.conditions) <= TOGETHER:
            return [self.table(heading, [one for column in columns for one in self.over_conditions(column, column.heading)])]
        return [self.table(f"{apart}, {column.heading}", self.over_conditions(column)) for column in columns]

    def main_tables(self):
        """Accuracy and error, or inliers without ground truth. With several seeds also the deviation of the first table."""
        if not self.truth:
            return [self.table("median number of inliers (no ground truth)", self.over_conditions(Column("", "inliers", 0)), True)]
        kinds = self._structure_kinds() if self.structures else self._accuracy_kinds()
        tables = [self.table(heading, self.over_conditions(column), costs, column.metric == SETS) for heading, column, costs in kinds]
        if self.results["seeds"]:
            heading, column, _ = kinds[0]
            heading = heading.split(", higher is better")[0].split(", lower is better")[0]
            column = dataclasses.replace(column, scene=column.scene + "_seed_deviation", paper="")
            tables.append(self.table(f"standard deviation over {len(self.results['seeds'])} seeds of {heading}", self.over_conditions(column), best=False))
        return tables

    def _accuracy_kinds(self):
        name, pixels = self.c.named("mAA"), self.c.pixels
        kinds = [(f"{name}{self.over}, higher is better", Column("", name, paper="mAA"), True)]
        if self.scenes > 1:
            kinds.append((f"{name}, mean over all pairs, higher is better", Column("", name, scene="all_pairs"), False))
        return kinds + [(f"median error in {'pixels' if pixels else 'degrees'}, lower is better",
                         Column("", "median_px" if pixels else "median_deg", higher=False, paper="median"), True)]

    def _structure_kinds(self):
        """Misclassification over all problems (as in papers: AdelaideRMF's scenes are single pairs), recall, quality of minimal sets."""
        every = "all_pairs" if self.scenes > 1 else "mean"
        kinds = [(f"misclassification error in %, {name}, lower is better", Column("", metric, 2, False, metric, every), name == "mean")
                 for name, metric in (("mean", "misclassification"), ("median", "misclassification_median"))]
        kinds.append((f"recall of structures{self.over}, higher is better", Column("", "recall", paper="recall"), False))
        if self._named(self.c.named("structures_within")):
            for part, paper in ((0.5 * self.c.value, "recall_auc_half"), (self.c.value, "recall_auc")):
                name = Tolerance(part, self.c.pixels).named("recall_AUC")
                kinds.append((f"{name} of structures in %, higher is better", Column("", name, 2, True, paper, every, 100.0), False))
            kinds.append((f"structures within {fixed(self.c.value, 1)}° in %, higher is better",
                          Column("", self.c.named("structures_within"), 1, True, "", every, 100.0), False))
        if self._any(SETS):
            kinds += [("share of the first 20 minimal sets that are of one true structure alone", Column("", SETS), False),
                      ("share of the true structures that such a set is of", Column("", "structures_in_sets"), False)]
        return kinds

    def pose_tables(self):
        """Two views: returned pose (beside the model's if there is room), rotation, translation, AUC and failures."""
        name, tables, poses = self.c.named("mAA"), [], self.results["poses"]
        if self._named(given := self.c.of_pose().named("mAA_pose")):
            beside = not self.c.pixels and len(self.conditions) <= TOGETHER
            of = "the pose that is given (R, t with its sign)"
            tables += self.together(of + " beside the model's" * beside, of, [Column(one, one) for one in [name] * beside + [given]])
        for what, letter in (("rotation", "R"), ("translation", "t")) if poses else ():
            tables += self.together(what + " alone", what + " alone", [
                Column(name, self.c.named("mAA_" + letter), paper=letter),
                Column("median degrees", f"median_{letter}_deg", 3, False, "median_" + letter)])
        if self.truth and self.results["two_view"]:
            areas = [Tolerance(limit).named("AUC") for limit in (5.0, 10.0, 20.0)] if poses else [self.c.named("AUC")]
            of = "max(R, t)" if poses else "errors"
            tables += self.together(f"{of}: exact AUC and failures", of, [Column(one, one) for one in areas] + [Column("failures", "failures", 0, False)])
        if self.results["two_view"] and self._any("all_inlier_sets"):
            tables.append(self.table("share of all-inlier sets among the first 20 minimal sets", self.over_conditions(Column("", "all_inlier_sets"))))
        return tables

    def scene_tables(self):
        tables, metric = [], "misclassification" if self.structures else self.c.named("mAA")
        for c, one in enumerate(self.conditions):
            scenes = self._scenes(c)
            of = f", {self.results['condition_label']} {one['label']}" if len(self.conditions) > 1 else ""
            if self.truth and len(scenes) > 1:
                heading = ("misclassification error in %" if self.structures else metric) + " by scene" + of
                tables.append(self.table(heading, [Column(scene, metric, 2 if self.structures else 3, not self.structures, scene=scene, condition=c)
                                                   for scene in scenes]))
        return tables


def tables_of(run):
    made = MetricTables(run)
    models = model_table(run)
    return made.main_tables() + ([] if made.structures else made.pose_tables()) + made.scene_tables() + ([models] if models else [])


def paper_text(value):
    """Formats a value with the paper's two or three digits."""
    if value is None:
        return UNKNOWN
    return fixed(value, 2 if abs(100 * value - round(100 * value)) < 1e-6 else 3)


# --- The lines or planes of a person's own points ---


def _digits_for(change, least):
    """Digits behind the point that keep the rounding error below a twentieth of `change`."""
    return int(min(16, max(least, math.ceil(1 - math.log10(change))))) if change > 0 else 16


def _model_rows(one, points_of, method, several, dimension):
    """Yields the cells of each model. `one` is a line of problems.csv with its models and their inlier counts."""
    change = one["sigma"] if one["sigma"] == one["sigma"] else 0.1 * one["threshold"] if one["threshold"] > 0 else None
    farthest = one["largest_coordinate"] * math.sqrt(dimension)
    digits, behind = (_digits_for(change / farthest, 6), _digits_for(change, 0)) if change is not None else (6, 0)
    for number, (model, inliers) in enumerate(zip(one["models"], one["counts"]), 1):
        found = len(model) == dimension + 1
        cells = [method, *points_of] + ([str(number) if found else UNKNOWN] if several else [])
        if found:
            before = math.floor(math.log10(max(abs(model[-1]), 1.0))) + 1
            cells += [fixed(value, digits) for value in model[:-1]] + [f"{model[-1]:.{min(17, max(8, before + behind))}g}", str(inliers)]
        else:
            cells += [UNKNOWN] * (dimension + 2)
        yield cells + [str(one["points"]), f"{one['sigma']:.3g}" if one["sigma"] == one["sigma"] else UNKNOWN]


def model_table(run):
    """Normal, offset, inliers and noise of each model; None for other data, or without estimates."""
    task, configured, facts = run.facts["task"], run.facts["configuration"]["conditions"], run.facts
    own = [c for c, one in enumerate(configured) if one["data"].get("type") == "point_sets"]
    if task not in ("line", "plane") or not own or not configured or not run.estimates:
        return None
    dimension, several_conditions = 2 if task == "line" else 3, len(facts["conditions"]) > 1
    several = any(len(estimates.structures(i)) for estimates in run.estimates.values() for i in range(len(estimates)))
    units = {one["data"].get("unit", "") for one in configured}
    unit = units.pop() if len(units) == 1 else ""
    table = Table("", ["method", "points of"] + [run.results["condition_label"]] * several_conditions + ["structure"] * several
                  + [f"normal {axis}" for axis in "xyz"[:dimension]] + ["offset d", "inliers", "of", "noise"])
    for (c, m), cell in run.problems.groupby(["c", "m"]):
        estimates = run.estimates.get((c, m))
        for one in cell.to_dict("records") if estimates and c in own else ():
            i = estimates.at.get(one["index"])
            if i is None:
                continue
            models, labels = estimates.structures(i), estimates.labels(i)
            one["models"] = models if len(models) else [estimates.model(i)]
            one["counts"] = [int((labels == k).sum()) for k in range(1, len(models) + 1)] or [len(estimates.inliers(i))]
            one["threshold"] = estimates.value("inlier_threshold", i)
            name = f"{one['id']} (no model: {one['status']})" if one["status"] != "ok" else one["id"] + " (may be chance)" * (one["log10_nfa"] > 0)
            points_of = [name] + [facts["conditions"][c]["label"]] * several_conditions
            for cells in _model_rows(one, points_of, facts["methods"][m]["label"], several, dimension):
                table.add(cells)
    table.heading = f"{task}s found: n · x + d = 0, |n| = 1; d and noise in {unit or 'the unit of the points'}"
    if len(table.rows) > MOST_MODELS:
        table.heading += f"; the first {MOST_MODELS} of {len(table.rows)}, problems.csv and estimates.h5 have all"
        del table.rows[MOST_MODELS:]
    return table if table.rows else None
