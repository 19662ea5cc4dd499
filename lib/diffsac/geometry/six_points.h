#pragma once

#include "diffsac/geometry/points.h"
#include "diffsac/geometry/unknown_focal.h"

namespace diffsac {

/// Solutions of six points at most: 15 with one unknown focal length in both images, 9 with one in the second.
constexpr int MaxSixPointSolutions(UnknownFocal unknown) { return unknown == UnknownFocal::kBoth ? 15 : 9; }
/// Focal lengths from its inverse to this, in the unit of the points, are looked for.
inline constexpr double kGreatestFocal = 10.0;

/// All real solutions E, f of six correspondences, without the orientation test; `points[i]` = x1 y1 x2 y2 as
/// UnknownFocal says. Returns how many; 0 for degenerate sets.
///
/// F is a combination x F₁ + y F₂ + F₃ of the null vectors of the epipolar equations. With Q = diag(1, 1, w), w = f⁻²,
/// the matrix E that F makes with the unknown cameras is essential where det F = 0 and
///   2 F Q Fᵀ Q F − tr(F Q Fᵀ Q) F = 0 (both unknown),   2 F Fᵀ Q F − tr(F Fᵀ Q) F = 0 (the second)
/// (Stewénius, Nistér, Kahl, Schaffalitzky, "A minimal solution for relative pose with unknown focal length", CVPR
/// 2005; Bujnak, Kukelova, Pajdla, "3D reconstruction from image collections with a single known focal length", ICCV
/// 2009): ten cubics in x and y whose coefficients are polynomials in w, C(w) v = 0 with v the ten monomials. That is a
/// polynomial eigenvalue problem (Kukelova, Bujnak, Pajdla, "Polynomial eigenvalue solutions to the 5-pt and 6-pt
/// relative pose problems", BMVC 2008), solved for f². Of C₂ w², which has F₃₃ as a factor, the rank is six: the
/// linearised matrix is 16 × 16. Each root is polished on the trace constraint of E by Gauss-Newton steps.
template <UnknownFocal kUnknown>
int SolveSixPoints(const double (*points)[4], FocalParameters* out);

}  // namespace diffsac
