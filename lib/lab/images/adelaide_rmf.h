#pragma once

#include <string>

#include "lab/files/correspondence_files.h"

namespace diffsac {

/// AdelaideRMF (Wong et al., "Dynamic and hierarchical multi-structure geometric model fitting", ICCV 2011), whose
/// correspondences come with it: `<name>A.png`, `<name>B.png`, `<name>_model.txt` (F, x2ᵀ F x1 = 0) and either
///   kLabelled     `<name>_pts.txt`, rows `x1 y1 1 x2 y2 1 label`: 0 an outlier, k ≥ 1 on plane k;
///   kTentative    `sift_update/<name>_pts.txt`, a count and rows `x1 y1 x2 y2`, with `<name>_score.txt`, the ratios.
/// Pairs are named `<name>A-<name>B`. Where F misses more than a fifth of the labelled inliers by 3 pixels (neem and
/// napierb), it is fitted to them again, by OpenCV's USAC_MAGSAC, since some of the labels are wrong too. Throws Error
/// with one line that names the file.
enum class AdelaideCorrespondences { kLabelled, kTentative };
CorrespondenceSet ReadAdelaideRmf(const std::string& folder, AdelaideCorrespondences kind);

}  // namespace diffsac
