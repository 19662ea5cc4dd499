#!/usr/bin/env bash
# Reproduces tables: sets up, builds the programs in Release, trains networks that a table needs and that are not there,
# evaluates and prints the tables. Everything is written under runs/; a whole table goes to docs/results/TABLE.md as well.
# Stopped and started again, it continues. With --data it begins with images.
set -euo pipefail
readonly caller=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tables() { for config in configs/tables/*.yaml; do [[ -e "$config" ]] && basename "$config" .yaml; done; true; }

usage() {
  echo "usage: scripts/reproduce.sh TABLE...|all [--data DIR] [--size compact|paper] [--again] [options of diffsac_eval]"
  echo "       scripts/reproduce.sh pairs|kitti|data --data DIR"
  echo "tables: $(tables | tr '\n' ' ')"
  echo "--data: where images and other data are; matches go to runs/pairs/ (data_tools/README.md):"
  echo "  DIR/kitti, DIR/strecha/castle-P19, DIR/lund_door, DIR/oxford_graf, DIR/hpatches_v_dogman, DIR/adelaidermf,"
  echo "  DIR/ModelNet40 or DIR/modelnet_off, DIR/tutorial, DIR/pyransac3d_ply; to train on: DIR/fox, DIR/mobilebrick,"
  echo "  DIR/sevenscenes_redkitchen"
  echo "--size paper: networks of the paper's size (configs/paper), trained first; needs a CUDA device and the paper's data"
  echo "--again: also tables that were made here already"
  echo "pairs: the tables learned_*; kitti: those on KITTI alone, in runs/kitti/; data: matches alone, no table"
  echo "options of diffsac_eval: such as --threads 1, --limit 100"
}

fail() { echo "reproduce: $*" >&2; exit 1; }

. scripts/data_sets.sh

# The paper's configuration for a table, where it has one.
paper_config() {
  case "$1" in
    line*) echo line ;;
    plane*) echo plane ;;
    fundamental_tutorial|essential_tutorial|fundamental_kitti) echo "$1" ;;
    kitti_homography) echo homography_kitti ;;
    modelnet_fundamental) echo fundamental_modelnet40 ;;
  esac
}

# train CONFIG OUTPUT: goes on where an earlier run stopped.
train() {
  local arguments=(--config "$1" --output "$2")
  if [[ -f "$2/checkpoints/last.pt" ]]; then arguments+=(--resume); fi
  echo "reproduce: training $1 (log in $2/log.txt)"
  build/release/bin/diffsac_train "${arguments[@]}" >"$2.log" 2>&1 || { tail -n 5 "$2.log" >&2; return 1; }
}

# Networks under runs/ that the table's rows name, and that are not there.
train_missing() {
  local checkpoint name config
  while read -r checkpoint; do
    if [[ -f "$checkpoint" ]]; then continue; fi
    name=$(basename "$(dirname "$(dirname "$checkpoint")")")
    config=$(grep -rlx "name: $name" configs --include='*.yaml' --exclude-dir=tables | head -n 1)
    if [[ -z "$config" ]]; then
      echo "reproduce: no configuration is named $name, for $checkpoint" >&2
      continue
    fi
    mkdir -p runs
    train "$config" "runs/$name" || echo "reproduce: $name was not trained; its rows are left out" >&2
  done < <(grep -o 'checkpoint: runs/[^,} ]*/checkpoints/best.pt' "configs/tables/$1.yaml" | sed 's/^checkpoint: //' | sort -u)
}

# The pictures in a folder, of those of matches no more than two, from first to last.
pictures() {
  local all=() i most
  find "$1" -maxdepth 1 -name '*.png' ! -name 'matches_*' | sort
  mapfile -t all < <(find "$1" -maxdepth 1 -name 'matches_*.png' | sort)
  most=$((${#all[@]} < 2 ? ${#all[@]} : 2))
  for ((i = 0; i < most; ++i)); do echo "${all[i * ${#all[@]} / most]}"; done
}

# publish TABLE FOLDER COMMAND: the whole table with what it was made by and on.
publish() {
  local page=docs/results/$1.md picture
  mkdir -p docs/results
  {
    cat "$2/table.md"
    echo
    while read -r picture; do
      cp "$picture" "docs/results/$1_$(basename "$picture")"
      echo "![$1: $(basename "$picture" .png)]($1_$(basename "$picture"))"
      echo
    done < <(pictures "$2")
    echo "Written by \`$3\`."
    echo
    sed -n 's/^# \(git revision\|seed\|machine\|date\): /- \1: /p' "$2/config.yaml"
  } >"$page.part"
  mv "$page.part" "$page"
  echo "reproduce: $page"
}

# is_made TABLE FOLDER COMMAND: whether docs/results has what this command made here in FOLDER, and neither programs nor table
# nor the networks that it names have changed since. (A page that came with the repository doesn't count: whoever runs this
# wants to see it made.)
is_made() {
  local config=$2/config.yaml table=configs/tables/$1.yaml revision date models
  [[ -f "$config" && -f "$2/table.md" ]] && grep -qsxF -- "Written by \`$3\`." "docs/results/$1.md" || return 1
  revision=$(sed -n 's/^# git revision: //p' "$config") date=$(sed -n 's/^# date: //p' "$config")
  grep -qsxF -- "- date: $date" "docs/results/$1.md" || return 1
  mapfile -t models < <(grep -o 'checkpoint: models/[^,} ]*' "$table" | sed 's/^checkpoint: //' | sort -u)
  [[ "$revision" =~ ^[0-9a-f]+$ ]] && git diff --quiet "$revision" -- lib apps "$table" "${models[@]}" 2>/dev/null
}

# Whether one of the tables has such a line.
any_table_has() {
  local table
  for table in "${wanted[@]}"; do
    if grep -q -- "$1" "configs/tables/$table.yaml"; then return; fi
  done
  return 1
}

# From the images of DIR to the matches that the wanted tables and their missing networks are about.
prepare_data() {
  if [[ "$mode" == data ]]; then
    prepare_kitti; prepare_others; prepare_adelaidermf; prepare_training_scenes runs/pairs/test runs/pairs/train
    prepare_warped; prepare_descriptors
    return
  fi
  if any_table_has 'runs/pairs\|kitti_pairs'; then prepare_kitti; fi
  if [[ "$mode" != kitti ]] && any_table_has runs/pairs; then prepare_others; fi
  if [[ -n "$mode" ]]; then
    if ((${#scenes[@]} + ${#homographies[@]} == 0)); then fail "there are none of the sets in $data"; fi
    return
  fi
  if any_table_has runs/pairs/adelaidermf; then prepare_adelaidermf; fi
  # Tables of all of runs/pairs/test, and those with networks that are trained for them.
  if any_table_has 'runs/pairs/test\]\|checkpoint: runs/'; then prepare_training_scenes runs/pairs/test runs/pairs/train; fi
  if any_table_has runs/descriptors; then prepare_descriptors; fi
}

wanted=()
while (($#)) && [[ "$1" != -* ]]; do wanted+=("$1"); shift; done
if [[ "${1:-}" == "-h" || "${1:-}" == "--help" ]]; then usage; exit 0; fi
if ((${#wanted[@]} == 0)); then usage >&2; exit 1; fi
mode="" data="" runs=runs
case "${wanted[*]}" in
  kitti) mode=kitti runs=runs/kitti wanted=(learned_essential learned_fundamental) ;;
  data) mode=data wanted=() ;;
  pairs) mode=pairs wanted=(learned_essential learned_fundamental learned_homography) ;;
  all) mapfile -t wanted < <(tables) ;;
esac
size=compact again=""
options=()
while (($#)); do
  case "$1" in
    --data) if [[ -z "${2:-}" ]]; then fail "--data needs a folder"; fi; data=$2; shift 2 ;;
    --data=*) data=${1#--data=}; shift ;;
    --size) size=${2:-}; shift $(($# > 1 ? 2 : 1)) ;;
    --size=*) size=${1#--size=}; shift ;;
    --again) again=yes; shift ;;
    *) options+=("$1"); shift ;;
  esac
done
set -- "${options[@]}"
if [[ "$size" != compact && "$size" != paper ]]; then fail "--size is compact or paper, not '$size'"; fi
if [[ -n "$mode" && -z "$data" ]]; then fail "$mode needs --data DIR, the folder of the images"; fi
if [[ -n "$data" ]]; then
  # A relative folder means the caller's.
  if [[ "$data" != /* ]]; then data=$caller/$data; fi
  if [[ ! -d "$data" ]]; then fail "--data: there is no folder $data"; fi
  data=${data%/}
fi
for table in "${wanted[@]}"; do
  if [[ "$table" == */* || ! -f "configs/tables/$table.yaml" ]]; then
    echo "reproduce: there is no table '$table'" >&2
    usage >&2
    exit 1
  fi
done
for option in "$@"; do
  if [[ "$option" == --output* && ${#wanted[@]} -gt 1 ]]; then
    echo "reproduce: --output works with one table; without it each is written under runs/" >&2
    exit 1
  fi
done

scripts/setup.sh
log=build/release/reproduce.log
mkdir -p build/release
echo "reproduce: building (details in $log)"
if ! { cmake --preset release -DDIFFSAC_BUILD_TESTS=OFF && cmake --build --preset release; } >"$log" 2>&1; then
  tail -n 30 "$log" >&2
  echo "reproduce: the build failed; all of its output is in $log" >&2
  exit 1
fi

if [[ -n "$data" ]]; then prepare_data; fi
if [[ "$mode" == data ]]; then exit; fi
# A table with options is another table than the one that docs/results shows; the number of threads changes nothing.
whole=yes
for ((i = 1; i <= $#; ++i)); do
  if [[ "${!i}" == --threads ]]; then ((++i)); elif [[ "${!i}" != --threads=* ]]; then whole=""; fi
done
if [[ "$mode" == kitti ]]; then whole=""; fi
for table in "${wanted[@]}"; do
  output="$runs/$table" page=$table
  command="scripts/reproduce.sh $table${data:+ --data DIR}"
  if [[ -n "$whole" && -z "$again" && "$size" == compact ]] && is_made "$table" "$output" "$command"; then
    echo "reproduce: docs/results/$table.md was made here, and nothing it was made from has changed (--again makes it anew)"
    continue
  fi
  if ! locate "$table"; then echo "reproduce: left out: the table $table, none of its data is there"; continue; fi
  # A later --output of the caller's replaces ours.
  arguments=(--config "configs/tables/$table.yaml" "${located[@]}")
  if [[ "$size" == paper ]]; then
    network=$(paper_config "$table")
    if [[ -z "$network" ]]; then echo "reproduce: left out: $table has no network of the paper's size"; continue; fi
    if ! command -v nvidia-smi >/dev/null; then
      echo "reproduce: left out: $table at the paper's size, there is no CUDA device"
      continue
    fi
    train "configs/paper/$network.yaml" "runs/paper_$network" || fail "configs/paper/$network.yaml was not trained"
    arguments+=(--checkpoint "runs/paper_$network/checkpoints/best.pt")
    page="paper_$table" output="runs/paper_$table" command+=" --size paper"
  else
    train_missing "$table"
  fi
  if [[ " $* " == *" --output"* ]]; then
    output=""
  else
    arguments+=(--output "$output")
    rm -f "$output/table.md"
  fi
  build/release/bin/diffsac_eval "${arguments[@]}" "$@"
  if [[ -z "$output" ]]; then continue; fi
  if [[ ! -f "$output/table.md" ]]; then continue; fi   # left out, as the program said
  echo "reproduce: tables, pictures and results are in $output/"
  if [[ -n "$whole" ]]; then publish "$page" "$output" "$command"; fi
done
