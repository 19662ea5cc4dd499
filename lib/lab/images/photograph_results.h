#pragma once

#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "lab/eval/results.h"
#include "lab/images/estimate_photographs.h"

namespace diffsac {

// What a run on photographs leaves in its folder.
inline constexpr const char* kPosesFile = "poses.csv";
inline constexpr const char* kDatabaseFile = "database.db";
inline constexpr const char* kPairProgram = "diffsac_pair";

/// poses.csv: a line for each pair,
/// image1,image2,status,may_be_chance,method,seed,qw,qx,qy,qz,tx,ty,tz,focal1_px,focal2_px,matches,inliers,noise_px,
/// ms_matching,ms_estimate,m11,...,m33,translation,focal1_source,focal2_source,other_qw,...,other_tz: x2 = R x1 + t
/// with R as a unit quaternion, qw >= 0, and |t| = 1; the focal lengths that were given or found, and where they come
/// from (FocalSource); the model row by row (docs/estimates.md); the other motion of a plane that has two; then
/// camera1,camera2,focal1_low_px,focal1_high_px,focal2_low_px,focal2_high_px: which camera took each image where no
/// calibration is given, and 68 % of what the focal lengths may be; focal1_observable,focal2_observable: whether the
/// matches know them better than the prior does. Unknown values are empty.
/// files: of the images' names; a pair without them has its own name in the first column.
std::string PosesCsv(const std::vector<EstimatedPair>& pairs, const std::map<std::string, std::string>& files,
                     const std::string& method, std::uint64_t seed);

/// Writes all of them: correspondence files in `output`/matches/NAME, estimates.h5, report.html, config.yaml (to try
/// other rows on these matches by diffsac_eval), a COLMAP database and poses.csv, and says in `out` what there is.
/// `pairs`: those of the scene of `photographs`. `experiment`: has one row. Throws Error.
void WritePhotographResults(const Photographs& photographs, const FeatureStore& store, const PhotographCameras& cameras,
                            std::vector<EstimatedPair> pairs, ExperimentOptions experiment, double inlier_threshold_px,
                            const std::string& output, std::ostream& out);

/// The same of matches that something else made, without the database and the thumbnails; `files`: of the images'
/// names, where these are not the files'.
void WriteGivenResults(std::vector<EstimatedPair> pairs, const std::map<std::string, std::string>& files,
                       const std::string& scene, ExperimentOptions experiment, double inlier_threshold_px,
                       const std::string& output, std::ostream& out);

}  // namespace diffsac
