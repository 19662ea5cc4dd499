#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "diffsac/geometry/degeneracy.h"
#include "diffsac/geometry/points.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// Whether the matches of two views show parallax, without which epipolar geometry says nothing of the translation.
struct ParallaxTest {
  Degeneracy degeneracy = Degeneracy::kNotTested;  ///< What they say of it.
  /// Where the camera turned or stood still: R, fitted to the matches, which determine it better than E does.
  std::optional<Eigen::Matrix3d> pure_rotation = {};
};

/// Of an essential matrix. points: N × 4, normalised coordinates; inliers: N values, not 0 for those of E.
///
/// Compares a rotation, fitted robustly to the inliers, with E. What the rotation leaves of a match has a length ρ, in
/// the unit of its noise. Of a camera that only turned it is noise, or, of a wrong match, anything: it has no preferred
/// direction, so that E's Sampson distance is within δ with probability 2/π asin(δ/ρ). Parallax points along the
/// epipolar line: the distance is noise, whatever ρ is. σ is the inliers' root mean square. The test is the ratio of
/// the two likelihoods. In each octave of ρ some share of the matches has parallax, the likeliest one: wrong matches,
/// of which few are as far from the map as right ones, count neither for nor against it. The ratio must exceed what the
/// best direction of t gives by chance.
ParallaxTest TestTurn(const PointMatrix& points, const Matrix3Parameters& essential,
                      const std::vector<std::uint8_t>& inliers);

/// Of a fundamental matrix: the same with a homography in place of the rotation. points: N × 4, any unit.
ParallaxTest TestPlane(const PointMatrix& points, const Matrix3Parameters& fundamental,
                       const std::vector<std::uint8_t>& inliers);

/// Which focal lengths of two views are unknown.
enum class TurnFocals { kFirst, kSecond, kBothAlike, kEach };

/// By how much the points of either image must be divided for a rotation to explain the inliers best, each from 1/4 to
/// 4 in one step of the search; 1 for a known focal length. False where no homography fits them.
bool FindFocalsOfTurn(const PointMatrix& points, const std::vector<std::uint8_t>& inliers, TurnFocals unknown,
                      Eigen::Vector2d* factors);

/// Which of the points (`columns`: two of them) are beside the line on which most of the inliers lie; N values. A point
/// is beside it that is farther away than `reach`, or than rounding errors.
std::vector<std::uint8_t> BesideLine(const PointMatrix& points, int column, const std::vector<std::uint8_t>& inliers,
                                     double reach);

}  // namespace diffsac
