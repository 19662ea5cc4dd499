#include "lab/ground_truth/instances_error.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "diffsac/problem/normalized_problem.h"
#include "diffsac/problem/tasks.h"
#include "lab/ground_truth/task_truth.h"

namespace diffsac {
namespace {

bool KnowsInstances(const Example& example) {
  return !example.truth.instances.empty() &&
         static_cast<Eigen::Index>(example.truth.assignment.size()) == example.problem.points.rows();
}

std::int32_t MostOf(std::span<const std::int32_t> labels) {
  return labels.empty() ? 0 : *std::max_element(labels.begin(), labels.end());
}

// The points of each structure of the truth.
std::vector<std::vector<int>> Members(const GroundTruth& truth) {
  std::vector<std::vector<int>> members(truth.instances.size());
  for (std::size_t i = 0; i < truth.assignment.size(); ++i) {
    const std::int32_t label = truth.assignment[i];
    if (label > 0 && static_cast<std::size_t>(label) <= members.size())
      members[static_cast<std::size_t>(label) - 1].push_back(static_cast<int>(i));
  }
  return members;
}

template <class Model>
bool StandsFor(const typename Model::Parameters& model, const std::vector<int>& members,
               const NormalizedProblem& space) {
  const PointMatrix& points = space.points();
  const double most = kRecallTruncation * space.threshold();
  double sum = 0.0;
  for (const int i : members) {
    const double residual = Model::Residual(model, points.data() + i * points.cols());
    // Of a residual that is not finite, too.
    const double truncated = residual < most ? residual : most;
    sum += truncated * truncated;
  }
  return std::sqrt(sum / static_cast<double>(members.size())) <= space.threshold();
}

// Found models by true structures: 1 where the one stands for the other.
Eigen::MatrixXd Standing(const std::vector<ModelParameters>& found, const std::vector<std::vector<int>>& members,
                         const Problem& problem) {
  const NormalizedProblem space(problem);
  return DispatchTask(problem.task, [&]<class Model>() {
    Eigen::MatrixXd stands =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(found.size()), static_cast<Eigen::Index>(members.size()));
    for (Eigen::Index f = 0; f < stands.rows() && space.is_accepted(); ++f) {
      const ModelParameters& model = found[static_cast<std::size_t>(f)];
      if (model.size() != Model::Parameters::SizeAtCompileTime || !model.allFinite()) continue;
      const typename Model::Parameters parameters = model;
      for (Eigen::Index k = 0; k < stands.cols(); ++k) {
        const std::vector<int>& points = members[static_cast<std::size_t>(k)];
        stands(f, k) = !points.empty() && StandsFor<Model>(parameters, points, space) ? 1.0 : 0.0;
      }
    }
    return stands;
  });
}

}  // namespace

std::vector<int> BestAssignment(const Eigen::MatrixXd& gains) {
  constexpr int kFree = -1;
  const bool wide = gains.rows() <= gains.cols();
  const Eigen::MatrixXd costs = wide ? Eigen::MatrixXd(-gains) : Eigen::MatrixXd(-gains.transpose());
  // Rows and columns have potentials; a pair's reduced cost, cost - potential - potential, is never negative, and zero
  // for what is assigned. Columns count from 1: the one before them is the new row's.
  const auto rows = static_cast<int>(costs.rows()), columns = static_cast<int>(costs.cols());
  const auto count = static_cast<std::size_t>(columns) + 1;
  Eigen::VectorXd of_rows = Eigen::VectorXd::Zero(rows), of_columns = Eigen::VectorXd::Zero(columns + 1);
  std::vector<int> row_of(count, kFree);
  for (int row = 0; row < rows; ++row) {
    // Along the cheapest alternating path from the row to a free column.
    Eigen::VectorXd cheapest = Eigen::VectorXd::Constant(columns + 1, std::numeric_limits<double>::infinity());
    std::vector<int> from(count, 0);  // The column before on the path.
    std::vector<char> reached(count, 0);
    row_of[0] = row;
    int column = 0;
    for (int at = row; at != kFree; at = row_of[column]) {
      reached[column] = 1;
      int nearest = 0;
      for (int c = 1; c <= columns; ++c) {
        if (reached[c] != 0) continue;
        const double reduced = costs(at, c - 1) - of_rows[at] - of_columns[c];
        if (reduced < cheapest[c]) cheapest[c] = reduced, from[c] = column;
        if (nearest == 0 || cheapest[c] < cheapest[nearest]) nearest = c;
      }
      // The nearest column's reduced cost becomes zero, those of the tree stay so.
      const double step = cheapest[nearest];
      for (int c = 0; c <= columns; ++c) {
        if (reached[c] == 0) cheapest[c] -= step;
        if (reached[c] != 0) of_rows[row_of[c]] += step, of_columns[c] -= step;
      }
      column = nearest;
    }
    for (; column != 0; column = from[column]) row_of[column] = row_of[from[column]];
  }
  row_of.erase(row_of.begin());
  if (!wide) return row_of;
  std::vector<int> column_of(static_cast<std::size_t>(rows), kFree);
  for (int c = 0; c < columns; ++c)
    if (row_of[c] != kFree) column_of[row_of[c]] = c;
  return column_of;
}

EstimatedInstances InstancesOf(const Estimate& estimate, const Problem& problem) {
  const auto size = static_cast<std::size_t>(problem.points.rows());
  EstimatedInstances found;
  if (estimate.status == Status::kOk && estimate.instances.empty()) {
    found.models = {estimate.model};
    found.assignment.assign(estimate.inliers.begin(), estimate.inliers.end());
  } else if (estimate.status == Status::kOk) {
    found.models = estimate.instances;
    found.assignment = estimate.assignment;
  }
  if (found.assignment.size() != size) found.assignment.assign(size, 0);
  return found;
}

double Misclassification(std::span<const std::int32_t> found, std::span<const std::int32_t> truth) {
  if (truth.empty()) return std::numeric_limits<double>::quiet_NaN();
  // How many points each pair of structures has in common.
  Eigen::MatrixXd common = Eigen::MatrixXd::Zero(MostOf(truth), MostOf(found));
  for (std::size_t i = 0; i < truth.size(); ++i)
    if (found[i] > 0 && truth[i] > 0) common(truth[i] - 1, found[i] - 1) += 1.0;
  std::vector<std::int32_t> partner_of = {0};
  for (const int partner : BestAssignment(common)) partner_of.push_back(partner >= 0 ? partner + 1 : -1);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) wrong += found[i] != partner_of[static_cast<std::size_t>(truth[i])];
  return 100.0 * static_cast<double>(wrong) / static_cast<double>(truth.size());
}

double InstanceRecall(const std::vector<ModelParameters>& found, const Example& example) {
  const std::vector<std::vector<int>> members = Members(example.truth);
  const auto known = std::count_if(members.begin(), members.end(), [](const auto& points) { return !points.empty(); });
  if (known == 0) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::MatrixXd stands = Standing(found, members, example.problem);
  const std::vector<int> matched = BestAssignment(stands);
  double count = 0.0;
  for (std::size_t f = 0; f < matched.size(); ++f)
    if (matched[f] >= 0) count += stands(static_cast<Eigen::Index>(f), matched[f]);
  return count / static_cast<double>(known);
}

std::vector<double> InstanceAngles(const std::vector<ModelParameters>& found, const Example& example) {
  const std::vector<ModelParameters>& truth = example.truth.instances;
  const auto angle = TruthOf(example.problem.task).instance_angle;
  if (angle == nullptr) return {};
  const auto count = static_cast<Eigen::Index>(std::min(found.size(), truth.size()));
  // How much better than none.
  Eigen::MatrixXd gain(static_cast<Eigen::Index>(truth.size()), count);
  for (Eigen::Index t = 0; t < gain.rows(); ++t)
    for (Eigen::Index f = 0; f < count; ++f)
      gain(t, f) =
          kWorstAngleDeg - angle(found[static_cast<std::size_t>(f)], truth[static_cast<std::size_t>(t)], example);
  std::vector<double> angles;
  const std::vector<int> partners = BestAssignment(gain);
  for (Eigen::Index t = 0; t < gain.rows(); ++t) {
    const int partner = partners[static_cast<std::size_t>(t)];
    angles.push_back(partner < 0 ? kWorstAngleDeg : kWorstAngleDeg - gain(t, partner));
  }
  return angles;
}

void AddInstancesError(const Estimate& estimate, const Example& example, EstimateError* error) {
  if (!KnowsInstances(example)) return;
  const EstimatedInstances found = InstancesOf(estimate, example.problem);
  error->misclassified = Misclassification(found.assignment, example.truth.assignment);
  error->recall = InstanceRecall(found.models, example);
  error->instance_angles_deg = InstanceAngles(found.models, example);
}

InstanceShares InstanceSharesOf(const std::vector<std::vector<int>>& sets, const GroundTruth& truth) {
  if (sets.empty() || truth.instances.empty()) return {};
  const std::set<std::int32_t> known(truth.assignment.begin(), truth.assignment.end());
  std::set<std::int32_t> seen;
  int pure = 0;
  for (const std::vector<int>& set : sets) {
    if (set.empty()) continue;
    const auto label = [&](int i) { return truth.assignment[static_cast<std::size_t>(i)]; };
    const std::int32_t first = label(set.front());
    if (first <= 0 || !std::all_of(set.begin(), set.end(), [&](int i) { return label(i) == first; })) continue;
    ++pure;
    seen.insert(first);
  }
  const auto instances = std::count_if(known.begin(), known.end(), [](std::int32_t label) { return label > 0; });
  return {static_cast<double>(pure) / static_cast<double>(sets.size()),
          instances == 0 ? std::nan("") : static_cast<double>(seen.size()) / static_cast<double>(instances)};
}

}  // namespace diffsac
