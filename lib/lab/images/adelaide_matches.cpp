#include "lab/images/adelaide_matches.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "diffsac/core/status.h"
#include "lab/images/image_format.h"
#include "lab/images/image_source.h"
#include "lab/images/matlab_file.h"
#include "lab/images/write_scene.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> MatlabFilesIn(const std::string& folder) {
  std::error_code code;
  if (!fs::is_directory(folder, code)) throw Error(folder + ": no such folder");
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".mat") paths.push_back(entry.path());
  if (paths.empty()) throw Error(folder + ": no files *.mat");
  std::sort(paths.begin(), paths.end());
  return paths;
}

ImageSize SizeOf(const MatlabFile& file, const std::string& image) {
  const auto [height, width] = file.Size(image);
  return {width, height};
}

Example ReadPair(const fs::path& path) {
  const MatlabFile file(path.string());
  const std::string matches = "6xN numbers x1 y1 1 x2 y2 1",
                    numbers = "a whole number at least 0 for each column of data";
  const Eigen::MatrixXd data = file.Matrix("data", matches), labels = file.Matrix("label", numbers);
  if (data.rows() != 6 || (data.row(2).array() != 1.0).any() || (data.row(5).array() != 1.0).any())
    throw Error(file.path() + ": expected a variable data, " + matches);
  if (labels.rows() != 1 || labels.cols() != data.cols() ||
      !(labels.array() >= 0.0 && labels.array() <= 1e6 && labels.array() == labels.array().floor()).all())
    throw Error(file.path() + ": expected a variable label, " + numbers);
  Example pair;
  const std::string name = path.stem().string();
  pair.image1 = ImageName(name + "A");
  pair.image2 = ImageName(name + "B");
  pair.id = pair.image1 + "-" + pair.image2;
  pair.problem.size1 = SizeOf(file, "img1");
  pair.problem.size2 = SizeOf(file, "img2");
  pair.problem.points.resize(data.cols(), 4);
  pair.problem.points << data.row(0).transpose(), data.row(1).transpose(), data.row(3).transpose(),
      data.row(4).transpose();
  for (const double label : labels.row(0)) pair.truth.assignment.push_back(static_cast<std::int32_t>(label));
  return pair;
}

PrepareResult WriteAdelaideMatches(const PairsRequest& request, const std::atomic<bool>& stop) {
  PrepareResult result;
  WriteScene(
      request, request.scene.empty() ? "adelaidermf_matches" : request.scene,
      [&] { return ReadAdelaideMatches(request.input); }, stop, &result);
  return result;
}

const Registered<ImageFormat> kAdelaideMatches("adelaidermf_matches", {.write = WriteAdelaideMatches});

}  // namespace

CorrespondenceSet ReadAdelaideMatches(const std::string& folder) {
  CorrespondenceSet set;
  for (const fs::path& path : MatlabFilesIn(folder)) set.pairs.push_back(ReadPair(path));
  return set;
}

}  // namespace diffsac
