#include "lab/images/given_pairs.h"

#include <algorithm>
#include <filesystem>

#include "diffsac/core/logging.h"
#include "diffsac/problem/keypoint_similarity.h"

namespace diffsac {

namespace fs = std::filesystem;

void WriteScene(const PairsRequest& request, const std::string& name, const std::function<CorrespondenceSet()>& read,
                const std::atomic<bool>& stop, PrepareResult* result) {
  const std::string folder = (fs::path(request.output) / name).string();
  RefuseInputsInScene(request, folder);
  if (!request.options.overwrite && fs::exists(fs::path(folder) / "matches.h5")) {
    LogInfo(folder + ": already there");
    result->already_there += 1;
    return;
  }
  const CorrespondenceSet set = read();
  result->finished = !stop;
  if (stop) return;
  WriteCorrespondences(folder, set);
  LogInfo(folder + ": " + std::to_string(set.pairs.size()) + " pairs");
  result->written += 1;
}

PointMatrix ScaleRotationChangesOf(const PointMatrix& first, const PointMatrix& second, const MatchIndices& matches) {
  if (first.rows() == 0 || second.rows() == 0) return {};
  PointMatrix scale_rotation_changes(matches.rows(), 2);
  for (Eigen::Index i = 0; i < matches.rows(); ++i)
    scale_rotation_changes.row(i) = SimilarityOf(first.row(matches(i, 0)), second.row(matches(i, 1)));
  return scale_rotation_changes;
}

void KeepAllScaleRotationChangesOrNone(CorrespondenceSet* set) {
  const bool all = std::all_of(set->pairs.begin(), set->pairs.end(), [](const Example& pair) {
    return pair.problem.scale_rotation_changes.rows() == pair.problem.points.rows();
  });
  if (all) return;
  for (Example& pair : set->pairs) pair.problem.scale_rotation_changes.resize(0, 0);
}

}  // namespace diffsac
