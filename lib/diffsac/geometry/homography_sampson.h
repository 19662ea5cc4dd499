#pragma once

#include <cmath>

#include "diffsac/geometry/sampson_equations.h"

namespace diffsac {

/// The first-order (Sampson) distance of a correspondence from a homography, and what Levenberg-Marquardt needs of it
/// (Chum, Pajdla, Sturm, "The geometric error for homographies", CVIU 2005). With w = (H x1)₃, the algebraic errors
///   e = w x2 − ((H x1)₁, (H x1)₂)
/// and their derivative J = [p₀ p₁ w 0; q₀ q₁ 0 w] by x1 y1 x2 y2, where p = x2 (h₇, h₈) − (h₁, h₂) and
/// q = y2 (h₇, h₈) − (h₄, h₅), the square is 2 eᵀ (J Jᵀ)⁻¹ e: twice the least squared motion of both points, to first
/// order, that makes them correspond. The factor makes it |H x1 − x2|² where H keeps lengths, so that thresholds mean
/// pixels of one image, as those of transfer errors do. Where H shrinks or stretches, it weighs each direction by the
/// noise of both images; transfer errors count one image's noise as magnified by H, most so in views from the side.
struct HomographySampson {
  double e0, e1, p0, p1, q0, q1, w;

  HomographySampson(const double* h, double x1, double y1, double x2, double y2)
      : p0(x2 * h[6] - h[0]),
        p1(x2 * h[7] - h[1]),
        q0(y2 * h[6] - h[3]),
        q1(y2 * h[7] - h[4]),
        w((h[6] * x1 + h[7] * y1) + h[8]) {
    e0 = x2 * w - ((h[0] * x1 + h[1] * y1) + h[2]);
    e1 = y2 * w - ((h[3] * x1 + h[4] * y1) + h[5]);
  }

  /// det J Jᵀ, as a sum of squares.
  double Determinant() const {
    const double cross = p0 * q1 - p1 * q0, square = w * w;
    return cross * cross + square * (((p0 * p0 + p1 * p1) + (q0 * q0 + q1 * q1)) + square);
  }

  double Square() const {
    const double a = e0 * q0 - e1 * p0, b = e0 * q1 - e1 * p1;
    return 2.0 * ((a * a + b * b) + w * w * (e0 * e0 + e1 * e1)) / Determinant();
  }
};

/// The square roots of the squares of points [begin, end), given as 4 columns. Not finite where H says nothing: w = 0
/// and the two errors depend on the points alike.
void HomographySampsonDistances(const double* h, const double* const* columns, int begin, int end, double* out);

/// Weighted sums over `count` points given as 4 columns: the exact gradient of half the weighted squares by the nine
/// entries of H, and the normal equations of Gauss and Newton with (J Jᵀ)⁻¹ held. Points of weight 0 add nothing,
/// wherever H sends them.
NormalEquations SumHomographySampsonEquations(const double* h, const double* const* columns, const double* weights,
                                              int count);

}  // namespace diffsac
