#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <utility>

#include "diffsac/diffsac.h"
#include "results.h"

namespace diffsac::python {

namespace nb = nanobind;

/// What numpy.asarray takes. A class of its own, so that signatures and stubs say so.
class ArrayLike : public nb::object {
  NB_OBJECT(ArrayLike, nb::object, "numpy.typing.ArrayLike", IsAnything)
};

using OptionalArray = std::optional<ArrayLike>;
/// Width and height in pixels.
using OptionalSize = std::optional<std::pair<int, int>>;
/// Focal length in pixels and the standard deviation of its logarithm; a principal point.
using OptionalPair = std::optional<std::pair<double, double>>;
using OptionalPath = std::optional<std::filesystem::path>;

// Arrays of real numbers of any type and layout are copied into the library's. Each function throws nb::value_error
// that names the argument, says what was expected and what was given; values that are not finite are the library's to
// judge.

Eigen::Matrix<double, Eigen::Dynamic, 2> Points2(const ArrayLike& array, const char* name);
Eigen::Matrix<double, Eigen::Dynamic, 3> Points3(const ArrayLike& array, const char* name);
Eigen::Matrix<double, Eigen::Dynamic, 4> Points4(const ArrayLike& array, const char* name);
Eigen::Matrix3d Matrix3(const ArrayLike& array, const char* name);

/// `x1`, `x2`: N × 2; `ratio`: N.
Matches MatchesOf(const ArrayLike& x1, const ArrayLike& x2, const OptionalArray& ratio, const OptionalSize& size1,
                  const OptionalSize& size2, const OptionalArray& similarities = {});
/// `points3d`: N × 3, `points2d`: N × 2; `ratio`: N.
ScenePoints ScenePointsOf(const ArrayLike& points3d, const ArrayLike& points2d, const OptionalArray& ratio);

/// Models are those of this folder where neither the caller nor $DIFFSAC_MODELS says another.
void SetPackagedModels(const std::filesystem::path& folder);
/// Unknown where there is none.
ImageSize SizeOf(const OptionalSize& size);
/// EstimateOptions::models_folder.
std::string ModelsFolder(const OptionalPath& given);

}  // namespace diffsac::python
