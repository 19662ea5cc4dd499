#pragma once

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"

namespace diffsac {

DIFFSAC_CONSENSUS_TEMPLATES(extern, Homography)
DIFFSAC_CONSENSUS_TEMPLATES(extern, Fundamental)
DIFFSAC_CONSENSUS_TEMPLATES(extern, Fundamental8)
DIFFSAC_CONSENSUS_TEMPLATES(extern, Essential)

/// SampleConsensus<Essential> for callers with pixels: the correspondences (N × 4), both calibration matrices and the
/// inlier threshold in pixels, which is divided by the mean focal length. The model is E, for normalised coordinates
/// (K⁻¹ times pixels); inliers are those of its Sampson distance there. Threads: as for SampleConsensus. kDegenerate for
/// a calibration matrix that is not invertible, or of a mean focal length that is not positive.
ConsensusResult SampleEssential(const PointMatrix& pixels, const Eigen::Matrix3d& K1, const Eigen::Matrix3d& K2,
                                double threshold_px, const HypothesisSource& source, const ConsensusOptions& options,
                                Rng rng, int threads = 1);

}  // namespace diffsac
