#!/usr/bin/env bash
# Fetches the public scenes of configs/sets.yaml (data_tools/README.md has their table): scripts/scenes.sh DIR makes DIR/scenes/NAME,
# each a repository at one commit with the files that are needed alone. Those that are there stay. Nothing of them is part of this project.
set -euo pipefail
if [[ $# -lt 1 || "$1" == -* ]]; then
  echo "usage: scripts/scenes.sh DIR [NAME...]    then: python3 data_tools/convert.py sets --config configs/sets.yaml --data DIR --only 'runs/pairs/scenes'" >&2
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
# Line segments with vanishing points (data_tools/README.md).
scene nyu_vp fkluger/nyu_vp 5dadc1c1d28f3c28f266346ac537bc2f2ec59559 /data
scene yud_plus fkluger/yud_plus a18c79c36775dffd46e7c3eae42cb37a0eafa7a8 /data
# Labelled motions, and one pair of labelled planes.
scene rcmsa trungtpham/RCMSA 0d5f3e3946015398b21e5e02c4fa541045a5a71b /data/AdelaideRMF/F /data/AdelaideRMF/H/elderhalla.mat
# Matches of clouds with the motion between them.
scene tcf ShiPC-AI/TCF 401a80a332a536f53722172baa658001d7d2fb0c /data
scene turboreg Laka-3DV/TurboReg 827025f370d3dbf4fd7ae35b3c9a21d25d24043e '/demo_data/*.txt'
scene macpp zhangxy0517/MAC-PLUS-PLUS a304edf921e044e1928e027a1cdb1d8215cdcaba '/demo/*.txt'
# Depth frames of a kitchen, and which pairs of their fragments overlap, with the motions (scripts/peers/registration.py).
scene redkitchen andyzeng/tsdf-fusion-python 3f22a940d90f684145b1f29b1feaa92e09eb1db6 '/data/frame-*.depth.png' '/data/frame-*.pose.txt' /data/camera-intrinsics.txt
scene fragment_pairs qinzheng93/GeoTransformer e7a135af4c318ff3b8d7f6c963df094d7e4ea540 '/data/3DMatch/metadata/benchmarks/*/7-scenes-redkitchen/gt.log'
# Training.
scene dtu jingz666/NeuF ebe501dc192622e74410776a4b79e1ee3a5f01ed /data/DTU/dtu_scan65/image /data/DTU/dtu_scan65/cameras.npz
scene middlebury ma-mehralian/EKFPnP_matlab_toolbox 77400fef0eabef17c2ffe46f77f83fb0e11c1076 /data/templeRing /data/dino
# Hard pairs (data_tools/README.md). Training.
scene blowtorch vork/blowtorch_photogrammetry 8d2ec815831081449f18159a306c7a2d43a4f7ec /images /poses_bounds.npy
scene fruit tusharparimi/fruit-NeRF 236cb0105d687745f7a13f454679346a64ac47d6 /newfruit_small /transforms.json
scene liberty vork/StatueOfLiberty-Photogrammetry 1d860be7ed5ebe86dafcb11f90c8557eb8cc5efc /images /poses_bounds.npy
scene mold_gold vork/moldGoldCape c7ef1f0f2a7c2ec5ea7fa3fb43a01ed56fc5216b /images /poses_bounds.npy
scene mouse Myhan1023/mouse-3d-reconstruction 7b95efcf8568f983cdafcc0cbf6127bd73c5dbe4 /images /sparse
scene mydata lambkin108/TensoRF_mydata 7df228d992d263be12824e51263efe2c3a7bfbb1 /data/mydata
scene nerf_pytorch Michael-Yi-Rong/NeRF-Pytorch b0c10844b87e7e57b26d023805fc03bdbf3a3c54 /images /sparse
# Tuning.
scene final_tensorf kwrous/final_tensorf 85c25f19aecbf4b170a68e0fa93c19805b28de3b /images /sparse
scene milk zhouyou9505/milk e08c85768da6c663ac18bb959be18bb94486b3a3 /images /poses_bounds.npy
scene thesis_nvh hungvipqt15/Thesis_project_NVH dc3675b91c2663ab0ad349d19e5351e590208423 /uploads/images /transforms.json
# Left out.
scene mother_child vork/mother_child-photogrammetry ae06a449d3370f81deb6d8732494fda3ddadd19d /images /poses_bounds.npy
scene duck_queen vork/duck_queen-photogrammetry 6cf93f71f5adcbbacdc3cd57266c72fe26ff5c0e /images /poses_bounds.npy
scene kangaroo pechpo/JNerf 646874b835ffab2d0c773d7736bbb822d70c38c0 /images/kangaroo /transforms.json
scene nerf_tensorf 5697526/NeRF-TensoRF a0b42d4b70c0a595748106c58cd2d8d0915b2bed /images /transforms.json
scene scene2mesh akristoffersen/Scene2Mesh bb684d598e92d051d3b771bd2114a0c6ff7f5115 \
  /real_scene_data/gum/train /real_scene_data/gum/transforms_train.json
scene sou_photographs mkdsrt10/SoU b9c81dc05497e88e76ba74e6f348990a00a84b47 '/*_.jpg'
scene vggsfm facebookresearch/vggsfm e1d9d2eb2b3575525792206fb94b2c749c58dc50 /examples/statue

# reconstruct NAME IMAGES: poses by COLMAP from all images, where a scene has none.
reconstruct() {
  local name=$1 images=$2
  if [[ ( "$names" != "  " && "$names" != *" $name "* ) || ! -d "$images" ]]; then return; fi
  if [[ -d "$name" ]]; then echo "$name: is there"; return; fi
  if ! command -v colmap > /dev/null; then echo "$name: left out, it needs COLMAP (apt-get install colmap)"; return; fi
  rm -rf "$name.part"
  mkdir -p "$name.part/sparse"
  mkdir "$name.part/images"
  cp "$images"/* "$name.part/images"
  local database=(--database_path "$name.part/database.db") folder=(--image_path "$name.part/images")
  colmap feature_extractor "${database[@]}" "${folder[@]}" --ImageReader.camera_model SIMPLE_RADIAL --SiftExtraction.use_gpu 0 \
    --SiftExtraction.max_image_size 1600 > "$name.part/log.txt" 2>&1
  colmap exhaustive_matcher "${database[@]}" --SiftMatching.use_gpu 0 >> "$name.part/log.txt" 2>&1
  colmap mapper "${database[@]}" "${folder[@]}" --output_path "$name.part/sparse" >> "$name.part/log.txt" 2>&1
  mv "$name.part" "$name"
  echo "$name: reconstructed by COLMAP"
}
reconstruct statue vggsfm/examples/statue/images
reconstruct sou sou_photographs
