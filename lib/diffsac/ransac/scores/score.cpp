#include "diffsac/ransac/scores/score.h"

#include <stdexcept>

#include "diffsac/core/status.h"
#include "diffsac/geometry/lanes.h"
#include "diffsac/ransac/scores/inlier_count.h"
#include "diffsac/ransac/scores/magsac.h"
#include "diffsac/ransac/scores/mlesac.h"
#include "diffsac/ransac/scores/msac.h"
#include "diffsac/ransac/scores/sigma_marginalised_msac.h"

namespace diffsac {
namespace {

std::shared_ptr<const ScoreFunction> Make(ScoreKind kind, const ScoreSetting& setting) {
  switch (kind) {
    case ScoreKind::kInlierCount:
      return std::make_shared<const InlierCount>(setting);
    case ScoreKind::kMsac:
      return std::make_shared<const Msac>(setting);
    case ScoreKind::kMlesac:
      return std::make_shared<const Mlesac>(setting);
    case ScoreKind::kMagsac:
      return std::make_shared<const MagsacScore>(setting);
    case ScoreKind::kSigmaMarginalisedMsac:
      return std::make_shared<const SigmaMarginalisedMsac>(setting);
  }
  throw std::logic_error("a score is not registered");
}

}  // namespace

Score::Score(ScoreKind kind, const ScoreSetting& setting)
    : kind_(kind), threshold_(setting.threshold), function_(Make(kind, setting)) {}

double ScoreFunction::UpperBound(const float*, const float*, int) const { throw Error("the score has no quick bound"); }

double ScoreFunction::Sum(const double* residuals, const double* weights, int count) const {
  return SumInLanes(
      residuals, weights, count, [](double residual) { return residual; },
      [this](double residual) { return (*this)(residual); });
}

}  // namespace diffsac
