#!/usr/bin/env python3
"""page.py RUN_FOLDER --page docs/results/NAME.md: a page of a run's tables and pictures, and NAME.json with its tables and facts.

Documents take their figures from the JSON file (docs.py). Pictures are copied beside the page as NAME_*.png, those of matches, two of them,
as JPEG.
"""
import argparse
import hashlib
import io
import json
import os

from files import run_script, write_whole
from runs import Run
from tables import digest_line, markdown_table

SHOWN_DIGITS = 12  # Of a digest.
MOST_MATCHES = 2
COLOURS = 64  # Of a drawn picture.


def facts_of(run):
    """Revision, seed, machine, date, what the run took, and digests of its data and networks, a line each."""
    facts = run.results["facts"]
    lines = [f"{key}: {value}" for key, value in facts["run"].items() if key != "program"]
    if facts["seconds"] > 0:
        lines.append(f"time: {facts['seconds']:.0f} s")
    if facts["peak_memory_mib"] > 0:
        lines.append(f"peak memory: {facts['peak_memory_mib']:.0f} MiB")
    if facts["data_sha256"]:
        lines.append(f"data: sha256 {facts['data_sha256'][:SHOWN_DIGITS]}")
    lines += [f"network: {path}, sha256 {digest[:SHOWN_DIGITS]}" for path, digest in facts["networks_sha256"].items()]
    return lines


def configuration_digest(run):
    """Of the run's config.yaml, which has every key, without its header and without where this machine has its data."""
    with open(run.path("config.yaml"), encoding="utf-8") as file:
        body = file.read().partition("\n\n")[2]
    root = next((line.split(": ", 1)[1] for line in body.splitlines() if line.startswith("data_root: /")), None)
    return hashlib.sha256((body.replace(root, "data") if root else body).encode()).hexdigest()


def picture_beside(picture, page, name):
    """Copies a picture beside a page as NAME_*; what shows it there, in Markdown."""
    from PIL import Image

    stem = os.path.splitext(os.path.basename(picture))[0]
    photograph, content = stem.startswith("matches_"), io.BytesIO()
    extension = ".jpg" if photograph else ".png"
    with Image.open(picture) as image:
        if photograph:
            image.convert("RGB").save(content, "JPEG", quality=75)
        else:
            image.convert("RGB").quantize(COLOURS).save(content, "PNG", optimize=True)
    write_whole(os.path.join(os.path.dirname(page), f"{name}_{stem}{extension}"), content.getvalue())
    return f"![{name}: {stem}]({name}_{stem}{extension})\n\n"


def pictures_in(folder):
    """All but those of matches, then two of these, from first to last."""
    every = sorted(name for name in os.listdir(folder) if name.endswith(".png"))
    matches = [name for name in every if name.startswith("matches_")]
    most = min(MOST_MATCHES, len(matches))
    return [name for name in every if name not in matches] + [matches[i * len(matches) // most] for i in range(most)]


def page_json(command, facts, tables):
    """A line a fact and a row, without what is empty, so that a change shows in few lines."""
    def text(value):
        return json.dumps(value, ensure_ascii=False)

    def row_text(row):
        kept = {"cells": row.cells, "best": row.best if any(row.best) else [], "intervals": row.intervals, "from_paper": row.from_paper}
        return text({key: value for key, value in kept.items() if value})

    def table_text(table):
        rows = ",\n".join(map(row_text, table.rows))
        return f'{{"heading": {text(table.heading)}, "columns": {text(table.columns)}, "rows": [\n{rows}]}}'

    return (f'{{"command": {text(command)},\n"facts": [\n' + ",\n".join(map(text, facts)) + '],\n"tables": [\n'
            + ",\n".join(map(table_text, tables)) + "]}\n")


def markdown_report(run):
    results = run.results
    text = f"# {results['title'] or results['experiment']}\n\n"
    if run.partial:
        text += "**Partial results: the run was interrupted.**\n\n"
    text += f"{results['setting']}. Best in bold; references that are told more than the points (oracle) do not compete.\n"
    text += "".join(f"\n## {table.heading}\n\n{markdown_table(table)}" for table in run.tables)
    text += "\n" + "\n".join(run.notes) + "\n" + "".join(f"\nLeft out: {row}.\n" for row in results["left_out"])
    return text + (f"\n{results['experiment_notes']}\n" if results["experiment_notes"] else "")


def write_page(folder, page, command):
    run, name = Run(folder), os.path.splitext(os.path.basename(page))[0]
    os.makedirs(os.path.dirname(page) or ".", exist_ok=True)
    text = markdown_report(run) + "\n"
    text += "".join(picture_beside(run.path(picture), page, name) for picture in pictures_in(folder))
    facts = facts_of(run) + [f"configuration, with every key: sha256 {configuration_digest(run)[:SHOWN_DIGITS]}, the run's config.yaml"]
    text += f"Written by `{command}`.\n\n" + "".join(f"- {fact}\n" for fact in facts)
    write_whole(page, text + digest_line(text))
    write_whole(os.path.splitext(page)[0] + ".json", page_json(command, facts, run.tables))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder")
    parser.add_argument("--page", required=True)
    parser.add_argument("--command", help="what the page says that it was written by (default: this call)")
    arguments = parser.parse_args()
    write_page(arguments.folder, arguments.page, arguments.command or f"scripts/report/page.py {arguments.folder} --page {arguments.page}")


if __name__ == "__main__":
    run_script(main)
