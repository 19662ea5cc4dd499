#!/usr/bin/env bash
# Fetches the public scenes of configs/sets.yaml (data_tools/README.md has their table): scripts/scenes.sh DIR makes DIR/scenes/NAME,
# each a repository at one commit with the files that are needed alone. Those that are there stay. Nothing of them is part of this project.
set -euo pipefail
if [[ $# -lt 1 || "$1" == -* ]]; then
  echo "usage: scripts/scenes.sh DIR [NAME...]    then: diffsac_prepare sets --config configs/sets.yaml --data DIR --only 'runs/pairs/scenes'" >&2
  exit 1
fi
mkdir -p "$1/scenes"
cd "$1/scenes"
shift
names=" $* "

# scene NAME OWNER/REPOSITORY 69c4062485aa2e9135f65c93069342cd049cf321 PATH...: paths as in .gitignore.
scene() {
  local name=$1 repository=$2 commit=$3
  if [[ "$names" != "  " && "$names" != *" $name "* ]]; then return; fi
  if [[ -d "$name" ]]; then echo "$name: is there"; return; fi
  rm -rf "$name.part"
  git clone --quiet --filter=blob:none --no-checkout "https://github.com/$repository" "$name.part"
  git -C "$name.part" sparse-checkout set --no-cone "${@:4}"
  git -C "$name.part" checkout --quiet "$commit"
  mv "$name.part" "$name"
  echo "$name: $repository $commit"
}

# Tuning.
scene test_colmap bartoszek/test_colmap 79fce7a67f15b0604e9741d9d50618840740b32f /dense/0/images /dense/0/sparse
scene nerf_database YhuoyuH/NeRF-Database 83b34224ffb43e34e48db8137b3f95f8e7059cc3 /images /sparse
scene sfm_book yDing121/video_sfm_mvs 9b52ed10405752b550d5bc4e9c3c0f6b43ce5b4b /data/dense/images /data/dense/sparse
scene gs_room mamechun/gs_data 57e50c56a1e601e468e012e0814187e5f698825b /dense/0/images /dense/0/sparse
scene scodive Scodive/Data 4495a8acc3893532bf724c6b2b9945cb5beb9ae1 /images /poses_bounds.npy
# Left out.
scene vr_project xu-zhy/VR-project 6532dd01eadd11d4c0ac882e4a10b91bc370624b /data/images /data/sparse
scene lf_gs yixuhuang72-hue/LF-GS 00f77487aed3a6367ddf7ea95a8e3e18523ddaa4 /data/images /data/sparse
scene lakshya LakshyaTaneja/Metric-Semantic-3D-Reconstruction 40979ab3bf2ef38496d7148758032b1647c51476 /data/images /data/transforms.json
scene giza Vincent7140/dataset_perso 3db5ced2dc16cdd1d95f37f84958face30c7f347 '/frame_*.png' /transforms.json
scene maryrose vork/maryRose 807bff05487ffeb53e8dd2400c18e72581117df3 /images /poses_bounds.npy
scene vgg_oxford openMVG/Features_Repeatability 69c4062485aa2e9135f65c93069342cd049cf321 \
  /vgg_oxford_feat_eval/bikes /vgg_oxford_feat_eval/leuven /vgg_oxford_feat_eval/ubc
# Training.
scene dtu jingz666/NeuF ebe501dc192622e74410776a4b79e1ee3a5f01ed /data/DTU/dtu_scan65/image /data/DTU/dtu_scan65/cameras.npz
scene middlebury ma-mehralian/EKFPnP_matlab_toolbox 77400fef0eabef17c2ffe46f77f83fb0e11c1076 /data/templeRing /data/dino
