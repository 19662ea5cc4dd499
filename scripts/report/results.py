"""Metrics, intervals, differences, effects and strata of a run (docs/metrics.md), as results.json holds them."""
import difflib
import fnmatch
import itertools
import math
import sys

import numpy as np
import pandas as pd

from bootstrap import interval
from files import BadInput
from metrics import MEDIANS, SETS, Tolerance, accuracy_of, add_deviations, cell_metrics, column

QUANTITIES = {"inlier_share": "share of true inliers", "points": "number of points", "true_rotation_deg": "true rotation in degrees",
              "true_baseline": "true baseline", "true_parallax_deg": "true parallax in degrees", "scene": "scene"}
KEYS = {"title", "notes", "condition_label", "reference", "compare", "strata", "paper", "scene_groups", "series", "factors", "figures"}
FIGURES = {"curve", "qualitative", "qualitative_method", "qualitative_methods", "qualitative_conditions", "confidence_condition", "bars", "images"}
LEAST_OF_INTERVAL = 5  # Of fewer problems in a bin no interval is told: redrawing them says nothing of those that are not there.


def as_list(value):
    return value if isinstance(value, list) else [value]


def check_keys(given, known, where):
    """Rejects misspelt keys of the block `report`, which C++ copies without parsing."""
    for key in given:
        if key not in known:
            raise BadInput(f"{where}: unknown key '{key}'; did you mean '{difflib.get_close_matches(key, known, 1, 0)[0]}'?")


class Grid:
    """One condition: problems as rows, in the order of the data, and methods as columns."""

    def __init__(self, problems, methods, seed):
        self.problems, self.methods, self.seed, self._values = problems, methods, seed, {}
        self.index, first, at = np.unique(problems["index"].to_numpy(), return_index=True, return_inverse=True)
        self.first = problems.iloc[first]
        self.scene = pd.factorize(self.first["scene"])[0]
        self._cells = at * methods + problems["m"].to_numpy()
        self.records = self._counts(np.ones(len(problems), bool))

    def _counts(self, known):
        return np.bincount(self._cells[known], minlength=len(self.index) * self.methods).reshape(-1, self.methods)

    def of(self, values):
        """Returns problems x methods, NaN where unknown. Several seeds of a problem are averaged."""
        known = ~np.isnan(values)
        with np.errstate(invalid="ignore"):
            sums = np.bincount(self._cells[known], values[known], len(self.index) * self.methods)
            return sums.reshape(-1, self.methods) / self._counts(known)

    def value(self, name):
        """Returns `of` a column of the problems, cached."""
        if name not in self._values:
            self._values[name] = self.of(column(self.problems, name))
        return self._values[name]

    def within(self, chosen):
        """Restricts the grid to some problems, as a single scene. Otherwise a scene with one problem in a bin would weigh as much as one with
        forty, and would never be resampled."""
        own = np.isin(self.problems["index"].to_numpy(), self.index[chosen])
        return Grid(self.problems[own].assign(scene="all"), self.methods, self.seed)

    def interval(self, values):
        """Returns mean and interval of one value per problem."""
        known = ~np.isnan(values)
        scene = pd.factorize(self.scene[known])[0]
        return interval(values[known][np.argsort(scene, kind="stable")], np.bincount(scene), self.seed)

    def difference(self, values, a, b):
        """Returns column a minus column b over problems with both values, None without any."""
        change = values[:, a] - values[:, b]
        return None if a == b or np.isnan(change).all() else self.interval(change)

    def share_problems(self, competing):
        """Whether the methods ran on the same problems, or on some of them."""
        ran = self.records > 0
        largest = max(competing, key=lambda m: self.records[:, m].sum(), default=0)
        return all((ran[:, m] <= ran[:, largest]).all() or (ran[:, m] >= ran[:, largest]).all() for m in competing if ran[:, m].any())


def level_effect(grid, rows, values):
    """Mean over pairs (column, column of the first level or None) of the difference, or of the value; None without values."""
    of_rows = [values[:, own] - (0 if other is None else values[:, other]) for own, other in rows]
    counts = sum(~np.isnan(one) for one in of_rows) if rows else np.zeros(0)
    with np.errstate(invalid="ignore"):
        return grid.interval(sum(np.nan_to_num(one) for one in of_rows) / counts) if counts.any() else None


def effects_of(grids, names, factors):
    """Effects of each level of each factor, by condition, over the combinations of other factors that the level and the first level share:
    accuracy minus the first level's, and milliseconds divided by the first level's. The first level has its own means."""
    effects = []
    for f, (factor, levels) in enumerate(factors.items()):
        effects.append({"factor": factor, "levels": [{"level": level, "accuracy": [], "milliseconds": [], "combinations": []} for level in levels]})
        for grid, told in itertools.product(grids, effects[-1]["levels"]):
            row_of, rows = {name: m for m, name in enumerate(names) if grid.records[:, m].any()}, []
            for combination in itertools.product(*factors.values()):
                beside = combination[:f] + (levels[0],) + combination[f + 1:]
                own, other = row_of.get("_".join(combination)), row_of.get("_".join(beside))
                if combination[f] == told["level"] and own is not None and other is not None:
                    rows.append((own, None if told["level"] == levels[0] else other))
            ms = level_effect(grid, rows, grid.value("log_ms"))
            told["accuracy"].append(level_effect(grid, rows, grid.value("accuracy")))
            told["milliseconds"].append(ms and {end: math.exp(value) for end, value in ms.items()})
            told["combinations"].append(len(rows))
    return effects


def bins_of(division, problems):
    """Returns (name in results.csv, label) of each bin, and a function from problems to bin numbers, -1 for unknown quantities."""
    by = division.get("by", "inlier_share")
    if by == "scene":
        scenes = list(dict.fromkeys(problems["scene"]))
        return [(f"scene {one}", one) for one in scenes], lambda first: np.array([scenes.index(one) for one in first["scene"]])
    edges = [float(edge) for edge in division["bins"]]
    texts = [f"{edge:.6g}" for edge in edges]
    names = [(f"{by} below {texts[0]}", f"< {texts[0]}")]
    names += [(f"{by} {a}-{b}", f"{a}–{b}") for a, b in zip(texts, texts[1:])] + [(f"{by} from {texts[-1]}", f"≥ {texts[-1]}")]

    def place(first):
        values = column(first, by)
        return np.where(np.isnan(values), -1, np.searchsorted(edges, values, side="right"))

    return names, place


def told(interval, few):
    return interval and {**interval, "low": None, "high": None} if few else interval


class Results:
    """Computes `json`, the content of results.json, from a runs.Run. Unknown numbers are None."""

    def __init__(self, run):
        self.run, facts = run, run.facts
        self.seed, self.names = facts["seed"], [one["name"] for one in facts["methods"]]
        self.conditions = [one["name"] for one in facts["conditions"]]
        pixels = "threshold_px" in facts
        self.c = Tolerance(facts["threshold_px" if pixels else "threshold_deg"], pixels)
        problems = run.problems
        self.problems = problems.assign(accuracy=accuracy_of(problems, self.c), sets=column(problems, SETS),
                                        log_ms=np.log(problems["ms_total"].where(problems["ms_total"] > 0)))
        self.structures = bool((~np.isnan(column(problems, "recall"))).any())
        self.poses = not pixels and bool(problems["rotation_deg"].notna().any())
        self.accuracy = "recall" if self.structures else self.c.named("mAA")
        self.grids = [Grid(self.problems[self.problems["c"] == c], len(self.names), self.seed) for c in range(len(self.conditions))]
        self.factors = {name: [str(level) for level in levels] for name, levels in run.told("factors", {}).items()}
        self.absent, where = {}, run.path("config.yaml: report")
        check_keys(facts["configuration"].get("report") or {}, KEYS, where)
        check_keys(run.told("figures", {}), FIGURES, where + ".figures")
        self.strata = [run.told("strata")] if isinstance(run.told("strata"), dict) else run.told("strata", [])
        for one in self.strata:
            check_keys(one, {"by", "bins", "rows"}, where + ".strata")
            edges = [float(edge) for edge in one.get("bins", [])]
            if one.get("by", "inlier_share") not in QUANTITIES or edges != sorted(set(edges)) or (one.get("by") != "scene" and not edges):
                raise BadInput(f"{where}.strata: expected `by`, one of {', '.join(QUANTITIES)}, and `bins`, ascending edges")
        self.compare = self._known_pairs()
        self.reference = self._reference()
        self.json = _clean(self._json())
        if self.absent:
            print(f"{run.folder}: `report` names rows that this run has not: {', '.join(self.absent)}", file=sys.stderr)

    def _known(self, names):
        """Keeps names of methods that the run has. Others are reported once: they are misspelt, or the method was left out."""
        self.absent.update(dict.fromkeys(name for name in names if name not in self.names))
        return [name for name in names if name in self.names]

    def _known_pairs(self):
        given = self.run.told("compare", [])
        pairs = [(a, b) for a, others in given.items() for b in as_list(others)] if isinstance(given, dict) else \
            [(one["a"], one["b"]) if isinstance(one, dict) else tuple(one) for one in given]
        return [pair for pair in pairs if len(self._known(pair)) == 2]

    def _reference(self):
        """Index of the reference method: the named one, or the first of type diffsac."""
        named = self.run.told("reference", "")
        found = [m for m, one in enumerate(self.run.facts["methods"]) if (one["name"] == named if named else one["type"] == "diffsac")]
        return found[0] if found else None

    def _differences(self, grids, name):
        """Differences by comparison, then by condition."""
        return [[grid.difference(grid.value(name), self.names.index(a), self.names.index(b)) for grid in grids] for a, b in self.compare]

    def _cell(self, c, m, metrics, bars):
        grid, method = self.grids[c], self.run.facts["methods"][m]
        accuracies, sets = grid.value("accuracy"), grid.value("sets")[:, m]
        difference = None if self.reference is None else grid.difference(accuracies, self.reference, m)
        cell = {"condition": self.conditions[c], "method": method["name"], "type": method["type"], "label": method["label"], "metrics": metrics,
                self.accuracy + "_ci95": grid.interval(accuracies[:, m]),
                "reference_minus_this": difference and {"reference": self.names[self.reference], **difference}}
        if not np.isnan(sets).all():
            cell[SETS + "_ci95"] = grid.interval(sets)
        if method["name"] in bars and self.poses and not self.structures:
            cell.update({part + "_ci95": self._angle(c, m, part) for part in ("rotation", "translation")})
        return cell

    def _angle(self, c, m, part):
        """Accuracy of rotation or translation alone."""
        grid = self.grids[c]
        return grid.interval(grid.of(self.c.accuracies(column(grid.problems, part + "_deg")))[:, m])

    def _strata(self, division, cells):
        names, place = bins_of(division, self.problems)
        places, bins = [place(grid.first) for grid in self.grids], []
        for i, (name, label) in enumerate(names):
            grids = [grid.within(at == i) for grid, at in zip(self.grids, places)]
            few = [len(grid.index) < LEAST_OF_INTERVAL for grid in grids]
            bins.append({"name": name, "label": label, "problems": [len(grid.index) for grid in grids],
                         "accuracies": [told(grids[c].interval(grids[c].value("accuracy")[:, m]), few[c]) for c, m in cells],
                         "differences": [list(map(told, row, few)) for row in self._differences(grids, "accuracy")],
                         "effects": effects_of(grids, self.names, self.factors),
                         "records": [{"problems": int((own := grids[c].problems["m"] == m).sum()), "failures": int(grids[c].problems["failed"][own].sum())}
                                     for c, m in cells]})
            for level in (level for factor in bins[-1]["effects"] for level in factor["levels"]):
                level.update({part: list(map(told, level[part], few)) for part in ("accuracy", "milliseconds")})
        by, unknown = division.get("by", "inlier_share"), [int((at < 0).sum()) for at in places]
        rows = self._known(division.get("rows", [])) or self.names
        return {"by": by, "title": QUANTITIES[by], "rows": rows, "bins": bins, "unknown": unknown}

    def _paper(self):
        """Returns label -> condition -> the paper's values, by their keys in configurations."""
        def values(given):
            named = given if isinstance(given, dict) else dict(zip(("mAA", "median"), as_list(given)))
            return {key: float(value) for key, value in named.items()}

        return {label: {name: values(given) for name, given in row.items() if name in self.conditions}
                for label, row in self.run.told("paper", {}).items()}

    def _beside_paper(self, cells):
        """Pairs each value of the paper with our method that the row names, and its interval."""
        rows, known = [], {(self.conditions.index(cell["condition"]), cell["method"]): cell for cell in cells}
        for label, values in {} if self.structures else self.paper.items():
            ours = self.run.told("paper", {})[label].get("ours", "")
            for c, condition in enumerate(self.conditions):
                for metric, key, part in (("mAA", "mAA", None), ("mAA of R", "R", "rotation"), ("mAA of t", "t", "translation")):
                    paper, cell = values.get(condition, {}).get(key), known.get((c, ours))
                    if paper is not None and cell is not None:
                        own = self._angle(c, self.names.index(ours), part) if part else cell[self.accuracy + "_ci95"]
                        rows.append({"method": ours, "paper_row": label, "condition": c, "metric": metric, "paper": paper, "ours": own,
                                     "problems": int(cell["metrics"]["mean"]["problems"])})
        return rows

    def _figures(self):
        figures = self.run.told("figures", {})
        series = {label: [name for name in self.names if any(fnmatch.fnmatchcase(name, one) for one in as_list(patterns))]
                  for label, patterns in self.run.told("series", {}).items()}
        return {"curve": figures.get("curve", True), "bars": self._known(figures.get("bars", [])),
                "budget": [{"label": label, "methods": names} for label, names in series.items() if names],
                "images": [{"scenes": "*", **one} for one in figures.get("images", [])]}

    def _methods(self):
        """Methods with their medians over all problems of all conditions."""
        medians = self.problems.groupby("m")[[name for name in (*MEDIANS, "draws") if name in self.problems]].median(numeric_only=True).to_dict("index")
        return [{**{key: one[key] for key in ("name", "label", "type")}, "competes": one["type"] != "oracle", "medians": medians.get(m, {})}
                for m, one in enumerate(self.run.facts["methods"])]

    def _setting(self, cells):
        facts, seeds = self.run.facts, self.run.facts["seeds"]
        most = max((int(cell["metrics"]["mean"]["problems"]) for cell in cells), default=0)
        of = "" if len(self.conditions) == 1 else f" a condition ({self.run.told('condition_label', 'condition')})"
        return f"{most} problems{of}, " + (f"mean of seeds {', '.join(map(str, seeds))}" if seeds else f"seed {facts['seed']}")

    def _json(self):
        facts = self.run.facts
        competing = [m for m, one in enumerate(facts["methods"]) if one["type"] != "oracle"]
        groups = self.problems.groupby(["c", "m"], sort=True)
        places, cells = list(groups.groups), []
        figures = self._figures()
        if places:
            numbered = self.problems.assign(cell=groups.ngroup())
            metrics = cell_metrics(numbered, self.c)
            add_deviations(metrics, numbered, self.c)
            cells = [self._cell(c, m, one, figures["bars"]) for (c, m), one in zip(places, metrics)]
        differences = [{"a": a, "b": b, "condition": self.conditions[c], "metric": metric, **one}
                       for metric, name in ((self.accuracy, "accuracy"), (SETS, "sets"))
                       for (a, b), row in zip(self.compare, self._differences(self.grids, name)) for c, one in enumerate(row) if one]
        self.paper = self._paper()
        kept = ("experiment", "task", "dataset", "seed", "seeds", "threshold_px" if self.c.pixels else "threshold_deg", "partial",
                "left_out", "git_revision", "machine", "learned", "facts")
        return {
            **{key: facts[key] for key in kept}, "title": self.run.told("title", ""), "setting": self._setting(cells), "experiment_notes": self.run.told("notes", ""),
            "accuracy": {"metric": self.accuracy, "title": "recall of structures" if self.structures else self.accuracy},
            "unit": "%" if self.structures else "px" if self.c.pixels else "°", "poses": self.poses, "structures": self.structures,
            "two_view": facts["two_view"], "reference": None if self.reference is None else self.names[self.reference],
            "condition_label": self.run.told("condition_label", "condition"),
            "conditions": [{"name": one["name"], "label": one["label"], "value": one["value"], "rows_share_problems": grid.share_problems(competing)}
                           for one, grid in zip(facts["conditions"], self.grids)],
            "methods": self._methods(), "figures": figures,
            "strata": [self._strata(one, places) for one in self.strata],
            "effects": effects_of(self.grids, self.names, self.factors),
            "results": cells, "differences": differences, "compare": [list(pair) for pair in self.compare], "paper": self.paper,
            "paper_of_same_data": [label for label, row in self.run.told("paper", {}).items() if row.get("same_data")],
            "beside_paper": self._beside_paper(cells)}


def _clean(value):
    """Converts NumPy values to plain ones, and NaN to None."""
    if isinstance(value, dict):
        return {key: _clean(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_clean(one) for one in value]
    value = value.item() if isinstance(value, np.generic) else value
    return None if isinstance(value, float) and math.isnan(value) else value
