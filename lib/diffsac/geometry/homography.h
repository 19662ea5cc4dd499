#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/model.h"
#include "diffsac/geometry/robust_loss.h"
#include "diffsac/geometry/square_bounds.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// A plane seen in two images: x2 ~ H x1. Points are correspondences x1 y1 x2 y2 in pixels (any unit); parameters are
/// H, row-major, unit Frobenius norm.
struct Homography {
  using Parameters = Matrix3Parameters;
  using Bounds = HomographyBounds;  ///< Of `Residual`.
  static constexpr int kDimension = 4;
  static constexpr int kResidualDimension = 2;  ///< Of what `Residual` is the length of.
  static constexpr int kMinimalSize = 4;
  static constexpr int kMaxSolutions = 1;

  /// The homography through 4 points in closed form: λ scales three points of each image so that they sum to the fourth
  /// (Heckbert, "Fundamentals of texture mapping and image warping", 1989), H = M2 adj(M1). 0 when three points of an
  /// image are collinear, and by the orientation test: a plane seen from one side keeps the turning sense of each
  /// triple (Marquez-Neila et al., "Improving RANSAC for fast landmark recognition", 2008). So mirrored images give 0;
  /// w > 0 for the four points.
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out);

  /// Weighted normalised direct linear transformation (Hartley and Zisserman, alg. 4.2). Needs 4 points of positive
  /// weight, no orientation test. The sign has w > 0 at the centroid.
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out);

  /// Finite, 4 distinct correspondences, in neither image all on one line.
  static bool Determined(const PointMatrix& points) { return DeterminesTwoViews(points, kMinimalSize); }

  /// As `Residual`, over 4 columns, bit for bit.
  static void Residuals(const Parameters& model, const double* const* columns, int begin, int end, double* out);

  /// HomographySampsonError.
  static double Residual(const Parameters& model, const double* point);

  /// Levenberg-Marquardt from *model (RefineHomography), with a weight ≥ 0 for each point, in `steps` steps at most;
  /// the loss is in the unit of `Residual`. False, leaving *model, when that does not lower the cost or the points are
  /// unfit.
  static bool Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                     Parameters* model, int steps = kMostRefineSteps);

  /// (s₁ − s₃)/s₂ of K2⁻¹ H K1, the singular values in order: of a plane, which is R + t nᵀ/d there, at most |t|/d.
  /// Large where the second camera would have to be far away, seen from the plane's distance to the first, or nearly
  /// within the plane; 10⁶ at most, and of what is no homography.
  static double CameraMismatch(const Parameters& model, const Eigen::Matrix3d& K1, const Eigen::Matrix3d& K2);
};

/// |H x1 - x2| in the second image. Not finite for points that H sends to infinity.
double TransferError(const Matrix3Parameters& model, const double* point);

/// The first-order distance from H (homography_sampson.h): |H x1 - x2| where H keeps lengths, so a threshold means
/// pixels of one image. Not finite where H says nothing of the correspondence. Any scale and sign of H.
double HomographySampsonError(const Matrix3Parameters& model, const double* point);

/// sqrt((|H x1 - x2|² + |H⁻¹ x2 - x1|²) / 2): root mean square of the two images' distances, so a threshold means
/// pixels of one image. Not finite (so no inlier) for a singular H and for points sent to infinity. Any scale and sign
/// of H.
double SymmetricTransferError(const Matrix3Parameters& model, const double* point);
/// The same of points [begin, end), given as 4 columns, bit for bit.
void SymmetricTransferErrors(const Matrix3Parameters& model, const double* const* columns, int begin, int end,
                             double* out);

}  // namespace diffsac
