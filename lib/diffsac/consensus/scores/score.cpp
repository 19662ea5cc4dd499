#include "diffsac/consensus/scores/score.h"

#include <stdexcept>

#include "diffsac/consensus/scores/gaussian_uniform.h"
#include "diffsac/consensus/scores/inlier_count.h"
#include "diffsac/consensus/scores/magsac.h"
#include "diffsac/consensus/scores/marginalised_msac.h"
#include "diffsac/consensus/scores/msac.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/lanes.h"

namespace diffsac {
namespace {

std::shared_ptr<const ScoreFunction> Make(ScoreKind kind, const ScoreSetting& setting) {
  switch (kind) {
    case ScoreKind::kInlierCount:
      return std::make_shared<const InlierCount>(setting);
    case ScoreKind::kMsac:
      return std::make_shared<const Msac>(setting);
    case ScoreKind::kGaussianUniform:
      return std::make_shared<const GaussianUniform>(setting);
    case ScoreKind::kMagsac:
      return std::make_shared<const MagsacScore>(setting);
    case ScoreKind::kMarginalised:
      return std::make_shared<const MarginalisedMsac>(setting);
  }
  throw std::logic_error("a score is not registered");
}

}  // namespace

Score::Score(ScoreKind kind, const ScoreSetting& setting)
    : kind_(kind), threshold_(setting.threshold), function_(Make(kind, setting)) {}

double ScoreFunction::Bound(const float*, const float*, int) const { throw Error("the score has no quick bound"); }

double ScoreFunction::Sum(const double* residuals, const double* weights, int count) const {
  return SumInLanes(
      residuals, weights, count, [](double residual) { return residual; },
      [this](double residual) { return (*this)(residual); });
}

}  // namespace diffsac
