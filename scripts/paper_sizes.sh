#!/usr/bin/env bash
# Runs the trainings of the paper's size (configs/paper/) for some minutes each, to see that they work: in runs/paper_sizes/NAME_whole as
# they are, for speed and memory, and in runs/paper_sizes/NAME_curve with a smaller batch, for a learning curve. Then it writes
# docs/results/paper_sizes.md. Called again, the curves go on where they were. 1.5 GB of disk a configuration.
set -euo pipefail
caller=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly runs=runs/paper_sizes page=docs/results/paper_sizes.md programs=build/release/bin
# Of the learning curves: a sixteenth of the batch, fewer matches of a pair, a short warm-up, and validations that end.
readonly smaller=16 matches=250 warmup=10 validate_every=20 validated=2 copies=1
mapfile -t names < <(basename -as .yaml configs/paper/*.yaml)
usage() {
  echo "usage: scripts/paper_sizes.sh [--minutes M] [--data DIR] [--page] [CONFIG...]"
  echo "configurations: ${names[*]}"
  echo "--minutes: of each, 8; a third of it with the whole batch, but one step at least"
  echo "--data: where kitti/, fox/, mobilebrick/ and modelnet_off/ are (data_tools/README.md); without it only lines and planes are run"
  echo "--page: trains nothing, writes the page of the runs that are there"
}
fail() { echo "paper_sizes: $*" >&2; exit 1; }

minutes=8 data="" only_page="" wanted=()
while (($#)); do
  case "$1" in
    -h | --help) usage; exit ;;
    --minutes) minutes=${2:-}; [[ "$minutes" =~ ^[1-9][0-9]*$ ]] || fail "--minutes needs a whole number"; shift ;;
    --data) data=${2:-}; [[ -n "$data" ]] || fail "--data needs a folder"; shift ;;
    --page) only_page=yes ;;
    -*) usage >&2; exit 1 ;;
    *) [[ " ${names[*]} " == *" $1 "* ]] || fail "there is no configs/paper/$1.yaml"; wanted+=("$1") ;;
  esac
  shift
done
((${#wanted[@]})) || wanted=("${names[@]}")
[[ -z "$data" || "$data" == /* ]] || data=$caller/$data
[[ -z "$data" || -d "$data" ]] || fail "--data: there is no folder $data"
[[ -x $programs/diffsac_train ]] || fail "build first: cmake --preset release && cmake --build --preset release --target programs"

# pairs FOLDER OPTIONS...: matches with SIFT descriptors; a scene that is there stays.
pairs() {
  "$programs/diffsac_prepare" pairs --features sift --descriptors --no-thumbnails --threads 1 "${@:2}" --output "$runs/pairs/$1" \
    >>"$runs/prepare.log" 2>&1 || fail "diffsac_prepare failed; see $runs/prepare.log"
}
# find_data NAME: sets `what` to the data that a configuration gets, and `replaced` to the options that put them in the place of its own
# where those are not there. False when there are none.
find_data() {
  replaced=() what=generated
  case "$1" in
    *_kitti)
      what="KITTI 00 to 06"
      [[ ! -d data/kitti_pairs ]] || return 0
      what="16 pairs of KITTI 00"
      [[ -n "$data" && -d "$data/kitti/sequences/00" && -d "$data/kitti/sequences/01" ]] || return 1
      pairs kitti --format kitti --input "$data/kitti" --sequence 00 --steps 1 --max-pairs 16
      pairs kitti --format kitti --input "$data/kitti" --sequence 01 --steps 1 --max-pairs 4
      replaced=(--set "data.root=$runs/pairs/kitti" --set 'data.sequences=["00"]'
                --set "validation.data.root=$runs/pairs/kitti" --set 'validation.data.sequences=["01"]') ;;
    *_tutorial)
      what="the tutorial's"
      [[ ! -d data/tutorial ]] || return 0
      what="12 pairs of fox"
      [[ -n "$data" && -d "$data/fox" && -d "$data/mobilebrick" ]] || return 1
      python3 data_tools/convert.py nerf "$data/fox" runs/converted/fox
      pairs tutorial/train --format colmap --input runs/converted/fox --steps 1 --max-pairs 12 --min-true-matches 30
      python3 data_tools/convert.py poses "$data/mobilebrick" runs/converted/mobilebrick
      pairs tutorial/val --format colmap --input runs/converted/mobilebrick
      replaced=(--set "data.root=$runs/pairs/tutorial" --set "validation.data.root=$runs/pairs/tutorial") ;;
    *_modelnet40)
      what=ModelNet40
      [[ ! -d data/ModelNet40 ]] || return 0
      [[ -n "$data" && -d "$data/modelnet_off" ]] || return 1
      what="$(find -L "$data/modelnet_off" -name '*.off' | wc -l) meshes of ModelNet"
      replaced=(--set "data.paths=[$data/modelnet_off]" --set 'data.subset=""') ;;
  esac
}
# train SECONDS FOLDER OPTIONS...: begins or goes on, and stops after so many seconds, at the end of a step and of one at least. Adds to
# FOLDER/peak_kib, and to FOLDER/steps.txt lines "steps done, seconds of the processor, seconds of the clock".
train() {
  local seconds=$1 folder=$2 peak=0 code=0 begun=$SECONDS kind=start first="" last="" now row pid starts
  shift 2
  if [[ -f "$folder/checkpoints/last.safetensors" ]]; then set -- --resume "$@"; fi
  touch "$folder/log.txt"
  starts=$(grep -c ' parameters, device ' "$folder/log.txt" || true)
  "$programs/diffsac_train" --output "$folder" --device cpu --threads 1 "$@" >>"$folder.out" 2>&1 &
  pid=$!
  while kill -0 "$pid" 2>/dev/null; do
    sleep 0.5
    now=$(awk '/^VmHWM/ {print $2}' "/proc/$pid/status" 2>/dev/null || true)
    if ((${now:-0} > peak)); then peak=$now; fi
    # Steps begin when the log says how many parameters there are.
    if (($(grep -c ' parameters, device ' "$folder/log.txt" || true) == starts)); then continue; fi
    row=$(($(wc -l <"$folder/metrics.csv") - 1))
    if [[ "$row" != "$last" ]]; then
      awk -v kind="$kind" -v row="$row" -v clock="$EPOCHREALTIME" -v ticks="$(getconf CLK_TCK)" \
        '{sub(/.*\) /, ""); printf "%s %d %.2f %.2f\n", kind, row, ($12 + $13) / ticks, clock}' \
        "/proc/$pid/stat" >>"$folder/steps.txt" 2>/dev/null || true
      kind=step first=${first:-$row} last=$row
    fi
    if ((SECONDS - begun >= seconds && row > first)); then kill -INT "$pid" 2>/dev/null || true; fi
  done
  wait "$pid" || code=$?
  [[ $code == 0 || $code == 130 ]] || { tail -n 3 "$folder.out" >&2; return 1; }
  echo "$peak" >>"$folder/peak_kib"
}

mkdir -p "$runs"
for name in "${wanted[@]}"; do
  [[ -z "$only_page" ]] || break
  if ! find_data "$name"; then
    echo "paper_sizes: $name is left out: its data are not there, and none in their place (--data)"
    continue
  fi
  echo "paper_sizes: $name, data: $what"
  config=configs/paper/$name.yaml whole=$runs/${name}_whole curve=$runs/${name}_curve
  common=(--config "$config" "${replaced[@]}" --set train.log_every=1 --set train.workers=1)
  small=(--set "train.batch_size=$(($(sed -n 's/^  batch_size: //p' "$config") / smaller))" --set "train.warmup_iterations=$warmup"
    --set "train.validate_every=$validate_every" --set "validation.problems=$validated" --set "inference.num_diffusion_samples=$copies")
  if grep -q '^  max_points:' "$config"; then
    small+=(--set "data.max_points=$matches" --set "validation.data.max_points=$matches")
  fi
  mkdir -p "$whole" "$curve"
  echo "$what" >"$whole/data.txt"
  git rev-parse --short HEAD >"$runs/revision.txt"
  [[ -f $whole/peak_kib ]] || train $((minutes * 20)) "$whole" "${common[@]}" || fail "$name failed; see $whole.out"
  train $((minutes * 40)) "$curve" "${common[@]}" "${small[@]}" || fail "$name failed; see $curve.out"
done

MATCHES=$matches VALIDATE_EVERY=$validate_every WARMUP=$warmup VALIDATED=$validated COPIES=$copies \
  /usr/bin/python3 - "$runs" "$page" "${names[@]}" <<'END'
import csv, os, re, statistics, sys

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt

runs, page, names = sys.argv[1], sys.argv[2], sys.argv[3:]
setting = {key: int(os.environ[key]) for key in ("MATCHES", "VALIDATE_EVERY", "WARMUP", "VALIDATED", "COPIES")}
# Problems that the compact networks are trained on: iterations and batch_size of configs/line.yaml and so on.
compact = {"line": 5000 * 64, "plane": 4500 * 64, "essential_tutorial": 4500 * 16, "homography_kitti": 3500 * 16}
compact_fundamental = 4000 * 16
set_sizes = {"line": 2, "plane": 3, "essential": 5, "homography": 4, "fundamental": 8}


def text_of(*path):
    with open(os.path.join(*path)) as file:
        return file.read()


class Run:
    """What the files of a training's folder say."""

    def __init__(self, folder):
        config, log = text_of(folder, "config.yaml"), text_of(folder, "log.txt")
        self.program = re.search(r"git revision: (\S+)", config)[1]
        self.batch = int(re.search(r"  batch_size: (\d+)", config)[1])
        self.iterations = int(re.search(r"  iterations: (\d+)", config)[1])
        self.validated = int(re.search(r"validation:\n  problems: (\d+)", config)[1])
        self.copies = int(re.search(r"  copies: (\d+)", config)[1])
        self.points = int(re.search(r"  (?:max_points|num_points): ([1-9]\d*)", config)[1])
        self.parameters, self.machine = re.findall(r"(\d+) parameters, device cpu, (.*)", log)[-1]
        self.date = re.findall(r"^\[(\S+)", log, re.M)[-1]
        self.mebibytes = max(int(line) for line in text_of(folder, "peak_kib").split()) / 1024
        rows = list(csv.DictReader(text_of(folder, "metrics.csv").splitlines()))
        self.losses = [float(row["loss_diffusion"]) for row in rows]
        self.accuracies = []
        for row in rows:
            values = [float(row[key]) for key in row if key.startswith("mAA") and row[key]]
            self.accuracies = values or self.accuracies
        self.read_steps(text_of(folder, "steps.txt"))

    def read_steps(self, text):
        """Median seconds of a step, validations apart, by the processor's time; its share of the clock's time."""
        plain, validated, processor, clock, last = [], [], 0.0, 0.0, None
        for line in text.splitlines():
            kind, *numbers = line.split()
            done, now, at = int(numbers[0]), float(numbers[1]), float(numbers[2])
            if kind == "step":
                steps, seconds = done - last[0], now - last[1]
                processor, clock = processor + seconds, clock + at - last[2]
                with_validation = done // setting["VALIDATE_EVERY"] > last[0] // setting["VALIDATE_EVERY"]
                (validated if with_validation else plain).append((seconds, steps))
            last = (done, now, at)
        self.seconds = statistics.median(seconds / steps for seconds, steps in plain for _ in range(steps))
        self.validation = statistics.median(s - n * self.seconds for s, n in validated) if validated else None
        self.share = processor / clock

    def tenth(self, first):
        count = max(1, len(self.losses) // 10)
        part = self.losses[:count] if first else self.losses[-count:]
        return sum(part) / count


def number(value, digits=3):
    """So many significant digits, no exponent."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e" in text or value >= 10 ** (digits - 1) else text


def table(header, rows):
    lines = [header, ["---"] * len(header)] + rows
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def runs_of(kind):
    folders = {name: os.path.join(runs, f"{name}_{kind}") for name in names}
    return {name: Run(folder) for name, folder in folders.items() if os.path.exists(os.path.join(folder, "peak_kib"))}


whole, curve = runs_of("whole"), runs_of("curve")
found = list(whole)
if not found:
    sys.exit("paper_sizes: there are no runs yet")
data = {name: text_of(runs, name + "_whole", "data.txt").strip() for name in found}


def trivial(name):
    return 4.0 * set_sizes[name.split("_")[0]] / curve[name].points


def days(name, problems):
    return problems / whole[name].batch * whole[name].seconds / 86400


sizes = table(
    ["configuration", "data here", "points", "batch", "steps", "s a step", "peak memory, MiB", "days for its 100 000 steps",
     "days for the compact network's problems"],
    [[f"`{name}`", data[name], run.points, run.batch, len(run.losses), number(run.seconds), f"{run.mebibytes:.0f}",
      number(days(name, run.iterations * run.batch), 2), number(days(name, compact.get(name, compact_fundamental)), 2)]
     for name, run in whole.items()])


def whole_validation(name):
    """Hours of a validation as the configuration has it, where the points are as many; the checkpoint is counted each time."""
    small, large = curve[name], whole[name]
    if not small.validation or small.points != large.points:
        return "–"
    return number(small.validation / (small.validated * small.copies) * large.validated * large.copies / 3600, 2)


curves = table(
    ["configuration", "points", "batch", "steps", "s a step", "peak memory, MiB", "loss, first tenth", "loss, last tenth", "loss if all are −1",
     f"mAA of {setting['VALIDATED']} problems", "its s", "the configuration's validation, at most h"],
    [[f"`{name}`", run.points, run.batch, len(run.losses), number(run.seconds), f"{run.mebibytes:.0f}", f"{run.tenth(True):.3f}",
      f"{run.tenth(False):.3f}", number(trivial(name), 2),
      ", ".join(f"{value:.2f}" for value in run.accuracies) or "–", number(run.validation, 2) if run.validation else "–",
      whole_validation(name)]
     for name, run in curve.items()])
any_run = whole[found[0]]
missing = [name for name in names if name not in found]
tutorial = next((name for name in found if name.endswith("_tutorial")), None)
picture = os.path.basename(page)[:-3] + "_curve.png"
programs = sorted({run.program for run in [*whole.values(), *curve.values()]})
# What somebody wrote about these runs, for the page.
notes_path = os.path.join(runs, "notes.txt")
notes = [text_of(notes_path).strip(), ""] if os.path.exists(notes_path) else []
shares = [run.share for run in [*whole.values(), *curve.values()]]
lines = [
    "# The paper's sizes, some minutes each",
    "",
    "The trainings of `configs/paper/` have the paper's network: width 512, 12 joint layers, 8 heads, "
    f"{int(any_run.parameters) / 1e6:.0f} million parameters. A GPU was",
    "not available, and one thread of a CPU is far too slow for them. This page shows that those below work as a whole, what they need, and how",
    "long they would take. **Nothing converged: these are no results.** The networks are not used anywhere.",
    "",
    "## As they are",
    "",
    sizes,
    "",
    "- Seconds are those of the processor, one thread, median over the steps. The machine was busy with other work: a run had "
    f"{100 * min(shares):.0f} to {100 * max(shares):.0f} % of",
    "  a core, so that the clock ran so much longer. Reading the data and making the labels are in them.",
    "- Peak memory is that of the process, start and checkpoints included. No batch had to be made smaller for it.",
    "- Days are steps times seconds a step. The paper trains for 100 epochs and does not say how many problems an epoch has; the configurations",
    "  take 100 000 steps. The last column has as many problems as this project's compact networks of 400 000 parameters are trained on, about a",
    "  hundredth as large: a guess at where a network begins to be of use.",
]
if tutorial:
    millions = 100e6 / whole[tutorial].batch
    lines += [
        "- Of the tutorial the paper says that there are over one million training pairs. A hundred epochs of them are 6.25 million steps of 16: "
        f"{number(days(tutorial, 100e6) / 365, 2)} years",
        "  of one thread. KITTI 00 to 07 have 16 330 pairs of neighbouring frames: 100 epochs are 102 000 steps, about the configuration's number.",
    ]
lines += [
    "- Data: lines and planes are generated as in the configuration. The others stand in for data that were not at hand: neighbouring frames of",
    "  KITTI 00, validated on 01, for sequences 00 to 06, validated on 07; neighbouring frames of fox, validated on mobilebrick, for the CVPR",
    "  2020 RANSAC tutorial; a few meshes for ModelNet40. Only folders, sequences and subset differ; points, features, labels and network do not.",
    "  Pairs of fox have 573 to 1726 matches, those of KITTI 1130 to 1701; of more than 1000 the configurations take 1000.",
]
if missing:
    lines += ["- Not run, for want of data or of time: " + ", ".join(f"`{name}`" for name in missing) + "."]
lines += [
    "",
    "## With a smaller batch, for a curve",
    "",
    f"A sixteenth of the batch, at most {setting['MATCHES']} matches of a photographed pair, a warm-up of {setting['WARMUP']} steps in place of 500, and a validation of",
    f"{setting['VALIDATED']} problems a group by {setting['COPIES']} copy each {setting['VALIDATE_EVERY']} steps; all else as above.",
    "",
    curves,
    "",
    "Labels are ±1 and γ of N points are +1, so a network that says −1 of every point has a loss of 4γ/N. To come down to that says only that the",
    "network, its gradients and its steps are right. It goes below also where little noise is added, so that the labels can be seen. The mAA is that",
    f"of {setting['VALIDATED']} problems, by outlier ratio where the configuration has several: it shows that inference of this size works, and what it takes.",
    "The configurations validate 200 to 256 problems a group by 20 copies, which takes hours of one thread each 5000 steps; set",
    "`validation.problems` lower there. Where few steps are shown the machine's other work left no time for more.",
    "",
    f"![Losses of the trainings with a smaller batch]({picture})",
    "",
    "*Loss of each step (grey) and its mean over a tenth of the steps (blue), logarithmic; dashed: a network that says −1 of every point.*",
    "",
    *notes,
    "Written by `scripts/paper_sizes.sh --data DIR`; called again it goes on with the same curves.",
    "",
    f"- revisions: {text_of(runs, 'revision.txt').strip()}, of the programs: {', '.join(programs)}",
    "- seed: 1",
    f"- machine: {any_run.machine}",
    f"- date: {max(run.date for run in [*whole.values(), *curve.values()])}",
]
with open(page, "w") as file:
    file.write("\n".join(lines) + "\n")

rows = -(-len(curve) // 2)
figure, grid = plt.subplots(rows, 2, figsize=(14, 3.3 * rows), dpi=100, squeeze=False, layout="constrained")
for axes, (name, run) in zip(grid.flat, curve.items()):
    width, steps = max(1, len(run.losses) // 10), range(1, len(run.losses) + 1)
    means = [sum(part) / len(part) for part in (run.losses[max(0, i - width):i] for i in steps)]
    axes.plot(steps, run.losses, color="#909090", linewidth=0.8)
    axes.plot(steps, means, color="#0072B2", linewidth=2)
    axes.axhline(trivial(name), color="#D55E00", linestyle="--")
    axes.set(title=f"{name}: {run.points} points, batch {run.batch}", yscale="log", xlabel="step", ylabel="loss")
    axes.set_ylim(top=2)
    axes.grid(color="#E0E0E0")
for axes in grid.flat[len(curve):]:
    axes.set_axis_off()
figure.savefig(os.path.join(os.path.dirname(page), picture))
print(f"paper_sizes: {page}")
END
