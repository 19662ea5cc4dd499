#include <Eigen/LU>

#include "diffsac/consensus/two_view_consensus.h"
#include "diffsac/geometry/pose.h"

namespace diffsac {

ConsensusResult SampleEssential(const PointMatrix& pixels, const Eigen::Matrix3d& K1, const Eigen::Matrix3d& K2,
                                double threshold_px, const HypothesisSource& source, const ConsensusOptions& options,
                                Rng rng, int threads) {
  ConsensusResult degenerate;
  degenerate.status = pixels.rows() < Essential::kMinimalSize ? Status::kTooFewPoints : Status::kDegenerate;
  const double focal = MeanFocal(K1, K2);
  if (!(focal > 0.0) || !K1.allFinite() || !K2.allFinite() || pixels.cols() != 4 ||
      pixels.rows() < Essential::kMinimalSize)
    return degenerate;
  if (K1.determinant() == 0.0 || K2.determinant() == 0.0) return degenerate;
  return SampleConsensus<Essential>(NormalizedCoordinates(pixels, K1, K2), threshold_px / focal, source, options, rng,
                                    {}, threads);
}

}  // namespace diffsac
