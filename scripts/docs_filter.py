"""docs_filter.py FILE: a page of GitHub's Markdown as Doxygen 1.9 reads it (scripts/docs.sh).

Headings get the names that links to them have on GitHub, pictures of docs/results their folder, and outside of code
'@' and '<word>', which Doxygen takes for commands and tags, are written as characters.
"""

import os
import re
import sys


def name_of(path: str, heading: str) -> str:
    """One for the whole site: of the page and the heading."""
    slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
    page = os.path.relpath(path)[: -len(".md")]
    return re.sub(r"\W", "_", page) + "_" + slug


def text(part: str, path: str) -> str:
    folder = os.path.dirname(path)
    part = re.sub(
        r"\]\(([\w./-]*\.md)?#([\w-]+)\)",
        lambda link: f"](#{name_of(os.path.join(folder, link[1]) if link[1] else path, link[2])})",
        part,
    )
    if folder.endswith("results"):
        part = re.sub(r"\]\((\w[\w.=-]*\.png)\)", r"](results/\1)", part)
    return re.sub(r"<(\w+)>", r"&lt;\1&gt;", part).replace("@", "&#64;")


def lines_of(path: str):
    fenced, taken = False, {}
    with open(path) as page:
        for number, line in enumerate(page):
            fenced ^= line.startswith("```")
            heading = re.match(r"(#{2,}) (.*)", line)
            if fenced or line.startswith(("    ", "```")):
                yield line
            elif line.startswith("# "):
                yield line.replace("`", "")  # Titles are in the tree of pages, where code would be shown as tags.
            elif heading:
                name = name_of(path, heading[2])
                taken[name] = taken.get(name, -1) + 1
                yield f"{heading[1]} {text(heading[2], path)} {{#{name}{f'-{taken[name]}' if taken[name] else ''}}}\n"
            else:
                yield "`".join(part if i % 2 else text(part, path) for i, part in enumerate(line.split("`")))


sys.stdout.writelines(lines_of(sys.argv[1]))
