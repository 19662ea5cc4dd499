#include "lab/images/pair_text.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/eval/format.h"

namespace diffsac {
namespace {

/// "  F = " and below it two more lines of three numbers.
std::string MatrixText(const std::string& name, const Eigen::Matrix3d& matrix) {
  std::string text;
  for (int r = 0; r < 3; ++r) {
    text += r == 0 ? "  " + name + " = " : std::string(name.size() + 5, ' ');
    for (int c = 0; c < 3; ++c) text += Format(" %14.7g", matrix(r, c));
    text += "\n";
  }
  return text;
}

/// The largest standard deviation of any direction; `first`: of a block of three.
double Spread(const Eigen::MatrixXd& covariance, int first) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance.block<3, 3>(first, first));
  return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
}

double Degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

/// With a digit behind the point, unless that would be a long number.
std::string PixelText(double value) { return Format(std::abs(value) < 1e7 ? "%.1f" : "%.4g", value); }

std::string FocalText(const PairEstimate& estimate) {
  const FocalEstimate& focal = *estimate.focal;
  const auto text = [&](const std::string& name, int image) {
    return "  " + name + " = " + PixelText(focal.focal_px[image]) + " px, 68 % within " +
           PixelText(focal.low_px[image]) + " and " + PixelText(focal.high_px[image]) +
           (focal.observable[image]                            ? "\n"
            : estimate.focal_from[image] == FocalSource::kExif ? ": not observable, EXIF's\n"
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

std::string RotationText(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return MatrixText("R", rotation) + Format("  turned by %.3f degrees about (%.4f, %.4f, %.4f)\n",
                                            Degrees(turn.angle()), turn.axis()[0], turn.axis()[1], turn.axis()[2]);
}

std::string SpreadText(const Eigen::MatrixXd& covariance, bool of_scene) {
  const double t = Spread(covariance, 3);
  return Format("  standard deviations by noise alone: R %.2g degrees, t ", Degrees(Spread(covariance, 0))) +
         (of_scene ? Format("%.2g\n", t) : Format("%.2g degrees\n", Degrees(t)));
}

/// Of two views, or of a camera in a known scene.
std::string PoseText(const RigidMotion& pose, bool of_scene) {
  const Eigen::Vector3d &t = pose.translation, place = -pose.rotation.transpose() * t;
  const auto three = [](const Eigen::Vector3d& v) { return Format("(%.7g, %.7g, %.7g)", v[0], v[1], v[2]); };
  return RotationText(pose.rotation) +
         (of_scene ? "  t =  " + three(t) + ", in the scene's unit; x ~ K (R X + t)\n  the camera is at " +
                         three(place) + "\n"
                   : Format("  t =  (%.6f, %.6f, %.6f), of unknown length; x2 = R x1 + t\n", t[0], t[1], t[2]));
}

/// The pose, how sure it is, and the other one of a plane; or why there is none.
std::string MotionText(const ImagePair& pair) {
  const PairEstimate& estimate = pair.estimate;
  const Task task = pair.example.problem.task;
  const bool of_scene = task == Task::kAbsolutePose;
  if (task == Task::kHomography && !pair.example.problem.cameras)
    return "  no pose: that of a homography needs --calibration, --cameras or --focal\n";
  if (!estimate.pose || estimate.pose->translation.isZero(0.0)) return "";
  std::string text = PoseText(*estimate.pose, of_scene);
  if (estimate.pose_covariance) text += SpreadText(*estimate.pose_covariance, of_scene);
  if (estimate.ambiguous_pose)
    text += std::string(of_scene ? "  the points lie on one plane, and this pose explains them as well:\n"
                                 : "  this motion explains the matches as well (a plane, or a zoom):\n") +
            PoseText(*estimate.ambiguous_pose, of_scene);
  if (estimate.IsGuess(0) || estimate.IsGuess(1))
    text += "  R and t are no better than the focal length, which is a guess: --focal or --calibration tells it\n";
  return text;
}

std::string TimesText(const ImagePair& pair) {
  const EstimationStats& stats = pair.estimate.stats;
  std::string text = Format("milliseconds: keypoints %.3g, matching %.3g", pair.ms_keypoints, pair.ms_matching);
  if (stats.ms_features > 0.0) text += Format(", features %.3g", stats.ms_features);
  if (stats.ms_network > 0.0) text += Format(", network %.3g", stats.ms_network);
  return text + Format(", consensus %.3g; estimate in all %.3g\n", stats.ms_consensus, stats.ms_total);
}

std::string LetterOf(Task task) { return task == Task::kHomography ? "H" : task == Task::kFundamental ? "F" : "E"; }

std::string NameOf(Task task) {
  if (task == Task::kSharedFocal) return "essential matrix and focal length";
  if (task == Task::kTwoFocals) return "essential matrix and two focal lengths";
  return task == Task::kAbsolutePose ? "absolute pose" : ToString(task) + " matrix";
}

/// ", 3 repeated, 2 not finite".
std::string UnusedText(const Diagnostics& diagnostics) {
  std::string text;
  if (diagnostics.num_duplicates > 0) text += ", " + std::to_string(diagnostics.num_duplicates) + " repeated";
  if (diagnostics.num_nonfinite > 0) text += ", " + std::to_string(diagnostics.num_nonfinite) + " not finite";
  if (diagnostics.scores_ignored) text += ", their ratios or scores not used";
  return text;
}

/// Of what the matches leave open, why.
std::string UndeterminedText(Degeneracy degeneracy, Task task) {
  const std::string letter = LetterOf(task), without = (letter == "F" ? letter : "t") + " is not determined: ";
  switch (degeneracy) {
    case Degeneracy::kPureRotation:
      return "t is not determined: the camera only turned";
    case Degeneracy::kStatic:
      return without + "the images show no motion";
    case Degeneracy::kPlane:
      return without + "the matches lie on one plane, or the camera only turned";
    default:
      return (letter == "E" ? "t" : letter) + " is not determined: the matches lie on one line";
  }
}

/// The model and what is to be known before it is used. Digits of what is anything would be taken for what they are
/// not; a turn's homography is determined.
std::string ModelText(const ImagePair& pair) {
  const PairEstimate& estimate = pair.estimate;
  const Diagnostics& diagnostics = estimate.diagnostics;
  const Task task = pair.example.problem.task;
  std::string text;
  if (diagnostics.mirrored)
    text += "  the matches fit the mirror image of the second photograph: one of the two is mirrored\n";
  if (diagnostics.focal_conflict) text += ConflictText(*diagnostics.focal_conflict);
  if (!estimate.MayBeChance() && diagnostics.error_probability > kLikelyWrong)
    text += Format("  may be wrong: of results like this %.0f %% are off by more than 10 degrees\n",
                   100.0 * diagnostics.error_probability);
  const bool determined = !IsUndetermined(diagnostics.degeneracy),
             turned = diagnostics.degeneracy == Degeneracy::kPureRotation && estimate.pose.has_value();
  if (task != Task::kAbsolutePose && (determined || (task == Task::kHomography && turned)))
    text += MatrixText(LetterOf(task), estimate.matrix);
  if (estimate.focal) text += FocalText(estimate);
  if (turned) text += RotationText(estimate.pose->rotation);
  if (!determined) text += "  " + UndeterminedText(diagnostics.degeneracy, task) + "\n";
  return text;
}

bool HasRatioOrScore(const Problem& problem) { return problem.snn_ratio.size() == problem.points.rows(); }
double RatioOrScore(const Problem& problem, Eigen::Index match) {
  return problem.scored ? 1.0 - problem.snn_ratio[match] : problem.snn_ratio[match];
}

Json FocalJson(const FocalEstimate& focal) {
  return {
      {"px", focal.focal_px},           {"low_px", focal.low_px},           {"high_px", focal.high_px},
      {"observable", focal.observable}, {"prior_px", focal.prior_focal_px}, {"prior_log_sigma", focal.prior_log_sigma}};
}

Json ConflictJson(const FocalConflict& conflict) {
  return {{"said_px", conflict.said_px},
          {"found_px", conflict.found_px},
          {"low_px", conflict.low_px},
          {"high_px", conflict.high_px}};
}

Json SizeJson(const ImageSize& size) { return size.known() ? Json({size.width, size.height}) : Json(nullptr); }

/// Of the calibration; where the focal length is looked for, the image's middle.
Json PrincipalPointJson(const Problem& problem, const ImageSize& size, Eigen::Matrix3d CameraPair::*K) {
  if (problem.cameras) return {((*problem.cameras).*K)(0, 2), ((*problem.cameras).*K)(1, 2)};
  if (!FindsFocals(problem.task) || !size.known()) return nullptr;
  return {0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

/// With R as a unit quaternion w x y z, w >= 0, too; t is null where it is not determined.
Json PoseJson(const RigidMotion& pose) {
  const Eigen::Vector3d& t = pose.translation;
  Eigen::Quaterniond q(pose.rotation);
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  return {{"R", MatrixJson(pose.rotation)},
          {"t", t.isZero(0.0) ? Json(nullptr) : Json({t[0], t[1], t[2]})},
          {"q", {q.w(), q.x(), q.y(), q.z()}}};
}

/// Row by row.
std::vector<double> ModelNumbers(const ImagePair& pair) {
  const auto numbers = [](const auto& matrix) {
    const auto values = matrix.template reshaped<Eigen::RowMajor>();
    return std::vector<double>(values.begin(), values.end());
  };
  if (!pair.estimate.ok()) return {};
  if (pair.example.problem.task != Task::kAbsolutePose) return numbers(pair.estimate.matrix);
  Eigen::Matrix<double, 3, 4> pose;
  pose << pair.estimate.pose->rotation, pair.estimate.pose->translation;
  return numbers(pose);
}

}  // namespace

std::string PairText(const ImagePair& pair) {
  const PairEstimate& estimate = pair.estimate;
  const Problem& problem = pair.example.problem;
  const auto matches = problem.points.rows();
  const std::string text = pair.example.id + ": " + std::to_string(matches) +
                           (problem.task == Task::kAbsolutePose ? " points" : " matches") +
                           UnusedText(estimate.diagnostics) + "\n";
  if (!estimate.ok())
    return text + "no " + NameOf(problem.task) + ": " + std::string(ToString(estimate.status)) + "\n" + TimesText(pair);
  std::string found = NameOf(problem.task) + ": " + std::to_string(estimate.num_inliers) + " inliers";
  if (matches > 0) found += Format(" (%.0f %%)", 100.0 * estimate.num_inliers / static_cast<double>(matches));
  if (std::isfinite(estimate.sigma)) found += Format(", noise %.2g px", estimate.sigma);
  return text + found + "\n" + ModelText(pair) + MotionText(pair) + TimesText(pair);
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

Json PairJson(const ImagePair& pair, const std::string& image1, const std::string& image2) {
  const PairEstimate& estimate = pair.estimate;
  const Diagnostics& diagnostics = estimate.diagnostics;
  const Problem& problem = pair.example.problem;
  const auto& cameras = problem.cameras;
  Json focal = OptionalJson(estimate.focal, FocalJson);
  if (cameras) focal = {{"px", {cameras->K1(0, 0), cameras->K2(0, 0)}}};
  if (!focal.is_null()) focal["source"] = {ToString(estimate.focal_from[0]), ToString(estimate.focal_from[1])};
  Json inliers = Json::array();
  for (std::size_t i = 0; i < estimate.inliers.size(); ++i)
    if (estimate.inliers[i] != 0) inliers.push_back(i);
  return {{"pair", pair.example.id},
          {"image1", image1},
          {"image2", image2},
          {"method", ToString(estimate.guidance)},
          {"seed", estimate.seed},
          {"size1", SizeJson(problem.size1)},
          {"size2", SizeJson(problem.size2)},
          {"principal_point1", PrincipalPointJson(problem, problem.size1, &CameraPair::K1)},
          {"principal_point2", PrincipalPointJson(problem, problem.size2, &CameraPair::K2)},
          {"K1", cameras ? MatrixJson(cameras->K1) : Json(nullptr)},
          {"K2", cameras ? MatrixJson(cameras->K2) : Json(nullptr)},
          {"task", ToString(problem.task)},
          {"status", std::string(ToString(estimate.status))},
          {"verdict", ToString(estimate.verdict)},
          {"may_be_chance", estimate.MayBeChance()},
          {"sure", estimate.IsSure()},
          {"log10_nfa", estimate.ok() ? FiniteJson(diagnostics.log10_nfa) : Json(nullptr)},
          {"mirrored", diagnostics.mirrored},
          {"error_probability", FiniteJson(diagnostics.error_probability)},
          {"model", ModelNumbers(pair)},
          {"pose", OptionalJson(estimate.pose, PoseJson)},
          {"ambiguous_pose", OptionalJson(estimate.ambiguous_pose, PoseJson)},
          {"degeneracy", ToString(diagnostics.degeneracy)},
          {"pose_covariance", OptionalJson(estimate.pose_covariance, MatrixJson)},
          {"cheirality_failure_ratio", diagnostics.cheirality_failure_ratio},
          {"focal_conflict", OptionalJson(diagnostics.focal_conflict, ConflictJson)},
          {"focal", std::move(focal)},
          {"matches", problem.points.rows()},
          {"num_inliers", estimate.num_inliers},
          {"inliers", std::move(inliers)},
          {"num_nonfinite", diagnostics.num_nonfinite},
          {"num_duplicates", diagnostics.num_duplicates},
          {"scores_ignored", diagnostics.scores_ignored},
          {"hypotheses", estimate.stats.hypotheses},
          {"sigma_px", estimate.ok() ? FiniteJson(estimate.sigma) : Json(nullptr)},
          {"ms",
           {{"keypoints", pair.ms_keypoints},
            {"matching", pair.ms_matching},
            {"features", estimate.stats.ms_features},
            {"network", estimate.stats.ms_network},
            {"consensus", estimate.stats.ms_consensus},
            {"estimate", estimate.stats.ms_total}}}};
}

}  // namespace diffsac
