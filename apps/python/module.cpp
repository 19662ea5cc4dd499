// The functions of diffsac/diffsac.h, with numpy in and out.
#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>

#include <array>
#include <limits>
#include <string>
#include <string_view>

#include "arguments.h"
#include "results.h"

namespace diffsac::python {
namespace {

using namespace nanobind::literals;

/// For each argument name a matrix K.
template <class Name>
using CameraOf = const ArrayLike&;
template <std::size_t count>
using CameraMatrices = std::array<Eigen::Matrix3d, count>;

/// The result as Python has it, of `estimate`, during which other Python threads run.
template <class Call>
auto Unlocked(const Call& estimate) {
  const auto result = [&] {
    const nb::gil_scoped_release release;
    return estimate();
  }();
  return ToPython(result);
}

void Set(const Whole& max_iterations, const Whole& seed, EstimateOptions* options) {
  options->max_iterations =
      static_cast<int>(WholeOf(max_iterations, "max_iterations", EstimateOptions::kMostIterations));
  options->seed = WholeOf(seed, "seed", std::numeric_limits<std::uint64_t>::max());
}

void SetNetwork(const Truth& use_network, const OptionalPath& models_folder, EstimateOptions* options) {
  options->use_network = TruthOf(use_network, "use_network");
  options->models_folder = ModelsFolder(models_folder);
}

ImageOptions Options(const Real& max_residual_px, const Whole& max_iterations, const Whole& seed) {
  ImageOptions options;
  options.max_residual_px = RealOf(max_residual_px, "max_residual_px");
  Set(max_iterations, seed, &options);
  return options;
}

// Each of these defines a function of one kind of input, which is listed here once for all functions of that kind.

/// Two views with a network. `cameras`: the names of the matrices K that the function takes; estimate(matches,
/// matrices, options).
template <class Call, class... Names>
void DefineLearned(nb::module_* module, const char* name, const char* doc, Call estimate, Names... cameras) {
  module->def(
      name,
      [=](const ArrayLike& x1, const ArrayLike& x2, CameraOf<Names>... K, const OptionalArray& ratio,
          const OptionalArray& scores, const OptionalSize& size1, const OptionalSize& size2,
          const OptionalArray& similarities, const Real& max_residual_px, const Whole& max_iterations,
          const Truth& use_network, const OptionalPath& models_folder, const Whole& seed,
          const char* cameras_known) {
        const Matches matches = MatchesOf(x1, x2, {ratio, scores}, size1, size2, similarities);
        const CameraMatrices<sizeof...(K)> matrices = {Matrix3(K, cameras)...};
        ImageOptions options = Options(max_residual_px, max_iterations, seed);
        SetNetwork(use_network, models_folder, &options);
        options.cameras = FromString<Cameras>(cameras_known);
        return Unlocked([&] { return estimate(matches, matrices, options); });
      },
      "x1"_a, "x2"_a, nb::arg(cameras)..., "ratio"_a = nb::none(), nb::kw_only(), "scores"_a = nb::none(),
      "size1"_a = nb::none(), "size2"_a = nb::none(), "similarities"_a = nb::none(), "max_residual_px"_a = 0.0,
      "max_iterations"_a = 0, "use_network"_a = true, "models_folder"_a = nb::none(), "seed"_a = 0,
      "cameras"_a = "photographs", doc);
}

/// Several models of two views.
template <class Call, class... Names>
void DefineSeveral(nb::module_* module, const char* name, const char* doc, Call estimate, Names... cameras) {
  module->def(
      name,
      [=](const ArrayLike& x1, const ArrayLike& x2, CameraOf<Names>... K, const OptionalArray& ratio,
          const OptionalArray& scores, const OptionalSize& size1, const OptionalSize& size2,
          const Real& max_residual_px, const Whole& max_iterations, const Whole& seed) {
        const Matches matches = MatchesOf(x1, x2, {ratio, scores}, size1, size2);
        const CameraMatrices<sizeof...(K)> matrices = {Matrix3(K, cameras)...};
        const ImageOptions options = Options(max_residual_px, max_iterations, seed);
        return Unlocked([&] { return estimate(matches, matrices, options); });
      },
      "x1"_a, "x2"_a, nb::arg(cameras)..., "ratio"_a = nb::none(), nb::kw_only(), "scores"_a = nb::none(),
      "size1"_a = nb::none(), "size2"_a = nb::none(), "max_residual_px"_a = 0.0, "max_iterations"_a = 0, "seed"_a = 0,
      doc);
}

/// Two views of unknown focal length.
template <class Call, class... Names>
void DefineFocal(nb::module_* module, const char* name, const char* doc, Call estimate, Names... cameras) {
  module->def(
      name,
      [=](const ArrayLike& x1, const ArrayLike& x2, CameraOf<Names>... K, const OptionalArray& ratio,
          const OptionalArray& scores, const OptionalSize& size1, const OptionalSize& size2,
          const OptionalPair& principal_point1, const OptionalPair& principal_point2, const OptionalPair& prior,
          const OptionalPair& prior2, const Real& max_residual_px, const Whole& max_iterations, const Whole& seed) {
        const Matches matches = MatchesOf(x1, x2, {ratio, scores}, size1, size2);
        const CameraMatrices<sizeof...(K)> matrices = {Matrix3(K, cameras)...};
        FocalOptions options;
        static_cast<ImageOptions&>(options) = Options(max_residual_px, max_iterations, seed);
        options.principal_point1 = PairOf(principal_point1, "principal_point1");
        options.principal_point2 = PairOf(principal_point2, "principal_point2");
        if (const auto likely = PairOf(prior, "prior")) options.prior = FocalPrior{likely->x(), likely->y()};
        if (const auto likely = PairOf(prior2, "prior2")) options.prior2 = FocalPrior{likely->x(), likely->y()};
        return Unlocked([&] { return estimate(matches, matrices, options); });
      },
      "x1"_a, "x2"_a, nb::arg(cameras)..., "ratio"_a = nb::none(), nb::kw_only(), "scores"_a = nb::none(),
      "size1"_a = nb::none(), "size2"_a = nb::none(), "principal_point1"_a = nb::none(),
      "principal_point2"_a = nb::none(), "prior"_a = nb::none(), "prior2"_a = nb::none(), "max_residual_px"_a = 0.0,
      "max_iterations"_a = 0, "seed"_a = 0, doc);
}

/// Points of a scene and where an image shows them; estimate(points, K, options).
template <class Call>
void DefineScenePoints(nb::module_* module, const char* name, const char* doc, Call estimate) {
  module->def(
      name,
      [=](const ArrayLike& points3d, const ArrayLike& points2d, const ArrayLike& K, const OptionalArray& ratio,
          const OptionalArray& scores, const Real& max_residual_px, const Whole& max_iterations, const Whole& seed) {
        const ScenePoints points = ScenePointsOf(points3d, points2d, {ratio, scores});
        const Eigen::Matrix3d matrix = Matrix3(K, "K");
        const ImageOptions options = Options(max_residual_px, max_iterations, seed);
        return Unlocked([&] { return estimate(points, matrix, options); });
      },
      "points3d"_a, "points2d"_a, "K"_a, "ratio"_a = nb::none(), nb::kw_only(), "scores"_a = nb::none(),
      "max_residual_px"_a = 0.0, "max_iterations"_a = 0, "seed"_a = 0, doc);
}

/// Points in the plane or in space, which `read` makes of an array; estimate(points, options).
template <class Read, class Call>
void DefinePoints(nb::module_* module, const char* name, const char* doc, Read read, Call estimate) {
  module->def(
      name,
      [=](const ArrayLike& points, const Real& max_distance, const Whole& max_iterations, const Whole& seed) {
        const auto rows = read(points, "points");
        PointOptions options(RealOf(max_distance, "max_distance"));
        Set(max_iterations, seed, &options);
        return Unlocked([&] { return estimate(rows, options); });
      },
      "points"_a, "max_distance"_a, nb::kw_only(), "max_iterations"_a = 0, "seed"_a = 0, doc);
}

/// estimate(matches of two clouds, options).
template <class Call>
void DefineClouds(nb::module_* module, const char* name, const char* doc, Call estimate) {
  module->def(
      name,
      [=](const ArrayLike& points1, const ArrayLike& points2, const OptionalArray& ratio, const OptionalArray& scores,
          const Real& max_distance, const Whole& max_iterations, const Whole& seed) {
        const CloudMatches matches = CloudMatchesOf(points1, points2, {ratio, scores});
        CloudOptions options(RealOf(max_distance, "max_distance"));
        Set(max_iterations, seed, &options);
        return Unlocked([&] { return estimate(matches, options); });
      },
      "points1"_a, "points2"_a, "ratio"_a = nb::none(), nb::kw_only(), "scores"_a = nb::none(), "max_distance"_a = 0.0,
      "max_iterations"_a = 0, "seed"_a = 0, doc);
}

void DefineTwoViews(nb::module_* module) {
  DefineLearned(module, "estimate_fundamental", "F: x2ᵀ F x1 = 0 in pixels.",
                [](const Matches& matches, const CameraMatrices<0>&, const ImageOptions& options) {
                  return EstimateFundamental(matches, options);
                });
  DefineLearned(
      module, "estimate_essential",
      "E: x2ᵀ E x1 = 0 in coordinates K⁻¹ x, and the pose of the second camera seen from the first. x1 and x2 are in\n"
      "pixels, K1 and K2 calibration matrices without lens distortion.",
      [](const Matches& matches, const CameraMatrices<2>& K, const ImageOptions& options) {
        return EstimateEssential(matches, {K[0], K[1]}, options);
      },
      "K1", "K2");
  DefineLearned(module, "estimate_homography", "H: x2 ~ H x1 in pixels.",
                [](const Matches& matches, const CameraMatrices<0>&, const ImageOptions& options) {
                  return EstimateHomography(matches, options);
                });
  DefineFocal(
      module, "estimate_shared_focal",
      "F, the pose and the focal length, where both images are of one camera of unknown focal length. It needs\n"
      "size1 and size2 (width, height), or principal_point1, principal_point2 and prior: the likeliest focal\n"
      "length in pixels and the standard deviation of its logarithm (EXIF's: 0.1).",
      [](const Matches& matches, const CameraMatrices<0>&, const FocalOptions& options) {
        return EstimateSharedFocal(matches, options);
      });
  DefineFocal(
      module, "estimate_one_focal",
      "The same where the first camera has the calibration K1 and the focal length of the second is unknown.",
      [](const Matches& matches, const CameraMatrices<1>& K, const FocalOptions& options) {
        return EstimateOneFocal(matches, K[0], options);
      },
      "K1");
  DefineFocal(
      module, "estimate_two_focals",
      "The same where each image has a camera of its own, of unknown focal length: photographs from anywhere. prior2:\n"
      "of the second camera, where it is not as `prior`.",
      [](const Matches& matches, const CameraMatrices<0>&, const FocalOptions& options) {
        return EstimateTwoFocals(matches, options);
      });
}

void DefineSeveralTwoViews(nb::module_* module) {
  DefineSeveral(module, "estimate_fundamentals", "Several fundamental matrices in the same matches.",
                [](const Matches& matches, const CameraMatrices<0>&, const ImageOptions& options) {
                  return EstimateFundamentals(matches, options);
                });
  DefineSeveral(
      module, "estimate_essentials", "Several essential matrices in the same matches.",
      [](const Matches& matches, const CameraMatrices<2>& K, const ImageOptions& options) {
        return EstimateEssentials(matches, {K[0], K[1]}, options);
      },
      "K1", "K2");
  DefineSeveral(module, "estimate_homographies", "Several homographies in the same matches.",
                [](const Matches& matches, const CameraMatrices<0>&, const ImageOptions& options) {
                  return EstimateHomographies(matches, options);
                });
}

void DefineOthers(nb::module_* module) {
  DefineScenePoints(module, "estimate_absolute_pose", "[R | t], world-to-camera: points2d ~ K (R points3d + t).",
                    &EstimateAbsolutePose);
  DefineScenePoints(module, "estimate_absolute_poses", "Several poses in the same points.", &EstimateAbsolutePoses);
  DefineClouds(
      module, "estimate_rigid_motion",
      "[R | t]: points2 ≈ R points1 + t, of matches N × 3 of two clouds. max_distance: the greatest distance of "
      "an\ninlier; 0: twice the resolution of points2.",
      &EstimateRigidMotion);
  DefineClouds(module, "estimate_rigid_motions", "Several [R | t] in the same matches: things that move by themselves.",
               &EstimateRigidMotions);
  DefineClouds(module, "estimate_similarity", "[s R | t]: the same with a scale s > 0.", &EstimateSimilarity);
  DefinePoints(module, "estimate_line", "(a, b, c): a x + b y + c = 0 with a² + b² = 1.", &Points2, &EstimateLine);
  DefinePoints(module, "estimate_lines", "Several lines in the same points.", &Points2, &EstimateLines);
  DefinePoints(module, "estimate_plane", "(a, b, c, d): a x + b y + c z + d = 0 with a² + b² + c² = 1.", &Points3,
               &EstimatePlane);
  DefinePoints(module, "estimate_planes", "Several planes in the same points.", &Points3, &EstimatePlanes);
}

void DefineVanishingPoints(nb::module_* module) {
  module->def(
      "estimate_vanishing_points",
      [](const ArrayLike& segments, const OptionalArray& K, const OptionalSize& size, const Real& max_residual_deg,
         const Real& least_value, const Whole& max_iterations, const Truth& use_network,
         const OptionalPath& models_folder, const Whole& seed) {
        const auto rows = Points4(segments, "segments");
        VanishingPointOptions options;
        if (K) options.K = Matrix3(*K, "K");
        options.size = SizeOf(size, "size");
        options.max_residual_deg = RealOf(max_residual_deg, "max_residual_deg");
        options.least_value = RealOf(least_value, "least_value");
        Set(max_iterations, seed, &options);
        SetNetwork(use_network, models_folder, &options);
        return Unlocked([&] { return EstimateVanishingPoints(rows, options); });
      },
      "segments"_a, "K"_a = nb::none(), nb::kw_only(), "size"_a = nb::none(),
      "max_residual_deg"_a = VanishingPointOptions().max_residual_deg,
      "least_value"_a = VanishingPointOptions().least_value, "max_iterations"_a = 0, "use_network"_a = true,
      "models_folder"_a = nb::none(), "seed"_a = 0,
      "The vanishing points of an image's line segments, N × 4: x1 y1 x2 y2, the ends, in pixels; with the focal "
      "length\n"
      "where no K is given, and the horizon. It needs K or size (width, height).");
}

void TranslateError(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Error& error) {
    // By its name here.
    std::string text = error.what();
    constexpr std::string_view kRatios = "match_ratios";
    if (const auto at = text.find(kRatios); at != text.npos) text.replace(at, kRatios.size(), "ratio");
    PyErr_SetString(PyExc_ValueError, text.c_str());
  }
}

}  // namespace
}  // namespace diffsac::python

NB_MODULE(_native, module) {
  using namespace diffsac::python;
  nb::register_exception_translator(TranslateError);
  module.attr("VERSION") = diffsac::kVersion;
  module.def("set_packaged_models", &SetPackagedModels, nb::arg("folder"));
  DefineTwoViews(&module);
  DefineSeveralTwoViews(&module);
  DefineOthers(&module);
  DefineVanishingPoints(&module);
}
