#include "lab/registration/registration_text.h"

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "lab/eval/format.h"

namespace diffsac {
namespace {

using Json = nlohmann::ordered_json;

std::string SizesText(const Scan& scan) {
  std::string text = scan.name() + ": " + std::to_string(scan.points) + " points";
  if (scan.left_out > 0) text += ", " + std::to_string(scan.left_out) + " more are not finite";
  return text + ", described " + std::to_string(scan.descriptors.rows()) + "\n";
}

std::string Numbers(const Eigen::Ref<const Eigen::VectorXd>& values, const char* between = " ") {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : between) + ShortestNumber(value);
  return text;
}

/// x y z qx qy qz qw.
Eigen::VectorXd PoseNumbers(const RigidMotion& motion) {
  Eigen::VectorXd numbers(7);
  numbers << motion.translation, Eigen::Quaterniond(motion.rotation).coeffs();
  return numbers;
}

RigidMotion Chain(const RigidMotion& after, const RigidMotion& before) {
  return {after.rotation * before.rotation, after.rotation * before.translation + after.translation};
}

/// Each scan's pose in the frame of the first of its group; whether it is that one.
struct Placed {
  RigidMotion pose;
  bool placed = false, is_first = false;
};

/// The pair of most inliers of which one scan has a place.
const ScanPair* NextEdge(const std::vector<ScanPair>& pairs, const std::vector<Placed>& placed) {
  const ScanPair* best = nullptr;
  for (const ScanPair& pair : pairs)
    if (placed[pair.first].placed != placed[pair.second].placed && IsEdge(pair.registration) &&
        (!best || pair.registration.estimate.num_inliers > best->registration.estimate.num_inliers))
      best = &pair;
  return best;
}

std::vector<Placed> Place(std::size_t scans, const std::vector<ScanPair>& pairs) {
  std::vector<Placed> placed(scans);
  for (Placed& first : placed) {
    if (first.placed) continue;
    first.placed = first.is_first = true;
    while (const ScanPair* edge = NextEdge(pairs, placed)) {
      const RigidMotion& motion = edge->registration.motion;
      Placed &one = placed[edge->first], &other = placed[edge->second];
      if (one.placed)
        other = {Chain(one.pose, Inverse(motion)), true};
      else
        one = {Chain(other.pose, motion), true};
    }
  }
  return placed;
}

/// The upper triangle by rows.
std::string UpperText(const Eigen::Matrix<double, 6, 6>& matrix) {
  std::string text;
  for (int r = 0; r < 6; ++r) text += " " + Numbers(matrix.row(r).tail(6 - r).transpose());
  return text;
}

}  // namespace

std::string RegistrationText(const Scan& first, const Scan& second, const Registration& registration) {
  const std::string text =
      SizesText(first) + SizesText(second) + MotionText(registration, registration.motion, first.middle);
  if (!registration.estimate.ok()) return text;
  return text +
         Format("overlap: %.0f %% of the first, %.0f %% of the second; RMSE %.2g", 100.0 * registration.overlap1,
                100.0 * registration.overlap2, registration.rmse) +
         Format(" (before ICP %.0f %% of the first)\n", 100.0 * registration.overlap_before);
}

std::string RegistrationJson(const Scan& first, const Scan& second, const Registration& registration) {
  Json json = {{"first", first.path}, {"second", second.path}};
  json.update(MotionJson(registration, registration.motion, first.middle));
  if (registration.estimate.ok()) {
    json["overlap"] = {registration.overlap1, registration.overlap2};
    json["rmse"] = registration.rmse;
    json["hold"] = registration.hold;
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

bool IsEdge(const Registration& registration) {
  const RigidMotionEstimate& estimate = registration.estimate;
  return estimate.ok() && estimate.verdict != Verdict::kUnsupported && !registration.slides() &&
         estimate.pose_covariance.has_value();
}

std::string RegistrationsCsv(const std::vector<Scan>& scans, const std::vector<ScanPair>& pairs) {
  std::string text =
      "first,second,status,matches,inliers,may_be_chance,ambiguous,edge,hold,overlap_first,overlap_second,rmse,x,y,z,"
      "qx,qy,"
      "qz,"
      "qw\n";
  for (const ScanPair& pair : pairs) {
    const Registration& found = pair.registration;
    text +=
        CsvText(scans[pair.first].name()) + "," + CsvText(scans[pair.second].name()) + "," +
        std::string(ToString(found.estimate.status)) +
        Format(",%d,%d,%d,%d,%d,", found.matches, found.estimate.num_inliers,
               int{found.estimate.verdict == Verdict::kUnsupported}, int{found.estimate.ambiguous_pose.has_value()},
               int{IsEdge(found)}) +
        (found.estimate.ok() ? Format("%.3f,%.4f,%.4f,%.6g,", found.hold, found.overlap1, found.overlap2, found.rmse) +
                                   Numbers(PoseNumbers(found.motion), ",")
                             : ",,,,,,,,,,") +
        "\n";
  }
  return text;
}

std::string PoseGraphText(const std::vector<Scan>& scans, const std::vector<ScanPair>& pairs) {
  std::string text;
  const std::vector<Placed> placed = Place(scans.size(), pairs);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const std::string id = std::to_string(i);
    text += "# " + id + ": " + scans[i].name() + "\nVERTEX_SE3:QUAT " + id + " " +
            Numbers(PoseNumbers(placed[i].pose)) + "\n";
    if (placed[i].is_first) text += "FIX " + id + "\n";
  }
  for (const ScanPair& pair : pairs) {
    if (!IsEdge(pair.registration)) continue;
    const auto information = Information(pair.registration, scans[pair.first].middle);
    if (!information) continue;
    text += "EDGE_SE3:QUAT " + std::to_string(pair.second) + " " + std::to_string(pair.first) + " " +
            Numbers(PoseNumbers(pair.registration.motion)) + UpperText(*information) + "\n";
  }
  return text;
}

}  // namespace diffsac
