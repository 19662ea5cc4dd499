#include "diffsac/problem/coordinates.h"

#include <algorithm>
#include <vector>

#include "diffsac/geometry/pose.h"
#include "diffsac/problem/shared_focal_task.h"

namespace diffsac {
namespace {

double Median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + middle, values.end());
  if (values.size() % 2 == 1) return values[middle];
  return 0.5 * (values[middle] + *std::max_element(values.begin(), values.begin() + middle));
}

void CentreImage(const ImageSize& size, int first, PointMatrix* points) {
  const double unit = kUsualFocal * std::max(size.width, size.height);
  points->col(first).array() = (points->col(first).array() - 0.5 * size.width) / unit;
  points->col(first + 1).array() = (points->col(first + 1).array() - 0.5 * size.height) / unit;
}

}  // namespace

PointMatrix CentredCoordinates(const PointMatrix& points) {
  PointMatrix centred = points;
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    const Eigen::VectorXd column = points.col(k);
    centred.col(k).array() -= Median({column.data(), column.data() + column.size()});
  }
  const Eigen::VectorXd distances = centred.rowwise().norm();
  double scale = Median({distances.data(), distances.data() + distances.size()});
  if (!(scale > 0.0)) scale = distances.mean();
  return scale > 0.0 ? PointMatrix(centred / scale) : centred;
}

Eigen::Matrix3d CentredCamera(double focal, const ImageSize& size) {
  Eigen::Matrix3d K = Eigen::Vector3d(focal, focal, 1.0).asDiagonal();
  K.topRightCorner<2, 1>() << 0.5 * (size.width - 1), 0.5 * (size.height - 1);
  return K;
}

PointMatrix MatchCoordinates(const Problem& problem, bool use_calibration) {
  if (problem.cameras && use_calibration)
    return NormalizedCoordinates(problem.points, problem.cameras->K1, problem.cameras->K2);
  PointMatrix points = problem.points;
  if (problem.size1.known() && problem.size2.known()) {
    CentreImage(problem.size1, 0, &points);
    CentreImage(problem.size2, 2, &points);
  } else {
    points.leftCols(2) = CentredCoordinates(problem.points.leftCols(2));
    points.rightCols(2) = CentredCoordinates(problem.points.rightCols(2));
  }
  return points;
}

}  // namespace diffsac
