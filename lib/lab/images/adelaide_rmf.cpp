#include "lab/images/adelaide_rmf.h"

#include <algorithm>
#include <filesystem>
#include <opencv2/calib3d.hpp>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/files/number_file.h"
#include "lab/images/image_features.h"
#include "lab/images/image_format.h"
#include "lab/images/image_source.h"
#include "lab/images/write_scene.h"
#include "lab/truth/pair_truth.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr double kPlausibleDistancePx = 3.0;
constexpr double kPlausibleShare = 0.8;  // the good files explain 0.9 and more, the two bad ones 0.6 and 0.7
constexpr const char* kModelSuffix = "_model.txt";

struct LabelledPoints {
  PointMatrix points;
  std::vector<std::int32_t> assignment;
};

LabelledPoints ReadLabelled(const std::string& path) {
  const auto lines = ReadNumberFile(path, 7);
  LabelledPoints read{PointMatrix(static_cast<Eigen::Index>(lines.size()), 4), {}};
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto& v = lines[i].values;
    if (v[2] != 1.0 || v[5] != 1.0 || !(v[6] >= 0.0 && v[6] <= 1e9))
      throw Error(path + ":" + std::to_string(lines[i].line) + ": expected x1 y1 1 x2 y2 1 label");
    read.points.row(static_cast<Eigen::Index>(i)) << v[0], v[1], v[3], v[4];
    read.assignment.push_back(static_cast<std::int32_t>(v[6]));
  }
  return read;
}

void ReadTentative(const std::string& prefix, Problem* problem) {
  const std::string path = prefix + "_pts.txt", score_path = prefix + "_score.txt";
  const auto lines = ReadNumberFile(path);
  const auto scores = ReadNumberFile(score_path, 1);
  if (lines.empty() || lines[0].values.size() != 1 || lines[0].values[0] != static_cast<double>(lines.size() - 1))
    throw Error(path + ":1: expected the number of rows that follow");
  if (scores.size() != lines.size() - 1)
    throw Error(score_path + ": expected " + std::to_string(lines.size() - 1) + " ratios, found " +
                std::to_string(scores.size()));
  const auto count = static_cast<Eigen::Index>(scores.size());
  problem->points.resize(count, 4);
  problem->match_ratio.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const NumberLine& line = lines[i + 1];
    if (line.values.size() != 4) throw Error(path + ":" + std::to_string(line.line) + ": expected x1 y1 x2 y2");
    problem->points.row(i) = Eigen::Map<const Eigen::RowVector4d>(line.values.data());
    problem->match_ratio[i] = scores[i].values[0];
  }
}

// The labelled inliers of any plane: all of them obey F.
PointMatrix Inliers(const LabelledPoints& labelled) {
  PointMatrix inliers(labelled.points.rows(), 4);
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < labelled.points.rows(); ++i)
    if (labelled.assignment[i] > 0) inliers.row(count++) = labelled.points.row(i);
  inliers.conservativeResize(count, 4);
  return inliers;
}

bool Explains(const Eigen::Matrix3d& fundamental, const PointMatrix& inliers) {
  Problem problem;
  problem.points = inliers;
  GroundTruth truth;
  truth.fundamental = fundamental;
  const auto near = (TruthDistances(problem, truth).array() < kPlausibleDistancePx).count();
  return static_cast<double>(near) >= kPlausibleShare * static_cast<double>(inliers.rows());
}

// Robust, since some labels are wrong: least squares on them all is no better than what the files give.
Eigen::Matrix3d FitFundamental(const PointMatrix& inliers, const std::string& path) {
  std::vector<cv::Point2d> first, second;
  for (Eigen::Index i = 0; i < inliers.rows(); ++i) {
    first.emplace_back(inliers(i, 0), inliers(i, 1));
    second.emplace_back(inliers(i, 2), inliers(i, 3));
  }
  cv::Mat fitted;
  if (inliers.rows() >= 8) fitted = cv::findFundamentalMat(first, second, cv::USAC_MAGSAC, 2.0, 0.9999, 10000);
  if (fitted.rows != 3 || fitted.cols != 3)
    throw Error(path + ": the labelled inliers determine no fundamental matrix");
  return MatrixFromRows(fitted.ptr<double>());
}

Eigen::Matrix3d TrueFundamental(const std::string& prefix, const LabelledPoints& labelled) {
  const std::string path = prefix + kModelSuffix;
  const Eigen::Matrix3d given = ReadMatrixFile(path);
  const PointMatrix inliers = Inliers(labelled);
  if (Explains(given, inliers)) return given;
  const Eigen::Matrix3d fitted = FitFundamental(inliers, path);
  if (!Explains(fitted, inliers)) throw Error(path + ": no fundamental matrix fits the labelled inliers");
  LogInfo(path + ": misses the labelled inliers; fitted to them again");
  return fitted;
}

std::vector<std::string> NamesIn(const std::string& folder) {
  std::error_code code;
  if (!fs::is_directory(folder, code)) throw Error(folder + ": no such folder");
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string file = entry.path().filename().string();
    if (file.ends_with(kModelSuffix)) names.push_back(file.substr(0, file.size() - std::string(kModelSuffix).size()));
  }
  if (names.empty()) throw Error(folder + ": no files <name>" + kModelSuffix);
  std::sort(names.begin(), names.end());
  return names;
}

Example ReadPair(const std::string& folder, const std::string& name, AdelaideCorrespondences kind) {
  const std::string prefix = (fs::path(folder) / name).string();
  Example pair;
  pair.image1 = ImageName(name + "A.png");
  pair.image2 = ImageName(name + "B.png");
  pair.id = pair.image1 + "-" + pair.image2;
  pair.problem.size1 = ReadImageSize(prefix + "A.png");
  pair.problem.size2 = ReadImageSize(prefix + "B.png");
  const LabelledPoints labelled = ReadLabelled(prefix + "_pts.txt");
  pair.truth.fundamental = TrueFundamental(prefix, labelled);
  if (kind == AdelaideCorrespondences::kLabelled) {
    pair.problem.points = labelled.points;
    pair.truth.assignment = labelled.assignment;
  } else {
    ReadTentative((fs::path(folder) / "sift_update" / name).string(), &pair.problem);
  }
  return pair;
}

}  // namespace

CorrespondenceSet ReadAdelaideRmf(const std::string& folder, AdelaideCorrespondences kind) {
  CorrespondenceSet set;
  for (const std::string& name : NamesIn(folder)) set.pairs.push_back(ReadPair(folder, name, kind));
  return set;
}

namespace {

// Both sets of correspondences, a scene each.
PrepareResult WriteAdelaideRmf(const PairsRequest& request, const std::atomic<bool>& stop) {
  PrepareResult result;
  const std::string name = request.scene.empty() ? "adelaidermf" : request.scene;
  for (const AdelaideCorrespondences kind : {AdelaideCorrespondences::kLabelled, AdelaideCorrespondences::kTentative}) {
    const bool tentative = kind == AdelaideCorrespondences::kTentative;
    if (tentative && !fs::exists(fs::path(request.input) / "sift_update")) break;
    WriteScene(
        request, name + (tentative ? "_sift" : ""), [&] { return ReadAdelaideRmf(request.input, kind); }, stop,
        &result);
    if (stop) break;
  }
  return result;
}

const Registered<ImageFormat> kAdelaideRmf("adelaidermf", {.write = WriteAdelaideRmf});

}  // namespace

}  // namespace diffsac
