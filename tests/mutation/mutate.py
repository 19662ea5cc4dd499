#!/usr/bin/env python3
"""Do the tests bite? Plants one small fault at a time and runs the tests of the folder that holds it, then those of the
folders that use it.

usage: tests/mutation/mutate.py [--count 400] [--seed 1] [--folders geometry,consensus] [--files NAME,...] [--work DIR]
                                [--jobs 2] [--again]

Works in a copy of the checkout under DIR (build/mutation), with a build of its own and assertions on, and never touches
the checkout. All faults are built at once (fault.h) and switched on one by one. What was chosen is kept in
DIR/faults.json, results in DIR/results.jsonl, a line a fault; the same call goes on where it stopped. --again takes those
that were not found once more, after tests were added, into DIR/again.jsonl. Prints a table and what was not found at the end. Whether a fault that was not
found changes anything that can be seen is for a person to say.
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ["geometry", "consensus", "data", "diffusion", "eval"]
F = "::diffsac::faults::"

# A fault: what it looks for, and what a reader would find there instead, and what the copy says (@: the
# fault's number, ~: what was there).
BINARY = {name: (name[:2], name[2:]) for name in
          "LtLe LtGt LeLt GtGe GtLt GeGt EqNe NeEq".split()} | {"AddSub": ("+", "-"), "SubAdd": ("-", "+"),
                                                              "MulDiv": ("*", "/"), "DivMul": ("/", "*")}
SIGN = {"Lt": "<", "Le": "<=", "Gt": ">", "Ge": ">=", "Eq": "==", "Ne": "!="}
NUMBER = r"(?<![\w.\"'])"
OPERATORS = []
for NAME, (OLD, NEW) in BINARY.items():
    OLD, NEW = SIGN.get(OLD, OLD), SIGN.get(NEW, NEW)
    OPERATORS.append((rf" {re.escape(OLD)} ", f" {NEW} ", f" {OLD} {F}{NAME}<@>{{}} {OLD} "))
OPERATORS += [
    (r" && ", " && false && ", f" && !{F}Active<@>() && "), (r" \|\| ", " || true || ", f" || {F}Active<@>() || "),
    (r"\bif \(!", "if (", f"if ({F}Not<@>{{}} == "),
    (r"\bstd::min\(", "std::max(", f"{F}Min<@>("), (r"\bstd::max\(", "std::min(", f"{F}Max<@>("),
    (NUMBER + r"0(?![\w.\"'])", "1", f"{F}Pick<@>(0, 1)"), (NUMBER + r"1(?![\w.\"'])", "0", f"{F}Pick<@>(1, 0)"),
    (NUMBER + r"1(?![\w.\"'])", "2", f"{F}Pick<@>(1, 2)"),
    (NUMBER + r"[2-9](?![\w.\"'])", "one more", f"{F}Pick<@>(~, ~ + 1)"),
    (NUMBER + r"\d+\.\d+(?![\w.])", "another", f"{F}Pick<@>(~, ~ == 0.0 ? 0.5 : 2.0 * ~)"),
    (r"\btrue\b", "false", f"{F}Pick<@>(true, false)"), (r"\bfalse\b", "true", f"{F}Pick<@>(false, true)"),
    (r"(?<=^)\s+(?:continue|break);$", "nothing", f"if (!{F}Active<@>()) {{ ~ }}"),
    (r"^\s+(?!return|throw|delete|co_)[\w.>\[\]-]+\(.*\);$", "nothing", f"if (!{F}Active<@>()) {{ ~ }}"),
    (r"^\s+[\w.>\[\]-]+ [-+*/]?= .*;$", "nothing", f"if (!{F}Active<@>()) {{ ~ }}"),
]
SKIPPED = re.compile(r"^\s*(//|#|template|using|namespace|throw|struct|class|}|b\.Field|\.Help|enum|default:)"
                     r"|\"|\bcase |\bconstexpr\b|\bstatic_assert|\boperator\b|^(inline )?const |\]\s*[{;=]*$|^\S")


def in_template(code, column):
    """Whether the place is within template arguments: Matrix<double, 3, 1>."""
    depth = 0
    for i in range(column):
        if code[i] == "<" and i > 0 and (code[i - 1].isalnum() or code[i - 1] == "_"):
            depth += 1
        elif code[i] == ">" and depth > 0 and code[i - 1] != "-":
            depth -= 1
    return depth > 0


def faults_of(path):
    """All faults of a file: dicts of file, line, code, column, old and new text, and what the copy says."""
    found = []
    for number, line in enumerate(path.read_text().splitlines(), 1):
        code = line.split("  //")[0]
        if SKIPPED.search(code):
            continue
        for pattern, new, text in OPERATORS:
            for match in re.finditer(pattern, code):
                if not in_template(code, match.start()):
                    found.append({"file": str(path.relative_to(ROOT)), "line": number, "code": line.strip(), "column": match.start(),
                                  "old": match.group().strip(" ") or match.group(), "length": len(match.group()),
                                  "new": new.strip(), "text": text.replace("~", match.group())})
    return found


def choose(folders, files, count, seed):
    """The same number of each folder, at most one a line."""
    rng = random.Random(seed)
    chosen = []
    for folder in folders:
        every = []
        for path in sorted((ROOT / "lib/diffsac" / folder).rglob("*.*")):
            if path.suffix in (".cpp", ".h") and (not files or path.name in files):
                every += faults_of(path)
        rng.shuffle(every)
        of_lines = {}
        for fault in every:
            of_lines.setdefault((fault["file"], fault["line"]), fault)
        chosen += list(of_lines.values())[: -(-count // len(folders))]
    for number, fault in enumerate(chosen):
        fault["number"] = number
    return chosen


def program_of(fault):
    return pathlib.Path(fault["file"]).parts[2] + "_test"


def chosen_before(arguments, path):
    """As choose(), but a choice that was made stays, as long as its lines do."""
    kept = json.loads(path.read_text()) if path.exists() else {}
    if kept.get("wanted") == wanted(arguments):
        return [fault for fault in kept["faults"] if in_place(fault)]
    return choose(arguments.folders.split(","), set(filter(None, arguments.files.split(","))), arguments.count, arguments.seed)


def wanted(arguments):
    return {"folders": arguments.folders, "files": arguments.files, "count": arguments.count, "seed": arguments.seed}


def keep(arguments, faults, path):
    path.write_text(json.dumps({"wanted": wanted(arguments), "faults": faults}))


def asked_for(fault, arguments):
    path = pathlib.Path(fault["file"])
    return path.parts[2] in arguments.folders.split(",") and (not arguments.files or path.name in arguments.files.split(","))


def in_place(fault):
    """Whether the line is still what it was."""
    path = ROOT / fault["file"]
    lines = path.read_text().splitlines() if path.exists() else []
    return fault["line"] <= len(lines) and lines[fault["line"] - 1].strip() == fault["code"]


class Copy:
    """A copy of the checkout with a build of its own."""

    def __init__(self, folder, jobs):
        self.folder, self.source, self.build, self.jobs = folder, folder / "diffsac", folder / "build", jobs
        self.seconds, self.passed = {}, set()

    def update(self, texts):
        """Writes the files that git lists, or what `texts` holds in their place, where they differ: no more is built again."""
        listing = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
        names = set(filter(None, listing.split("\0")))
        for name in names:
            target, content = self.source / name, (ROOT / name).read_bytes()
            if name in texts:
                content = texts[name].encode()
            if not target.exists() or target.read_bytes() != content:
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(content)
                target.chmod((ROOT / name).stat().st_mode)
        for old in (p for p in self.source.rglob("*") if p.is_file() and ".deps" not in p.parts):
            if str(old.relative_to(self.source)) not in names:
                old.unlink()
        torch = ROOT / ".deps"
        if torch.exists() and not (self.source / ".deps").exists():
            (self.source / ".deps").symlink_to(torch.resolve())

    def plant(self, faults):
        """The files with all faults in them, each switched off."""
        texts = {}
        for fault in faults:
            lines = texts.setdefault(fault["file"], (ROOT / fault["file"]).read_text().splitlines(keepends=True))
            line, at = lines[fault["line"] - 1], fault["column"]
            lines[fault["line"] - 1] = line[:at] + fault["text"].replace("@", str(fault["number"])) + line[at + fault["length"]:]
        header = self.source / "tests/mutation/fault.h"
        return {name: f'#include "{header}"\n#line 1\n' + "".join(lines) for name, lines in texts.items()}

    def make(self, faults):
        """Builds all, leaves out what does not compile, and returns what is left."""
        programs = sorted({program_of(fault) for fault in faults})
        left = faults
        while True:
            self.update(self.plant(left))
            subprocess.run(["cmake", "-S", self.source, "-B", self.build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                            "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -w", f"-DDIFFSAC_SHARED_DATA={ROOT.parent / 'shared/data'}"],
                           check=True, stdout=subprocess.DEVNULL)
            built = subprocess.run(["ninja", "-C", self.build, f"-j{self.jobs}", "-k0", *programs], capture_output=True, text=True)
            if built.returncode == 0:
                return left
            named = set(re.findall(r"(lib/diffsac/\w+/\w+\.(?:cpp|h)):(\d+)", built.stdout))
            fewer = [f for f in left if (f["file"], str(f["line"])) not in named]
            if len(fewer) == len(left):
                sys.exit(built.stdout)
            print(f"{len(left) - len(fewer)} faults do not compile", flush=True)
            left = fewer

    def test(self, program, fault, limit, **environment):
        with tempfile.TemporaryDirectory() as own:
            started = time.time()
            try:
                result = subprocess.run([self.build / "bin" / program, "--abort"], cwd=own, timeout=limit, text=True, errors="replace",
                                        env=os.environ | {"DIFFSAC_FAULT": str(fault), "TMPDIR": own} | environment,
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            except subprocess.TimeoutExpired:
                return "hangs", time.time() - started, ""
            return ("passes" if result.returncode == 0 else "fails"), time.time() - started, result.stdout

    def without_faults(self, program):
        """Takes the time, and which faults the tests pass through."""
        passed = self.folder / "passed.txt"
        outcome, self.seconds[program], output = self.test(program, -1, 3600, DIFFSAC_FAULTS_PASSED=str(passed))
        if outcome != "passes":
            sys.exit(f"{program} fails without a fault:\n{output}")
        self.passed |= {(program, int(line)) for line in passed.read_text().split()}

    def outcome(self, fault):
        """And the program that found it."""
        programs = [p for p in self.users(fault) if (p, fault["number"]) in self.passed]
        for program in programs:
            if self.test(program, fault["number"], 15.0 + 3.0 * self.seconds[program])[0] != "passes":
                return "found", program
        return ("survives" if programs else "not run"), ""

    def users(self, fault):
        """The tests of its folder, and of the later ones that were built."""
        own = program_of(fault)
        names = [folder + "_test" for folder in FOLDERS]
        return [name for name in names[names.index(own):] if name in self.seconds]


def report(records):
    print("\n| folder | faults | not run by any test | survive | found | share |\n|---|---|---|---|---|---|")
    for folder in FOLDERS + ["all"]:
        of = [r["outcome"] for r in records if folder == "all" or f"/{folder}/" in r["file"]]
        if of:
            print(f"| {folder} | {len(of)} | {of.count('not run')} | {of.count('survives')} | {of.count('found')} "
                  f"| {of.count('found') / len(of):.3f} |")
    print()
    for r in sorted(records, key=lambda r: (r["file"], r["line"])):
        if r["outcome"] != "found":
            print(f"{r['file']}:{r['line']}: {r['outcome']}: '{r['old']}' -> '{r['new']}': {r['code']}")


def arguments_given():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folders", default=",".join(FOLDERS))
    parser.add_argument("--files", default="")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/mutation")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--again", action="store_true")
    arguments = parser.parse_args()
    unknown = set(arguments.folders.split(",")) - set(FOLDERS)
    if unknown:
        parser.error(f"--folders: {', '.join(sorted(unknown))} is none of {', '.join(FOLDERS)}")
    return arguments


def main():
    arguments = arguments_given()
    work = arguments.work.resolve()
    results, again = work / "results.jsonl", work / "again.jsonl"
    records = [json.loads(line) for line in results.read_text().splitlines()] if results.exists() else []
    if arguments.again:
        faults, results = [r for r in records if r["outcome"] != "found" and in_place(r) and asked_for(r, arguments)], again
        records = [r for r in records if r["outcome"] == "found" and asked_for(r, arguments)]
    else:
        faults = chosen_before(arguments, work / "faults.json")
    copy = Copy(work, arguments.jobs)
    faults = copy.make(faults)
    if not arguments.again:
        keep(arguments, faults, work / "faults.json")  # What does not compile is not tried again.
    for program in sorted({program_of(fault) for fault in faults}):
        copy.without_faults(program)
        print(f"{program}: {copy.seconds[program]:.1f} s without a fault", flush=True)
    done = set() if arguments.again else {(r["file"], r["line"], r["column"], r["new"]) for r in records}
    todo = [f for f in faults if (f["file"], f["line"], f["column"], f["new"]) not in done]
    todo.sort(key=lambda fault: copy.seconds[program_of(fault)])  # Quick programs first.
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool, results.open("a") as file:
        for fault, outcome in zip(todo, pool.map(copy.outcome, todo)):
            records.append(fault | {"outcome": outcome[0], "by": outcome[1]})
            file.write(json.dumps(records[-1]) + "\n")
            file.flush()
            print(f"{len(records)}: {fault['file']}:{fault['line']} '{fault['old']}' -> '{fault['new']}': {' by '.join(filter(None, outcome))}", flush=True)
    report(records)


if __name__ == "__main__":
    main()
