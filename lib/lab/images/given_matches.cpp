#include "lab/images/given_matches.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/keypoint_similarity.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/problem/within_size.h"
#include "lab/config/report_script.h"
#include "lab/data/point_files.h"
#include "lab/files/files.h"
#include "lab/images/image_cameras.h"

namespace diffsac {

namespace fs = std::filesystem;

namespace {

/// The column of a table with this name; nothing where it has none.
std::optional<Eigen::VectorXd> ColumnOf(const TextTable& table, const std::string& name) {
  const auto found = std::find(table.names.begin(), table.names.end(), name);
  if (found == table.names.end()) return std::nullopt;
  return table.values.col(found - table.names.begin());
}

Eigen::VectorXd QualitiesOf(const TextTable& table, const std::string& file, bool* scored) {
  const auto ratio = ColumnOf(table, "ratio"), score = ColumnOf(table, "score");
  *scored = !ratio && score;
  if (!ratio && !score) return {};
  const Eigen::VectorXd& given = ratio ? *ratio : *score;
  for (Eigen::Index i = 0; i < given.size(); ++i)
    if (!(given[i] >= 0.0 && given[i] <= 1.0))
      throw Error(file + ": match " + std::to_string(i + 1) + ": expected a " + (ratio ? "ratio" : "score") +
                  " in [0, 1], found " + std::to_string(given[i]));
  return ratio ? given : Eigen::VectorXd(1.0 - given.array());
}

bool IsNumpy(const std::string& file) {
  const fs::path extension = fs::path(file).extension();
  return extension == ".npy" || extension == ".npz";
}

void RequireMiddles(const std::vector<ImageSize>& sizes, const GivenCalibration& calibration) {
  if (sizes.empty() && calibration.focal > 0.0 && calibration.center.empty())
    throw Error("--focal alone takes each image's middle as the principal point: give --sizes, or --center");
}

/// Both images hold their points.
void RequireWithinSizes(const Problem& problem, const std::string& place) {
  RequireWithin(problem.size1, problem.points.leftCols(2), place + ": the size of image 1");
  RequireWithin(problem.size2, problem.points.rightCols(2), place + ": the size of image 2");
}

/// Of pixels as they are seen.
void Calibrate(const std::optional<LensCamera>& first, const std::optional<LensCamera>& second, Problem* problem) {
  if (!first || !second) return;
  problem->points << StraightPositions(first, problem->points.leftCols(2)),
      StraightPositions(second, problem->points.rightCols(2));
  problem->cameras = CameraPair{first->K, second->K};
}

TextTable ReadMatchTable(const std::string& file, const TextColumns& columns) {
  if (!IsNumpy(file)) return ReadTextTable(file, columns);
  TextTable table;
  ReadConverted("matches", file, [&](const std::string& text) { table = ReadTextTable(text, columns); });
  return table;
}

}  // namespace

ImagePair ReadMatches(const GivenMatches& given, const GivenCalibration& calibration) {
  const TextTable table =
      ReadMatchTable(given.file, {"matches", {"x1", "y1", "x2", "y2"}, {"ratio", "log_size", "angle", "score"}});
  RequireMiddles(given.sizes, calibration);
  const ImageCameras cameras(calibration, {given.file, given.file});
  ImagePair matched;
  matched.example.id = fs::path(given.file).stem().string();
  Problem& problem = matched.example.problem;
  problem.snn_ratio = QualitiesOf(table, given.file, &problem.scored);
  const auto log_size = ColumnOf(table, "log_size"), angle = ColumnOf(table, "angle");
  if (log_size && angle) {
    problem.scale_rotation_changes.resize(table.values.rows(), 2);
    problem.scale_rotation_changes << *log_size, *angle;
  }
  if (!given.sizes.empty()) problem.size1 = given.sizes.front(), problem.size2 = given.sizes.back();
  const auto first = cameras.Of(0, problem.size1), second = cameras.Of(1, problem.size2);
  cameras.WarnOfSizes({problem.size1, problem.size2});
  problem.points = table.values.leftCols(4);
  RequireWithinSizes(problem, given.file);
  Calibrate(first, second, &problem);
  return matched;
}

ImagePair ReadScenePoints(const GivenMatches& given, const GivenCalibration& calibration) {
  if (IsNumpy(given.file)) throw Error(given.file + ": expected points x y X Y Z in a text file");
  // Small letters: the scene's are told by those of the image, u and v.
  const TextTable table =
      ReadTextTable(given.file, {"points x y X Y Z", {"u", "v", "x", "y", "z"}, {"ratio", "score"}});
  RequireMiddles(given.sizes, calibration);
  ImagePair matched;
  matched.example.id = fs::path(given.file).stem().string();
  Problem& problem = matched.example.problem;
  problem.task = Task::kAbsolutePose;
  problem.snn_ratio = QualitiesOf(table, given.file, &problem.scored);
  if (!given.sizes.empty()) problem.size1 = given.sizes.front();
  RequireWithin(problem.size1, table.values.leftCols(2), given.file + ": the image's size");
  const auto camera = ImageCameras(calibration, {given.file}).Of(0, problem.size1);
  if (!camera) throw Error("--task absolute_pose needs --calibration, --cameras or --focal");
  problem.points.resize(table.values.rows(), 5);
  problem.points << table.values.middleCols(2, 3), StraightPositions(camera, table.values.leftCols(2));
  problem.cameras = CameraPair{camera->K, camera->K};
  return matched;
}

bool AreManyMatches(const std::string& path) {
  std::error_code code;
  const fs::path extension = fs::path(path).extension();
  return fs::is_directory(path, code) || extension == ".db" || extension == ".h5" || extension == ".hdf5";
}

namespace {

bool HoldsHloc(const std::string& folder) {
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code))
    if (entry.path().extension() == ".h5") return true;
  return false;
}

std::vector<std::string> MatchFilesOf(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code))
    if (entry.is_regular_file(code) && (IsTextPointFile(entry.path().string()) || IsNumpy(entry.path().string())))
      files.push_back(entry.path().string());
  if (files.empty())
    throw Error(folder + ": expected files of matches (.txt, .csv, .npy, .npz), hloc's two .h5 files, or a .db file");
  std::sort(files.begin(), files.end());
  return files;
}

GivenPairs ReadFolder(const GivenMatches& given, const GivenCalibration& calibration) {
  GivenPairs pairs;
  std::set<std::string> ids;
  std::string problem;
  for (const std::string& file : MatchFilesOf(given.file)) {
    try {
      Example pair = ReadMatches({file, given.sizes}, calibration).example;
      if (!ids.insert(pair.id).second) throw Error(file + ": another file is called " + pair.id + " too");
      const std::size_t dash = pair.id.find('-');
      if (dash != 0 && dash + 1 < pair.id.size() && dash == pair.id.rfind('-') && dash != std::string::npos) {
        pair.image1 = pair.id.substr(0, dash);
        pair.image2 = pair.id.substr(dash + 1);
      }
      pairs.set.pairs.push_back(std::move(pair));
    } catch (const Error& error) {
      LogWarning(std::string("left out: ") + error.what());
      if (problem.empty()) problem = error.what();
    }
  }
  if (pairs.set.pairs.empty()) throw Error(problem);
  return pairs;
}

/// hloc's and COLMAP's images by their names.
void CalibrateByName(const GivenMatches& given, const GivenCalibration& calibration, GivenPairs* pairs) {
  for (Example& pair : pairs->set.pairs) {
    Problem& problem = pair.problem;
    if (!given.sizes.empty() && !problem.size1.known()) problem.size1 = given.sizes.front();
    if (!given.sizes.empty() && !problem.size2.known()) problem.size2 = given.sizes.back();
    RequireWithinSizes(problem, given.file + ": " + pair.id);
  }
  if (!calibration.IsGiven()) return;
  std::vector<std::string> files;
  std::map<std::string, std::size_t> places;
  for (const auto& [name, file] : pairs->files) {
    places[name] = files.size();
    files.push_back(file);
  }
  const ImageCameras cameras(calibration, files);
  for (Example& pair : pairs->set.pairs) {
    Problem& problem = pair.problem;
    if (!problem.size1.known() || !problem.size2.known()) RequireMiddles({}, calibration);
    Calibrate(cameras.Of(places.at(pair.image1), problem.size1), cameras.Of(places.at(pair.image2), problem.size2),
              &problem);
  }
}

/// Files of a scene hold of all pairs what they hold.
void KeepWhatAllHave(CorrespondenceSet* set) {
  const auto all = [&](const auto& has) { return std::all_of(set->pairs.begin(), set->pairs.end(), has); };
  KeepAllScaleRotationChangesOrNone(set);
  const bool scored = set->pairs.front().problem.scored;
  if (!all([&](const Example& pair) {
        return pair.problem.snn_ratio.size() == pair.problem.points.rows() && pair.problem.scored == scored;
      }))
    for (Example& pair : set->pairs) {
      pair.problem.snn_ratio.resize(0);
      pair.problem.scored = false;
    }
  if (!all([](const Example& pair) { return pair.problem.size1.known() && pair.problem.size2.known(); }))
    for (Example& pair : set->pairs) pair.problem.size1 = pair.problem.size2 = {};
}

}  // namespace

GivenPairs ReadManyMatches(const GivenMatches& given, const GivenCalibration& calibration, bool poses) {
  std::error_code code;
  GivenPairs pairs;
  if (fs::is_directory(given.file, code) && !HoldsHloc(given.file)) {
    pairs = ReadFolder(given, calibration);
  } else if (fs::path(given.file).extension() == ".db") {
    if (poses && !calibration.IsGiven()) pairs = ReadColmapPairs(given.file, true);
    if (pairs.set.pairs.empty()) {
      pairs = ReadColmapPairs(given.file, false);
      CalibrateByName(given, calibration, &pairs);
    }
  } else {
    pairs = ReadHlocPairs(given.file);
    CalibrateByName(given, calibration, &pairs);
  }
  KeepWhatAllHave(&pairs.set);
  return pairs;
}

GivenPhotographs PhotographsOf(GivenPairs given, const std::string& scene) {
  GivenPhotographs all;
  ImageSource& source = all.photographs.source;
  source.scenes = {{scene, {}}};
  std::map<std::string, int> places;
  const auto place = [&](const std::string& name, const ImageSize& size) {
    const auto [found, is_new] = places.try_emplace(name, static_cast<int>(source.images.size()));
    if (!is_new && !name.empty()) return found->second;
    source.images.push_back({name, "", {}, {}});
    const auto file = given.files.find(name);
    all.photographs.files.push_back(file == given.files.end() ? name : file->second);
    all.sizes.push_back(size);
    return static_cast<int>(source.images.size()) - 1;
  };
  for (std::size_t i = 0; i < given.set.pairs.size(); ++i) {
    ImagePair& pair = all.pairs.emplace_back();
    pair.example = std::move(given.set.pairs[i]);
    const Problem& problem = pair.example.problem;
    pair.images = {place(pair.example.image1, problem.size1), place(pair.example.image2, problem.size2)};
    if (!given.set.match_indices.empty()) pair.matches = std::move(given.set.match_indices[i]);
    source.scenes.front().pairs.push_back({pair.images[0], pair.images[1], {}});
  }
  return all;
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

// Matches made by hloc's matchers (SuperGlue, LightGlue, LoFTR, ...) as pairs, by convert.py.

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
