#!/usr/bin/env python3
"""Do the tests bite? Plants one small fault at a time in a room of lib and runs the room's tests.

usage: tests/mutation/mutate.py [--count 100] [--seed 1] [--rooms diffsac/geometry,lab/eval] [--work DIR]

Works in a git worktree of HEAD under DIR (build/mutation) with a build of its own, and never touches the checkout. A line of
DIR/results.jsonl a fault; the same call goes on where it stopped. Prints a table and what was not found at the end. Whether a
fault that was not found changes anything that can be seen is for a person to say.
"""

import argparse
import json
import os
import pathlib
import random
import re
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROOMS = "diffsac/geometry,diffsac/ransac,diffsac/problem,diffsac/guidance,lab/data,lab/eval"
SLOWEST = 1800  # Seconds that a test program may run.

NUMBER = r"(?<![\w.\"'])"
# What is looked for in a line, and what stands there instead.
FAULTS = [(f" {re.escape(old)} ", f" {new} ") for old, new in
          ["< <=".split(), "< >".split(), "<= <".split(), "> >=".split(), "> <".split(), ">= >".split(), "== !=".split(),
           "!= ==".split(), "+ -".split(), "- +".split(), "* /".split(), "/ *".split()]]
FAULTS += [
    (r" && ", " && false && "), (r" \|\| ", " || true || "), (r"\bif \(!", "if (!!"), (r"\bif \((?!!)", "if (!"),
    (r"\bstd::min\(", "std::max("), (r"\bstd::max\(", "std::min("), (r"\btrue\b", "false"), (r"\bfalse\b", "true"),
    (NUMBER + r"0(?![\w.\"'])", "1"), (NUMBER + r"1(?![\w.\"'])", "0"), (NUMBER + r"([2-9])(?![\w.\"'])", r"(\1 + 1)"),
    (NUMBER + r"(\d+\.\d+)(?![\w.])", r"(2.0 * \1 + 0.5)"),
    (r"^\s+(?:continue|break);$", ""), (r"^\s+(?!return|throw|delete|co_)[\w.>\[\]-]+\(.*\);$", ""),
    (r"^\s+[\w.>\[\]-]+ [-+*/]?= .*;$", ""),
]
SKIPPED = re.compile(r"^\s*(//|#|template|using|namespace|throw|struct|class|}|b\.Field|\.Help|enum|default:)"
                     r"|\"|\bcase |\bconstexpr\b|\bstatic_assert|\boperator\b|^(inline )?const |\]\s*[{;=]*$|^\S")


def faults_of(path):
    """All faults of a file."""
    lines = path.read_text().splitlines()
    return [{"file": str(path.relative_to(ROOT)), "line": number, "code": line.strip(), "column": match.start(),
             "new": line[:match.start()] + match.expand(new) + line[match.end():]}
            for number, line in enumerate(lines, 1) if not SKIPPED.search(line.split("  //")[0])
            for old, new in FAULTS for match in re.finditer(old, line.split("  //")[0])]


def choose(rooms, count, seed):
    """As many of each room, at most one a line; more than are wanted, since some do not compile."""
    rng = random.Random(seed)
    chosen = {}
    for room in rooms:
        every = [fault for path in sorted((ROOT / "lib" / room).rglob("*.*")) if path.suffix in (".cpp", ".h")
                 for fault in faults_of(path)]
        rng.shuffle(every)
        chosen[room] = list({(fault["file"], fault["line"]): fault for fault in every}.values())[:2 * -(-count // len(rooms))]
    return chosen


class Copy:
    """A worktree of HEAD with a build of its own."""

    def __init__(self, folder):
        self.source, self.build = folder / "diffsac", folder / "build"
        if not self.source.exists():
            subprocess.run(["git", "worktree", "add", "--detach", self.source, "HEAD"], cwd=ROOT, check=True)
            if (ROOT / ".deps").exists():
                (self.source / ".deps").symlink_to((ROOT / ".deps").resolve())
        subprocess.run(["git", "checkout", "--force", "--detach", subprocess.check_output(
            ["git", "rev-parse", "HEAD"], cwd=ROOT, text=True).strip()], cwd=self.source, check=True, capture_output=True)
        subprocess.run(["cmake", "-S", self.source, "-B", self.build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                        "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -w"], check=True, stdout=subprocess.DEVNULL)

    def outcome(self, program):
        """ "does not compile", or what the tests do: "passes", "fails"."""
        if subprocess.run(["ninja", "-C", self.build, program], capture_output=True).returncode != 0:
            return "does not compile"
        with tempfile.TemporaryDirectory() as own:
            try:
                result = subprocess.run([self.build / "bin" / program, "--abort"], cwd=own, timeout=SLOWEST, capture_output=True,
                                        env=os.environ | {"TMPDIR": own})
            except subprocess.TimeoutExpired:
                return "fails"
        return "passes" if result.returncode == 0 else "fails"

    def with_fault(self, fault, program):
        path = self.source / fault["file"]
        sound = path.read_text()
        lines = sound.splitlines(keepends=True)
        lines[fault["line"] - 1] = fault["new"] + "\n"
        path.write_text("".join(lines))
        try:
            return {"passes": "survives", "fails": "found"}.get(outcome := self.outcome(program), outcome)
        finally:
            path.write_text(sound)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rooms", default=ROOMS)
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/mutation")
    arguments = parser.parse_args()
    rooms, work = arguments.rooms.split(","), arguments.work.resolve()
    copy, results = Copy(work), work / "results.jsonl"
    done = [json.loads(line) for line in results.read_text().splitlines()] if results.exists() else []
    known = {(r["file"], r["line"], r["new"]): r for r in done}
    counted = {room: [] for room in rooms}
    for room, faults in choose(rooms, arguments.count, arguments.seed).items():
        program = pathlib.Path(room).name + "_test"
        for fault in faults:
            if len(counted[room]) >= -(-arguments.count // len(rooms)):
                break
            record = known.get((fault["file"], fault["line"], fault["new"]))
            if record is None:
                record = fault | {"outcome": copy.with_fault(fault, program)}
                with results.open("a") as file:
                    file.write(json.dumps(record) + "\n")
                print(f"{fault['file']}:{fault['line']}: {record['outcome']}:{fault['new']}", flush=True)
            if record["outcome"] != "does not compile":
                counted[room].append(record)
        if copy.outcome(program) != "passes":
            raise SystemExit(f"{program} fails without a fault")
    print("\n| room | faults | survive | found | share |\n|---|---|---|---|---|")
    for room, records in counted.items():
        found = sum(r["outcome"] == "found" for r in records)
        print(f"| {room} | {len(records)} | {len(records) - found} | {found} | {found / max(1, len(records)):.3f} |")
    for record in sum(counted.values(), []):
        if record["outcome"] != "found":
            print(f"{record['file']}:{record['line']}: survives:{record['new']}\n    was: {record['code']}")


if __name__ == "__main__":
    main()
