#include "arguments.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include <cmath>
#include <limits>
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

/// Its text in one line, as Python writes it.
[[noreturn]] void RefuseValue(const char* name, const std::string& expected, const nb::handle& given) {
  constexpr std::size_t kLongest = 60;
  std::string text = nb::cast<std::string>(nb::repr(given));
  text = text.substr(0, text.find('\n'));
  Refuse(name, expected, text.size() > kLongest ? text.substr(0, kLongest) + "..." : text);
}

/// What Python's float() makes of it, of texts nothing.
std::optional<double> NumberOf(const nb::handle& value) {
  const double number = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() == nullptr) return number;
  PyErr_Clear();
  return std::nullopt;
}

std::optional<Eigen::Vector2d> NumbersOfPair(const nb::handle& value) {
  try {
    const nb::list items(value);
    if (items.size() != 2) return std::nullopt;
    const auto first = NumberOf(items[0]), second = NumberOf(items[1]);
    if (first && second) return Eigen::Vector2d(*first, *second);
  } catch (const nb::python_error&) {
    // Nothing to go through.
  }
  return std::nullopt;
}

bool IsMasked(const nb::handle& array) {
  return nb::cast<bool>(nb::module_::import_("numpy").attr("ma").attr("isMaskedArray")(array));
}

bool Fits(const Shape& given, const Shape& expected) {
  if (given.size() != expected.size()) return false;
  for (std::size_t i = 0; i < given.size(); ++i)
    if (expected[i] != kAny && given[i] != expected[i]) return false;
  return true;
}

Numbers NumbersOf(const ArrayLike& array, const char* name, const Shape& expected) {
  const nb::module_ numpy = nb::module_::import_("numpy");
  nb::object any;
  try {
    any = numpy.attr("asanyarray")(array);
  } catch (const nb::python_error&) {
    RefuseValue(name, "real numbers", array);  // Rows of unlike lengths.
  }
  const nb::object type = any.attr("dtype");
  // Floating-point numbers and integers: neither bool, nor complex, nor text or objects.
  if (std::string("fiu").find(nb::cast<std::string>(type.attr("kind"))) == std::string::npos)
    Refuse(name, "real numbers", "dtype " + nb::cast<std::string>(nb::str(type)));
  if (IsMasked(any)) any = any.attr("astype")("float64").attr("filled")(std::numeric_limits<double>::quiet_NaN());
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
Eigen::VectorXd OneEach(const OptionalArray& given, const char* name, Eigen::Index points) {
  if (!given) return {};
  return Eigen::Map<const Eigen::VectorXd>(NumbersOf(*given, name, {points}).data(), points);
}

/// Rows of which `given` is masked are left out, as those are whose points are.
template <class Points>
void LeaveOutMasked(const OptionalArray& given, const Eigen::MatrixXd& values, Points* points) {
  if (!given || !IsMasked(*given)) return;
  for (Eigen::Index i = 0; i < values.rows(); ++i)
    if (values.row(i).hasNaN()) points->row(i).setConstant(std::numeric_limits<double>::quiet_NaN());
}

/// `points`: those of `input` (Matches or ScenePoints) that are left out where a ratio or score is masked.
template <class Input, class Points>
void SetRatiosOrScores(const RatioOrScores& given, Input* input, Points* points) {
  input->match_ratios = OneEach(given.ratio, "ratio", points->rows());
  input->scores = OneEach(given.scores, "scores", points->rows());
  LeaveOutMasked(given.ratio, input->match_ratios, points);
  LeaveOutMasked(given.scores, input->scores, points);
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

ImageSize SizeOf(const OptionalSize& size, const char* name) {
  if (!size) return {};
  const auto sides = NumbersOfPair(*size);
  const auto is_side = [](double side) {
    return std::abs(side) <= std::numeric_limits<int>::max() && side == std::floor(side);
  };
  if (!sides || !is_side(sides->x()) || !is_side(sides->y()))
    RefuseValue(name, "(width, height) in whole pixels", *size);
  return {static_cast<int>(sides->x()), static_cast<int>(sides->y())};
}

std::optional<Eigen::Vector2d> PairOf(const OptionalPair& pair, const char* name) {
  if (!pair) return std::nullopt;
  const auto numbers = NumbersOfPair(*pair);
  if (!numbers) RefuseValue(name, "two numbers", *pair);
  return numbers;
}

std::uint64_t WholeOf(const Whole& value, const char* name, std::uint64_t most) {
  nb::object whole = nb::steal(PyNumber_Index(value.ptr()));
  if (!whole.is_valid()) {
    PyErr_Clear();
    const std::optional<double> number = NumberOf(value);  // 1e4, say.
    if (number && *number == std::floor(*number)) whole = nb::steal(PyLong_FromDouble(*number));
  }
  const std::uint64_t result = whole.is_valid() ? PyLong_AsUnsignedLongLong(whole.ptr()) : 0;
  const bool fits = whole.is_valid() && PyErr_Occurred() == nullptr && result <= most;
  PyErr_Clear();
  if (!fits) RefuseValue(name, "a whole number from 0 to " + std::to_string(most), value);
  return result;
}

double RealOf(const Real& value, const char* name) {
  const std::optional<double> number = NumberOf(value);
  if (!number) RefuseValue(name, "a number", value);
  return *number;
}

bool TruthOf(const Truth& value, const char* name) {
  if (!PyBool_Check(value.ptr()) && !nb::isinstance(value, nb::module_::import_("numpy").attr("bool_")))
    RefuseValue(name, "True or False", value);
  return nb::cast<bool>(nb::bool_(value));
}

Matches MatchesOf(const ArrayLike& x1, const ArrayLike& x2, const RatioOrScores& given, const OptionalSize& size1,
                  const OptionalSize& size2, const OptionalArray& similarities) {
  Matches matches;
  matches.points1 = Points2(x1, "x1");
  matches.points2 = Rows<2>(x2, "x2", matches.points1.rows());
  matches.size1 = SizeOf(size1, "size1");
  matches.size2 = SizeOf(size2, "size2");
  if (similarities) matches.similarities = Rows<2>(*similarities, "similarities", matches.points1.rows());
  SetRatiosOrScores(given, &matches, &matches.points1);
  LeaveOutMasked(similarities, matches.similarities, &matches.points1);
  return matches;
}

ScenePoints ScenePointsOf(const ArrayLike& points3d, const ArrayLike& points2d, const RatioOrScores& given) {
  ScenePoints points;
  points.points3d = Points3(points3d, "points3d");
  points.points2d = Rows<2>(points2d, "points2d", points.points3d.rows());
  SetRatiosOrScores(given, &points, &points.points2d);
  return points;
}

CloudMatches CloudMatchesOf(const ArrayLike& points1, const ArrayLike& points2, const RatioOrScores& given) {
  CloudMatches matches;
  matches.points1 = Points3(points1, "points1");
  matches.points2 = Rows<3>(points2, "points2", matches.points1.rows());
  SetRatiosOrScores(given, &matches, &matches.points2);
  return matches;
}

std::string ModelsFolder(const OptionalPath& given) {
  std::filesystem::path folder;
  if (given && !nb::try_cast(*given, folder)) RefuseValue("models_folder", "a path", *given);
  return folder.string();
}

}  // namespace diffsac::python
