#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "diffsac/geometry/points.h"
#include "diffsac/geometry/translation.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// Whether the matches of two views show parallax, without which epipolar geometry says nothing of the translation.
struct ParallaxTest {
  Translation translation = Translation::kNotTested;  ///< What they say of it.
  /// Where the camera turned or stood still: R, fitted to the matches, which determine it better than E does.
  std::optional<Eigen::Matrix3d> turn = {};
};

/// Of an essential matrix. points: N × 4, normalised coordinates; inliers: N values, not 0 for those of E.
///
/// Compared are a rotation, fitted robustly to the inliers, and E. What the rotation leaves of a match has a length ρ,
/// in the unit of its noise. Where the camera only turned that is noise, or, of a wrong match, anything: it has no
/// preferred direction, so that E's Sampson distance is within δ with probability 2/π asin(δ/ρ). Parallax points along
/// the epipolar line: the distance is noise, whatever ρ is. δ is the inliers' root mean square. The test is the ratio
/// of the two likelihoods over all matches, some share of which has parallax; it must exceed what the best direction of
/// t gives by chance. It knows no threshold and no noise, and a few wrong inliers prove nothing.
ParallaxTest TestTurn(const PointMatrix& points, const Matrix3Parameters& essential,
                      const std::vector<std::uint8_t>& inliers);

/// Of a fundamental matrix: the same with a homography in place of the rotation. points: N × 4, any unit.
ParallaxTest TestPlane(const PointMatrix& points, const Matrix3Parameters& fundamental,
                       const std::vector<std::uint8_t>& inliers);

/// Of which points are of unknown focal length: by how much those of one image, or of both, must be divided for a
/// rotation to explain the inliers best, from 1/4 to 4. False where none does.
bool FindFocalOfTurn(const PointMatrix& points, const std::vector<std::uint8_t>& inliers, bool first, bool second,
                     double* factor);

/// Which of the points (`columns`: two of them) are beside the line on which most of the inliers lie; N values. A point
/// is beside it that is farther away than `reach`, or than rounding errors.
std::vector<std::uint8_t> BesideLine(const PointMatrix& points, int column, const std::vector<std::uint8_t>& inliers,
                                     double reach);

}  // namespace diffsac
