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

nb::object CostOf(const EstimateReport& cost) {
  nb::dict fields;
  fields["hypotheses"] = cost.hypotheses;
  fields["unique_minimal_sets"] = cost.unique_minimal_sets;
  fields["draws"] = cost.draws;
  fields["ms_features"] = cost.ms_features;
  fields["ms_network"] = cost.ms_network;
  fields["ms_consensus"] = cost.ms_consensus;
  fields["ms_total"] = cost.ms_total;
  return Make("Cost", fields);
}

template <class Result>
void SetCounts(const Result& estimate, nb::dict* fields) {
  (*fields)["cost"] = CostOf(estimate.cost);
  (*fields)["rows_left_out"] = estimate.rows_left_out;
  (*fields)["repeated_rows"] = estimate.repeated_rows;
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

nb::object ConflictOf(const FocalConflict& conflict) {
  nb::dict fields;
  for (const auto& [name, values] : {std::pair("said_px", conflict.said_px), std::pair("found_px", conflict.found_px),
                                     std::pair("low_px", conflict.low_px), std::pair("high_px", conflict.high_px)})
    fields[name] = std::pair(values[0], values[1]);
  return Make("FocalConflict", fields);
}

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
  fields["model"] = Array(estimate.model);
  fields["inliers"] = Array(VectorOf(estimate.inliers).template cast<bool>());
  fields["num_inliers"] = estimate.num_inliers;
  fields["inlier_threshold"] = estimate.inlier_threshold;
  fields["noise_scale"] = estimate.noise_scale;
  fields["log_false_alarms"] = estimate.log_false_alarms;
  fields["inlier_probabilities"] =
      estimate.inlier_probabilities.empty() ? nb::none() : Array(VectorOf(estimate.inlier_probabilities));
  fields["posteriors"] = Array(VectorOf(estimate.posteriors));
  fields["scores_ignored"] = estimate.scores_ignored;
  SetCounts(estimate, &fields);
  return fields;
}

nb::dict TwoViewFieldsOf(const TwoViewEstimate& estimate) {
  nb::dict fields = FieldsOf(estimate);
  fields["pose"] = estimate.pose ? PoseOf(*estimate.pose) : nb::none();
  fields["pose_covariance"] = Covariance(estimate.pose_covariance);
  fields["translation"] = ClassOf("Translation")(ToString(estimate.translation));
  fields["mirrored"] = estimate.mirrored;
  fields["error_probability"] = estimate.error_probability;
  fields["focal_conflict"] = estimate.focal_conflict ? ConflictOf(*estimate.focal_conflict) : nb::none();
  fields["share_behind"] = estimate.share_behind;
  fields["other_pose"] = estimate.other_pose ? PoseOf(*estimate.other_pose) : nb::none();
  return fields;
}

/// K × rows × columns, or K × rows for vectors.
template <class Model>
PyEstimates Several(const ModelsEstimate<Model>& estimate) {
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
  return nb::borrow<PyEstimates>(Make("Estimates", fields));
}

}  // namespace

PyEstimate ToPython(const LineEstimate& estimate) {
  return nb::borrow<PyEstimate>(Make("Estimate", FieldsOf(estimate)));
}
PyEstimate ToPython(const PlaneEstimate& estimate) {
  return nb::borrow<PyEstimate>(Make("Estimate", FieldsOf(estimate)));
}

PyTwoViewEstimate ToPython(const TwoViewEstimate& estimate) {
  return nb::borrow<PyTwoViewEstimate>(Make("TwoViewEstimate", TwoViewFieldsOf(estimate)));
}

PySharedFocalEstimate ToPython(const SharedFocalEstimate& estimate) {
  nb::dict fields = TwoViewFieldsOf(estimate);
  fields["focal"] = estimate.focal ? FocalOf(*estimate.focal) : nb::none();
  fields["K1"] = Array(estimate.cameras.K1);
  fields["K2"] = Array(estimate.cameras.K2);
  return nb::borrow<PySharedFocalEstimate>(Make("SharedFocalEstimate", fields));
}

PyAbsolutePoseEstimate ToPython(const AbsolutePoseEstimate& estimate) {
  nb::dict fields = FieldsOf(estimate);
  fields["pose"] = PoseOf(estimate.pose);
  fields["pose_covariance"] = Covariance(estimate.pose_covariance);
  fields["share_behind"] = estimate.share_behind;
  fields["other_pose"] = estimate.other_pose ? PoseOf(*estimate.other_pose) : nb::none();
  return nb::borrow<PyAbsolutePoseEstimate>(Make("AbsolutePoseEstimate", fields));
}

PyRigidMotionEstimate ToPython(const RigidMotionEstimate& estimate) {
  nb::dict fields = FieldsOf(estimate);
  fields["motion"] = PoseOf(estimate.motion);
  fields["covariance"] = Covariance(estimate.covariance);
  fields["other_motion"] = estimate.other_motion ? PoseOf(*estimate.other_motion) : nb::none();
  return nb::borrow<PyRigidMotionEstimate>(Make("RigidMotionEstimate", fields));
}

PySimilarityEstimate ToPython(const SimilarityEstimate& estimate) {
  nb::dict fields = FieldsOf(estimate);
  fields["scale"] = estimate.scale;
  fields["motion"] = PoseOf(estimate.motion);
  fields["covariance"] = Covariance(estimate.covariance);
  return nb::borrow<PySimilarityEstimate>(Make("SimilarityEstimate", fields));
}

PyEstimates ToPython(const ModelsEstimate<Eigen::Matrix3d>& estimate) { return Several(estimate); }
PyEstimates ToPython(const ModelsEstimate<Eigen::Matrix<double, 3, 4>>& estimate) { return Several(estimate); }
PyEstimates ToPython(const ModelsEstimate<Eigen::Vector3d>& estimate) { return Several(estimate); }
PyEstimates ToPython(const ModelsEstimate<Eigen::Vector4d>& estimate) { return Several(estimate); }

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
