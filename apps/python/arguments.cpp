#include "arguments.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace diffsac::python {
namespace {

using Numbers = nb::ndarray<const double, nb::device::cpu>;
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

/// Of float64 without a copy, but where its strides are not whole numbers from 0.
Numbers AsNumbers(const nb::module_& numpy, const nb::object& array) {
  Numbers numbers;
  const auto is_backwards = [&] {
    for (std::size_t i = 0; i < numbers.ndim(); ++i)
      if (numbers.stride(i) < 0) return true;
    return false;
  };
  if (!nb::try_cast(numpy.attr("asarray")(array, "float64"), numbers) || is_backwards())
    numbers = nb::cast<Numbers>(numpy.attr("array")(array, "float64", nb::arg("order") = "C"));
  return numbers;
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
  const Numbers numbers = AsNumbers(numpy, any);
  Shape given;
  for (std::size_t i = 0; i < numbers.ndim(); ++i) given.push_back(static_cast<Eigen::Index>(numbers.shape(i)));
  if (!Fits(given, expected)) Refuse(name, "shape " + ShapeText(expected), ShapeText(given));
  return numbers;
}

/// Its numbers, which the view keeps alive.
template <int kColumns>
RowsView<kColumns> ViewOf(const Numbers& numbers) {
  const auto rows = static_cast<Eigen::Index>(numbers.shape(0));
  return {numbers.data(), rows, numbers.stride(0), kColumns == 1 ? 1 : numbers.stride(numbers.ndim() - 1),
          std::make_shared<const Numbers>(numbers)};
}

/// Empty where there is none.
ValuesView OneEach(const OptionalArray& given, const char* name, Eigen::Index points) {
  return given ? ViewOf<1>(NumbersOf(*given, name, {points})) : ValuesView();
}

/// Rows of which `given` is masked are left out, as those are whose points are.
template <int kColumns, int kValues>
void LeaveOutMasked(const OptionalArray& given, const RowsView<kValues>& values, RowsView<kColumns>* points) {
  if (!given || !IsMasked(*given)) return;
  typename RowsView<kColumns>::Matrix kept = points->matrix();
  for (Eigen::Index i = 0; i < values.rows(); ++i)
    if (values.matrix().row(i).hasNaN()) kept.row(i).setConstant(std::numeric_limits<double>::quiet_NaN());
  *points = std::move(kept);
}

/// `points`: those of `input` that are left out where a ratio or score is masked.
template <class Input, int kColumns>
void SetRatiosOrScores(const RatioOrScores& given, Input* input, RowsView<kColumns>* points) {
  input->snn_ratio = OneEach(given.snn_ratio, "snn_ratio", points->rows());
  input->scores = OneEach(given.scores, "scores", points->rows());
  LeaveOutMasked(given.snn_ratio, input->snn_ratio, points);
  LeaveOutMasked(given.scores, input->scores, points);
}

}  // namespace

template <int kColumns>
RowsView<kColumns> Rows(const ArrayLike& array, const char* name, Eigen::Index rows) {
  return ViewOf<kColumns>(NumbersOf(array, name, {rows, kColumns}));
}

template Points2DView Rows<2>(const ArrayLike&, const char*, Eigen::Index);
template Points3DView Rows<3>(const ArrayLike&, const char*, Eigen::Index);
template SegmentsView Rows<4>(const ArrayLike&, const char*, Eigen::Index);

Eigen::Matrix3d Matrix3(const ArrayLike& array, const char* name) { return Rows<3>(array, name, 3).matrix(); }

Eigen::MatrixXd ModelOf(const ArrayLike& array, const char* name) {
  const nb::object any = nb::module_::import_("numpy").attr("asarray")(array);
  if (nb::cast<int>(any.attr("ndim")) == 1) return ViewOf<1>(NumbersOf(array, name, {kAny})).matrix();
  const Numbers numbers = NumbersOf(array, name, {kAny, kAny});
  const Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic> strides(numbers.stride(1), numbers.stride(0));
  return Eigen::Map<const Eigen::MatrixXd, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>(
      numbers.data(), static_cast<Eigen::Index>(numbers.shape(0)), static_cast<Eigen::Index>(numbers.shape(1)),
      strides);
}

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

namespace {

/// A value by its name.
template <class Enum>
Enum NamedOf(const Text& value, const char* name, const char* expected) {
  for (const auto& entry : kEnumNames<Enum>)
    if (nb::isinstance<nb::str>(value) && nb::cast<std::string>(value) == entry.name) return entry.value;
  RefuseValue(name, expected, value);
}

}  // namespace

Guidance GuidanceOf(const Text& value, const char* name) {
  return NamedOf<Guidance>(value, name, "'none', 'network' or 'diffusion'");
}

Cameras CamerasOf(const Text& value, const char* name) {
  return NamedOf<Cameras>(value, name, "'photographs' or 'unknown'");
}

Matches MatchesOf(const ArrayLike& x1, const ArrayLike& x2, const RatioOrScores& given, const OptionalSize& size1,
                  const OptionalSize& size2, const OptionalArray& scale_rotation_changes) {
  Matches matches;
  matches.points1 = Rows<2>(x1, "x1");
  const Eigen::Index count = matches.points1.rows();
  matches.points2 = Rows<2>(x2, "x2", count);
  matches.size1 = SizeOf(size1, "size1");
  matches.size2 = SizeOf(size2, "size2");
  if (scale_rotation_changes)
    matches.scale_rotation_changes = Rows<2>(*scale_rotation_changes, "scale_rotation_changes", count);
  SetRatiosOrScores(given, &matches, &matches.points1);
  LeaveOutMasked(scale_rotation_changes, matches.scale_rotation_changes, &matches.points1);
  return matches;
}

Matches2D3D Matches2D3DOf(const ArrayLike& points3d, const ArrayLike& points2d, const RatioOrScores& given) {
  Matches2D3D matches;
  matches.points3d = Rows<3>(points3d, "points3d");
  matches.points2d = Rows<2>(points2d, "points2d", matches.points3d.rows());
  SetRatiosOrScores(given, &matches, &matches.points2d);
  return matches;
}

Matches3D3D Matches3D3DOf(const ArrayLike& points1, const ArrayLike& points2, const RatioOrScores& given) {
  Matches3D3D matches;
  matches.points1 = Rows<3>(points1, "points1");
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
