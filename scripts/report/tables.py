"""Tables, and their Markdown, LaTeX and CSV forms."""
import csv
import dataclasses
import hashlib
import io

UNKNOWN = "–"  # Stands in tables for what is not known.
DIGEST = "- page: sha256 "


def digest_line(text):
    """The last line of a page, which shows whether its text was changed by hand."""
    return DIGEST + hashlib.sha256(text.encode()).hexdigest() + "\n"


@dataclasses.dataclass
class Row:
    cells: list  # As many texts as the table has columns; the first is the row's name.
    best: list = dataclasses.field(default_factory=list)  # As many: to be set in bold; none: no cell.
    intervals: list = dataclasses.field(default_factory=list)  # As many, or none: "[0.45, 0.57]", empty for no interval.
    from_paper: bool = False


@dataclasses.dataclass
class Table:
    heading: str
    columns: list
    rows: list = dataclasses.field(default_factory=list)

    @staticmethod
    def of_json(json_table):
        table = Table(json_table["heading"], json_table["columns"], [Row(**row) for row in json_table["rows"]])
        for row in table.rows:
            row.best = row.best or [False] * len(row.cells)
        return table

    def mark_best(self, column, values, higher=True):
        """Sets the best value of a column, and those that print the same, in bold. `values` by row; None for rows that do not compete."""
        told = [(value, row) for value, row in zip(values, self.rows) if value is not None and value == value]
        texts = [row.cells[column].split(" [")[0] for _, row in told]
        best = texts[(max if higher else min)(range(len(told)), key=lambda i: told[i][0])] if told else None
        for text, (_, row) in zip(texts, told):
            row.best[column] = text == best

    def add(self, cells, best=None):
        self.rows.append(Row(list(cells), best or [False] * len(cells)))


def _escaped(text, special):
    return "".join("\\" + c if c in special else c for c in text)


def markdown_table(table):
    """With aligned columns, ready to read on a terminal."""
    lines = [table.columns] + [[f"**{cell}**" if best else cell for cell, best in zip(row.cells, row.best)] for row in table.rows]
    lines = [[_escaped(cell, "|") for cell in line] for line in lines]
    widths = [max(3, *(len(line[i]) for line in lines)) for i in range(len(table.columns))]

    def text(line):
        return "| " + " | ".join(cell.ljust(w) if i == 0 else cell.rjust(w)
                                 for i, (cell, w) in enumerate(zip(line, widths))) + " |\n"

    rule = "|" + "|".join("-" * (w + 2) if i == 0 else "-" * (w + 1) + ":" for i, w in enumerate(widths)) + "|\n"
    return text(lines[0]) + rule + "".join(text(line) for line in lines[1:])


def latex_text(text):
    special = {"\\": "\\textbackslash{}", "~": "\\textasciitilde{}", "^": "\\textasciicircum{}", UNKNOWN: "--"}
    return "".join(special.get(c) or _escaped(c, "&%$#_{}") for c in text)


def latex_table(table):
    """A tabular in the style of booktabs."""
    def line(cells):
        return " & ".join(cells) + " \\\\\n"

    text = (f"\\begin{{tabular}}{{l{'r' * (len(table.columns) - 1)}}}\n\\toprule\n"
            + line(latex_text(column) for column in table.columns) + "\\midrule\n")
    paper = False
    for row in table.rows:
        if row.from_paper and not paper:
            text += "\\midrule\n"
        paper = paper or row.from_paper
        text += line(f"\\textbf{{{latex_text(cell)}}}" if best else latex_text(cell) for cell, best in zip(row.cells, row.best))
    return text + "\\bottomrule\n\\end{tabular}\n"


def latex_report(run):
    """The whole table.tex: one `table` environment a table."""
    title, setting = run.results["title"] or run.results["experiment"], run.results["setting"]
    text = "% Needs \\usepackage{booktabs}.\n"
    for table in run.tables:
        caption = f"{latex_text(title)}: {latex_text(table.heading)}. {latex_text(setting)}{'. Partial results' if run.partial else ''}."
        text += f"\\begin{{table}}[t]\n\\centering\n\\caption{{{caption}}}\n{latex_table(table)}\\end{{table}}\n"
    return text


def tables_csv(tables):
    """The tables as they are printed, one below the other, an empty line between; unknown values are empty."""
    parts = []
    for table in tables:
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerows(
            [[table.heading], table.columns] + [["" if cell == UNKNOWN else cell for cell in row.cells] for row in table.rows])
        parts.append(out.getvalue())
    return "\n".join(parts)
