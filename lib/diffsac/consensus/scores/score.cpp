#include "diffsac/consensus/scores/score.h"

#include <stdexcept>

#include "diffsac/consensus/scores/gaussian_uniform.h"
#include "diffsac/consensus/scores/inlier_count.h"
#include "diffsac/consensus/scores/magsac.h"
#include "diffsac/consensus/scores/marginal_likelihood.h"
#include "diffsac/consensus/scores/marginalised_msac.h"
#include "diffsac/consensus/scores/msac.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/lanes.h"

namespace diffsac {
namespace {

struct Entry {
  ScoreKind kind;
  ScoreNeeds needs;
  std::shared_ptr<const ScoreFunction> (*make)(const ScoreSetting& setting);
};

template <class Function>
std::shared_ptr<const ScoreFunction> Make(const ScoreSetting& setting) {
  return std::make_shared<const Function>(setting);
}

const Entry kScores[] = {
    {ScoreKind::kInlierCount, {}, Make<InlierCount>},
    {ScoreKind::kMsac, {}, Make<Msac>},
    {ScoreKind::kGaussianUniform, {.sigma = true, .share = true}, Make<GaussianUniform>},
    {ScoreKind::kMagsac, {.dof = true}, Make<MagsacScore>},
    {ScoreKind::kMarginalLikelihood, {.half_width = true}, Make<MarginalLikelihood>},
    {ScoreKind::kMarginalised, {.scales = true}, Make<MarginalisedMsac>},
};

const Entry& EntryOf(ScoreKind kind) {
  for (const Entry& entry : kScores)
    if (entry.kind == kind) return entry;
  throw std::logic_error("a score is not registered");
}

[[noreturn]] void FailOfKind() { throw Error("the score is no sum over points, or is one alone"); }

}  // namespace

ScoreNeeds NeedsOf(ScoreKind kind) { return EntryOf(kind).needs; }

Score::Score(ScoreKind kind, const ScoreSetting& setting)
    : kind_(kind), threshold_(setting.threshold), function_(EntryOf(kind).make(setting)) {}

double ScoreFunction::operator()(double) const { FailOfKind(); }
double ScoreFunction::Derivative(double) const { FailOfKind(); }
double ScoreFunction::Bound(const float*, const float*, int) const { FailOfKind(); }
double ScoreFunction::BoundOfAll(const SquareHistogram&) const { FailOfKind(); }

double ScoreFunction::Sum(const double* residuals, const double* weights, int count) const {
  return SumInLanes(
      residuals, weights, count, [](double residual) { return residual; },
      [this](double residual) { return (*this)(residual); });
}

double ScoreFunction::OfAll(const double* residuals, const double* weights, int count, double) const {
  return Sum(residuals, weights, count);
}

}  // namespace diffsac
