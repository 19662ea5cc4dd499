#!/usr/bin/env python3
"""Counts of docs/registration.md: how many results are right, and how many of these and of the wrong ones are told doubtful.

  scripts/peers/registration_counts.py run RUN [--row recommended]          of diffsac_eval: may be chance
  scripts/peers/registration_counts.py scans registrations.csv LISTS        of diffsac_register: no edges of the pose graph

LISTS: the folder of 3DMatch.log and 3DLoMatch.log, whose pairs of fragments and motions are of redkitchen (scripts/scenes.sh DIR
fragment_pairs); scans are in the order of the fragments. Right: within 15 degrees and .3 m; of a run within the table's angle.
"""
import argparse
import csv
import glob
import sys

import numpy as np


def say(name, rows):
    """rows: (right, told doubtful)."""
    for kind, part in (("right", [doubtful for right, doubtful in rows if right]), ("wrong", [doubtful for right, doubtful in rows if not right])):
        print(f"{name}: {len(part)} of {len(rows)} {kind}, {sum(part)} of them told doubtful")


def run(arguments):
    files = sorted(glob.glob(f"{arguments.run}/points/seed=*/problems.csv")) or [f"{arguments.run}/problems.csv"]
    rows = [row for file in files for row in csv.DictReader(open(file)) if row["method"] == arguments.row and row["status"] == "ok"]
    limit = 5.0 if "outdoors" in open(f"{arguments.run}/config.yaml").read() else 15.0
    say("problems", [(float(row["angle_deg"]) < limit, float(row["log10_nfa"]) > 0) for row in rows])


def motions(path):
    """Of pairs (i, j) the motion from j to i."""
    lines = open(path).read().splitlines()
    return {tuple(int(word) for word in lines[k].split()[:2]): np.array([line.split() for line in lines[k + 1:k + 4]], float)
            for k in range(0, len(lines) - 4, 5)}


def rotation(x, y, z, w):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def judged(row, truth):
    if row["status"] != "ok":
        return False, True
    R = rotation(*(float(row[name]) for name in ("qx", "qy", "qz", "qw")))
    t = np.array([float(row[name]) for name in "xyz"])
    cosine = 0.5 * (np.trace(truth[:, :3] @ R) - 1.0)
    right = cosine > np.cos(np.radians(15.0)) and np.linalg.norm(truth[:, :3] @ t + truth[:, 3]) < 0.3
    return right, row["edge"] == "0"


def scans(arguments):
    rows = list(csv.DictReader(open(arguments.registrations)))
    places = {name: i for i, name in enumerate(sorted({row[key] for row in rows for key in ("first", "second")}))}
    for name in ("3DMatch", "3DLoMatch"):
        listed = motions(f"{arguments.lists}/{name}.log")
        pairs = [(row, listed.get((places[row["first"]], places[row["second"]]))) for row in rows]
        say(name, [judged(row, truth) for row, truth in pairs if truth is not None and abs(places[row["first"]] - places[row["second"]]) > 1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("run")
    command.add_argument("run")
    command.add_argument("--row", default="recommended")
    command.set_defaults(call=run)
    command = commands.add_parser("scans")
    command.add_argument("registrations")
    command.add_argument("lists")
    command.set_defaults(call=scans)
    arguments = parser.parse_args()
    arguments.call(arguments)


if __name__ == "__main__":
    sys.exit(main())
