#include "lab/data/structure_truth.h"

#include <algorithm>
#include <vector>

#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/dominant_plane.h"
#include "lab/data/structure_sizes.h"

namespace diffsac {
namespace {

// Empty where the matches fix none. A wrong label far off would lead the fit to all matches astray, so that the start
// is what most of them follow.
ModelParameters FitPlane(const PointMatrix& points, double loss_px) {
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(points.rows());
  if (points.rows() < FewestLabelled(Task::kHomography) || !Homography::Determined(points)) return {};
  const auto start = FitDominantPlane(points, loss_px, FewestLabelled(Task::kHomography), Rng(0).Fork("structure"));
  Matrix3Parameters model;
  if (start) {
    model = *start;
  } else if (!Homography::Fit(points, weights, &model)) {
    return {};
  }
  Homography::Refine(points, weights, {LossKind::kHuber, loss_px}, &model);
  return model;
}

ModelParameters FitMotion(const PointMatrix& points, double loss_px) {
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(points.rows());
  Matrix3Parameters model;
  if (points.rows() < FewestLabelled(Task::kFundamental) || !Fundamental::Determined(points) ||
      !Fundamental::Fit(points, weights, &model))
    return {};
  Fundamental::Refine(points, weights, {LossKind::kHuber, loss_px}, &model);
  return model;
}

}  // namespace

int FewestLabelled(Task task) {
  return 1 + (task == Task::kFundamental ? Fundamental::kMinimalSize : Homography::kMinimalSize);
}

void FitStructures(Task task, const Problem& problem, double loss_px, GroundTruth* truth) {
  truth->structures.clear();
  std::vector<std::vector<int>> rows;
  for (std::size_t i = 0; i < truth->assignment.size(); ++i) {
    const std::int32_t label = truth->assignment[i];
    if (label <= 0) continue;
    rows.resize(std::max(rows.size(), static_cast<std::size_t>(label)));
    rows[label - 1].push_back(static_cast<int>(i));
  }
  const auto fit = task == Task::kFundamental ? FitMotion : FitPlane;
  for (const std::vector<int>& structure : rows) {
    truth->structures.push_back(fit(problem.points(structure, Eigen::all), loss_px));
    if (truth->structures.back().size() > 0) continue;
    for (const int i : structure) truth->assignment[i] = 0;
  }
  ArrangeStructuresOf(task, truth);
}

void ArrangeStructuresOf(Task task, GroundTruth* truth) {
  ArrangeStructures(FewestLabelled(task), truth);
  auto& largest = task == Task::kFundamental ? truth->fundamental : truth->homography;
  largest.reset();
  if (!truth->structures.empty()) largest = AsMatrix(Matrix3Parameters(truth->model));
}

}  // namespace diffsac
