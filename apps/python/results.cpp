#include "results.h"

#include <nanobind/eigen/dense.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include <array>
#include <optional>
#include <string_view>
#include <utility>

namespace diffsac::python {
namespace {

using namespace nanobind::literals;

nb::object ClassOf(const char* name) { return nb::module_::import_("diffsac._results").attr(name); }

/// One of the classes of diffsac/_results.py, of its fields by name.
template <class... Fields>
nb::object Make(const char* name, Fields&&... fields) {
  return ClassOf(name)(std::forward<Fields>(fields)...);
}
template <class Result, class... Fields>
Result MakeResult(Fields&&... fields) {
  return nb::borrow<Result>(Make(Result::kClass, std::forward<Fields>(fields)...));
}

template <class... Fields>
nb::dict Dict(Fields&&... fields) {
  return nb::borrow<nb::dict>(nb::handle(reinterpret_cast<PyObject*>(&PyDict_Type))(std::forward<Fields>(fields)...));
}

/// An array that owns its numbers, row by row as numpy has them.
template <class Derived>
nb::object Array(const Eigen::MatrixBase<Derived>& matrix) {
  constexpr auto kOrder = Derived::ColsAtCompileTime == 1 ? Eigen::ColMajor : Eigen::RowMajor;
  return nb::cast(
      Eigen::Matrix<typename Derived::Scalar, Derived::RowsAtCompileTime, Derived::ColsAtCompileTime, kOrder>(matrix));
}

template <class Value>
auto VectorOf(const std::vector<Value>& values) {
  return Eigen::Map<const Eigen::Matrix<Value, Eigen::Dynamic, 1>>(values.data(),
                                                                   static_cast<Eigen::Index>(values.size()));
}

/// None where there is no value.
template <class Value, class Convert>
nb::object Optional(const std::optional<Value>& value, const Convert& convert) {
  return value ? nb::object(convert(*value)) : nb::none();
}

template <class Value>
std::pair<Value, Value> Two(const std::array<Value, 2>& values) {
  return {values[0], values[1]};
}

nb::object StatsOf(const EstimationStats& stats) {
  return Make("EstimationStats", "hypotheses"_a = stats.hypotheses, "unique_minimal_sets"_a = stats.unique_minimal_sets,
              "iterations"_a = stats.iterations, "ms_features"_a = stats.ms_features, "ms_network"_a = stats.ms_network,
              "ms_consensus"_a = stats.ms_consensus, "ms_total"_a = stats.ms_total);
}

nb::object ConflictOf(const FocalConflict& conflict) {
  return Make("FocalConflict", "said_px"_a = Two(conflict.said_px), "found_px"_a = Two(conflict.found_px),
              "low_px"_a = Two(conflict.low_px), "high_px"_a = Two(conflict.high_px));
}

nb::object DiagnosticsOf(const Diagnostics& diagnostics) {
  return Make("Diagnostics", "log10_nfa"_a = diagnostics.log10_nfa,
              "error_probability"_a = diagnostics.error_probability,
              "degeneracy"_a = ClassOf("Degeneracy")(ToString(diagnostics.degeneracy)),
              "cheirality_failure_ratio"_a = diagnostics.cheirality_failure_ratio, "mirrored"_a = diagnostics.mirrored,
              "focal_conflict"_a = Optional(diagnostics.focal_conflict, ConflictOf),
              "scores_ignored"_a = diagnostics.scores_ignored, "num_nonfinite"_a = diagnostics.num_nonfinite,
              "num_duplicates"_a = diagnostics.num_duplicates);
}

/// What all results without Diagnostics have.
template <class Result>
nb::dict CountsOf(const Result& estimate) {
  return Dict("status"_a = ClassOf("Status")(ToString(estimate.status)),
              "assignment"_a = Array(VectorOf(estimate.assignment)), "stats"_a = StatsOf(estimate.stats),
              "num_nonfinite"_a = estimate.num_nonfinite, "num_duplicates"_a = estimate.num_duplicates);
}

nb::object PoseOf(const RigidMotion& motion) {
  return Make("Pose", "rotation"_a = Array(motion.rotation), "translation"_a = Array(motion.translation));
}

nb::object FocalOf(const FocalEstimate& focal) {
  return Make("Focal", "focal_px"_a = Two(focal.focal_px), "low_px"_a = Two(focal.low_px),
              "high_px"_a = Two(focal.high_px), "observable"_a = Two(focal.observable),
              "prior_focal_px"_a = Two(focal.prior_focal_px), "prior_log_sigma"_a = Two(focal.prior_log_sigma));
}

/// From 0, as Python counts.
nb::object PlacesOf(const std::vector<int>& places) { return nb::tuple(Array(VectorOf(places)).attr("tolist")()); }

nb::object VanishingFocalOf(const VanishingFocal& focal) {
  return Make("VanishingFocal", "focal_px"_a = focal.focal_px, "log_sigma"_a = focal.log_sigma,
              "orthogonal"_a = PlacesOf(focal.orthogonal));
}

nb::object HorizonOf(const Horizon& horizon) {
  return Make("Horizon", "line"_a = Array(horizon.line), "up"_a = Array(horizon.up), "tilt_deg"_a = horizon.TiltDeg(),
              "pitch_deg"_a = horizon.PitchDeg(),
              "vertical"_a = horizon.vertical >= 0 ? nb::cast(horizon.vertical) : nb::none(),
              "horizontal"_a = PlacesOf(horizon.horizontal));
}

/// M × 3.
nb::object RowsOf(const std::vector<Eigen::Vector3d>& vectors) {
  Eigen::Matrix<double, Eigen::Dynamic, 3> rows(static_cast<Eigen::Index>(vectors.size()), 3);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) = vectors[static_cast<std::size_t>(i)].transpose();
  return Array(rows);
}

template <class Model>
nb::dict FieldsOf(const ModelEstimate<Model>& estimate) {
  const auto& probabilities = estimate.inlier_probabilities;
  return Dict("status"_a = ClassOf("Status")(ToString(estimate.status)),
              "verdict"_a = ClassOf("Verdict")(ToString(estimate.verdict)), "model"_a = Array(estimate.model),
              "inliers"_a = Array(VectorOf(estimate.inliers).template cast<bool>()),
              "num_inliers"_a = estimate.num_inliers, "inlier_threshold"_a = estimate.inlier_threshold,
              "sigma"_a = estimate.sigma,
              "inlier_probabilities"_a = probabilities.empty() ? nb::none() : Array(VectorOf(probabilities)),
              "posteriors"_a = Array(VectorOf(estimate.posteriors)),
              "diagnostics"_a = DiagnosticsOf(estimate.diagnostics), "stats"_a = StatsOf(estimate.stats));
}

template <class Model>
nb::dict FieldsOf(const PoseEstimate<Model>& estimate) {
  return Dict(**FieldsOf(static_cast<const ModelEstimate<Model>&>(estimate)),
              "pose"_a = Optional(estimate.pose, PoseOf),
              "pose_covariance"_a = Optional(estimate.pose_covariance, Array<Eigen::MatrixXd>),
              "ambiguous_pose"_a = Optional(estimate.ambiguous_pose, PoseOf));
}

nb::dict FieldsOf(const TwoViewEstimate& estimate) {
  return Dict(**FieldsOf(static_cast<const PoseEstimate<Eigen::Matrix3d>&>(estimate)),
              "focal"_a = Optional(estimate.focal, FocalOf));
}

}  // namespace

/// K × rows × columns, or K × rows for vectors.
template <class Model>
PyMultiModelEstimate ToPython(const MultiModelEstimate<Model>& estimate) {
  constexpr int kRows = Model::RowsAtCompileTime, kColumns = Model::ColsAtCompileTime;
  const auto count = static_cast<Eigen::Index>(estimate.models.size());
  Eigen::Matrix<double, Eigen::Dynamic, kRows * kColumns> models(count, kRows * kColumns);
  for (Eigen::Index k = 0; k < count; ++k)
    models.row(k) = estimate.models[k].template reshaped<Eigen::RowMajor>().transpose();
  const nb::object rows = Array(models);
  return MakeResult<PyMultiModelEstimate>(
      "models"_a = kColumns == 1 ? rows : rows.attr("reshape")(count, kRows, kColumns), **CountsOf(estimate));
}
template PyMultiModelEstimate ToPython(const MultiModelEstimate<Eigen::Matrix3d>& estimate);
template PyMultiModelEstimate ToPython(const MultiModelEstimate<Eigen::Matrix<double, 3, 4>>& estimate);
template PyMultiModelEstimate ToPython(const MultiModelEstimate<Eigen::Vector3d>& estimate);
template PyMultiModelEstimate ToPython(const MultiModelEstimate<Eigen::Vector4d>& estimate);

PyEstimate ToPython(const LineEstimate& estimate) { return MakeResult<PyEstimate>(**FieldsOf(estimate)); }
PyEstimate ToPython(const PlaneEstimate& estimate) { return MakeResult<PyEstimate>(**FieldsOf(estimate)); }
PyTwoViewEstimate ToPython(const TwoViewEstimate& estimate) {
  return MakeResult<PyTwoViewEstimate>(**FieldsOf(estimate));
}
PyUnknownFocalEstimate ToPython(const UnknownFocalEstimate& estimate) {
  return MakeResult<PyUnknownFocalEstimate>(**FieldsOf(estimate), "K1"_a = Array(estimate.cameras.K1),
                                            "K2"_a = Array(estimate.cameras.K2));
}
PyAbsolutePoseEstimate ToPython(const AbsolutePoseEstimate& estimate) {
  return MakeResult<PyAbsolutePoseEstimate>(**FieldsOf(estimate));
}
PyRigidMotionEstimate ToPython(const RigidMotionEstimate& estimate) {
  return MakeResult<PyRigidMotionEstimate>(**FieldsOf(estimate));
}
PySimilarityEstimate ToPython(const SimilarityEstimate& estimate) {
  return MakeResult<PySimilarityEstimate>(**FieldsOf(estimate), "scale"_a = estimate.scale);
}

PyVanishingPointsEstimate ToPython(const VanishingPointsEstimate& estimate) {
  const bool has_directions = estimate.directions.size() == estimate.points.size() && estimate.K;
  return MakeResult<PyVanishingPointsEstimate>(
      "points"_a = RowsOf(estimate.points), "directions"_a = has_directions ? RowsOf(estimate.directions) : nb::none(),
      "values"_a = estimate.values.empty() ? nb::none() : Array(VectorOf(estimate.values)),
      "K"_a = Optional(estimate.K, Array<Eigen::Matrix3d>), "focal"_a = Optional(estimate.focal, VanishingFocalOf),
      "horizon"_a = Optional(estimate.horizon, HorizonOf), **CountsOf(estimate));
}

}  // namespace diffsac::python
