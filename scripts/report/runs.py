"""A run's folder: what results.json and problems.csv beside it say."""
import functools
import json
import os

import told_tables
from tables import Table


class Run:
    """What a run left in its folder; files are read when they are asked for."""

    def __init__(self, folder):
        self.folder = folder
        with open(self.path("results.json"), encoding="utf-8") as file:
            self.results = json.load(file)
        self.title = (self.results["title"] or self.results["experiment"]) + (" (partial)" if self.partial else "")

    def path(self, name):
        return os.path.join(self.folder, name)

    @functools.cached_property
    def tables(self):
        return [Table.of_json(table) for table in self.results["tables"]] + told_tables.tables_of(self.results)

    @property
    def notes(self):
        """What is said under the tables, a line each."""
        return self.results["notes"].splitlines() + told_tables.notes_of(self.results)

    @property
    def partial(self):
        return self.results["partial"]

    @functools.cached_property
    def problems(self):
        """problems.csv; names stay texts, whatever they look like."""
        import pandas

        texts = ("id", "scene", "condition", "method", "status", "model", "rotation_level", "translation_level", "structure_angles_deg")
        return pandas.read_csv(self.path("problems.csv"), converters={name: str for name in texts})

    def condition_title(self, condition):
        return f"{self.results['condition_label']}: {self.results['conditions'][condition]['label']}"

    @functools.cached_property
    def cells(self):
        """The results of a condition and a method, by their numbers."""
        conditions = {one["name"]: i for i, one in enumerate(self.results["conditions"])}
        methods = {one["name"]: i for i, one in enumerate(self.results["methods"])}
        return {(conditions[cell["condition"]], methods[cell["method"]]): cell for cell in self.results["results"]}

    def metric(self, condition, method, name):
        """Its mean over scenes; nothing where it is unknown."""
        cell = self.cells.get((condition, method))
        return None if cell is None else cell["metrics"].get("mean", {}).get(name)

    def accuracy(self, condition, method):
        return self.metric(condition, method, self.results["accuracy"]["metric"])
