#include "lab/images/segment_benchmarks.h"

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <utility>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/images/image_source.h"
#include "lab/images/matlab_file.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr ImageSize kSize = {640, 480};

/// A table with a line of names, values separated by single blanks; empty values are NaN.
struct NamedColumns {
  std::vector<std::string> names;
  std::vector<std::vector<double>> rows;
  std::string path;

  explicit NamedColumns(const std::string& file) : path(file) {
    std::istringstream text(ReadTextFile(file));
    std::string line;
    if (!std::getline(text, line)) throw Error(path + ":1: expected the names of the columns");
    std::istringstream heading(line);
    for (std::string name; heading >> name;) names.push_back(name);
    for (int number = 2; std::getline(text, line); ++number) {
      std::istringstream values(line);
      rows.emplace_back();
      for (double value; values >> value;) rows.back().push_back(value);
      if (!values.eof() || rows.back().size() != names.size())
        throw Error(path + ":" + std::to_string(number) + ": expected " + std::to_string(names.size()) + " numbers");
    }
  }

  std::size_t Column(const std::string& name) const {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) throw Error(path + ":1: there is no column " + name);
    return static_cast<std::size_t>(found - names.begin());
  }
};

PointMatrix ReadEnds(const std::string& path) {
  const NamedColumns table(path);
  const std::size_t columns[] = {table.Column("point1_x"), table.Column("point1_y"), table.Column("point2_x"),
                                 table.Column("point2_y")};
  PointMatrix segments(static_cast<Eigen::Index>(table.rows.size()), 4);
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    for (int k = 0; k < 4; ++k) segments(static_cast<Eigen::Index>(i), k) = table.rows[i][columns[k]];
  return segments;
}

/// Files of a folder that begin so, by name; their names without beginning and extension.
std::vector<std::pair<std::string, std::string>> FilesOf(const std::string& folder, const std::string& beginning) {
  if (!fs::is_directory(folder)) throw Error(folder + ": there is no such folder");
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string stem = entry.path().stem().string();
    if (stem.starts_with(beginning)) files.emplace_back(stem.substr(beginning.size()), entry.path().string());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) throw Error(folder + ": there is no file " + beginning + "*");
  return files;
}

Eigen::Matrix3d Calibration(double fx, double fy, double cx, double cy) {
  Eigen::Matrix3d K = Eigen::Vector3d(fx, fy, 1.0).asDiagonal();
  K.topRightCorner<2, 1>() << cx, cy;
  return K;
}

/// The variable `vp` of a MATLAB file: directions in space, 3 × K.
Eigen::Matrix3Xd ReadDirections(const std::string& path) {
  const Eigen::MatrixXd directions = MatlabFile(path).Matrix("vp", "3xK numbers");
  if (directions.rows() != 3 || directions.cols() == 0) throw Error(path + ": expected a variable vp, 3xK numbers");
  return directions;
}

/// Divides images into scenes, of which each begins at a place.
std::vector<SegmentScene> Split(std::vector<ImageSegments> images,
                                const std::vector<std::pair<std::string, std::size_t>>& beginnings) {
  std::vector<SegmentScene> scenes;
  for (std::size_t i = 0; i < images.size(); ++i) {
    while (scenes.size() < beginnings.size() && i >= beginnings[scenes.size()].second)
      scenes.push_back({beginnings[scenes.size()].first, {}});
    scenes.back().images.push_back(std::move(images[i]));
  }
  return scenes;
}

}  // namespace

std::vector<SegmentScene> ReadNyuVp(const std::string& folder) {
  std::vector<ImageSegments> images;
  for (const auto& [name, path] : FilesOf(folder, "lsd_lines_")) {
    ImageSegments image{name, ReadEnds(path), {}, {}, kSize};
    image.K = Calibration(518.85790117450188, 519.46961112127485, 325.58244941119034, 253.73616633400465);
    const NamedColumns points((fs::path(folder) / ("vps_" + name + ".csv")).string());
    const std::size_t x = points.Column("X"), y = points.Column("Y");
    for (const std::vector<double>& row : points.rows) image.vanishing_points.emplace_back(row[x], row[y], 1.0);
    images.push_back(std::move(image));
  }
  return Split(std::move(images), {{"nyu_vp_train", 0}, {"nyu_vp_val", 1000}, {"nyu_vp_test", 1224}});
}

std::vector<SegmentScene> ReadYudPlus(const std::string& folder) {
  constexpr double kFocalMm = 6.05317058975369, kPixelMm = 0.00896875;
  std::vector<ImageSegments> images;
  for (const auto& [name, path] : FilesOf((fs::path(folder) / "lines").string(), "P")) {
    ImageSegments image{"P" + name, ReadEnds(path), {}, {}, kSize};
    image.K = Calibration(kFocalMm / kPixelMm, kFocalMm / kPixelMm, 307.551305282635, 251.454244960136);
    const std::string truth = "P" + name + "GroundTruthVP_CamParams.mat";
    Eigen::Matrix3Xd directions = ReadDirections((fs::path(folder) / "vps" / truth).string());
    directions.row(1) *= -1.0;  // Their y axis points up.
    for (Eigen::Index k = 0; k < directions.cols(); ++k) image.vanishing_points.push_back(*image.K * directions.col(k));
    images.push_back(std::move(image));
  }
  return Split(std::move(images), {{"yud_plus_train", 0}, {"yud_plus_test", 25}});
}

}  // namespace diffsac
