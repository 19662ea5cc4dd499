"""A run's folder: what run.json, problems.csv and estimates.h5 say."""
import fnmatch
import functools
import hashlib
import json
import os

import pandas as pd

import examples
import results
import told_tables

TEXTS = ("id", "scene", "condition", "method", "status", "model", "degeneracy", "structure_angles_deg")


class NoRun(ValueError):
    """Names the folder and what it lacks."""


def read_facts(folder):
    path = os.path.join(folder, "run.json")
    if not os.path.exists(path):
        raise NoRun(f"'{folder}' holds no whole run of diffsac_eval: no run.json")
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def read_problems(folder, facts):
    """problems.csv with the numbers of conditions and methods (c, m); names stay texts, whatever they look like."""
    path = os.path.join(folder, "problems.csv")
    try:
        problems = pd.read_csv(path, converters={name: str for name in TEXTS}, float_precision="round_trip")
        for number, names in (("c", "condition"), ("m", "method")):
            places = {one["name"]: i for i, one in enumerate(facts[names + "s"])}
            problems[number] = problems[names].map(places)
            if problems[number].isna().any():
                line = int(problems[number].isna().to_numpy().argmax()) + 2
                raise NoRun(f"{path}:{line}: run.json has no {names} '{problems[names].iloc[line - 2]}'")
        return problems
    except (OSError, KeyError, ValueError) as error:
        raise error if isinstance(error, NoRun) else NoRun(f"{path}: {error}") from None


def flat(value, path=""):
    """key.path -> value; maps of a list are told apart by their name, or by their place."""
    if isinstance(value, dict):
        return {key: one for k, v in value.items() for key, one in flat(v, f"{path}.{k}" if path else str(k)).items()}
    if isinstance(value, list) and value and all(isinstance(one, dict) for one in value):
        return {key: one for i, v in enumerate(value) for key, one in flat(v, f"{path}.{v.get('name', i)}").items()}
    return {path: value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)}


def joined_facts(parts):
    """Of runs with other seeds: the first one's, with all rows, times and digests."""
    facts, methods, networks = dict(parts[0]), {}, {}
    for part in parts:
        if [one["name"] for one in part["conditions"]] != [one["name"] for one in facts["conditions"]]:
            raise NoRun(f"seeds: {facts['seed']} and {part['seed']} have different conditions")
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
    """What a run left in its folder, or several runs with other seeds in its sub-folders; files are read when they are asked for."""

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

    def told(self, key, default):
        """What the block `report` of the configuration says."""
        configuration = self.facts["configuration"]
        block = configuration.get("report")
        value = block[key] if isinstance(block, dict) and key in block else configuration.get(key)
        return default if value is None else value

    def group_of(self, scene):
        """The first of `scene_groups` that holds the scene, or the scene itself."""
        for group, patterns in self.told("scene_groups", {}).items():
            if any(fnmatch.fnmatchcase(scene, one) for one in results.as_list(patterns)):
                return group
        return scene

    @functools.cached_property
    def problems(self):
        """In the order of conditions and methods. `run`: which of several seeds; their problems are numbered by scene and id."""
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
        """What problems.csv has of an estimate; None where the method was not run on that problem."""
        place = (condition, method, index)
        return self._lines.loc[[place]].iloc[0].to_dict() if place in self._lines.index else None

    @functools.cached_property
    def _opened(self):
        return examples.open_estimates(self)

    @property
    def estimates(self):
        """examples.Estimates by the numbers of condition and method."""
        return self._opened[0]

    @property
    def examples(self):
        return self._opened[1]

    @functools.cached_property
    def made(self):
        return results.Results(self)

    @property
    def results(self):
        """As results.json has them."""
        return self.made.json

    @functools.cached_property
    def tables(self):
        return told_tables.tables_of(self)

    @property
    def notes(self):
        """What is said under the tables, a line each."""
        return told_tables.notes_of(self)

    def condition_title(self, condition):
        return f"{self.results['condition_label']}: {self.results['conditions'][condition]['label']}"

    @functools.cached_property
    def cells(self):
        """The results of a condition and a method, by their numbers."""
        conditions = {one["name"]: i for i, one in enumerate(self.results["conditions"])}
        methods = {one["name"]: i for i, one in enumerate(self.results["methods"])}
        return {(conditions[cell["condition"]], methods[cell["method"]]): cell for cell in self.results["results"]}

    def metric(self, condition, method, name, scene="mean"):
        """Of a scene, or its mean over scenes; nothing where it is unknown."""
        cell = self.cells.get((condition, method))
        return None if cell is None else cell["metrics"].get(scene, {}).get(name)

    def accuracy(self, condition, method):
        return self.metric(condition, method, self.results["accuracy"]["metric"])
