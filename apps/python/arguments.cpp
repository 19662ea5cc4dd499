#include "arguments.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <cstdlib>
#include <string>
#include <vector>

namespace diffsac::python {
namespace {

using Numbers = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Shape = std::vector<Eigen::Index>;  // −1: any number.

constexpr Eigen::Index kAny = -1;

std::string ShapeText(const Shape& shape) {
  std::string text;
  for (const Eigen::Index size : shape) text += (text.empty() ? "" : ", ") + (size < 0 ? "N" : std::to_string(size));
  return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

[[noreturn]] void Refuse(const char* name, const std::string& expected, const std::string& given) {
  throw nb::value_error((std::string(name) + ": expected " + expected + ", got " + given).c_str());
}

bool Fits(const Shape& given, const Shape& expected) {
  if (given.size() != expected.size()) return false;
  for (std::size_t i = 0; i < given.size(); ++i)
    if (expected[i] != kAny && given[i] != expected[i]) return false;
  return true;
}

Numbers NumbersOf(const ArrayLike& array, const char* name, const Shape& expected) {
  const nb::module_ numpy = nb::module_::import_("numpy");
  const nb::object any = numpy.attr("asarray")(array);
  const nb::object type = any.attr("dtype");
  // Floating-point numbers and integers: neither bool, nor complex, nor text or objects.
  if (std::string("fiu").find(nb::cast<std::string>(type.attr("kind"))) == std::string::npos)
    Refuse(name, "real numbers", "dtype " + nb::cast<std::string>(nb::str(type)));
  const auto numbers = nb::cast<Numbers>(numpy.attr("asarray")(any, "float64", "C"));
  Shape given;
  for (std::size_t i = 0; i < numbers.ndim(); ++i) given.push_back(static_cast<Eigen::Index>(numbers.shape(i)));
  if (!Fits(given, expected)) Refuse(name, "shape " + ShapeText(expected), ShapeText(given));
  return numbers;
}

/// `rows`: how many there must be, or kAny.
template <int Columns>
Eigen::Matrix<double, Eigen::Dynamic, Columns> Rows(const ArrayLike& array, const char* name, Eigen::Index rows) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Columns, Eigen::RowMajor>;
  const Numbers numbers = NumbersOf(array, name, {rows, Columns});
  return Eigen::Map<const RowMajor>(numbers.data(), static_cast<Eigen::Index>(numbers.shape(0)), Columns);
}

/// Empty where there is none.
Eigen::VectorXd Ratios(const OptionalArray& ratio, Eigen::Index points) {
  if (!ratio) return {};
  return Eigen::Map<const Eigen::VectorXd>(NumbersOf(*ratio, "ratio", {points}).data(), points);
}

std::string& PackagedModels() {
  static std::string folder;
  return folder;
}

}  // namespace

Eigen::Matrix<double, Eigen::Dynamic, 2> Points2(const ArrayLike& array, const char* name) {
  return Rows<2>(array, name, kAny);
}

Eigen::Matrix<double, Eigen::Dynamic, 3> Points3(const ArrayLike& array, const char* name) {
  return Rows<3>(array, name, kAny);
}

Eigen::Matrix<double, Eigen::Dynamic, 4> Points4(const ArrayLike& array, const char* name) {
  return Rows<4>(array, name, kAny);
}

Eigen::Matrix3d Matrix3(const ArrayLike& array, const char* name) { return Rows<3>(array, name, 3); }

ImageSize SizeOf(const OptionalSize& size) { return size ? ImageSize{size->first, size->second} : ImageSize{}; }

Matches MatchesOf(const ArrayLike& x1, const ArrayLike& x2, const OptionalArray& ratio, const OptionalSize& size1,
                  const OptionalSize& size2, const OptionalArray& similarities) {
  Matches matches;
  matches.points1 = Points2(x1, "x1");
  matches.points2 = Rows<2>(x2, "x2", matches.points1.rows());
  matches.match_ratios = Ratios(ratio, matches.points1.rows());
  matches.size1 = SizeOf(size1);
  matches.size2 = SizeOf(size2);
  if (similarities) matches.similarities = Rows<2>(*similarities, "similarities", matches.points1.rows());
  return matches;
}

ScenePoints ScenePointsOf(const ArrayLike& points3d, const ArrayLike& points2d, const OptionalArray& ratio) {
  ScenePoints points;
  points.points3d = Points3(points3d, "points3d");
  points.points2d = Rows<2>(points2d, "points2d", points.points3d.rows());
  points.match_ratios = Ratios(ratio, points.points3d.rows());
  return points;
}

void SetPackagedModels(const std::filesystem::path& folder) {
  PackagedModels() = folder.string();
  AddModelsFolder(PackagedModels());
}

std::string ModelsFolder(const OptionalPath& given) {
  if (given) return given->string();
  // Said here rather than left to the library's order, in which models that another version installed beside the
  // interpreter (/usr/share/diffsac) would come first.
  const char* models = std::getenv("DIFFSAC_MODELS");
  return models != nullptr && *models != '\0' ? "" : PackagedModels();
}

}  // namespace diffsac::python
