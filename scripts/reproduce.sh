#!/usr/bin/env bash
# Reproduces tables: sets up, builds the programs in Release, trains networks that a table needs and that are not there,
# evaluates and prints the tables. Everything is written under runs/; a whole table goes to docs/results/TABLE.md as well.
# Stopped and started again, it continues. `kitti` and `pairs` begin with images: their matches go to runs/pairs/.
set -euo pipefail
readonly caller=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tables() { for config in configs/tables/*.yaml; do [[ -e "$config" ]] && basename "$config" .yaml; done; true; }

usage() {
  echo "usage: scripts/reproduce.sh TABLE... [--size compact|paper] [--again] [options of diffsac_eval, such as --limit 100]"
  echo "       scripts/reproduce.sh kitti|pairs --data DIR [options of diffsac_eval]"
  echo "tables: $(tables | tr '\n' ' ')all"
  echo "--size paper: networks of the paper's size (configs/paper), trained first; needs a CUDA device and the paper's data"
  echo "--again: also tables that were made here already"
  echo "kitti, pairs: from the images in DIR to the tables learned_*, on KITTI alone or on all sets that are there:"
  echo "  DIR/kitti, DIR/strecha/castle-P19, DIR/lund_door, DIR/oxford_graf, DIR/hpatches_v_dogman (data_tools/README.md)"
}

fail() { echo "reproduce: $*" >&2; exit 1; }

# Sequences that models are tested on: trained on are others (configs/essential.yaml).
readonly KITTI_TEST_SEQUENCES=(01 08 09 10)
scenes=() homographies=() image_folders=()

# add_set NAME FOLDER FORMAT KIND SCENES [OPTIONS]: prepares a set when its folder is there, says so when it is not. SCENES
# are the folders it makes, FOLDER/images or FOLDER holds its images.
add_set() {
  local name=$1 folder=$2 format=$3 kind=$4 made=$5 scene images
  shift 5
  if [[ ! -d "$folder" ]]; then
    echo "reproduce: left out: $name, there is no $folder"
    return
  fi
  build/release/bin/diffsac_prepare pairs --format "$format" --output "runs/pairs/$kind" "$@"
  images=$folder
  if [[ -d "$folder/images" ]]; then images=$folder/images; fi
  for scene in $made; do
    if [[ "$kind" == homography ]]; then homographies+=("runs/pairs/$kind/$scene"); else scenes+=("runs/pairs/$kind/$scene"); fi
    image_folders+=("{scenes: '$scene', folder: '${images//\'/\'\'}'}")
  done
}

prepare_kitti() {
  local root=$data/kitti sequence
  if [[ ! -d "$root" && -d "$data/sequences" ]]; then root=$data; fi
  for sequence in "${KITTI_TEST_SEQUENCES[@]}"; do
    add_set "KITTI $sequence" "$root/sequences/$sequence/image_0" kitti test \
      "$(printf "kitti_${sequence}_step_%s " 01 02 05 10)" \
      --input "$root" --sequence "$sequence" --steps 1,2,5,10 --max-pairs 200
  done
}

prepare_others() {
  add_set castle-P19 "$data/strecha/castle-P19" strecha test castle-P19 \
    --input "$data/strecha/castle-P19" --min-true-matches 20
  add_set lund_door "$data/lund_door" colmap test lund_door --input "$data/lund_door"
  add_set oxford_graf "$data/oxford_graf" homographies homography oxford_graf --input "$data/oxford_graf"
  # The set may have a folder of its own in that of the download.
  local dogman=$data/hpatches_v_dogman
  if [[ -d "$dogman/v_dogman" ]]; then dogman=$dogman/v_dogman; fi
  add_set hpatches_v_dogman "$dogman" homographies homography hpatches_v_dogman --input "$dogman" --scene hpatches_v_dogman
}

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

# publish TABLE FOLDER COMMAND: the whole table with what it was made by and on.
publish() {
  local page=docs/results/$1.md picture
  mkdir -p docs/results
  {
    cat "$2/table.md"
    echo
    for picture in "$2"/*.png; do
      if [[ ! -f "$picture" ]]; then continue; fi
      cp "$picture" "docs/results/$1_$(basename "$picture")"
      echo "![$1: $(basename "$picture" .png)]($1_$(basename "$picture"))"
      echo
    done
    echo "Written by \`$3\`."
    sed -n 's/^# \(git revision\|seed\|machine\|date\): /- \1: /p' "$2/config.yaml"
  } >"$page.part"
  mv "$page.part" "$page"
  echo "reproduce: $page"
}

# Whether docs/results has what runs/ made here, and neither programs nor table nor the networks that it names have changed
# since. (A page that came with the repository doesn't count: whoever runs this wants to see it made.)
is_made() {
  local config=runs/$1/config.yaml table=configs/tables/$1.yaml revision date models
  [[ -f "$config" && -f "runs/$1/table.md" ]] || return 1
  revision=$(sed -n 's/^# git revision: //p' "$config") date=$(sed -n 's/^# date: //p' "$config")
  grep -qsxF -- "- date: $date" "docs/results/$1.md" || return 1
  mapfile -t models < <(grep -o 'checkpoint: models/[^,} ]*' "$table" | sed 's/^checkpoint: //' | sort -u)
  [[ "$revision" =~ ^[0-9a-f]+$ ]] && git diff --quiet "$revision" -- lib apps "$table" "${models[@]}" 2>/dev/null
}

joined() { local IFS=,; echo "[$*]"; }

# evaluate_on TABLE OUTPUT SCENES... -- OPTIONS...: the table on these scenes alone.
evaluate_on() {
  local table=$1 output=$2 paths=()
  shift 2
  while [[ "$1" != -- ]]; do paths+=("$1"); shift; done
  shift
  if ((${#paths[@]} == 0)); then
    echo "reproduce: left out: the table $table, none of its data is there"
    return
  fi
  build/release/bin/diffsac_eval --config "configs/tables/$table.yaml" --output "$output" \
    --set "data.paths=$(joined "${paths[@]}")" --set "figures.images=$(joined "${image_folders[@]}")" \
    --set figures.qualitative=2 "$@"
  echo "reproduce: tables, pictures and results are in $output/"
}

reproduce_from_images() {
  local output=runs
  prepare_kitti
  if [[ "$from_images" == kitti ]]; then output=runs/kitti; else prepare_others; fi
  if ((${#scenes[@]} + ${#homographies[@]} == 0)); then fail "there are none of the sets in $data"; fi
  evaluate_on learned_essential "$output/learned_essential" "${scenes[@]}" -- "$@"
  evaluate_on learned_fundamental "$output/learned_fundamental" "${scenes[@]}" -- "$@"
  if [[ "$from_images" == kitti ]]; then return; fi
  evaluate_on learned_homography "$output/learned_homography" "${homographies[@]}" -- "$@"
}

wanted=()
while (($#)) && [[ "$1" != -* ]]; do wanted+=("$1"); shift; done
if [[ "${1:-}" == "-h" || "${1:-}" == "--help" ]]; then usage; exit 0; fi
if ((${#wanted[@]} == 0)); then usage >&2; exit 1; fi
from_images="" data=""
if [[ "${wanted[*]}" == kitti || "${wanted[*]}" == pairs ]]; then
  from_images=${wanted[*]}
  wanted=()
  options=()
  while (($#)); do
    case "$1" in
      --data) if [[ -z "${2:-}" ]]; then fail "--data needs a folder"; fi; data=$2; shift 2 ;;
      --data=*) data=${1#--data=}; shift ;;
      --output*) fail "--output works with one table; $from_images writes its tables under runs/" ;;
      *) options+=("$1"); shift ;;
    esac
  done
  set -- "${options[@]}"
  if [[ -z "$data" ]]; then fail "$from_images needs --data DIR, the folder of the images"; fi
  # A relative folder means the caller's.
  if [[ "$data" != /* ]]; then data=$caller/$data; fi
  if [[ ! -d "$data" ]]; then fail "--data: there is no folder $data"; fi
  data=${data%/}
fi
size=compact again=""
if [[ -z "$from_images" ]]; then
  options=()
  while (($#)); do
    case "$1" in
      --size) size=${2:-}; shift $(($# > 1 ? 2 : 1)) ;;
      --size=*) size=${1#--size=}; shift ;;
      --again) again=yes; shift ;;
      *) options+=("$1"); shift ;;
    esac
  done
  set -- "${options[@]}"
  if [[ "$size" != compact && "$size" != paper ]]; then fail "--size is compact or paper, not '$size'"; fi
fi
if [[ "${wanted[*]}" == "all" ]]; then mapfile -t wanted < <(tables); fi
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

if [[ -n "$from_images" ]]; then
  reproduce_from_images "$@"
  exit
fi
# A table with options is another table than the one that docs/results shows; the number of threads changes nothing.
whole=yes
for ((i = 1; i <= $#; ++i)); do
  if [[ "${!i}" == --threads ]]; then ((++i)); elif [[ "${!i}" != --threads=* ]]; then whole=""; fi
done
for table in "${wanted[@]}"; do
  if [[ -n "$whole" && -z "$again" && "$size" == compact ]] && is_made "$table"; then
    echo "reproduce: docs/results/$table.md was made here, and nothing it was made from has changed (--again makes it anew)"
    continue
  fi
  output="runs/$table"
  # A later --output of the caller's replaces ours.
  arguments=(--config "configs/tables/$table.yaml")
  page=$table
  command="scripts/reproduce.sh $table"
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
