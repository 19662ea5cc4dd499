"""growth.py CSV PNG: what diffsac_guide_benchmark --csv CSV wrote, milliseconds by number of matches."""
import csv
import sys

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt  # noqa: E402

SHOWN = {"learned_prosac": "learned PROSAC", "prosac_marginalised": "the same search without a network", "usac": "OpenCV USAC_ACCURATE 1000"}

with open(sys.argv[1], encoding="utf-8") as file:
    lines = [line for line in csv.reader(file) if len(line) > 2 and line[1] in SHOWN]
figure, axes = plt.subplots(figsize=(7.6, 4.4), dpi=100, layout="constrained")
for row, label in SHOWN.items():
    axes.plot(*zip(*[(float(line[0]), float(line[2])) for line in lines if line[1] == row]), marker="o", markersize=4, label=label)
axes.plot([400, 120000], [400 / 60, 120000 / 60], linestyle="--", color="gray", label="in proportion to N")
axes.set(xscale="log", yscale="log", xlim=(400, 120000), xlabel="matches", ylabel="milliseconds, one thread")
axes.grid(color="#E0E0E0")
axes.legend()
figure.savefig(sys.argv[2])
