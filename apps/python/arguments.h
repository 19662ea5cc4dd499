#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>

#include <Eigen/Core>
#include <filesystem>
#include <limits>
#include <optional>

#include "diffsac/diffsac.h"
#include "diffsac/estimate/estimate_options.h"
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
/// One of some words.
DIFFSAC_PYTHON_ARGUMENT(Text, "str")
/// Width and height in pixels, of an image.
DIFFSAC_PYTHON_ARGUMENT(SizeLike, "tuple[int, int]")
/// Focal length in pixels and the standard deviation of its logarithm; a principal point.
DIFFSAC_PYTHON_ARGUMENT(PairLike, "tuple[float, float]")
DIFFSAC_PYTHON_ARGUMENT(PathLike, "str | os.PathLike")
#undef DIFFSAC_PYTHON_ARGUMENT

using OptionalArray = std::optional<ArrayLike>;
using OptionalWhole = std::optional<Whole>;
using OptionalReal = std::optional<Real>;
using OptionalText = std::optional<Text>;
using OptionalSize = std::optional<SizeLike>;
using OptionalPair = std::optional<PairLike>;
using OptionalPath = std::optional<PathLike>;

// Arrays of float64 are views of Python's memory, in any layout, which the results keep alive; others are copied. Each
// function throws nb::value_error that names the argument, says what was expected and what was given; values that are
// not finite are the library's to judge. Masked values (numpy.ma) are not finite.

/// N × kColumns. rows: how many there must be, or −1.
template <int kColumns>
RowsView<kColumns> Rows(const ArrayLike& array, const char* name, Eigen::Index rows = -1);
Eigen::Matrix3d Matrix3(const ArrayLike& array, const char* name);

/// N each; at most one of them.
struct RatioOrScores {
  const OptionalArray &snn_ratio, &scores;
};
/// `x1`, `x2`: N × 2. A row of which anything is masked is not finite.
Matches MatchesOf(const ArrayLike& x1, const ArrayLike& x2, const RatioOrScores& given, const OptionalSize& size1,
                  const OptionalSize& size2, const OptionalArray& scale_rotation_changes = {});
/// `points3d`: N × 3, `points2d`: N × 2.
Matches2D3D Matches2D3DOf(const ArrayLike& points3d, const ArrayLike& points2d, const RatioOrScores& given);
/// `points1`, `points2`: N × 3.
Matches3D3D Matches3D3DOf(const ArrayLike& points1, const ArrayLike& points2, const RatioOrScores& given);

/// The options that functions have in common; those that a function does not take are absent.
struct SearchArguments {
  OptionalReal max_residual = {};
  OptionalWhole max_iterations = {}, min_iterations = {};
  OptionalReal confidence = {};
  OptionalWhole num_threads = {};
  OptionalArray initial_model = {};
  OptionalText guidance = {}, cameras = {};
  OptionalPath models_folder = {};
  OptionalWhole seed = {};
};
/// Sets all of them that `Options` has.
template <class Options>
Options OptionsOf(const SearchArguments& search);

/// Unknown where there is none.
ImageSize SizeOf(const OptionalSize& size, const char* name);
std::optional<Eigen::Vector2d> PairOf(const OptionalPair& pair, const char* name);
/// A number of any type that is whole, from 0 to `most`.
std::uint64_t WholeOf(const Whole& value, const char* name, std::uint64_t most);
double RealOf(const Real& value, const char* name);
Guidance GuidanceOf(const Text& value, const char* name);
Cameras CamerasOf(const Text& value, const char* name);
/// A model of the result's shape; a vector is one column.
Eigen::MatrixXd ModelOf(const ArrayLike& array, const char* name);
/// EstimateOptions::models_folder.
std::string ModelsFolder(const OptionalPath& given);

template <class Options>
Options OptionsOf(const SearchArguments& search) {
  const auto whole = [](const OptionalWhole& value, const char* name) -> std::optional<int> {
    if (!value) return std::nullopt;
    return static_cast<int>(WholeOf(*value, name, EstimateOptions::kMostIterations));
  };
  Options options;
  options.max_iterations = whole(search.max_iterations, "max_iterations");
  if (search.seed) options.seed = WholeOf(*search.seed, "seed", std::numeric_limits<std::uint64_t>::max());
  if constexpr (requires { options.max_residual; })
    if (search.max_residual) options.max_residual = RealOf(*search.max_residual, "max_residual");
  if constexpr (requires { options.min_iterations; }) {
    options.min_iterations = whole(search.min_iterations, "min_iterations");
    if (search.confidence) options.confidence = RealOf(*search.confidence, "confidence");
    options.num_threads = whole(search.num_threads, "num_threads").value_or(options.num_threads);
  }
  if constexpr (requires { options.initial_model; })
    if (search.initial_model) options.initial_model = ModelOf(*search.initial_model, "initial_model");
  if constexpr (requires { options.cameras; })
    if (search.cameras) options.cameras = CamerasOf(*search.cameras, "cameras");
  if constexpr (requires { options.guidance; }) {
    if (search.guidance) options.guidance = GuidanceOf(*search.guidance, "guidance");
    options.models_folder = ModelsFolder(search.models_folder);
  }
  return options;
}

}  // namespace diffsac::python
