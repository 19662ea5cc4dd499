#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>

#include "diffsac/diffsac.h"
#include "results.h"

namespace diffsac::python {

namespace nb = nanobind;

// Arguments come as any object, so that what is wrong with one is said in a line that names it: nanobind says of a type
// that does not fit what all would have to be. Classes of their own, so that signatures and stubs say what is expected.
#define DIFFSAC_PYTHON_ARGUMENT(Name, text)       \
  class Name : public nb::object {                \
    NB_OBJECT(Name, nb::object, text, IsAnything) \
  };

/// What numpy.asarray takes.
DIFFSAC_PYTHON_ARGUMENT(ArrayLike, "numpy.typing.ArrayLike")
/// A whole number, of any type.
DIFFSAC_PYTHON_ARGUMENT(Whole, "int")
/// A real number, of any type.
DIFFSAC_PYTHON_ARGUMENT(Real, "float")
DIFFSAC_PYTHON_ARGUMENT(Truth, "bool")
/// Width and height in pixels, of an image.
DIFFSAC_PYTHON_ARGUMENT(SizeLike, "tuple[int, int]")
/// Focal length in pixels and the standard deviation of its logarithm; a principal point.
DIFFSAC_PYTHON_ARGUMENT(PairLike, "tuple[float, float]")
DIFFSAC_PYTHON_ARGUMENT(PathLike, "str | os.PathLike")
#undef DIFFSAC_PYTHON_ARGUMENT

using OptionalArray = std::optional<ArrayLike>;
using OptionalSize = std::optional<SizeLike>;
using OptionalPair = std::optional<PairLike>;
using OptionalPath = std::optional<PathLike>;

// Arrays of real numbers of any type and layout are copied into the library's. Each function throws nb::value_error
// that names the argument, says what was expected and what was given; values that are not finite are the library's to
// judge. Masked values (numpy.ma) are not finite.

Eigen::Matrix<double, Eigen::Dynamic, 2> Points2(const ArrayLike& array, const char* name);
Eigen::Matrix<double, Eigen::Dynamic, 3> Points3(const ArrayLike& array, const char* name);
Eigen::Matrix<double, Eigen::Dynamic, 4> Points4(const ArrayLike& array, const char* name);
Eigen::Matrix3d Matrix3(const ArrayLike& array, const char* name);

/// N each; at most one of them.
struct RatioOrScores {
  const OptionalArray &ratio, &scores;
};
/// `x1`, `x2`: N × 2. A row of which anything is masked is not finite.
Matches MatchesOf(const ArrayLike& x1, const ArrayLike& x2, const RatioOrScores& given, const OptionalSize& size1,
                  const OptionalSize& size2, const OptionalArray& similarities = {});
/// `points3d`: N × 3, `points2d`: N × 2.
ScenePoints ScenePointsOf(const ArrayLike& points3d, const ArrayLike& points2d, const RatioOrScores& given);

/// `points1`, `points2`: N × 3.
CloudMatches CloudMatchesOf(const ArrayLike& points1, const ArrayLike& points2, const RatioOrScores& given);

/// Unknown where there is none.
ImageSize SizeOf(const OptionalSize& size, const char* name);
std::optional<Eigen::Vector2d> PairOf(const OptionalPair& pair, const char* name);
/// Numbers of any type that are whole, from 0 to `most`.
std::uint64_t WholeOf(const Whole& value, const char* name, std::uint64_t most);
double RealOf(const Real& value, const char* name);
bool TruthOf(const Truth& value, const char* name);
/// EstimateOptions::models_folder.
std::string ModelsFolder(const OptionalPath& given);

}  // namespace diffsac::python
