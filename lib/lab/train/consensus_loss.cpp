#include "lab/train/consensus_loss.h"

#include <torch/torch.h>

#include <cmath>

#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/ground_truth/task_truth.h"

namespace diffsac {
namespace {

// Ridge and gap, relative to the trace, below which a smallest eigenvector is left alone: its derivative has the gap in
// the denominator.
constexpr double kLeastGap = 1e-7;

torch::Tensor ToTensor(const PointMatrix& matrix) {
  return torch::from_blob(const_cast<double*>(matrix.data()), {matrix.rows(), matrix.cols()}, torch::kDouble).clone();
}

torch::Tensor UnitVector(const Eigen::VectorXd& vector) {
  if (!vector.allFinite() || !(vector.norm() > 0.0)) return {};
  const Eigen::VectorXd unit = vector.normalized();
  return torch::from_blob(const_cast<double*>(unit.data()), {unit.size()}, torch::kDouble).clone();
}

// The unit vector of least Σ w (row · v)²; *determined is false where it is not one.
torch::Tensor SmallestVector(const torch::Tensor& scatter, bool* determined) {
  const auto size = scatter.size(0);
  const auto trace = scatter.diagonal().sum();
  *determined = false;
  if (!(trace.item<double>() > 0.0)) return {};
  const auto [values, vectors] = torch::linalg_eigh(scatter / trace);
  *determined = (values[1] - values[0]).item<double>() > kLeastGap;
  return vectors.select(1, 0).view({size});
}

}  // namespace

torch::Tensor AdaptiveTemperature(const torch::Tensor& distances, const torch::Tensor& inliers, double alpha) {
  const auto cooled = torch::exp(-(1.0 - distances.clamp(0.0, 1.0)) / alpha);
  return torch::where(inliers > 0.5, cooled, torch::ones_like(cooled));
}

torch::Tensor BalancedCrossEntropy(const torch::Tensor& logits, const torch::Tensor& inliers,
                                   const torch::Tensor& temperature, const torch::Tensor& mask) {
  const auto real = mask.to(logits.dtype());
  const auto each = torch::binary_cross_entropy_with_logits(logits.masked_fill(mask.logical_not(), 0.0) * temperature,
                                                            inliers, {}, {}, torch::Reduction::None);
  const auto mean = [&](const torch::Tensor& of) { return (each * of).sum(1) / of.sum(1).clamp_min(1.0); };
  return 0.5 * (mean(inliers * real) + mean((1.0 - inliers) * real)).mean();
}

LinearFit MakeLinearFit(const Example& example) {
  const auto equations_of = TruthOf(example.problem.task).equations;
  if (equations_of == nullptr) throw Error("clnet: the task " + ToString(example.problem.task) + " has no linear fit");
  const LinearEquations equations = equations_of(NormalizedProblem(example.problem), example.truth);
  LinearFit fit{ToTensor(equations.rows), equations.rows_per_point, equations.about_mean, {}};
  if (equations.truth.size() > 0) fit.truth = UnitVector(equations.truth);
  return fit;
}

torch::Tensor RegressionLoss(const torch::Tensor& weights, const std::vector<LinearFit>& fits) {
  torch::Tensor total = torch::zeros({}, torch::kDouble);
  int count = 0;
  const auto all = weights.to(torch::kCPU, torch::kDouble);
  for (std::size_t b = 0; b < fits.size(); ++b) {
    if (!fits[b].truth.defined()) continue;
    ++count;
    auto rows = fits[b].rows;
    const auto points = rows.size(0) / fits[b].rows_per_point;
    const auto w =
        all[static_cast<std::int64_t>(b)].slice(0, 0, points).repeat_interleave(fits[b].rows_per_point).unsqueeze(1);
    if (fits[b].about_mean) rows = rows - (w * rows).sum(0, true) / w.sum().clamp_min(1e-9);
    bool determined = false;
    const auto vector = SmallestVector(torch::matmul(rows.t(), w * rows), &determined);
    if (determined) total = total + 1.0 - vector.dot(fits[b].truth).square();
  }
  return total / std::max(count, 1);
}

}  // namespace diffsac
