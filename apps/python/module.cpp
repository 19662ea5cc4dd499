// The functions of diffsac/diffsac.h, with numpy in and out.
#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include <array>
#include <tuple>

#include "arguments.h"
#include "results.h"

namespace diffsac::python {
namespace {

using namespace nanobind::literals;

/// The result as Python has it, of `estimate`, during which other Python threads run.
template <class Call>
auto Unlocked(const Call& estimate) {
  const auto result = [&] {
    const nb::gil_scoped_release release;
    return estimate();
  }();
  return ToPython(result);
}

// Options that functions share: its type in Python, its default, and where it goes.
#define DIFFSAC_PYTHON_OPTION(Name, name, Python, standard)                        \
  struct Name {                                                                    \
    using Type = const Python&;                                                    \
    static auto Argument() { return nb::arg(#name) = standard; }                   \
    static void Set(Type value, SearchArguments* search) { search->name = value; } \
  };

DIFFSAC_PYTHON_OPTION(MaxResidual, max_residual, OptionalReal, nb::none())
DIFFSAC_PYTHON_OPTION(MaxIterations, max_iterations, OptionalWhole, nb::none())
DIFFSAC_PYTHON_OPTION(MinIterations, min_iterations, OptionalWhole, nb::none())
DIFFSAC_PYTHON_OPTION(Confidence, confidence, OptionalReal, nb::none())
DIFFSAC_PYTHON_OPTION(NumThreads, num_threads, Whole, 1)
DIFFSAC_PYTHON_OPTION(InitialModel, initial_model, OptionalArray, nb::none())
DIFFSAC_PYTHON_OPTION(GuidanceOption, guidance, Text, "network")
DIFFSAC_PYTHON_OPTION(ModelsFolderOption, models_folder, OptionalPath, nb::none())
DIFFSAC_PYTHON_OPTION(Seed, seed, Whole, 0)
DIFFSAC_PYTHON_OPTION(CamerasOption, cameras, Text, "photographs")
#undef DIFFSAC_PYTHON_OPTION

template <class... Each>
struct List {};
using ForMultiple = List<MaxResidual, MaxIterations, Seed>;
using ForFocals = List<MaxResidual, MaxIterations, MinIterations, Confidence, NumThreads, Seed>;
using ForRegistration = List<MaxResidual, MaxIterations, MinIterations, Confidence, NumThreads, InitialModel, Seed>;
using ForImages = List<MaxResidual, MaxIterations, MinIterations, Confidence, NumThreads, InitialModel, GuidanceOption,
                       ModelsFolderOption, Seed>;
using ForPhotographs = List<MaxResidual, MaxIterations, MinIterations, Confidence, NumThreads, InitialModel,
                            GuidanceOption, ModelsFolderOption, CamerasOption, Seed>;
using ForPoints =
    List<MaxIterations, MinIterations, Confidence, NumThreads, InitialModel, GuidanceOption, ModelsFolderOption, Seed>;
using ForVanishing = List<MaxIterations, GuidanceOption, ModelsFolderOption, Seed>;

/// Defines a function with arguments of its own, of the types Own, and shared options: call(own ..., search).
/// arguments: the names of its own.
template <class... Own, class... Shared, class Call, class... Arguments>
void Define(nb::module_* module, const char* name, const char* doc, List<Own...>, List<Shared...>, const Call& call,
            const Arguments&... arguments) {
  module->def(
      name,
      [call](Own... own, typename Shared::Type... shared) {
        SearchArguments search;
        (Shared::Set(shared, &search), ...);
        return call(own..., search);
      },
      arguments..., Shared::Argument()..., doc);
}

using Array = const ArrayLike&;
using MaybeArray = const OptionalArray&;
using MaybeSize = const OptionalSize&;
using MaybePair = const OptionalPair&;

/// For each argument name a matrix K.
template <class Name>
using CameraOf = Array;

/// Two views, by a network or several models; estimate(matches, matrices K ..., options). cameras: their names.
template <class Shared, class Call, class... Names>
void DefineViews(nb::module_* module, const char* name, const char* doc, Shared shared, Call estimate,
                 Names... cameras) {
  Define(
      module, name, doc,
      List<Array, Array, CameraOf<Names>..., MaybeArray, MaybeArray, MaybeSize, MaybeSize, MaybeArray>(), shared,
      [=](Array x1, Array x2, CameraOf<Names>... K, MaybeArray snn_ratio, MaybeArray scores, MaybeSize size1,
          MaybeSize size2, MaybeArray changes, const SearchArguments& search) {
        const Matches matches = MatchesOf(x1, x2, {snn_ratio, scores}, size1, size2, changes);
        const auto options = OptionsOf<ImageOptions>(search);
        const std::array<Eigen::Matrix3d, sizeof...(K)> matrices{Matrix3(K, cameras)...};
        return Unlocked([&] {
          return std::apply([&](const auto&... each) { return estimate(matches, each..., options); }, matrices);
        });
      },
      "x1"_a, "x2"_a, nb::arg(cameras)..., "snn_ratio"_a = nb::none(), nb::kw_only(), "scores"_a = nb::none(),
      "size1"_a = nb::none(), "size2"_a = nb::none(), "scale_rotation_changes"_a = nb::none());
}

/// Two views of unknown focal length; estimate(matches, matrices K ..., options).
template <class Call, class... Names>
void DefineFocal(nb::module_* module, const char* name, const char* doc, Call estimate, Names... cameras) {
  Define(
      module, name, doc,
      List<Array, Array, CameraOf<Names>..., MaybeArray, MaybeArray, MaybeSize, MaybeSize, MaybePair, MaybePair,
           MaybePair, MaybePair>(),
      ForFocals(),
      [=](Array x1, Array x2, CameraOf<Names>... K, MaybeArray snn_ratio, MaybeArray scores, MaybeSize size1,
          MaybeSize size2, MaybePair principal_point1, MaybePair principal_point2, MaybePair prior, MaybePair prior2,
          const SearchArguments& search) {
        const Matches matches = MatchesOf(x1, x2, {snn_ratio, scores}, size1, size2);
        auto options = OptionsOf<FocalOptions>(search);
        options.principal_point1 = PairOf(principal_point1, "principal_point1");
        options.principal_point2 = PairOf(principal_point2, "principal_point2");
        if (const auto likely = PairOf(prior, "prior")) options.prior = FocalPrior{likely->x(), likely->y()};
        if (const auto likely = PairOf(prior2, "prior2")) options.prior2 = FocalPrior{likely->x(), likely->y()};
        const std::array<Eigen::Matrix3d, sizeof...(K)> matrices{Matrix3(K, cameras)...};
        return Unlocked([&] {
          return std::apply([&](const auto&... each) { return estimate(matches, each..., options); }, matrices);
        });
      },
      "x1"_a, "x2"_a, nb::arg(cameras)..., "snn_ratio"_a = nb::none(), nb::kw_only(), "scores"_a = nb::none(),
      "size1"_a = nb::none(), "size2"_a = nb::none(), "principal_point1"_a = nb::none(),
      "principal_point2"_a = nb::none(), "prior"_a = nb::none(), "prior2"_a = nb::none());
}

/// Points of a scene and where an image shows them; estimate(matches, K, options).
template <class Shared, class Call>
void DefineScenePoints(nb::module_* module, const char* name, const char* doc, Shared shared, Call estimate) {
  Define(
      module, name, doc, List<Array, Array, Array, MaybeArray, MaybeArray>(), shared,
      [=](Array points3d, Array points2d, Array K, MaybeArray snn_ratio, MaybeArray scores,
          const SearchArguments& search) {
        const Matches2D3D matches = Matches2D3DOf(points3d, points2d, {snn_ratio, scores});
        const Eigen::Matrix3d matrix = Matrix3(K, "K");
        const auto options = OptionsOf<ImageOptions>(search);
        return Unlocked([&] { return estimate(matches, matrix, options); });
      },
      "points3d"_a, "points2d"_a, "K"_a, "snn_ratio"_a = nb::none(), nb::kw_only(), "scores"_a = nb::none());
}

/// Points in the plane or in space; estimate(points, options).
template <int kColumns, class Call>
void DefinePoints(nb::module_* module, const char* name, const char* doc, Call estimate) {
  Define(
      module, name, doc, List<Array, const Real&>(), ForPoints(),
      [=](Array points, const Real& max_residual, SearchArguments search) {
        const auto rows = Rows<kColumns>(points, "points");
        search.max_residual = max_residual;
        const auto options = OptionsOf<PointOptions>(search);
        return Unlocked([&] { return estimate(rows, options); });
      },
      "points"_a, "max_residual"_a, nb::kw_only());
}

/// estimate(matches of two clouds, options).
template <class Call>
void DefineClouds(nb::module_* module, const char* name, const char* doc, Call estimate) {
  Define(
      module, name, doc, List<Array, Array, MaybeArray, MaybeArray>(), ForRegistration(),
      [=](Array points1, Array points2, MaybeArray snn_ratio, MaybeArray scores, const SearchArguments& search) {
        const Matches3D3D matches = Matches3D3DOf(points1, points2, {snn_ratio, scores});
        const auto options = OptionsOf<RegistrationOptions>(search);
        return Unlocked([&] { return estimate(matches, options); });
      },
      "points1"_a, "points2"_a, "snn_ratio"_a = nb::none(), nb::kw_only(), "scores"_a = nb::none());
}

template <class Estimate>
auto WithCameras(Estimate estimate) {
  return
      [=](const Matches& matches, const Eigen::Matrix3d& K1, const Eigen::Matrix3d& K2, const ImageOptions& options) {
        return estimate(matches, {K1, K2}, options);
      };
}

void DefineTwoViews(nb::module_* module) {
  DefineViews(module, "estimate_fundamental", "Fundamental matrix F: x2ᵀ F x1 = 0 in pixels.", ForPhotographs(),
              &EstimateFundamental);
  DefineViews(
      module, "estimate_essential",
      "Essential matrix E: x2ᵀ E x1 = 0 in coordinates K⁻¹ x, and the pose of the second camera in the first one's\n"
      "frame. x1 and x2 are in pixels.",
      ForImages(), WithCameras(&EstimateEssential), "K1", "K2");
  DefineViews(module, "estimate_homography", "Homography H: x2 ~ H x1 in pixels.", ForImages(), &EstimateHomography);
  DefineFocal(
      module, "estimate_shared_focal",
      "F, pose and focal length of two images of one camera with unknown focal length. Needs size1 and size2\n"
      "(width, height), or principal_point1, principal_point2 and prior: the likeliest focal length in pixels and\n"
      "the standard deviation of its logarithm (EXIF: 0.1).",
      &EstimateSharedFocal);
  DefineFocal(module, "estimate_one_focal",
              "The same if the first camera has calibration matrix K1 and the focal length of the second is unknown.",
              &EstimateOneFocal, "K1");
  DefineFocal(module, "estimate_two_focals",
              "The same if each image has a camera of its own with unknown focal length: photographs from anywhere.\n"
              "prior2: that of the second camera, if it differs from `prior`.",
              &EstimateTwoFocals);
  DefineViews(module, "estimate_multiple_fundamentals", "Multiple fundamental matrices in the same matches.",
              ForMultiple(), &EstimateMultipleFundamentals);
  DefineViews(module, "estimate_multiple_essentials", "Multiple essential matrices in the same matches.", ForMultiple(),
              WithCameras(&EstimateMultipleEssentials), "K1", "K2");
  DefineViews(module, "estimate_multiple_homographies", "Multiple homographies in the same matches.", ForMultiple(),
              &EstimateMultipleHomographies);
}

void DefineOthers(nb::module_* module) {
  DefineScenePoints(module, "estimate_absolute_pose", "[R | t], world to camera: points2d ~ K (R points3d + t).",
                    ForImages(), &EstimateAbsolutePose);
  DefineScenePoints(module, "estimate_multiple_absolute_poses", "Multiple poses in the same points.", ForMultiple(),
                    &EstimateMultipleAbsolutePoses);
  DefineClouds(module, "estimate_rigid_motion", "[R | t]: points2 ≈ R points1 + t, from matches N × 3 of two clouds.",
               &EstimateRigidMotion);
  DefineClouds(module, "estimate_multiple_rigid_motions",
               "Multiple [R | t] in the same matches: objects that move independently.", &EstimateMultipleRigidMotions);
  DefineClouds(module, "estimate_similarity", "[s R | t] with a scale s > 0: points2 ≈ s R points1 + t.",
               &EstimateSimilarity);
  DefinePoints<2>(module, "estimate_line", "Line (a, b, c): a x + b y + c = 0 with a² + b² = 1.", &EstimateLine);
  DefinePoints<2>(module, "estimate_multiple_lines", "Multiple lines in the same points.", &EstimateMultipleLines);
  DefinePoints<3>(module, "estimate_plane", "Plane (a, b, c, d): a x + b y + c z + d = 0 with a² + b² + c² = 1.",
                  &EstimatePlane);
  DefinePoints<3>(module, "estimate_multiple_planes", "Multiple planes in the same points.", &EstimateMultiplePlanes);
}

void DefineVanishingPoints(nb::module_* module) {
  const VanishingPointOptions standard;
  Define(
      module, "estimate_vanishing_points",
      "Vanishing points of the line segments of an image, N × 4: x1 y1 x2 y2, the ends, in pixels; its focal length "
      "if\n"
      "no K is given, and its horizon. Needs K or size (width, height).",
      List<Array, MaybeArray, MaybeSize, const Real&, const Real&>(), ForVanishing(),
      [](Array segments, MaybeArray K, MaybeSize size, const Real& max_residual_deg, const Real& least_value,
         const SearchArguments& search) {
        const SegmentsView rows = Rows<4>(segments, "segments");
        auto options = OptionsOf<VanishingPointOptions>(search);
        if (K) options.K = Matrix3(*K, "K");
        options.size = SizeOf(size, "size");
        options.max_residual_deg = RealOf(max_residual_deg, "max_residual_deg");
        options.least_value = RealOf(least_value, "least_value");
        return Unlocked([&] { return EstimateVanishingPoints(rows, options); });
      },
      "segments"_a, "K"_a = nb::none(), nb::kw_only(), "size"_a = nb::none(),
      "max_residual_deg"_a = standard.max_residual_deg, "least_value"_a = standard.least_value);
}

void TranslateError(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Error& error) {
    PyErr_SetString(PyExc_ValueError, error.what());
  }
}

}  // namespace
}  // namespace diffsac::python

NB_MODULE(_native, module) {
  using namespace diffsac::python;
  nb::register_exception_translator(TranslateError);
  module.attr("VERSION") = diffsac::kVersion;
  DefineTwoViews(&module);
  DefineOthers(&module);
  DefineVanishingPoints(&module);
}
