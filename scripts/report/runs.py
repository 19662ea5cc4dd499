"""Reads a run's folder: run.json, problems.csv and estimates.h5."""
import fnmatch
import functools
import hashlib
import json
import os

import pandas as pd

import examples
import results
from files import BadInput
import told_tables

TEXTS = ("id", "scene", "condition", "method", "status", "model", "degeneracy", "structure_angles_deg")


def read_facts(folder):
    path = os.path.join(folder, "run.json")
    if not os.path.exists(path):
        raise BadInput(f"'{folder}' holds no whole run of diffsac_eval: no run.json")
    try:
        with open(path, encoding="utf-8") as file:
            facts = json.load(file)
        if not facts["format"].startswith("diffsac run"):
            raise ValueError(f"another format, {facts['format']}")
        return facts
    except (TypeError, KeyError, ValueError) as error:
        raise BadInput(f"{path}: not as diffsac_eval wrote it: {error}") from None


def read_problems(folder, facts):
    """Reads problems.csv and adds the numbers of condition and method (c, m). Names stay texts, whatever they look like."""
    path = os.path.join(folder, "problems.csv")
    try:
        problems = pd.read_csv(path, converters={name: str for name in TEXTS}, float_precision="round_trip")
        for number, names in (("c", "condition"), ("m", "method")):
            places = {one["name"]: i for i, one in enumerate(facts[names + "s"])}
            problems[number] = problems[names].map(places)
            if problems[number].isna().any():
                line = int(problems[number].isna().to_numpy().argmax()) + 2
                raise BadInput(f"{path}:{line}: run.json has no {names} '{problems[names].iloc[line - 2]}'")
        return problems
    except (KeyError, ValueError) as error:
        raise BadInput(f"{path}: {error}") from None


def flat(value, path=""):
    """Returns key.path -> value. Maps in a list are identified by their name, or by their place."""
    if isinstance(value, dict):
        return {key: one for k, v in value.items() for key, one in flat(v, f"{path}.{k}" if path else str(k)).items()}
    if isinstance(value, list) and value and all(isinstance(one, dict) for one in value):
        return {key: one for i, v in enumerate(value) for key, one in flat(v, f"{path}.{v.get('name', i)}").items()}
    return {path: value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)}


def joined_facts(parts):
    """Joins run.json of several seeds: the first one's facts with all methods, times and digests."""
    facts, methods, networks = dict(parts[0]), {}, {}
    for part in parts:
        if [one["name"] for one in part["conditions"]] != [one["name"] for one in facts["conditions"]]:
            raise BadInput(f"seeds: {facts['seed']} and {part['seed']} have different conditions")
        for one in part["methods"]:
            methods.setdefault(one["name"], one)
        networks.update(part["facts"]["networks_sha256"])
    digests = [part["facts"]["data_sha256"] for part in parts]
    facts["facts"] = {**facts["facts"], "seconds": sum(part["facts"]["seconds"] for part in parts),
                      "peak_memory_mib": max(part["facts"]["peak_memory_mib"] for part in parts), "networks_sha256": dict(sorted(networks.items())),
                      "data_sha256": digests[0] if len(set(digests)) == 1 else hashlib.sha256("".join(digests).encode()).hexdigest()}
    facts["learned"] = dict(sorted(facts["learned"].items()))
    return {**facts, "methods": list(methods.values()), "partial": any(part["partial"] for part in parts), "reliability": []}


class Run:
    """A run, or runs with several seeds in sub-folders. Files are read on first use."""

    def __init__(self, folder):
        self.folder = folder
        self.facts = read_facts(folder)
        self.parts = [Run(self.path(name)) for name in self.facts.get("folders", ())]
        if self.parts:
            own = {key: self.facts[key] for key in ("experiment", "seeds", "configuration")}
            self.facts = {**joined_facts([part.facts for part in self.parts]), **own}
        self.facts.setdefault("seeds", [])
        self.partial = self.facts["partial"]
        self.title = (self.told("title", "") or self.facts["experiment"]) + (" (partial)" if self.partial else "")

    def path(self, name):
        return os.path.join(self.folder, name)

    def told(self, key, default=None):
        """Returns a key of the configuration's block `report`."""
        value = (self.facts["configuration"].get("report") or {}).get(key)
        return default if value is None else value

    def group_of(self, scene):
        """Returns the first of `scene_groups` that contains the scene, else the scene."""
        for group, patterns in self.told("scene_groups", {}).items():
            if any(fnmatch.fnmatchcase(scene, one) for one in results.as_list(patterns)):
                return group
        return scene

    @functools.cached_property
    def problems(self):
        """Problems sorted by condition and method. `run` is the number of the seed; with several seeds problems are identified by scene and id."""
        tables = [read_problems(part.folder, self.facts) for part in self.parts or [self]]
        problems = pd.concat([table.assign(run=i) for i, table in enumerate(tables)], ignore_index=True)
        problems = problems.sort_values(["c", "m"], kind="stable").reset_index(drop=True)
        problems["scene"] = problems["scene"].map({scene: self.group_of(scene) for scene in problems["scene"].unique()})
        if self.parts or "index" not in problems:
            problems["index"] = pd.factorize(pd.MultiIndex.from_frame(problems[["c", "scene", "id"]]))[0]
        return problems

    @functools.cached_property
    def _lines(self):
        return self.problems.set_index(["c", "m", "index"], drop=False).sort_index()

    def line_of(self, condition, method, index):
        """Returns the line of problems.csv, None if the method was not run on that problem."""
        place = (condition, method, index)
        return self._lines.loc[[place]].iloc[0].to_dict() if place in self._lines.index else None

    @functools.cached_property
    def _opened(self):
        return examples.open_estimates(self)

    @property
    def estimates(self):
        """Estimates by (condition, method)."""
        return self._opened[0]

    @property
    def examples(self):
        return self._opened[1]

    @functools.cached_property
    def made(self):
        return results.Results(self)

    @property
    def results(self):
        """Content of results.json."""
        return self.made.json

    @functools.cached_property
    def tables(self):
        return told_tables.tables_of(self)

    @property
    def notes(self):
        """Lines below the tables."""
        return told_tables.notes_of(self)

    def condition_title(self, condition):
        return f"{self.results['condition_label']}: {self.results['conditions'][condition]['label']}"

    @functools.cached_property
    def cells(self):
        """Entries of `results` by (condition, method)."""
        conditions = {one["name"]: i for i, one in enumerate(self.results["conditions"])}
        methods = {one["name"]: i for i, one in enumerate(self.results["methods"])}
        return {(conditions[cell["condition"]], methods[cell["method"]]): cell for cell in self.results["results"]}

    def metric(self, condition, method, name, scene="mean"):
        """Returns a metric of a scene, by default the mean over scenes; None if unknown."""
        cell = self.cells.get((condition, method))
        return None if cell is None else cell["metrics"].get(scene, {}).get(name)

    def accuracy(self, condition, method):
        return self.metric(condition, method, self.results["accuracy"]["metric"])
