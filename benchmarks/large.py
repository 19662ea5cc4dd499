#!/usr/bin/env python3
"""Time and memory of each row on very many points, every row in a process of its own.

usage: benchmarks/large.py [CONFIG.yaml...] [--eval build/release/bin/diffsac_eval] [--rows a,b] [--points N] [--limit-s 300]

Without configurations: all of benchmarks/large/. Prints a Markdown table a configuration: status, milliseconds of the
estimate with all points and with a tenth of them, their ratio (10 where time is linear), peak memory of the process in
MiB (with the data, drawing it and the libraries). Linux and Python 3 alone.
"""

import argparse
import csv
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading

HERE = pathlib.Path(__file__).resolve().parent


def run(command, seconds):
    """Exit status, output and peak memory in MiB."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    timer = threading.Timer(seconds, process.kill)
    timer.start()
    output = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    timer.cancel()
    return os.waitstatus_to_exitcode(status), output, usage.ru_maxrss // 1024


def rows_of(program, config):
    """All rows, from a run of each on ten points."""
    with tempfile.TemporaryDirectory() as folder:
        code, output, _ = run([program, "--config", config, "--limit", "1", "--output", folder, "--set", "data.num_points=10"], 120)
        if code != 0:
            sys.exit(output)
        with open(folder + "/problems.csv") as file:
            return list(dict.fromkeys(row["method"] for row in csv.DictReader(file)))


def measure(program, config, row, points, limit_s):
    """Status, milliseconds of the estimate (None where there is none) and peak memory of the process in MiB."""
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "--config", config, "--methods", row, "--threads", "1", "--device", "cpu", "--output", folder,
                   "--set", f"data.num_points={points}"]
        code, output, memory = run(command, limit_s)
        if code == -9:
            return f"over {limit_s:.0f} s", None, memory
        if code != 0:
            return f"exit status {code}: {(output.strip().splitlines() or ['no message'])[-1]}", None, memory
        with open(folder + "/problems.csv") as file:
            problem = next(csv.DictReader(file))
        return problem["status"], float(problem["ms_total"]), memory


def line_of(program, config, row, points, limit_s):
    tenth_status, of_tenth, _ = measure(program, config, row, points // 10, limit_s)
    status, of_all, memory = measure(program, config, row, points, limit_s)
    shown = [f"{ms:.4g}" if was == "ok" else "" for was, ms in ((tenth_status, of_tenth), (status, of_all))]
    growth = f"{of_all / of_tenth:.1f}" if all(shown) else ""
    return f"| {row} | {status} | {shown[1]} | {shown[0]} | {growth} | {memory} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("configs", nargs="*", default=sorted(str(path) for path in (HERE / "large").glob("*.yaml")))
    parser.add_argument("--eval", default=str(HERE.parent / "build/release/bin/diffsac_eval"))
    parser.add_argument("--rows", default="")
    parser.add_argument("--points", type=int)
    parser.add_argument("--limit-s", type=float, default=300.0)
    arguments = parser.parse_args()
    for config in arguments.configs:
        points = arguments.points or int(re.search(r"num_points: (\d+)", pathlib.Path(config).read_text())[1])
        print(f"\n### {pathlib.Path(config).stem}\n\n| row | status | ms, N = {points} | ms, N / 10 | growth | MiB |\n"
              "|---|---|---|---|---|---|", flush=True)
        for row in arguments.rows.split(",") if arguments.rows else rows_of(arguments.eval, config):
            print(line_of(arguments.eval, config, row, points, arguments.limit_s), flush=True)


if __name__ == "__main__":
    main()
