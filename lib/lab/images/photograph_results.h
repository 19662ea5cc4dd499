#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "lab/images/estimate_photographs.h"
#include "lab/images/json_values.h"

namespace diffsac {

// What a run on photographs leaves in its folder.
inline constexpr const char* kPosesFile = "poses.csv";
inline constexpr const char* kPairsJson = "pairs.json";
inline constexpr const char* kDatabaseFile = "database.db";
inline constexpr const char* kPairProgram = "diffsac_pair";

/// A run on photographs, or on pairs that came with their matches.
struct PhotographsRun {
  const Photographs& photographs;
  const PhotographCameras& cameras;
  const FeatureStore* store = nullptr;  ///< Of the images' keypoints; null: pairs came with their matches.
  const PairOptions& options;
  std::string output;  ///< Its folder.
};

/// poses.csv of the pairs of pairs.json: a line for each,
/// image1,image2,status,may_be_chance,method,seed,qw,qx,qy,qz,tx,ty,tz,focal1_px,focal2_px,matches,inliers,noise_px,
/// ms_matching,ms_estimate,m11,...,m33,degeneracy,focal1_source,focal2_source,other_qw,...,other_tz: x2 = R x1 + t
/// with R as a unit quaternion, qw >= 0, and |t| = 1; the focal lengths that were given or found, and where they come
/// from (FocalSource); the model row by row (docs/estimates.md); the other motion of a plane that has two; then
/// camera1,camera2,focal1_low_px,focal1_high_px,focal2_low_px,focal2_high_px: which camera took each image where no
/// calibration is given, and 68 % of what the focal lengths may be; focal1_observable,focal2_observable: whether the
/// matches know them better than the prior does; verdict (diffsac/results.h); focal_conflict: 1 where the matches
/// contradict the focal lengths. Unknown values are empty. A pair whose images have no names has its own name in the
/// first column.
std::string PosesCsv(const std::vector<Json>& pairs);

/// Writes correspondence files in `output`/matches/NAME, a COLMAP database of photographs, poses.csv, pairs.json (all
/// pairs as PairJson has them) and report.html, of those pairs that are done, and says in `out` what there is. Throws
/// Error.
void WritePhotographResults(const PhotographsRun& run, std::vector<ImagePair> pairs, std::ostream& out);

}  // namespace diffsac
