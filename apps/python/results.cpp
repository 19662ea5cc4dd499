#include "results.h"

#include <nanobind/eigen/dense.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include <string_view>
#include <utility>

namespace diffsac::python {
namespace {

nb::object ClassOf(const char* name) { return nb::module_::import_("diffsac._results").attr(name); }

nb::object Make(const char* name, const nb::dict& fields) { return ClassOf(name)(**fields); }

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

nb::object Covariance(const std::optional<Eigen::MatrixXd>& covariance) {
  return covariance ? Array(*covariance) : nb::none();
}

nb::object StatusOf(Status status) { return ClassOf("Status")(ToString(status)); }

nb::object StatsOf(const EstimationStats& stats) {
  nb::dict fields;
  fields["hypotheses"] = stats.hypotheses;
  fields["unique_minimal_sets"] = stats.unique_minimal_sets;
  fields["iterations"] = stats.iterations;
  fields["ms_features"] = stats.ms_features;
  fields["ms_network"] = stats.ms_network;
  fields["ms_consensus"] = stats.ms_consensus;
  fields["ms_total"] = stats.ms_total;
  return Make("EstimationStats", fields);
}

/// Its word, as docs have it.
nb::object DegeneracyOf(Degeneracy degeneracy) { return ClassOf("Degeneracy")(ToString(degeneracy)); }

nb::object ConflictOf(const FocalConflict& conflict) {
  nb::dict fields;
  for (const auto& [name, values] : {std::pair("said_px", conflict.said_px), std::pair("found_px", conflict.found_px),
                                     std::pair("low_px", conflict.low_px), std::pair("high_px", conflict.high_px)})
    fields[name] = std::pair(values[0], values[1]);
  return Make("FocalConflict", fields);
}

nb::object DiagnosticsOf(const Diagnostics& diagnostics) {
  nb::dict fields;
  fields["log10_nfa"] = diagnostics.log10_nfa;
  fields["error_probability"] = diagnostics.error_probability;
  fields["degeneracy"] = DegeneracyOf(diagnostics.degeneracy);
  fields["cheirality_failure_ratio"] = diagnostics.cheirality_failure_ratio;
  fields["mirrored"] = diagnostics.mirrored;
  fields["focal_conflict"] = diagnostics.focal_conflict ? ConflictOf(*diagnostics.focal_conflict) : nb::none();
  fields["scores_ignored"] = diagnostics.scores_ignored;
  fields["num_nonfinite"] = diagnostics.num_nonfinite;
  fields["num_duplicates"] = diagnostics.num_duplicates;
  return Make("Diagnostics", fields);
}

/// Of results without Diagnostics.
template <class Result>
void SetCounts(const Result& estimate, nb::dict* fields) {
  (*fields)["stats"] = StatsOf(estimate.stats);
  (*fields)["num_nonfinite"] = estimate.num_nonfinite;
  (*fields)["num_duplicates"] = estimate.num_duplicates;
}

nb::object PoseOf(const RigidMotion& motion) {
  nb::dict fields;
  fields["rotation"] = Array(motion.rotation);
  fields["translation"] = Array(motion.translation);
  return Make("Pose", fields);
}

nb::object FocalOf(const FocalEstimate& focal) {
  nb::dict fields;
  fields["focal_px"] = std::pair(focal.focal_px[0], focal.focal_px[1]);
  fields["low_px"] = std::pair(focal.low_px[0], focal.low_px[1]);
  fields["high_px"] = std::pair(focal.high_px[0], focal.high_px[1]);
  fields["observable"] = std::pair(focal.observable[0], focal.observable[1]);
  fields["prior_focal_px"] = std::pair(focal.prior_focal_px[0], focal.prior_focal_px[1]);
  fields["prior_log_sigma"] = std::pair(focal.prior_log_sigma[0], focal.prior_log_sigma[1]);
  return Make("Focal", fields);
}

/// From 0, as Python counts.
nb::object PlacesOf(const std::vector<int>& places) { return nb::tuple(Array(VectorOf(places)).attr("tolist")()); }

nb::object VanishingFocalOf(const VanishingFocal& focal) {
  nb::dict fields;
  fields["focal_px"] = focal.focal_px;
  fields["log_sigma"] = focal.log_sigma;
  fields["orthogonal"] = PlacesOf(focal.orthogonal);
  return Make("VanishingFocal", fields);
}

nb::object HorizonOf(const Horizon& horizon) {
  nb::dict fields;
  fields["line"] = Array(horizon.line);
  fields["up"] = Array(horizon.up);
  fields["tilt_deg"] = horizon.TiltDeg();
  fields["pitch_deg"] = horizon.PitchDeg();
  fields["vertical"] = horizon.vertical >= 0 ? nb::cast(horizon.vertical) : nb::none();
  fields["horizontal"] = PlacesOf(horizon.horizontal);
  return Make("Horizon", fields);
}

/// M × 3.
nb::object RowsOf(const std::vector<Eigen::Vector3d>& vectors) {
  Eigen::Matrix<double, Eigen::Dynamic, 3> rows(static_cast<Eigen::Index>(vectors.size()), 3);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) = vectors[static_cast<std::size_t>(i)].transpose();
  return Array(rows);
}

template <class Model>
nb::dict FieldsOf(const ModelEstimate<Model>& estimate) {
  nb::dict fields;
  fields["status"] = StatusOf(estimate.status);
  fields["verdict"] = ClassOf("Verdict")(ToString(estimate.verdict));
  fields["model"] = Array(estimate.model);
  fields["inliers"] = Array(VectorOf(estimate.inliers).template cast<bool>());
  fields["num_inliers"] = estimate.num_inliers;
  fields["inlier_threshold"] = estimate.inlier_threshold;
  fields["sigma"] = estimate.sigma;
  fields["inlier_probabilities"] =
      estimate.inlier_probabilities.empty() ? nb::none() : Array(VectorOf(estimate.inlier_probabilities));
  fields["posteriors"] = Array(VectorOf(estimate.posteriors));
  fields["diagnostics"] = DiagnosticsOf(estimate.diagnostics);
  fields["stats"] = StatsOf(estimate.stats);
  return fields;
}

template <class Model>
nb::dict FieldsOf(const PoseEstimate<Model>& estimate) {
  nb::dict fields = FieldsOf(static_cast<const ModelEstimate<Model>&>(estimate));
  fields["pose"] = estimate.pose ? PoseOf(*estimate.pose) : nb::none();
  fields["pose_covariance"] = Covariance(estimate.pose_covariance);
  fields["ambiguous_pose"] = estimate.ambiguous_pose ? PoseOf(*estimate.ambiguous_pose) : nb::none();
  return fields;
}

nb::dict FieldsOf(const TwoViewEstimate& estimate) {
  nb::dict fields = FieldsOf(static_cast<const PoseEstimate<Eigen::Matrix3d>&>(estimate));
  fields["focal"] = estimate.focal ? FocalOf(*estimate.focal) : nb::none();
  return fields;
}

/// K × rows × columns, or K × rows for vectors.
template <class Model>
PyMultiModelEstimate Several(const MultiModelEstimate<Model>& estimate) {
  constexpr int kRows = Model::RowsAtCompileTime, kColumns = Model::ColsAtCompileTime;
  const auto count = static_cast<Eigen::Index>(estimate.models.size());
  Eigen::Matrix<double, Eigen::Dynamic, kRows * kColumns> models(count, kRows * kColumns);
  for (Eigen::Index k = 0; k < count; ++k)
    for (int i = 0; i < kRows * kColumns; ++i) models(k, i) = estimate.models[k](i / kColumns, i % kColumns);
  const nb::object rows = Array(models);
  nb::dict fields;
  fields["status"] = StatusOf(estimate.status);
  fields["models"] = kColumns == 1 ? rows : rows.attr("reshape")(count, kRows, kColumns);
  fields["assignment"] = Array(VectorOf(estimate.assignment));
  SetCounts(estimate, &fields);
  return nb::borrow<PyMultiModelEstimate>(Make("MultiModelEstimate", fields));
}

}  // namespace

PyEstimate ToPython(const LineEstimate& estimate) {
  return nb::borrow<PyEstimate>(Make("Estimate", FieldsOf(estimate)));
}
PyEstimate ToPython(const PlaneEstimate& estimate) {
  return nb::borrow<PyEstimate>(Make("Estimate", FieldsOf(estimate)));
}

PyTwoViewEstimate ToPython(const TwoViewEstimate& estimate) {
  return nb::borrow<PyTwoViewEstimate>(Make("TwoViewEstimate", FieldsOf(estimate)));
}

PyUnknownFocalEstimate ToPython(const UnknownFocalEstimate& estimate) {
  nb::dict fields = FieldsOf(estimate);
  fields["K1"] = Array(estimate.cameras.K1);
  fields["K2"] = Array(estimate.cameras.K2);
  return nb::borrow<PyUnknownFocalEstimate>(Make("UnknownFocalEstimate", fields));
}

PyAbsolutePoseEstimate ToPython(const AbsolutePoseEstimate& estimate) {
  return nb::borrow<PyAbsolutePoseEstimate>(Make("AbsolutePoseEstimate", FieldsOf(estimate)));
}

PyRigidMotionEstimate ToPython(const RigidMotionEstimate& estimate) {
  return nb::borrow<PyRigidMotionEstimate>(Make("RigidMotionEstimate", FieldsOf(estimate)));
}

PySimilarityEstimate ToPython(const SimilarityEstimate& estimate) {
  nb::dict fields = FieldsOf(estimate);
  fields["scale"] = estimate.scale;
  return nb::borrow<PySimilarityEstimate>(Make("SimilarityEstimate", fields));
}

PyMultiModelEstimate ToPython(const MultiModelEstimate<Eigen::Matrix3d>& estimate) { return Several(estimate); }
PyMultiModelEstimate ToPython(const MultiModelEstimate<Eigen::Matrix<double, 3, 4>>& estimate) {
  return Several(estimate);
}
PyMultiModelEstimate ToPython(const MultiModelEstimate<Eigen::Vector3d>& estimate) { return Several(estimate); }
PyMultiModelEstimate ToPython(const MultiModelEstimate<Eigen::Vector4d>& estimate) { return Several(estimate); }

PyVanishingPointsEstimate ToPython(const VanishingPointsEstimate& estimate) {
  const bool has_directions = estimate.directions.size() == estimate.points.size() && estimate.K;
  nb::dict fields;
  fields["status"] = StatusOf(estimate.status);
  fields["points"] = RowsOf(estimate.points);
  fields["directions"] = has_directions ? RowsOf(estimate.directions) : nb::none();
  fields["values"] = estimate.values.empty() ? nb::none() : Array(VectorOf(estimate.values));
  fields["assignment"] = Array(VectorOf(estimate.assignment));
  fields["K"] = estimate.K ? Array(*estimate.K) : nb::none();
  fields["focal"] = estimate.focal ? VanishingFocalOf(*estimate.focal) : nb::none();
  fields["horizon"] = estimate.horizon ? HorizonOf(*estimate.horizon) : nb::none();
  SetCounts(estimate, &fields);
  return nb::borrow<PyVanishingPointsEstimate>(Make("VanishingPointsEstimate", fields));
}

}  // namespace diffsac::python
