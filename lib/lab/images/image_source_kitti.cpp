#include <Eigen/LU>
#include <Eigen/SVD>
#include <charconv>
#include <filesystem>

#include "diffsac/core/status.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"
#include "lab/images/image_source.h"
#include "lab/images/run_pairs.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// "P0: " and twelve numbers, a row-major 3 × 4 matrix; the left grey camera is the origin, so its left part is K.
LensCamera ReadCalibration(const std::string& path) {
  const std::string text = ReadTextFile(path);
  std::string_view rest = text, line;
  for (int number = 1; TakeLine(&rest, &line); ++number) {
    const auto words = SplitWords(line, " \t");
    if (words.empty() || words[0] != "P0:") continue;
    double p[12];
    bool good = words.size() == 13;
    for (int i = 0; good && i < 12; ++i) good = ParseNumber(words[i + 1], &p[i]);
    if (!good) throw Error(path + ":" + std::to_string(number) + ": expected twelve numbers after P0:");
    LensCamera camera;
    camera.K << p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10];
    return camera;
  }
  throw Error(path + ": no line P0:");
}

// One frame of the file of poses.
struct PoseLine {
  RigidMotion pose;
  std::string problem;  // empty: none
};

// World-to-camera, of a camera-to-world matrix row by row; the nearest rotation in place of what is one within 1 %.
RigidMotion PoseOf(const std::vector<double>& values, const std::string& place) {
  constexpr double kTolerance = 0.01, kRounding = 1e-6;
  if (values.size() != 12) throw Error(place + ": expected 12 numbers, found " + std::to_string(values.size()));
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> rows(values.data());
  if (!rows.allFinite()) throw Error(place + ": the pose is not finite");
  RigidMotion to_world{rows.leftCols<3>(), rows.col(3)};
  const Eigen::Matrix3d square = to_world.rotation * to_world.rotation.transpose();
  if (!square.isApprox(Eigen::Matrix3d::Identity(), kTolerance) || to_world.rotation.determinant() < 0.0)
    throw Error(place + ": the pose holds no rotation");
  // Few digits, or a tracker that drifted: an essential matrix needs the rotation that is meant.
  if (!square.isApprox(Eigen::Matrix3d::Identity(), kRounding)) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(to_world.rotation, Eigen::ComputeFullU | Eigen::ComputeFullV);
    to_world.rotation = svd.matrixU() * svd.matrixV().transpose();
  }
  return Inverse(to_world);
}

// A line that makes no sense costs its frame alone.
std::vector<PoseLine> ReadPoseLines(const std::string& path) {
  const std::string text = ReadTextFile(path);
  std::vector<PoseLine> lines;
  std::string_view rest = text, line;
  for (int number = 1; TakeLine(&rest, &line); ++number) {
    const auto words = SplitWords(line, " \t");
    if (words.empty()) continue;
    const std::string place = path + ":" + std::to_string(number);
    PoseLine parsed;
    try {
      std::vector<double> values(words.size());
      for (std::size_t i = 0; i < words.size(); ++i)
        if (!ParseNumber(words[i], &values[i])) throw Error(place + ": '" + std::string(words[i]) + "' is no number");
      parsed.pose = PoseOf(values, place);
    } catch (const Error& error) {
      parsed.problem = error.what();
    }
    lines.push_back(std::move(parsed));
  }
  return lines;
}

int FrameNumber(const std::string& path) {
  const std::string name = fs::path(path).stem().string();
  int number = -1;
  const auto result = std::from_chars(name.data(), name.data() + name.size(), number);
  if (result.ec != std::errc() || result.ptr != name.data() + name.size() || number < 0)
    throw Error(path + ": expected a frame's number as name");
  return number;
}

}  // namespace

ImageSource ReadKitti(const std::string& root, const std::string& sequence, PairChoice choice) {
  const fs::path folder = fs::path(root) / "sequences" / sequence;
  const std::string pose_path = (fs::path(root) / "poses" / (sequence + ".txt")).string();
  const LensCamera camera = ReadCalibration((folder / "calib.txt").string());
  const std::vector<PoseLine> poses = ReadPoseLines(pose_path);
  ImageSource source;
  for (const std::string& path : ListImages((folder / "image_0").string())) {
    int frame = -1;
    const auto read = [&] {
      frame = FrameNumber(path);
      if (frame >= static_cast<int>(poses.size())) throw Error(pose_path + ": no pose for " + path);
      if (!poses[frame].problem.empty()) throw Error(poses[frame].problem);
      return SourceImage{ImageName(path), path, camera, poses[frame].pose};
    };
    const std::size_t before = source.images.size();
    AddImage(ImageName(path), read, &source);
    if (source.images.size() > before) source.images.back().frame = frame;
  }
  source.scenes.push_back({"kitti_" + sequence, {}});
  if (!choice.HasPairs()) choice.steps = {1};
  ChoosePairs(choice, folder.string(), &source);
  return source;
}

namespace {

const Registered<ImageFormat> kKitti("kitti", {.read =
                                                   [](const PairsRequest& request) {
                                                     return ReadKitti(request.input, request.sequence, request.choice);
                                                   },
                                               .takes_sequence = true,
                                               .chooses_pairs = true});

}  // namespace

}  // namespace diffsac
