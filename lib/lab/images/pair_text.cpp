#include "lab/images/pair_text.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diffsac/estimate/diagnose.h"
#include "diffsac/problem/tasks.h"
#include "lab/eval/estimates.h"
#include "lab/eval/format.h"
#include "lab/images/photograph_cameras.h"

namespace diffsac {
namespace {

using Json = nlohmann::ordered_json;

/// "  F = " and below it two more lines of three numbers.
std::string MatrixText(const std::string& name, const double* row_by_row) {
  std::string text;
  for (int r = 0; r < 3; ++r) {
    text += r == 0 ? "  " + name + " = " : std::string(name.size() + 5, ' ');
    for (int c = 0; c < 3; ++c) text += Format(" %14.7g", row_by_row[3 * r + c]);
    text += "\n";
  }
  return text;
}

/// The largest standard deviation of any direction, in degrees; `first`: of a block of three of radians.
double SpreadDegrees(const Eigen::MatrixXd& covariance, int first) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance.block<3, 3>(first, first));
  return std::sqrt(std::max(0.0, solver.eigenvalues()[2])) * 180.0 / std::numbers::pi;
}

/// With a digit behind the point, unless that would be a long number.
std::string PixelText(double value) { return Format(std::abs(value) < 1e7 ? "%.1f" : "%.4g", value); }

FocalSource SourceOf(const Problem& problem, const std::optional<FocalEstimate>& focal, int image) {
  const CameraPriorHint& hint = image == 0 ? problem.camera_prior1 : problem.camera_prior2;
  return SourceOfFocal(problem, focal, image, hint.focal ? FocalSource::kExif : FocalSource::kPrior);
}

std::string FocalText(const Problem& problem, const FocalEstimate& focal) {
  const auto text = [&](const std::string& name, int image) {
    return "  " + name + " = " + PixelText(focal.focal_px[image]) + " px, 68 % within " +
           PixelText(focal.low_px[image]) + " and " + PixelText(focal.high_px[image]) +
           (focal.observable[image]                                 ? "\n"
            : SourceOf(problem, focal, image) == FocalSource::kExif ? ": not observable, EXIF's\n"
                                                                    : ": not observable, the prior's\n");
  };
  const bool shared = focal.focal_px[0] == focal.focal_px[1];
  return shared ? text("f", 0) : text("f1", 0) + text("f2", 1);
}

std::string ConflictText(const FocalConflict& conflict) {
  const bool one = conflict.said_px[0] == conflict.said_px[1] && conflict.found_px[0] == conflict.found_px[1];
  const auto both = [&](const std::array<double, 2>& values) {
    return PixelText(values[0]) + (one ? "" : " and " + PixelText(values[1]));
  };
  return "  the matches contradict what is known of the focal length: " + both(conflict.said_px) + " px by that, " +
         both(conflict.found_px) + " px (68 % from " + both(conflict.low_px) + " to " + both(conflict.high_px) +
         ") by the matches: another zoom, size, unit or crop; R and t may be wrong\n";
}

std::string PoseText(const RigidMotion& pose) {
  return RotationText(pose.rotation) + Format("  t =  (%.6f, %.6f, %.6f), of unknown length; x2 = R x1 + t\n",
                                              pose.translation[0], pose.translation[1], pose.translation[2]);
}

std::string SpreadText(const Eigen::MatrixXd& covariance, const std::string& of_translation) {
  return Format("  standard deviations by noise alone: R %.2g degrees, t ", SpreadDegrees(covariance, 0)) +
         of_translation + "\n";
}

}  // namespace

std::string RotationText(const Eigen::Matrix3d& r) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation = r;
  const Eigen::AngleAxisd turn(r);
  return MatrixText("R", rotation.data()) + Format("  turned by %.3f degrees about (%.4f, %.4f, %.4f)\n",
                                                   turn.angle() * 180.0 / std::numbers::pi, turn.axis()[0],
                                                   turn.axis()[1], turn.axis()[2]);
}

std::string PoseSpreadText(const Eigen::MatrixXd& covariance) {
  return SpreadText(covariance, Format("%.2g", SpreadDegrees(covariance, 3) * std::numbers::pi / 180.0));
}

namespace {

/// Of a camera in a known scene.
std::string ScenePoseText(const Problem& problem, const Estimate& estimate) {
  const auto text = [](const RigidMotion& pose) {
    const auto three = [](const Eigen::Vector3d& v) { return Format("(%.7g, %.7g, %.7g)", v[0], v[1], v[2]); };
    return RotationText(pose.rotation) + "  t =  " + three(pose.translation) +
           ", in the scene's unit; x ~ K (R X + t)\n" + "  the camera is at " +
           three(-pose.rotation.transpose() * pose.translation) + "\n";
  };
  std::string all;
  if (const auto pose = PoseOfEstimate(estimate, problem)) all += text(*pose);
  if (const auto& covariance = estimate.pose_covariance) all += PoseSpreadText(*covariance);
  if (estimate.ambiguous_pose)
    all += "  the points lie on one plane, and this pose explains them as well:\n" + text(*estimate.ambiguous_pose);
  return all;
}

/// Of motions with a translation: the pose, how sure it is, and the other one of a plane; or that there is none.
std::string MotionText(const Problem& problem, const Estimate& estimate) {
  if (problem.task == Task::kAbsolutePose) return ScenePoseText(problem, estimate);
  if (problem.task == Task::kHomography && !problem.cameras)
    return "  no pose: that of a homography needs --calibration, --cameras or --focal\n";
  const auto pose = PoseOfEstimate(estimate, problem);
  if (!pose || pose->translation.isZero(0.0)) return "";
  std::string text = PoseText(*pose);
  if (const auto& covariance = estimate.pose_covariance)
    text += SpreadText(*covariance, Format("%.2g degrees", SpreadDegrees(*covariance, 3)));
  if (estimate.ambiguous_pose)
    text += "  this motion explains the matches as well (a plane, or a zoom):\n" + PoseText(*estimate.ambiguous_pose);
  const auto guessed = [&](int image) {
    return !estimate.focal->observable[image] && SourceOf(problem, estimate.focal, image) == FocalSource::kPrior;
  };
  if (estimate.focal && (guessed(0) || guessed(1)))
    text += "  R and t are no better than the focal length, which is a guess: --focal or --calibration tells it\n";
  return text;
}

std::string TimesText(const PairTimes& times, const EstimationStats& report) {
  std::string text = Format("milliseconds: keypoints %.3g, matching %.3g", times.keypoints, times.matching);
  if (report.ms_features > 0.0) text += Format(", features %.3g", report.ms_features);
  if (report.ms_network > 0.0) text += Format(", network %.3g", report.ms_network);
  text += Format(", consensus %.3g; estimate in all %.3g", report.ms_consensus, report.ms_total);
  return text + "\n";
}

std::string LetterOf(Task task) {
  const std::string name = ToString(task);
  return name == "homography" ? "H" : name == "fundamental" ? "F" : "E";
}

std::string NameOf(const Problem& problem) {
  const std::string name = ToString(problem.task);
  if (name == "shared_focal") return "essential matrix and focal length";
  if (name == "absolute_pose") return "absolute pose";
  return name == "two_focals" ? "essential matrix and two focal lengths" : name + " matrix";
}

std::size_t InlierCount(const Estimate& estimate) {
  return static_cast<std::size_t>(std::count(estimate.inliers.begin(), estimate.inliers.end(), 1));
}

/// ", 3 repeated, 2 not finite".
std::string UnusedText(const Estimate& estimate) {
  std::string text;
  if (estimate.num_duplicates > 0) text += ", " + std::to_string(estimate.num_duplicates) + " repeated";
  if (estimate.num_nonfinite > 0) text += ", " + std::to_string(estimate.num_nonfinite) + " not finite";
  if (estimate.scores_ignored) text += kScoresIgnored;
  return text;
}

Json FiniteJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json MatrixJson(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    rows.push_back(Json::array());
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) rows.back().push_back(matrix(r, c));
  }
  return rows;
}

Json FocalJson(const Problem& problem, const FocalEstimate& focal) {
  return {{"px", focal.focal_px},
          {"low_px", focal.low_px},
          {"high_px", focal.high_px},
          {"observable", focal.observable},
          {"prior_px", focal.prior_focal_px},
          {"prior_log_sigma", focal.prior_log_sigma},
          {"source", {ToString(SourceOf(problem, focal, 0)), ToString(SourceOf(problem, focal, 1))}}};
}

Json ConflictJson(const std::optional<FocalConflict>& conflict) {
  if (!conflict) return nullptr;
  return {{"said_px", conflict->said_px},
          {"found_px", conflict->found_px},
          {"low_px", conflict->low_px},
          {"high_px", conflict->high_px}};
}

Json SizeJson(const ImageSize& size) { return size.known() ? Json({size.width, size.height}) : Json(nullptr); }

/// Of the calibration; where the focal length is looked for, the image's middle.
Json PrincipalPointJson(const Problem& problem, const ImageSize& size, Eigen::Matrix3d CameraPair::*K) {
  if (problem.cameras) return {((*problem.cameras).*K)(0, 2), ((*problem.cameras).*K)(1, 2)};
  if (!FindsFocals(problem.task) || !size.known()) return nullptr;
  return {0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

bool HasRatioOrScore(const Problem& problem) { return problem.snn_ratio.size() == problem.points.rows(); }
double RatioOrScore(const Problem& problem, Eigen::Index match) {
  return problem.scored ? 1.0 - problem.snn_ratio[match] : problem.snn_ratio[match];
}

/// x1 y1 x2 y2 of each match, to a ten thousandth of a pixel, and its ratio or score where that is known.
Json CorrespondencesJson(const Problem& problem) {
  const auto rounded = [](double value) { return FiniteJson(std::round(1e4 * value) / 1e4); };
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < problem.points.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index c = 0; c < problem.points.cols(); ++c) row.push_back(rounded(problem.points(i, c)));
    if (HasRatioOrScore(problem)) row.push_back(rounded(RatioOrScore(problem, i)));
    rows.push_back(std::move(row));
  }
  return rows;
}

/// t is null where it is not determined.
Json PoseJson(const std::optional<RigidMotion>& pose) {
  if (!pose) return nullptr;
  const Eigen::Vector3d& t = pose->translation;
  return {{"R", MatrixJson(pose->rotation)}, {"t", t.isZero(0.0) ? Json(nullptr) : Json({t[0], t[1], t[2]})}};
}

}  // namespace

std::string PairText(const Example& pair, const Estimate& estimate, const PairTimes& times) {
  const std::size_t inliers = InlierCount(estimate);
  const auto matches = static_cast<std::size_t>(pair.problem.points.rows());
  std::string text = pair.id + ": " + std::to_string(matches) +
                     (pair.problem.task == Task::kAbsolutePose ? " points" : " matches") + UnusedText(estimate) + "\n";
  if (estimate.status != Status::kOk)
    return text + "no " + NameOf(pair.problem) + ": " + std::string(ToString(estimate.status)) + "\n" +
           TimesText(times, estimate.stats);
  text += NameOf(pair.problem) + ": " + std::to_string(inliers) + " inliers";
  if (matches > 0) text += Format(" (%.0f %%)", 100.0 * static_cast<double>(inliers) / static_cast<double>(matches));
  if (std::isfinite(estimate.sigma)) text += Format(", noise %.2g px", estimate.sigma);
  text += "\n";
  if (estimate.mirrored)
    text += "  the matches fit the mirror image of the second photograph: one of the two is mirrored\n";
  if (estimate.focal_conflict) text += ConflictText(*estimate.focal_conflict);
  if (!estimate.MayBeChance() && estimate.error_probability > kLikelyWrong)
    text += Format("  may be wrong: of results like this %.0f %% are off by more than 10 degrees\n",
                   100.0 * estimate.error_probability);
  const bool determined = !IsUndetermined(estimate.degeneracy);
  // Digits of what is anything would be taken for what they are not. A turn's homography is determined.
  const bool of_turn = pair.problem.task == Task::kHomography && estimate.pure_rotation;
  if ((determined && IsTwoView(pair.problem.task)) || of_turn)
    text += MatrixText(LetterOf(pair.problem.task), estimate.model.data());
  if (estimate.focal) text += FocalText(pair.problem, *estimate.focal);
  if (!determined) {
    if (estimate.degeneracy == Degeneracy::kPureRotation && estimate.pure_rotation)
      text += RotationText(*estimate.pure_rotation);
    text += "  " + UndeterminedText(estimate.degeneracy, pair.problem.task) + "\n";
  }
  return text + MotionText(pair.problem, estimate) + TimesText(times, estimate.stats);
}

std::string UndeterminedText(Degeneracy translation, Task task) {
  const std::string letter = LetterOf(task), without = (letter == "F" ? letter : "t") + " is not determined: ";
  switch (translation) {
    case Degeneracy::kPureRotation:
      return "t is not determined: the camera only turned";
    case Degeneracy::kStatic:
      return without + "the images show no motion";
    case Degeneracy::kPlane:
      return without + "the matches lie on one plane, or the camera only turned";
    case Degeneracy::kLine:
      return (letter == "E" ? "t" : letter) + " is not determined: the matches lie on one line";
    case Degeneracy::kNotTested:
    case Degeneracy::kDetermined:
      break;
  }
  return "";
}

std::string MatchesText(const Problem& problem) {
  const bool has_similarity = problem.scale_rotation_changes.rows() == problem.points.rows();
  std::string text;
  if (problem.scored) text = std::string("x1 y1 x2 y2 score") + (has_similarity ? " log_size angle\n" : "\n");
  for (Eigen::Index i = 0; i < problem.points.rows(); ++i) {
    const double* match = problem.points.row(i).data();
    text += Format("%.17g %.17g %.17g %.17g", match[0], match[1], match[2], match[3]);
    text += Format(" %.17g", HasRatioOrScore(problem) ? RatioOrScore(problem, i) : 1.0);
    if (has_similarity)
      text += Format(" %.17g %.17g", problem.scale_rotation_changes(i, 0), problem.scale_rotation_changes(i, 1));
    text += "\n";
  }
  return text;
}

std::string PairJson(const Example& pair, const Estimate& estimate, const PairTimes& times, const PairRun& run) {
  const EstimateRecord record = RecordOf(pair, estimate);
  const EstimationStats& report = estimate.stats;
  Json model = Json::array();
  for (Eigen::Index i = 0; i < record.model.size(); ++i) model.push_back(record.model[i]);
  const std::optional<CameraPair>& cameras = pair.problem.cameras;
  const Json json = {{"pair", pair.id},
                     {"image1", run.image1},
                     {"image2", run.image2},
                     {"method", run.method},
                     {"seed", run.seed},
                     {"size1", SizeJson(pair.problem.size1)},
                     {"size2", SizeJson(pair.problem.size2)},
                     {"principal_point1", PrincipalPointJson(pair.problem, pair.problem.size1, &CameraPair::K1)},
                     {"principal_point2", PrincipalPointJson(pair.problem, pair.problem.size2, &CameraPair::K2)},
                     {"K1", cameras ? MatrixJson(cameras->K1) : Json(nullptr)},
                     {"K2", cameras ? MatrixJson(cameras->K2) : Json(nullptr)},
                     {"task", ToString(pair.problem.task)},
                     {"status", std::string(ToString(record.status))},
                     {"may_be_chance", estimate.MayBeChance()},
                     {"log10_nfa", FiniteJson(record.log10_nfa)},
                     {"mirrored", estimate.mirrored},
                     {"error_probability", FiniteJson(estimate.error_probability)},
                     {"model", model},
                     {"pose", PoseJson(record.pose)},
                     {"ambiguous_pose", PoseJson(record.ambiguous_pose)},
                     {"degeneracy", ToString(record.degeneracy)},
                     {"pose_covariance", record.pose_covariance ? MatrixJson(*record.pose_covariance) : Json(nullptr)},
                     {"cheirality_failure_ratio", record.cheirality_failure_ratio},
                     {"focal_conflict", ConflictJson(estimate.focal_conflict)},
                     {"focal", record.focal ? FocalJson(pair.problem, *record.focal) : Json(nullptr)},
                     {"matches", record.points},
                     {"inliers", record.inlier_rows},
                     {"num_nonfinite", estimate.num_nonfinite},
                     {"num_duplicates", estimate.num_duplicates},
                     {"scores_ignored", estimate.scores_ignored},
                     {"sigma_px", FiniteJson(record.sigma)},
                     {"ms",
                      {{"keypoints", times.keypoints},
                       {"matching", times.matching},
                       {"features", report.ms_features},
                       {"network", report.ms_network},
                       {"consensus", report.ms_consensus},
                       {"estimate", report.ms_total}}},
                     {"correspondences", CorrespondencesJson(pair.problem)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace diffsac
