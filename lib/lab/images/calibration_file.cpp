#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/geometry/calibration.h"
#include "lab/config/report_script.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"
#include "lab/images/image_source.h"

namespace diffsac {
namespace {

using Json = nlohmann::json;

// The numbers of arrays in arrays, in their order.
void AddNumbers(const Json& json, std::vector<double>* numbers) {
  if (json.is_number()) numbers->push_back(json.get<double>());
  if (json.is_array())
    for (const Json& item : json) AddNumbers(item, numbers);
}

/// Of an object; `data` is OpenCV's and ROS's name of a matrix's numbers.
Eigen::Matrix3d MatrixFromJson(const Json& json, const std::string& path) {
  if (json.contains("fx") && json.contains("fy") && json.contains("cx") && json.contains("cy")) {
    std::vector<double> f;
    for (const char* key : {"fx", "fy", "cx", "cy"}) AddNumbers(json[key], &f);
    if (f.size() == 4) return Eigen::Matrix3d{{f[0], 0.0, f[2]}, {0.0, f[1], f[3]}, {0.0, 0.0, 1.0}};
  }
  std::vector<double> numbers;
  for (const char* key : {"K", "k", "camera_matrix"})
    if (json.contains(key) && numbers.empty())
      AddNumbers(json[key].is_object() ? json[key].value("data", Json()) : json[key], &numbers);
  if (numbers.size() != 9) throw Error(path + ": expected a 3x3 matrix at K or camera_matrix, or fx, fy, cx and cy");
  return MatrixFromRows(numbers.data());
}

Eigen::Matrix3d MatrixOf(const std::string& path) {
  Eigen::Matrix3d matrix;
  if (std::filesystem::path(path).extension() == ".npy") {
    ReadConverted("matrix", path, [&](const std::string& text) { matrix = ReadMatrixFile(text); });
    return matrix;
  }
  const std::string text = ReadTextFile(path);
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start == std::string::npos || text[start] != '{') return ReadMatrixFile(path);
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) throw Error(path + ": no JSON that can be read");
  return MatrixFromJson(json, path);
}

}  // namespace

Eigen::Matrix3d ReadCalibrationMatrix(const std::string& path) { return CheckedCalibration(MatrixOf(path), path); }

}  // namespace diffsac
