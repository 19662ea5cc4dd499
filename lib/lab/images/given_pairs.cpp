#include "lab/images/given_pairs.h"

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "diffsac/core/logging.h"
#include "diffsac/problem/keypoint_similarity.h"
#include "lab/config/report_script.h"
#include "lab/files/files.h"

namespace diffsac {

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

// Matches made by hloc's matchers (SuperGlue, LightGlue, LoFTR, ...) as pairs, by convert.py.

namespace fs = std::filesystem;

namespace {

/// Of convert.py: NAME, a tab and its file; a tab alone and what was left out.
void ReadImageNames(const std::string& path, GivenPairs* given) {
  std::istringstream lines(ReadFile(path));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t tab = line.find('\t');
    if (tab == std::string::npos) continue;
    if (tab == 0)
      LogWarning("left out: " + line.substr(1));
    else
      given->files[line.substr(0, tab)] = line.substr(tab + 1);
  }
}

/// A folder that is gone with it.
struct ScratchFolder {
  const std::string path = TemporaryBeside(fs::temp_directory_path() / "hloc");
  ~ScratchFolder() {
    std::error_code code;
    fs::remove_all(path, code);
  }
};

}  // namespace

GivenPairs ReadHlocPairs(const std::string& path) {
  const ScratchFolder scratch;
  RunPythonScript("convert.py", {"hloc", path, scratch.path, "--scene", "pairs"});
  const std::string folder = scratch.path + "/pairs";
  GivenPairs given;
  ReadImageNames(folder + "/images.txt", &given);
  const CorrespondenceScene scene(folder);
  for (std::int64_t i = 0; i < scene.size(); ++i) {
    given.set.pairs.push_back(scene.Read(i));
    const Example& pair = given.set.pairs.back();
    given.set.match_indices.push_back(scene.ReadMatchIndices(pair.id, pair.problem.points.rows()));
  }
  return given;
}

}  // namespace diffsac
