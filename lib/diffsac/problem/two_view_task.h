#pragma once

#include "diffsac/geometry/parallax.h"
#include "diffsac/geometry/two_view.h"
#include "diffsac/problem/coordinates.h"
#include "diffsac/problem/task_description.h"

namespace diffsac {

/// What homographies, fundamental and essential matrices share: matches of two images, in pixels, and a 3 × 3 matrix.
///
/// A description derived from it has members more:
///   PixelModel(model, problem)    the matrix by which PixelResidual of matches in pixels is in pixels, for what is
///                                 measured there (lab/data/repeated_structures.h, the errors without a pose)
///   kUnknownFocal                 where focal lengths are estimated: whose
template <class Own, class... Others>
struct TwoViewTask : TaskDescriptionOf<Own, Others...> {
  static constexpr bool kTwoView = true;
  static PointMatrix FeatureCoordinates(const NormalizedProblem& space) { return MatchCoordinates(space.problem()); }
  static PointMatrix ImagePoints(const Problem& problem) { return problem.points.leftCols(2); }
  static ParallaxTest Parallax(const ModelParameters&, const std::vector<std::uint8_t>&, const NormalizedProblem&) {
    return {Degeneracy::kDetermined};
  }
  static Matrix3Parameters PixelModel(const ModelParameters& model, const Problem&) { return model; }
  static double PixelResidual(const Matrix3Parameters& model, const double* point) {
    return Own::Residual(model, point);
  }
};

/// AsMatrix of parameters behind type erasure.
inline Eigen::Matrix3d ModelMatrix(const ModelParameters& model) { return AsMatrix(Matrix3Parameters(model)); }

}  // namespace diffsac
