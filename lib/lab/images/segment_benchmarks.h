#pragma once

#include <string>
#include <vector>

#include "lab/files/segment_files.h"

namespace diffsac {

struct SegmentScene {
  std::string name;
  std::vector<ImageSegments> images;
};

/// The folder `data` of NYU-VP (Kluger et al., "CONSAC", CVPR 2020): lsd_lines_*.csv and vps_*.csv of 1449 images of
/// 640 × 480 pixels with the Kinect's calibration (Silberman et al., ECCV 2012), by the authors' split: nyu_vp_train
/// (0 … 999), nyu_vp_val (… 1223), nyu_vp_test. Throws Error with file and line.
std::vector<SegmentScene> ReadNyuVp(const std::string& folder);

/// The folder `data` of YUD+ (the same): lines/*.txt and vps/*GroundTruthVP_CamParams.mat of York Urban's 102 images of
/// 640 × 480 pixels with its calibration (Denis et al., ECCV 2008): yud_plus_train (the first 25), yud_plus_test.
std::vector<SegmentScene> ReadYudPlus(const std::string& folder);

}  // namespace diffsac
