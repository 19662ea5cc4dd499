#include "diffsac/geometry/pose.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "diffsac/geometry/rotation.h"
#include "diffsac/geometry/svd3.h"

namespace diffsac {
namespace {

constexpr double kPi = 3.14159265358979323846, kDegrees = 180.0 / kPi;

Eigen::Vector3d First(const double* point) { return {point[0], point[1], 1.0}; }
Eigen::Vector3d Second(const double* point) { return {point[2], point[3], 1.0}; }

/// Rows that take part.
std::vector<int> Chosen(const PointMatrix& points, const std::vector<std::uint8_t>& inliers) {
  std::vector<int> rows;
  for (int i = 0; i < points.rows(); ++i)
    if (inliers.empty() || (i < static_cast<int>(inliers.size()) && inliers[i] != 0)) rows.push_back(i);
  return rows;
}

bool AllFinite(const PointMatrix& points, const std::vector<int>& rows) {
  for (const int i : rows)
    if (!points.row(i).allFinite()) return false;
  return true;
}

}  // namespace

Eigen::Matrix3d EssentialFromPose(const RelativePose& pose) { return CrossMatrix(pose.translation) * pose.rotation; }

Eigen::Matrix3d EssentialFromFundamental(const Eigen::Matrix3d& f, const Eigen::Matrix3d& k1,
                                         const Eigen::Matrix3d& k2) {
  return k2.transpose() * f * k1;
}

Eigen::Matrix3d FundamentalFromEssential(const Eigen::Matrix3d& e, const Eigen::Matrix3d& k1,
                                         const Eigen::Matrix3d& k2) {
  return k2.inverse().transpose() * e * k1.inverse();
}

PointMatrix NormalizedCoordinates(const PointMatrix& pixels, const Eigen::Matrix3d& k1, const Eigen::Matrix3d& k2) {
  const Eigen::Matrix3d inverse1 = k1.inverse(), inverse2 = k2.inverse();
  PointMatrix out(pixels.rows(), 4);
  for (Eigen::Index i = 0; i < pixels.rows(); ++i) {
    out.row(i).head<2>() = (inverse1 * First(pixels.data() + 4 * i)).hnormalized();
    out.row(i).tail<2>() = (inverse2 * Second(pixels.data() + 4 * i)).hnormalized();
  }
  return out;
}

std::array<RelativePose, 4> DecomposeEssential(const Eigen::Matrix3d& e) {
  const auto [u, v, values] = ComputeRotationSvd3(e);
  Eigen::Matrix3d quarter_turn;
  quarter_turn << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  const Eigen::Matrix3d r = u * quarter_turn * v.transpose(), twisted = u * quarter_turn.transpose() * v.transpose();
  const Eigen::Vector3d t = u.col(2);
  return {RelativePose{r, t}, RelativePose{r, -t}, RelativePose{twisted, t}, RelativePose{twisted, -t}};
}

bool InFront(const RelativePose& pose, const double* point) {
  // λ2 b = λ1 a + t in the least-squares sense, a = R x1, b = x2; only the signs of λ are needed.
  const Eigen::Vector3d a = pose.rotation * First(point), b = Second(point);
  const Eigen::Vector3d normal = a.cross(b);
  return b.cross(pose.translation).dot(normal) > 0.0 && a.cross(pose.translation).dot(normal) > 0.0;
}

namespace {

int CountInFront(const RelativePose& pose, const PointMatrix& points, const std::vector<int>& rows) {
  return static_cast<int>(std::count_if(rows.begin(), rows.end(), [&](int i) { return InFront(pose, &points(i, 0)); }));
}

/// Of the points in front, the fourth power of the angles between their rays in units of four times the noise, at most
/// 1 each: far points, be they many, whose angles are noise, do not outvote a few near ones.
double Parallax(const RelativePose& pose, const PointMatrix& points, const std::vector<int>& rows, double noise) {
  double sum = 0.0;
  for (const int i : rows) {
    const double* point = &points(i, 0);
    if (!InFront(pose, point)) continue;
    const Eigen::Vector3d a = pose.rotation * First(point), b = Second(point);
    const double square = a.cross(b).squaredNorm() / (16.0 * noise * noise * a.squaredNorm() * b.squaredNorm());
    sum += std::min(1.0, square * square);
  }
  return sum;
}

}  // namespace

bool PassesCheirality(const RelativePose& pose, const double* point, double tolerance) {
  if (InFront(pose, point)) return true;
  // In the epipolar plane, that of the ray farther from the epipole, by signed angles from t: a point before both
  // cameras is seen at 0 < φ2 < φ1 < π.
  const Eigen::Vector3d t = pose.translation, a = pose.rotation * First(point), b = Second(point);
  const Eigen::Vector3d plane_a = t.cross(a.normalized()), plane_b = t.cross(b.normalized());
  const Eigen::Vector3d normal = (plane_a.squaredNorm() > plane_b.squaredNorm() ? plane_a : plane_b).normalized();
  const auto angle = [&](const Eigen::Vector3d& ray) { return std::atan2(t.cross(ray).dot(normal), t.dot(ray)); };
  const double first = angle(a), second = angle(b);
  // Beyond the epipole the other way round, a little below 0 is a little above π.
  const auto turned = [&](double phi) { return phi < -0.5 * kPi ? phi + 2.0 * kPi : phi; };
  const auto front = [&](double phi1, double phi2) {
    return phi2 > -tolerance && phi1 < kPi + tolerance && phi1 - phi2 > -2.0 * tolerance;
  };
  return front(turned(first), turned(second)) || front(turned(-first), turned(-second));
}

PoseChoice ChoosePose(const Eigen::Matrix3d& e, const PointMatrix& points, const std::vector<std::uint8_t>& inliers,
                      double noise) {
  PoseChoice choice;
  const std::vector<int> rows = Chosen(points, inliers);
  choice.status = Status::kDegenerate;
  if (points.cols() != 4 && points.rows() > 0) return choice;
  if (!e.allFinite() || !(e.norm() > 0.0) || !AllFinite(points, rows)) return choice;
  choice.status = Status::kTooFewPoints;
  if (rows.empty()) return choice;
  choice.in_front = -1;
  choice.runner_up = -1;
  for (const RelativePose& pose : DecomposeEssential(e)) {
    const int count = CountInFront(pose, points, rows);
    if (count > choice.in_front) {
      choice.runner_up = choice.in_front;
      choice.in_front = count;
      choice.pose = pose;
    } else if (count > choice.runner_up) {
      choice.runner_up = count;
    }
  }
  const RelativePose opposite{choice.pose.rotation, -choice.pose.translation};
  if (noise > 0.0 && choice.in_front > 0 &&
      Parallax(opposite, points, rows, noise) > Parallax(choice.pose, points, rows, noise)) {
    choice.pose = opposite;
    choice.runner_up = choice.in_front;
    choice.in_front = CountInFront(opposite, points, rows);
  }
  choice.status = Status::kOk;
  if (choice.in_front == choice.runner_up) choice.status = Status::kDegenerate;
  if (choice.in_front == 0) choice.status = Status::kNoModel;
  return choice;
}

double RotationAngleDegrees(const Eigen::Matrix3d& r1, const Eigen::Matrix3d& r2) {
  // |R1 − R2| = 2 √2 sin(θ/2) and tr(R1ᵀ R2) = 4 cos²(θ/2) − 1: sine and cosine of the half angle each keep their
  // digits.
  const double sine = (r1 - r2).norm() / (2.0 * std::sqrt(2.0));
  const double cosine = 0.5 * std::sqrt(std::max(0.0, 1.0 + (r1.transpose() * r2).trace()));
  return 2.0 * std::atan2(sine, cosine) * kDegrees;
}

double DirectionAngleDegrees(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double length_a = a.norm(), length_b = b.norm();
  if (!(length_a > 0.0) || !(length_b > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d unit_a = a / length_a, unit_b = b / length_b;
  return 2.0 * std::atan2((unit_a - unit_b).norm(), (unit_a + unit_b).norm()) * kDegrees;
}

}  // namespace diffsac
