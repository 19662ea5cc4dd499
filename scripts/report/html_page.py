"""A page that needs nothing beside itself: style, scripts, pictures and data are in it, and it asks the browser to load
nothing else. What is given as text may be anything: the template (report.html.j2) escapes it."""
import base64
import os
import re

import jinja2
import markupsafe

import files
from tables import UNKNOWN

HERE = os.path.dirname(os.path.abspath(__file__))
_MOST_COLUMNS_WITH_INTERVALS = 7  # Of wider tables intervals stand below their values.
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?|[-+]?(?:inf|nan))(.*)\Z", re.IGNORECASE | re.DOTALL)


def number_of(cell):
    """The number that a cell begins with: "+0.21 [...]", "1.5e-3", "85 %". Nothing for other texts, as for "3 views"."""
    found = _NUMBER.match(cell) if cell and not cell[0].isspace() else None
    if not found:
        return None
    rest = found[2]
    return float(found[1]) if rest in ("", " %") or rest.startswith((" [", UNKNOWN)) else None


def _is_numeric(cells):
    """Every cell is a number, or unknown or empty."""
    known = [cell for cell in cells if cell not in ("", UNKNOWN)]
    return bool(known) and all(number_of(cell) is not None for cell in known)


def _cell(row, column, numeric):
    text = row.cells[column]
    value = number_of(text) if numeric else None
    interval = row.intervals[column] if column < len(row.intervals) else ""
    small = interval
    if not interval and number_of(text) is not None and text.endswith("]") and " [" in text:
        text, small = text.split(" [", 1)
        small = "[" + small
    return {"text": text, "small": small, "value": None if value is None else f"{value:.7g}",
            "classes": " ".join(["number"] * numeric + ["best"] * bool(row.best[column]))}


def _table_block(table, note):
    numeric = [_is_numeric([row.cells[c] for row in table.rows]) for c in range(len(table.columns))]
    bodies = []
    for paper in (False, True):
        rows = [[_cell(row, c, numeric[c]) for c in range(len(row.cells))] for row in table.rows if row.from_paper == paper]
        if rows:
            bodies.append({"paper": paper, "rows": rows})
    return {"kind": "table", "heading": table.heading, "columns": list(zip(table.columns, numeric)), "bodies": bodies,
            "wide": len(table.columns) > _MOST_COLUMNS_WITH_INTERVALS, "note": note}


class Page:
    """Parts appear in the order in which they are added."""

    def __init__(self, title):
        self.title, self.reload_seconds = title, 0
        self.subtitles, self.sections, self.blocks, self.data, self.scripts = [], [], [], [], []

    def _add(self, kind, **values):
        self.blocks.append({"kind": kind, **values})

    def section(self, heading):
        """A heading, which the page's list of sections names."""
        self.sections.append(heading)
        self._add("section", text=heading, number=len(self.sections))

    def text(self, text):
        self._add("text", text=text)

    def warning(self, text):
        """A paragraph that must not be overlooked."""
        self._add("warning", text=text)

    def tables(self, tables):
        """Small ones stand beside each other."""
        self._add("tables", tables=[_table_block(table, "") for table in tables])

    def table(self, table, note=""):
        self.blocks.append(_table_block(table, note))

    def words(self, words):
        """Terms and what they mean."""
        if words:
            self._add("words", words=words)

    def picture(self, png, caption):
        self._add("picture", png=base64.b64encode(png).decode(), text=caption)

    def pre(self, text):
        self._add("pre", text=text)

    def place(self, name):
        """Where a script puts what it makes."""
        self._add("place", name=name)

    def json(self, name, text):
        """JSON that scripts find by this name. '<' can only stand in a text, where it may be written so."""
        self.data.append(("application/json", name, text.replace("<", "\\u003c")))

    def bytes(self, name, content):
        self.data.append(("application/octet-stream", name, base64.b64encode(content).decode()))

    def script(self, file_name):
        """Runs a script of this folder once the page is there. `diffsacPage` (page.js) is at its service."""
        self.scripts.append(_own(file_name))

    def html(self):
        environment = jinja2.Environment(loader=jinja2.FileSystemLoader(HERE), autoescape=True, trim_blocks=True, lstrip_blocks=True)
        return environment.get_template("report.html.j2").render(
            page=self, css=_own("page.css"), js=_own("page.js"), safe=markupsafe.Markup) + "\n"

    def write(self, path):
        files.write_whole(path, self.html())


def _own(file_name):
    with open(os.path.join(HERE, file_name), encoding="utf-8") as file:
        return markupsafe.Markup(file.read())
