# The image sets that tables and trainings are about, as matches in runs/: read by reproduce.sh, whose DIR is `data`. Scenes
# that are complete stay.

# Sequences that models are tested on: trained on are others (configs/data/pairs_essential.yaml).
readonly KITTI_TEST_SEQUENCES=(01 08 09 10)
# What add_set finds: scenes with poses and with homographies, and where their images are.
scenes=() homographies=() image_folders=()

is_there() {
  if [[ -d "$2" ]]; then return; fi
  echo "reproduce: left out: $1, there is no $2"
  return 1
}

prepare() { build/release/bin/diffsac_prepare "$@"; }

# add_set NAME FOLDER FORMAT KIND SCENES [OPTIONS]: prepares a set when its folder is there, says so when it is not. SCENES
# are the folders it makes, FOLDER/images or FOLDER holds its images.
add_set() {
  local name=$1 folder=$2 format=$3 kind=$4 made=$5 scene images
  shift 5
  is_there "$name" "$folder" || return 0
  prepare pairs --format "$format" --output "runs/pairs/$kind" "$@"
  images=$folder
  if [[ -d "$folder/images" ]]; then images=$folder/images; fi
  for scene in $made; do
    if [[ "$kind" == homography ]]; then homographies+=("runs/pairs/$kind/$scene"); else scenes+=("runs/pairs/$kind/$scene"); fi
    image_folders+=("{scenes: '$scene', folder: '${images//\'/\'\'}'}")
  done
}

kitti_root() { if [[ ! -d "$data/kitti" && -d "$data/sequences" ]]; then echo "$data"; else echo "$data/kitti"; fi; }

prepare_kitti() {
  local root sequence
  root=$(kitti_root)
  for sequence in "${KITTI_TEST_SEQUENCES[@]}"; do
    add_set "KITTI $sequence" "$root/sequences/$sequence/image_0" kitti test \
      "$(printf "kitti_${sequence}_step_%s " 01 02 05 10)" \
      --input "$root" --sequence "$sequence" --steps 1,2,5,10 --max-pairs 200
  done
}

dogman() { if [[ -d "$data/hpatches_v_dogman/v_dogman" ]]; then echo "$data/hpatches_v_dogman/v_dogman"; else echo "$data/hpatches_v_dogman"; fi; }

prepare_others() {
  add_set castle-P19 "$data/strecha/castle-P19" strecha test castle-P19 \
    --input "$data/strecha/castle-P19" --min-true-matches 20
  add_set lund_door "$data/lund_door" colmap test lund_door --input "$data/lund_door"
  add_set oxford_graf "$data/oxford_graf" homographies homography oxford_graf --input "$data/oxford_graf"
  add_set hpatches_v_dogman "$(dogman)" homographies homography hpatches_v_dogman --input "$(dogman)" --scene hpatches_v_dogman
}

# prepare_set NAME FOLDER OPTIONS...: the matches of a set when its folder is there.
prepare_set() {
  is_there "$1" "$2" || return 0
  shift 2
  prepare pairs "$@"
}

prepare_adelaidermf() {
  prepare_set AdelaideRMF "$data/adelaidermf" --format adelaidermf --input "$data/adelaidermf" --output runs/pairs/adelaidermf
}

# prepare_training_scenes ROOT_OF_KITTI_00 ROOT [OPTIONS]
prepare_training_scenes() {
  local kitti_output=$1 output=$2
  shift 2
  prepare_set "KITTI 00" "$(kitti_root)/sequences/00/image_0" --format kitti --sequence 00 --steps 1,2,5,10 \
    --input "$(kitti_root)" --output "$kitti_output" "$@"
  prepare_set fox "$data/fox" --format nerf --max-keypoints 4000 --min-true-matches 30 --max-pairs 220 --input "$data/fox" \
    --output "$output" "$@"
  prepare_set mobilebrick "$data/mobilebrick" --format poses --max-keypoints 4000 --input "$data/mobilebrick" \
    --output "$output" "$@"
  prepare_set sevenscenes_redkitchen "$data/sevenscenes_redkitchen" --format poses --max-keypoints 4000 \
    --min-true-matches 30 --true-match-px 2 --max-pairs 250 --every 2 --focal 525 --center 320,240 --scene sevenscenes \
    --input "$data/sevenscenes_redkitchen" --output "$output" "$@"
}

# Views of images as planes: what networks for homographies are trained on.
prepare_warped() {
  local part name folder
  for part in fox/images:6 mobilebrick/image:5 kitti/sequences/00/image_0:4; do
    name=${part%%/*}
    is_there "images of $name" "$data/${part%:*}" || continue
    prepare warp --input "$data/${part%:*}" --images "${part#*:}" --views 5 --output "runs/warped/$name"
    for folder in "runs/warped/$name"/*; do
      prepare pairs --format homographies --input "$folder" --scene "${name}_$(basename "$folder")" \
        --output runs/pairs/train_homography
    done
  done
}

# Other features with their descriptors, for the ablation of descriptors. SuperPoint's are made elsewhere:
# diffsac_prepare --import-descriptors (data_tools/README.md).
prepare_descriptors() {
  local features root
  for features in rootsift orb; do
    root=runs/descriptors/$features
    local more=(--features "$features" --descriptors)
    prepare_set "KITTI 01" "$(kitti_root)/sequences/01/image_0" --format kitti --sequence 01 --steps 1,2,5,10 \
      --input "$(kitti_root)" --output "$root/test" "${more[@]}"
    prepare_set castle-P19 "$data/strecha/castle-P19" --format strecha --min-true-matches 20 \
      --input "$data/strecha/castle-P19" --output "$root/test" "${more[@]}"
    prepare_set lund_door "$data/lund_door" --format colmap --input "$data/lund_door" --output "$root/test" "${more[@]}"
    prepare_training_scenes "$root/train" "$root/train" "${more[@]}"
  done
}

joined() { local IFS=,; echo "[$*]"; }
quoted() { echo "'${1//\'/\'\'}'"; }

# on_scenes SCENES...: the options that make a table be about these; status 1 when there are none.
on_scenes() {
  if (($# == 0)); then return 1; fi
  located+=(--set "data.paths=$(joined "$@")")
}

# with_pictures SCENES...: and draw the matches of two pairs.
with_pictures() {
  on_scenes "$@" || return 1
  located+=(--set "figures.images=$(joined "${image_folders[@]}")" --set figures.qualitative=2)
}

# locate TABLE: puts the options that make a table read the data of DIR into `located`; status 1 when DIR has none of it.
# Tables of synthetic data, and those that read all of runs/pairs, need no options.
locate() {
  local folder sequence found=() of_kitti=()
  located=()
  if [[ -z "$data" ]]; then return; fi
  for folder in "${scenes[@]}"; do
    if [[ "$folder" == */kitti_* ]]; then of_kitti+=("$folder"); fi
  done
  case "$1" in
    learned_homography) with_pictures "${homographies[@]}" ;;
    learned_*) with_pictures "${scenes[@]}" ;;
    fundamental_budget | ablation) on_scenes "${scenes[@]}" ;;
    kitti_homography) on_scenes "${of_kitti[@]}" ;;
    fundamental_kitti)
      for sequence in 08 09 10; do
        if [[ -d "runs/pairs/test/kitti_${sequence}_step_01" ]]; then found+=("\"$sequence\""); fi
      done
      # In place of the paper's sequences, where they are not there.
      if ((${#found[@]} == 0)) && [[ -d runs/pairs/test/kitti_01_step_01 ]]; then found=('"01"'); fi
      if ((${#found[@]} == 0)); then return 1; fi
      located+=(--set data.root=runs/pairs/test --set "data.sequences=$(joined "${found[@]}")"
                --set "title=fundamental matrices of KITTI $(tr -d '"' <<<"${found[*]}")")
      ;;
    *_tutorial)
      [[ -d "$data/tutorial" ]] || return 1
      located+=(--set "data.root=$(quoted "$data/tutorial")")
      ;;
    modelnet_fundamental)
      if [[ -d "$data/ModelNet40" ]]; then
        located+=(--set "data.paths=[$(quoted "$data/ModelNet40")]" --set data.subset=test)
      else
        [[ -d "$data/modelnet_off" ]] || return 1
        located+=(--set "data.paths=[$(quoted "$data/modelnet_off")]")
      fi
      ;;
    scans)
      [[ -d "$data/pyransac3d_ply" ]] || return 1
      located+=(--set "data.paths=[$(quoted "$data/pyransac3d_ply")]")
      ;;
  esac
}
