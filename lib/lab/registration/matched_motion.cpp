#include "lab/registration/matched_motion.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "diffsac/geometry/motion_errors.h"
#include "lab/eval/format.h"
#include "lab/images/pair_text.h"

namespace diffsac {
namespace {

using Json = nlohmann::ordered_json;

Json Rows(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    const Eigen::VectorXd row = matrix.row(r);
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  }
  return rows;
}

std::string TextOf(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

std::string TransformText(const RigidMotion& motion, const char* scale) {
  const Eigen::Vector3d& t = motion.translation;
  return RotationText(motion.rotation) + "  t =  (" + ShortestNumber(t[0]) + ", " + ShortestNumber(t[1]) + ", " +
         ShortestNumber(t[2]) + "); y = " + scale + "R x + t\n";
}

/// ", 3 repeated, 2 not finite". found: Diagnostics, or a result without.
template <class Found>
std::string UnusedText(const Found& found) {
  std::string text;
  if (found.num_duplicates > 0) text += ", " + std::to_string(found.num_duplicates) + " repeated";
  if (found.num_nonfinite > 0) text += ", " + std::to_string(found.num_nonfinite) + " not finite";
  if constexpr (requires { found.scores_ignored; })
    if (found.scores_ignored) text += kScoresIgnored;
  return text;
}

std::string NoneText(Status status) { return "no motion: " + std::string(ToString(status)) + "\n"; }

Eigen::Vector3d MiddleOf(const Matches3D3D& matches, const RigidMotionEstimate& estimate) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < estimate.inliers.size(); ++i)
    if (estimate.inliers[i] == 1)
      middle += matches.points1.matrix().row(static_cast<Eigen::Index>(i)).transpose() / estimate.num_inliers;
  return middle;
}

std::string SpreadText(const MotionSpread& spread) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> variances(spread.of_middle.block<3, 3>(3, 3),
                                                                 Eigen::EigenvaluesOnly);
  return PoseSpreadText(spread.of_t) +
         Format("  where the middle of the inliers, (%.7g, %.7g, %.7g), moves to: within %.2g\n", spread.middle[0],
                spread.middle[1], spread.middle[2], std::sqrt(std::max(0.0, variances.eigenvalues()[2])));
}

RigidMotion MotionOf(const Eigen::Matrix<double, 3, 4>& model) { return {model.leftCols<3>(), model.col(3)}; }

}  // namespace

MatchedMotion EstimateMatched(Task task, const Matches3D3D& matches, const RegistrationOptions& options) {
  MatchedMotion found{task, static_cast<int>(matches.points1.rows()), {}};
  if (task == Task::kRigid) {
    found.estimate = EstimateRigidMotion(matches, options);
    found.middle = MiddleOf(matches, found.estimate);
    return found;
  }
  SimilarityEstimate similarity = EstimateSimilarity(matches, options);
  found.scale = similarity.scale;
  static_cast<PoseEstimate<Eigen::Matrix<double, 3, 4>>&>(found.estimate) = std::move(similarity);
  found.middle = MiddleOf(matches, found.estimate);
  return found;
}

std::optional<MotionSpread> SpreadOf(const MatchedMotion& found, const RigidMotion& motion,
                                     const Eigen::Vector3d& origin) {
  const std::optional<Eigen::MatrixXd>& covariance = found.estimate.pose_covariance;
  if (!covariance) return std::nullopt;
  const Eigen::Matrix3d turn = found.scale * motion.rotation;
  const auto moved = [&](const Eigen::Vector3d& from) -> Eigen::MatrixXd {
    const Eigen::MatrixXd change = ErrorsFromOrigin(turn * from, covariance->rows());
    return change * *covariance * change.transpose();
  };
  return MotionSpread{moved(origin), moved(-found.middle), found.middle + origin};
}

std::string MotionText(const MatchedMotion& found, const RigidMotion& motion, const Eigen::Vector3d& origin) {
  const RigidMotionEstimate& estimate = found.estimate;
  std::string text = "matches: " + std::to_string(found.matches) + UnusedText(estimate.diagnostics) + "\n";
  if (!estimate.ok()) return text + NoneText(estimate.status);
  const bool scaled = found.task == Task::kSimilarity;
  text += Format("%s: %d inliers (%.0f %%), noise %.2g\n", scaled ? "similarity" : "rigid motion", estimate.num_inliers,
                 100.0 * estimate.num_inliers / found.matches, estimate.sigma);
  text += TransformText(motion, scaled ? "s " : "");
  if (scaled) text += "  s = " + ShortestNumber(found.scale);
  if (scaled && estimate.pose_covariance)
    text += Format(", within %.2g %%", 100.0 * std::sqrt((*estimate.pose_covariance)(6, 6)));
  if (scaled) text += "\n";
  const auto spread = SpreadOf(found, motion, origin);
  return spread ? text + SpreadText(*spread) : text;
}

Json MotionJson(const MatchedMotion& found, const RigidMotion& motion, const Eigen::Vector3d& origin) {
  const RigidMotionEstimate& estimate = found.estimate;
  Json json = {{"status", ToString(estimate.status)}, {"matches", found.matches}, {"inliers", estimate.num_inliers}};
  if (!estimate.ok()) return json;
  json["rotation"] = Rows(motion.rotation);
  json["translation"] = Rows(motion.translation.transpose())[0];
  if (found.task == Task::kSimilarity) json["scale"] = found.scale;
  const auto spread = SpreadOf(found, motion, origin);
  json["covariance"] = spread ? Rows(spread->of_t) : Json();
  if (spread) {
    json["middle"] = Rows(spread->middle.transpose())[0];
    json["covariance_at_middle"] = Rows(spread->of_middle);
  }
  json["sigma"] = estimate.sigma;
  json["log10_nfa"] = estimate.diagnostics.log10_nfa;
  json["may_be_chance"] = (estimate.verdict == Verdict::kUnsupported);
  json["scores_ignored"] = estimate.diagnostics.scores_ignored;
  json["ambiguous"] = estimate.ambiguous_pose.has_value();
  return json;
}

std::string MatchedJson(const std::string& file, const MatchedMotion& found) {
  const RigidMotionEstimate& estimate = found.estimate;
  Json json = {{"file", file}, {"task", ToString(found.task)}};
  json.update(MotionJson(found, estimate.pose.value_or(RigidMotion())));
  if (estimate.ambiguous_pose)
    json["ambiguous_motion"] = {{"rotation", Rows(estimate.ambiguous_pose->rotation)},
                                {"translation", Rows(estimate.ambiguous_pose->translation.transpose())[0]}};
  json["inlier_threshold"] = estimate.inlier_threshold;
  json["inlier_rows"] = Json::array();
  for (std::size_t i = 0; i < estimate.inliers.size(); ++i)
    if (estimate.inliers[i] == 1) json["inlier_rows"].push_back(i);
  json["posteriors"] = estimate.posteriors;
  return TextOf(json);
}

std::string MotionsText(const MultiModelEstimate<Eigen::Matrix<double, 3, 4>>& found) {
  const auto& assignment = found.assignment;
  std::string text = "matches: " + std::to_string(assignment.size()) + UnusedText(found) + "\n";
  if (!found.ok()) return text + NoneText(found.status);
  for (std::size_t k = 0; k < found.models.size(); ++k)
    text += "rigid motion " + std::to_string(k + 1) + ": " +
            std::to_string(std::count(assignment.begin(), assignment.end(), static_cast<std::int32_t>(k) + 1)) +
            " matches\n" + TransformText(MotionOf(found.models[k]), "");
  return text;
}

std::string MotionsJson(const std::string& file, const MultiModelEstimate<Eigen::Matrix<double, 3, 4>>& found) {
  Json json = {{"file", file}, {"status", ToString(found.status)}, {"motions", Json::array()}};
  for (const auto& model : found.models)
    json["motions"].push_back(
        {{"rotation", Rows(model.leftCols<3>())}, {"translation", Rows(model.col(3).transpose())[0]}});
  json["assignment"] = found.assignment;
  return TextOf(json);
}

}  // namespace diffsac
