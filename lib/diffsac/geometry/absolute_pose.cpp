#include "diffsac/geometry/absolute_pose.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "diffsac/geometry/polynomial.h"
#include "diffsac/geometry/rotation.h"

namespace diffsac {
namespace {

/// The three rays' cosines and the scene's squared distances, of the pairs 01, 02, 12.
struct Triangle {
  double cosine[3];
  double square[3];
};
constexpr int kPairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};

Triangle TriangleOf(const Eigen::Vector3d scene[3], const Eigen::Vector3d rays[3]) {
  Triangle triangle;
  for (int k = 0; k < 3; ++k) {
    triangle.cosine[k] = rays[kPairs[k][0]].dot(rays[kPairs[k][1]]);
    triangle.square[k] = (scene[kPairs[k][0]] - scene[kPairs[k][1]]).squaredNorm();
  }
  return triangle;
}

/// With x = d0/d2 and y = d1/d2: d0² − 2 c d0 d2 + d2² and its like as conics in (x, y, 1).
Eigen::Matrix3d PairConic(const Triangle& triangle, int pair) {
  Eigen::Matrix3d conic = Eigen::Matrix3d::Zero();
  const int i = kPairs[pair][0], j = kPairs[pair][1];
  conic(i, i) = conic(j, j) = 1.0;
  conic(i, j) = conic(j, i) = -triangle.cosine[pair];
  return conic;
}

/// The two lines of a degenerate conic; false where they are not real.
bool SplitConic(const Eigen::Matrix3d& conic, Eigen::Vector3d lines[2]) {
  Eigen::Matrix3d adjugate;
  adjugate.row(0) = conic.col(1).cross(conic.col(2)).transpose();
  adjugate.row(1) = conic.col(2).cross(conic.col(0)).transpose();
  adjugate.row(2) = conic.col(0).cross(conic.col(1)).transpose();
  // The point where the lines meet, squared and with the sign of the discriminant: −adj(C) = p pᵀ for real lines.
  int largest = 0;
  (-adjugate).diagonal().maxCoeff(&largest);
  const double square = -adjugate(largest, largest);
  if (!(square > 0.0)) return false;
  const Eigen::Vector3d meeting = -adjugate.col(largest) / std::sqrt(square);
  const Eigen::Matrix3d product = conic + CrossMatrix(meeting);
  Eigen::Index row = 0, column = 0;
  product.cwiseAbs().maxCoeff(&row, &column);
  lines[0] = product.row(row).transpose();
  lines[1] = product.col(column);
  return lines[0].allFinite() && lines[1].allFinite();
}

/// The real points (x, y), both positive, where a line meets a conic.
int MeetConic(const Eigen::Vector3d& line, const Eigen::Matrix3d& conic, Eigen::Vector2d out[2]) {
  // The line as a + s b, by the coordinate that it determines best.
  Eigen::Vector3d a, b;
  if (std::abs(line[0]) > std::abs(line[1])) {
    a << -line[2] / line[0], 0.0, 1.0;
    b << -line[1] / line[0], 1.0, 0.0;
  } else {
    if (line[1] == 0.0) return 0;
    a << 0.0, -line[2] / line[1], 1.0;
    b << 1.0, -line[0] / line[1], 0.0;
  }
  const double c2 = b.dot(conic * b), c1 = a.dot(conic * b), c0 = a.dot(conic * a);
  const double discriminant = c1 * c1 - c2 * c0;
  if (!(discriminant >= 0.0)) return 0;
  const double root = c1 >= 0.0 ? -c1 - std::sqrt(discriminant) : -c1 + std::sqrt(discriminant);
  const double steps[2] = {root / c2, root != 0.0 ? c0 / root : 0.0};
  int count = 0;
  for (const double s : steps) {
    const Eigen::Vector2d point = (a + s * b).head<2>();
    if (point.allFinite() && point.minCoeff() > 0.0) out[count++] = point;
  }
  return count;
}

/// Newton steps on the three squared distances.
void PolishDepths(const Triangle& triangle, Eigen::Vector3d* depths) {
  constexpr int kSteps = 5;
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Vector3d residual;
    Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const int i = kPairs[k][0], j = kPairs[k][1];
      const double di = (*depths)[i], dj = (*depths)[j], c = triangle.cosine[k];
      residual[k] = di * di + dj * dj - 2.0 * c * di * dj - triangle.square[k];
      jacobian(k, i) = 2.0 * (di - c * dj);
      jacobian(k, j) = 2.0 * (dj - c * di);
    }
    const Eigen::Vector3d change = jacobian.partialPivLu().solve(residual);
    if (!change.allFinite() || change.norm() > 0.5 * depths->norm()) return;
    *depths -= change;
    if (change.norm() <= 1e-15 * depths->norm()) return;
  }
}

/// The pose that takes three points of the scene to three points before the camera.
AbsolutePose::Parameters PoseOfTriangles(const Eigen::Vector3d scene[3], const Eigen::Vector3d camera[3]) {
  const auto frame = [](const Eigen::Vector3d points[3]) {
    Eigen::Matrix3d axes;
    axes.col(0) = (points[1] - points[0]).normalized();
    axes.col(2) = axes.col(0).cross(points[2] - points[0]).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
    return axes;
  };
  const Eigen::Matrix3d rotation = frame(camera) * frame(scene).transpose();
  const Eigen::Vector3d from = (scene[0] + scene[1] + scene[2]) / 3.0, to = (camera[0] + camera[1] + camera[2]) / 3.0;
  return PoseOf(rotation, to - rotation * from);
}

bool OnOneLine(const Eigen::MatrixXd& points) {
  constexpr double kFlat = 1e-12;
  const Eigen::MatrixXd centred = points.rowwise() - points.colwise().mean();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(centred.transpose() * centred);
  const Eigen::VectorXd& values = solver.eigenvalues();
  return !(values[values.size() - 2] > kFlat * values[values.size() - 1]);
}

}  // namespace

Eigen::Matrix3d RotationOf(const AbsolutePose::Parameters& model) {
  Eigen::Matrix3d rotation;
  for (int i = 0; i < 3; ++i) rotation.row(i) = model.segment<3>(4 * i).transpose();
  return rotation;
}

Eigen::Vector3d TranslationOf(const AbsolutePose::Parameters& model) { return {model[3], model[7], model[11]}; }

AbsolutePose::Parameters PoseOf(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  AbsolutePose::Parameters model;
  for (int i = 0; i < 3; ++i) {
    model.segment<3>(4 * i) = rotation.row(i).transpose();
    model[4 * i + 3] = translation[i];
  }
  return model;
}

int SolveP3P(const Eigen::Vector3d scene[3], const Eigen::Vector3d rays[3], AbsolutePose::Parameters out[4]) {
  const Triangle triangle = TriangleOf(scene, rays);
  const double area = (scene[1] - scene[0]).cross(scene[2] - scene[0]).norm();
  const double longest = *std::max_element(triangle.square, triangle.square + 3);
  if (!(area > 1e-9 * longest)) return 0;
  // Each pair's conic times another's squared distance, so that the unknown scale of the depths drops out.
  const Eigen::Matrix3d last = PairConic(triangle, 2);
  const Eigen::Matrix3d first = (triangle.square[2] * PairConic(triangle, 0) - triangle.square[0] * last) / longest;
  const Eigen::Matrix3d second = (triangle.square[2] * PairConic(triangle, 1) - triangle.square[1] * last) / longest;
  const auto mixed = [](const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
      Eigen::Matrix3d replaced = a;
      replaced.col(k) = b.col(k);
      sum += replaced.determinant();
    }
    return sum;
  };
  const double cubic[4] = {first.determinant(), mixed(first, second), mixed(second, first), second.determinant()};
  double roots[3];
  const int count = SolveCubic(cubic, roots);
  int solutions = 0;
  for (int r = 0; r < count && solutions == 0; ++r) {
    Eigen::Vector3d lines[2];
    if (!SplitConic(first + roots[r] * second, lines)) continue;
    for (const Eigen::Vector3d& line : lines) {
      Eigen::Vector2d ratios[2];
      const int found = MeetConic(line, second, ratios);
      for (int i = 0; i < found && solutions < 4; ++i) {
        const Eigen::Vector3d ratio = ratios[i].homogeneous();
        const double square = ratio.dot(last * ratio);
        if (!(square > 0.0)) continue;
        Eigen::Vector3d depths = ratio * std::sqrt(triangle.square[2] / square);
        PolishDepths(triangle, &depths);
        if (!(depths.minCoeff() > 0.0)) continue;
        const Eigen::Vector3d camera[3] = {depths[0] * rays[0], depths[1] * rays[1], depths[2] * rays[2]};
        out[solutions] = PoseOfTriangles(scene, camera);
        if (out[solutions].allFinite()) ++solutions;
      }
    }
  }
  return solutions;
}

int AbsolutePose::SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
  Eigen::Vector3d scene[3], rays[3];
  for (int i = 0; i < 3; ++i) {
    scene[i] = points.row(set[i]).head<3>();
    rays[i] = Eigen::Vector3d(points(set[i], 3), points(set[i], 4), 1.0).normalized();
    if (!scene[i].allFinite() || !rays[i].allFinite()) return 0;
  }
  return SolveP3P(scene, rays, out);
}

bool AbsolutePose::Determined(const PointMatrix& points) {
  return points.rows() >= kMinimalSize && points.cols() == kDimension && points.allFinite() &&
         !OnOneLine(points.leftCols(3)) && !OnOneLine(points.rightCols(2));
}

double AbsolutePose::Residual(const Parameters& model, const double* point) {
  const auto row = [&](int i) {
    return model[4 * i] * point[0] + model[4 * i + 1] * point[1] + model[4 * i + 2] * point[2] + model[4 * i + 3];
  };
  const double depth = row(2);
  if (!(depth > 0.0)) return std::numeric_limits<double>::infinity();
  const double du = row(0) / depth - point[3], dv = row(1) / depth - point[4];
  return std::sqrt(du * du + dv * dv);
}

void AbsolutePose::Residuals(const Parameters& model, const double* const* columns, int begin, int end, double* out) {
  for (int i = begin; i < end; ++i) {
    const double point[kDimension] = {columns[0][i], columns[1][i], columns[2][i], columns[3][i], columns[4][i]};
    out[i - begin] = Residual(model, point);
  }
}

}  // namespace diffsac
