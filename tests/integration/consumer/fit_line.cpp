// Fits a line to ten points of which three are outliers, with exhaustive minimal sets: y = x / 2 + 1.
#include <cmath>
#include <cstdio>

#include "diffsac/geometry/hyperplane.h"
#include "diffsac/ransac/sample_consensus.h"

int main() {
  diffsac::PointMatrix points(10, 2);
  points << 0, 1, 1, 1.5, 2, 2, 3, 2.5, 4, 3, 5, 3.5, 6, 4, 1, 9, 7, 0, 8, 9;
  diffsac::ExhaustiveSampler source(10, diffsac::Line::kMinimalSize);
  const auto result = diffsac::SampleConsensus<diffsac::Line>(points, 0.1, source, {}, diffsac::Rng(1));
  if (result.status != diffsac::Status::kOk) return 1;
  const double slope = -result.model[0] / result.model[1];
  const double intercept = -result.model[2] / result.model[1];
  int inliers = 0;
  for (const auto inlier : result.inliers) inliers += inlier;
  std::printf("slope %.3f intercept %.3f inliers %d\n", slope, intercept, inliers);
  return std::abs(slope - 0.5) < 1e-9 && std::abs(intercept - 1.0) < 1e-9 && inliers == 7 ? 0 : 1;
}
