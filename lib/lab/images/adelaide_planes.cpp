#include "lab/images/adelaide_planes.h"

#include <algorithm>
#include <vector>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/problem/homography_task.h"
#include "diffsac/problem/tasks.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/ground_truth/task_truth.h"
#include "lab/images/given_pairs.h"
#include "lab/images/run_pairs.h"

namespace diffsac {
namespace {

constexpr double kNearPx = 3.0;
constexpr int kFewestLabels = 8;
constexpr double kMostOfAnother = 2.0 / 3.0;

PointMatrix MatchesOf(const Example& labelled, int plane) {
  std::vector<int> rows;
  for (std::size_t i = 0; i < labelled.truth.assignment.size(); ++i)
    if (labelled.truth.assignment[i] == plane) rows.push_back(static_cast<int>(i));
  return labelled.problem.points(rows, Eigen::all);
}

PointMatrix EveryOther(const PointMatrix& matches, int first) {
  return matches(Eigen::seq(first, Eigen::last, 2), Eigen::all);
}

/// The mean distance between two homographies as an estimate and a truth of this pair.
double MeanDistance(const Matrix3Parameters& found, const Matrix3Parameters& truth, Example pair) {
  pair.truth.model = truth;
  const ModelParameters model = found;
  return HomographyError(&model, {}, pair).error_px;
}

bool HalvesAgree(const PointMatrix& matches, const Example& pair) {
  if (matches.rows() < 2 * kFewestLabels) return false;
  const auto even = FitLabelledPlane(EveryOther(matches, 0)), odd = FitLabelledPlane(EveryOther(matches, 1));
  return even && odd && MeanDistance(*even, *odd, pair) <= kLargestDisagreementPx;
}

struct Plane {
  Matrix3Parameters homography;
  PointMatrix matches;
  Eigen::Index support = 0;  ///< Tentative matches near it.
};

std::vector<Plane> PlanesOf(const Example& labelled, const Example& tentative) {
  std::vector<Plane> planes;
  const auto& labels = labelled.truth.assignment;
  for (int k = 1; k <= *std::max_element(labels.begin(), labels.end()); ++k) {
    Plane plane{{}, MatchesOf(labelled, k)};
    const auto homography = FitLabelledPlane(plane.matches);
    if (!homography) continue;
    plane.homography = *homography;
    GroundTruth truth;
    truth.homography = AsMatrix(*homography);
    plane.support = (TruthDistances(tentative.problem, truth).array() <= kNearPx).count();
    planes.push_back(std::move(plane));
  }
  std::stable_sort(planes.begin(), planes.end(), [](const Plane& a, const Plane& b) { return a.support > b.support; });
  return planes;
}

/// Sets the pair's homography; false with a word in the log where it is not sure.
bool SetHomography(const Example& labelled, Example* pair) {
  const std::vector<Plane> planes = PlanesOf(labelled, *pair);
  const auto leave_out = [&](const std::string& why) {
    LogInfo("left out: " + pair->id + ", " + why);
    return false;
  };
  if (planes.empty()) return leave_out("no plane has labels enough");
  if (planes.size() > 1 && planes[1].support > kMostOfAnother * planes[0].support)
    return leave_out("two planes have about as many matches");
  if (!HalvesAgree(planes[0].matches, *pair)) return leave_out("its plane's labels do not determine a homography well");
  pair->truth.fundamental.reset();
  pair->truth.homography = AsMatrix(planes[0].homography);
  return true;
}

}  // namespace

std::optional<Matrix3Parameters> FitLabelledPlane(const PointMatrix& matches) {
  Matrix3Parameters model;
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(matches.rows());
  if (matches.rows() < kFewestLabels || !Homography::Fit(matches, weights, &model)) return {};
  RefineOptions options;
  options.loss = {LossKind::kTruncated, kNearPx};
  RefineHomography(matches, weights, options, &model);
  return model;
}

CorrespondenceSet ReadAdelaidePlanes(const std::string& folder, int first) {
  const CorrespondenceScene labelled(folder + "/adelaidermf"), tentative(folder + "/adelaidermf_sift");
  if (labelled.pairs() != tentative.pairs()) throw Error(folder + ": its two scenes are not of the same pairs");
  CorrespondenceSet set;
  for (std::int64_t i = first; i < tentative.size(); i += 2) {
    Example pair = tentative.Read(i);
    if (SetHomography(labelled.Read(i), &pair)) set.pairs.push_back(std::move(pair));
  }
  return set;
}

namespace {

PrepareResult WriteAdelaidePlanes(const PairsRequest& request, const std::atomic<bool>& stop) {
  PrepareResult result;
  const std::string name = request.scene.empty() ? "adelaidermf_planes" : request.scene;
  for (int first = 0; first < 2 && !stop; ++first)
    WriteScene(
        request, name + (first == 0 ? "_even" : "_odd"), [&] { return ReadAdelaidePlanes(request.input, first); }, stop,
        &result);
  return result;
}

const Registered<ImageFormat> kAdelaidePlanes("adelaidermf_planes", {.write = WriteAdelaidePlanes});

}  // namespace

}  // namespace diffsac
