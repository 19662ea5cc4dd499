#!/usr/bin/env python3
"""Fills the figures of documents from the pages of results, so that no figure is typed, or checks both.

    docs.py [--check] [--check-pages] README.md docs/*.md docs/results/claims.md
    docs.py --compare docs/results/line.json runs/verify/line.json

A document has marks, and docs/figures.yaml says what stands between them, by the JSON files beside the pages:

    <!-- figure: NAME -->.283<!-- / -->                      figures: NAME: {page: hard_fundamental, table: mAA@10deg by share, row: "learned PROSAC", column: "< 0.1"}
    <!-- claim: NAME -->in part<!-- / -->                    claims: NAME: {differences: [{page, table, row: learned − PROSAC, column}, ...]}
    <!-- evidence: NAME -->the claim's differences, as a table<!-- /evidence -->
    <!-- figures: NAME -->a table<!-- /figures -->           tables: NAME: {first, best: higher|lower, columns: [{title, page, table, column}], rows: [{title, row}]}

A cell of a table is where its column and its row say together: either may name page, table, row and column, and the row's word counts.
Table, row and column are whole names, or beginnings that only one has. `columns: [A, B]` in the place of `column` joins two values by a
slash, `interval: no` leaves out a figure's interval, `cells` gives a row's values themselves.

A claim says that A is better than B, by differences A − B with their intervals: "yes" where each interval is above zero, "in part" where some
are, else "no" where one is below zero, and "open" where each holds it. With `every: yes` there is no "in part"; `swapped: yes` is for a
difference that the page has as B − A. `older_pages: {NAME: why}` are passed over by --check-pages.
"""
import argparse
import glob
import json
import os
import re
import subprocess

import yaml

from files import BadInput, run_script, write_whole
from tables import DIGEST, Table, digest_line, markdown_table

MARK = re.compile(r"<!-- (figure|claim|evidence|figures): (.*?) -->", re.S)
ENDS = {"figure": "<!-- / -->", "claim": "<!-- / -->", "evidence": "<!-- /evidence -->", "figures": "<!-- /figures -->"}
NUMBER = re.compile(r"[-+]?[0-9]*\.?[0-9]+")
PAPER_ROWS = (" (paper, other data)", " (published)")


def find(names, name, where):
    """The place of the one name that `name` is, or begins; else an error that lists what there is."""
    if name in names:
        return names.index(name)
    found = [i for i, one in enumerate(names) if one.startswith(name)]
    if len(found) == 1:
        return found[0]
    raise BadInput(f"{where}{' has several that begin with' if found else ' has no'} '{name}', but: {'; '.join(names)}")


class Page:
    """A page's tables and facts."""

    def __init__(self, path):
        self.path = path
        try:
            with open(path, encoding="utf-8") as file:
                content = json.load(file)
        except (OSError, ValueError) as error:
            raise BadInput(f"{path}: {error}") from None
        self.tables = [Table.of_json(table) for table in content["tables"]]
        self.facts = content["facts"]

    def fact(self, key):
        return [fact[len(key) + 2:] for fact in self.facts if fact.startswith(key + ": ")]

    @property
    def revision(self):
        return next(iter(self.fact("git revision")), "")

    def trainings(self):
        """How many seeds its networks were trained with: those of networks named ..._seed_N; 1 of others, 0 without any."""
        networks = self.fact("network")
        return max(len({match[0] for network in networks for match in [re.search(r"_seed_[^/]*", network)] if match}), 1 if networks else 0)

    def place(self, table, row):
        found = self.tables[find([one.heading for one in self.tables], table, self.path)]
        where = f"{self.path}, table '{found.heading}'"
        return found, found.rows[find([one.cells[0] for one in found.rows], row, where)], where

    def cell(self, table, row, column):
        found, line, where = self.place(table, row)
        return line.cells[find(found.columns, column, where)]


def without_leading_zero(text):
    """As documents write numbers: ".283", "+.118 [.069, .172]"."""
    return re.sub(r"(?<![0-9.])0(?=\.)", "", text)


def leading_number(text):
    match = re.match(r"\s*([-+]?[0-9]*\.?[0-9]+)", text)
    return float(match[1]) if match else None


def mark_best(table, column, higher):
    values = [leading_number(row.cells[column]) for row in table.rows]
    known = [value for value in values if value is not None]
    best = (max if higher else min)(known) if known else None
    for row, value in zip(table.rows, values):
        row.best[column] = best is not None and value == best


class Figures:
    def __init__(self, definitions, pages):
        self.path, self.pages, self.read, self.changed = definitions, pages, {}, []
        with open(definitions, encoding="utf-8") as file:
            self.definitions = yaml.load(file, yaml.BaseLoader)  # All texts: "0.10" is a name.
        self.unused = {(kind, name) for kind in ("figures", "claims", "tables") for name in self.definitions.get(kind) or {}}

    def definition(self, kind, name):
        found = (self.definitions.get(kind) or {}).get(name)
        if not found:
            raise BadInput(f"{self.path}: no {kind}.{name}")
        self.unused.discard((kind, name))
        return found

    def page(self, name):
        if name not in self.read:
            self.read[name] = Page(os.path.join(self.pages, name + ".json"))
        return self.read[name]

    def value(self, place):
        try:
            columns = place.get("columns") or [place["column"]]
            return "/".join(without_leading_zero(self.page(place["page"]).cell(place["table"], place["row"], column)) for column in columns)
        except KeyError as error:
            raise BadInput(f"{self.path}: {place} has no {error}") from None

    def shown(self, place):
        value = self.value(place)
        return value.split(" [")[0] if place.get("interval") == "no" else value

    def differences(self, name):
        """Where each stands, its text, and 1 or −1 where its interval is on the side for or against the claim."""
        for place in self.definition("claims", name)["differences"]:
            value = self.value(place)
            interval = re.match(r"\s*[-+.0-9]+ \[([-+.0-9]+), ([-+.0-9]+)\]", value)
            if not interval:
                raise BadInput(f"{self.path}: claims.{name}: '{value}' is no difference with its interval")
            side = 1 if float(interval[1]) > 0 else -1 if float(interval[2]) < 0 else 0
            yield place, value, -side if place.get("swapped") == "yes" else side

    def claim(self, name):
        sides = [side for _, _, side in self.differences(name)]
        if all(side > 0 for side in sides):
            return "yes"
        if any(side > 0 for side in sides) and self.definition("claims", name).get("every") != "yes":
            return "in part"
        return "no" if any(side < 0 for side in sides) else "open"

    def evidence(self, name):
        table = Table("", ["A − B", "page", "of", "difference and 95 % interval", "trainings"])
        for place, value, side in self.differences(name):
            page = self.page(place["page"])
            pair = page.place(place["table"], place["row"])[1].cells[0]
            told = " (below zero speaks for the claim)" if place.get("swapped") == "yes" else ""
            table.add([pair + told, f"[{place['page']}]({place['page']}.md)", place["column"], value, str(page.trainings() or "")],
                      [False, False, False, side != 0, False])
        return markdown_table(table)

    def table(self, name):
        definition = self.definition("tables", name)
        columns = definition["columns"]
        table = Table("", [definition["first"]] + [column["title"] for column in columns])
        for row in definition["rows"]:
            cells = row.get("cells") or [self.shown({**column, **row}) for column in columns]
            if len(cells) != len(columns):
                raise BadInput(f"{self.path}: tables.{name}: a row has {len(cells)} cells, the table {len(columns)} columns")
            table.add([row["title"], *cells])
        if "best" in definition:
            for column in range(1, len(table.columns)):
                mark_best(table, column, definition["best"] == "higher")
        return markdown_table(table)

    def fill(self, document):
        filled, at = "", 0
        while mark := MARK.search(document, at):
            kind, name = mark[1], mark[2]
            end = document.find(ENDS[kind], mark.end())
            if end < 0:
                raise BadInput(f"the mark '{mark[0]}' is not closed by '{ENDS[kind]}'")
            before = document[mark.end():end]
            if kind == "figure":
                now = self.shown(self.definition("figures", name))
            elif kind == "claim":
                now = self.claim(name)
                if now != before:
                    self.changed.append(f"claim {name}: it said '{before}', now '{now}'")
            else:
                now = "\n" + (self.evidence(name) if kind == "evidence" else self.table(name))
            filled += document[at:mark.end()] + now
            at = end
        return filled + document[at:]


def check_documents(figures, documents, check):
    faults = 0
    for path in documents:
        with open(path, encoding="utf-8") as file:
            text = file.read()
        try:
            filled = figures.fill(text)
        except BadInput as error:
            raise BadInput(f"{path}: {error}") from None
        if filled == text:
            continue
        if not check:
            write_whole(path, filled)
            print("filled:", path)
            continue
        faults += 1
        line = os.path.commonprefix([text, filled]).count("\n") + 1
        print(f"{path}:{line}: a figure is not what its page has; scripts/report/docs.py fills it")
    for change in figures.changed:
        print(change + "; read again what is said about it")
    for kind, name in sorted(figures.unused):
        print(f"{figures.path}: no document asks for {kind}.{name}")
    return faults + len(figures.unused)


def output_of(*words):
    return subprocess.run(words, capture_output=True, text=True, check=False)


def paper_rows(table):
    """Labels of the paper's rows in a table's configuration and in what it includes."""
    with open(table, encoding="utf-8") as file:
        given = yaml.safe_load(file)
    included = given.get("include") or []
    rows = {*((given.get("report") or {}).get("paper") or {})}
    for name in [included] if isinstance(included, str) else included:
        rows |= paper_rows(os.path.join(os.path.dirname(table), name))
    return rows


def rows_of(program, table):
    """The labels of the rows that a table's configuration has, those of the paper included."""
    told = output_of(program, "--config", table, "--rows")
    if told.returncode != 0:
        raise BadInput(f"{table}: {told.stderr.strip() or program}")
    return {*told.stdout.splitlines()} | paper_rows(table)


def page_faults(path, page, table, program):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    body, found, _ = text.partition(DIGEST)
    if not found and os.path.exists(table):
        yield "has no digest of its text"
    elif found and text != body + digest_line(body):
        yield "was changed after it was written"
    for one in page.tables:
        if markdown_table(one) not in text:
            yield f"its table '{one.heading}' is not that of {os.path.basename(page.path)}"
    if not page.revision:
        yield "names no revision"
    if page.revision.endswith("-dirty"):
        yield f"is of a tree with changes, {page.revision}"
    elif page.revision and output_of("git", "rev-parse", "--is-shallow-repository").stdout.strip() == "false":
        if output_of("git", "merge-base", "--is-ancestor", page.revision, "HEAD").returncode != 0:
            yield f"its revision {page.revision} is not an ancestor of this one"
    if program and os.path.exists(table):
        rows = rows_of(program, table)
        shown = {row.cells[0] for one in page.tables if one.columns[0] == "method" for row in one.rows}
        for row in sorted(shown - rows - {label + paper for label in rows for paper in PAPER_ROWS}):
            yield f"{table} has no row '{row}'"


def check_pages(pages, older, tables, program):
    faults = 0
    for path in sorted(glob.glob(os.path.join(pages, "*.json"))):
        page, name = Page(path), os.path.splitext(os.path.basename(path))[0]
        markdown = path[:-len("json")] + "md"
        if name in older:
            print(f"{markdown}: of an older revision, {page.revision}: {older[name]}")
            continue
        for fault in page_faults(markdown, page, os.path.join(tables, name + ".yaml"), program):
            print(f"{markdown}: {fault}")
            faults += 1
    return faults


def same_but_for_rounding(a, b):
    """Values may differ by one in their last digit, which another machine's rounding may do."""
    if a == b:
        return True
    of_a, of_b = NUMBER.findall(a), NUMBER.findall(b)
    last = lambda text: 10.0 ** -len(text.partition(".")[2])
    return bool(of_a) and len(of_a) == len(of_b) and all(
        abs(float(x) - float(y)) < 1.5 * max(last(x), last(y)) for x, y in zip(of_a, of_b))


def numbered(names):
    """Several may have one name: the first is the other's first."""
    met = {}
    for name in names:
        met[name] = met.get(name, 0) + 1
        yield name, met[name]


def differences(page, again):
    """What differs between a page and the same page made again, a line each; times, and tables that the page has not, are passed over."""
    def only(a, b, where):
        yield from (f"{where}: only the page has '{name}'" for name in a if name not in b)
        yield from (f"{where}: only the new one has '{name}'" for name in b if name not in a)

    new = {one.heading for one in again.tables}  # What it has beside the page's tables, a later version reports.
    yield from (f"{page.path}: only the page has '{one.heading}'" for one in page.tables if one.heading not in new)
    others = dict(zip(numbered(one.heading for one in again.tables), again.tables))
    for key, table in zip(numbered(one.heading for one in page.tables), page.tables):
        other = others.get(key)
        if other is None:
            continue
        yield from only(table.columns, other.columns, table.heading)
        yield from only([row.cells[0] for row in table.rows], [row.cells[0] for row in other.rows], table.heading)
        rows = dict(zip(numbered(row.cells[0] for row in other.rows), other.rows))
        for row_key, row in zip(numbered(row.cells[0] for row in table.rows), table.rows):
            for c, column in enumerate(table.columns):
                if c == 0 or row_key not in rows or column not in other.columns or column == "ms" or "milliseconds" in table.heading:
                    continue
                value = rows[row_key].cells[other.columns.index(column)]
                if not same_but_for_rounding(row.cells[c], value):
                    yield f"{table.heading}: {row.cells[0]}, {column}: {row.cells[c]}, now {value}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("documents", nargs="*", help="Markdown files with marks")
    parser.add_argument("--compare", nargs=2, metavar="JSON", help="a page's data and the same made again: which values differ")
    parser.add_argument("--check", action="store_true", help="only names the documents that differ")
    parser.add_argument("--check-pages", action="store_true", help="names pages of results that were changed by hand, are of another history, "
                        "or have rows that no configuration has (these with --eval)")
    parser.add_argument("--eval", help="diffsac_eval, which is asked for a table's rows")
    parser.add_argument("--definitions", default="docs/figures.yaml", help="what the marks stand for")
    parser.add_argument("--pages", default="docs/results", help="folder of the pages")
    parser.add_argument("--tables", default="configs/tables", help="folder of their configurations")
    arguments = parser.parse_args()
    if arguments.compare:
        page, again = map(Page, arguments.compare)
        found = list(differences(page, again))
        print("".join(line + "\n" for line in found), end="")
        print(f"{page.path}: {'other values than those of ' + again.path if found else 'the same values'}")
        return 1 if found else 0
    figures = Figures(arguments.definitions, arguments.pages)
    faults = check_documents(figures, arguments.documents, arguments.check)
    if arguments.check_pages:
        faults += check_pages(arguments.pages, figures.definitions.get("older_pages") or {}, arguments.tables, arguments.eval)
    return 1 if faults else 0


if __name__ == "__main__":
    run_script(main)
