#pragma once

#include <iosfwd>
#include <string>

#include "lab/eval/results.h"

namespace diffsac {

/// Where the estimates of a run go beside its folder.
struct ColmapExport {
  std::string database;    ///< A COLMAP database that exists; empty: nowhere.
  bool overwrite = false;  ///< Whether pairs that have a two-view geometry get a new one.
  bool chance = false;  ///< Whether pairs whose inliers may be chance (Estimate::MayBeChance) are written as verified.
};

/// Throws Error where an experiment cannot be exported: not one row on one condition of correspondence files, a task
/// without two views, no estimates, a database that cannot be read. Before the work.
void CheckColmapExport(const ExperimentOptions& experiment, const ColmapExport& target);

/// Writes the estimates as verified matches (`two_view_geometries`), all or none, and says so. Which keypoints a match
/// joins stands in match_indices.h5 of its scene, as `diffsac_prepare pairs --format colmap_database` writes it. E is
/// exported with F and the pose as a calibrated pair, F as an uncalibrated one, H as planar or panoramic; what leaves
/// the translation open as panoramic, planar or panoramic, or a watermark, with H. Pixels are
/// COLMAP's, of cameras without distortion. Throws Error; the database is then as it was.
void ExportColmap(const ExperimentResults& results, const ColmapExport& target, std::ostream& out);

}  // namespace diffsac
