// The relative pose of two cameras that know where down is, from three matches: an own model, estimated by
// ransac::Search. Reads from stdin what upright_matches.py writes and prints the errors of R and t in degrees.
//
// In frames whose y axis is down, R is a turn about y by θ. With q = tan(θ/2), three matches have a common t where the
// determinant of their (R x1) × x2, a polynomial in q of degree 6, is 0.
#include <diffsac/geometry/polynomial.h>
#include <diffsac/ransac/search.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <numbers>
#include <vector>

using diffsac::PointMatrix;

struct UprightPose {
  using Parameters = Eigen::Vector4d;   // θ, t of any length
  static constexpr int kDimension = 6;  // unit rays of both cameras
  static constexpr int kMinimalSize = 3;
  static constexpr int kMaxSolutions = 6;
  static constexpr bool kFreeParameters = true;

  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
    Eigen::Matrix3d power[3];  // Row i: what of (R x1) × x2 of match i, times 1 + q², goes with 1, q and q².
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d a = points.row(set[i]).head<3>(), b = points.row(set[i]).tail<3>();
      power[0].row(i) = a.cross(b);
      power[1].row(i) = Eigen::Vector3d(2.0 * a[2], 0.0, -2.0 * a[0]).cross(b);
      power[2].row(i) = Eigen::Vector3d(-a[0], a[1], -a[2]).cross(b);
    }
    double determinant[11] = {}, roots[10];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k)
          determinant[i + j + k] += power[i].row(0).cross(power[j].row(1)).dot(power[k].row(2));
    const int count = std::min(diffsac::RealRoots10(determinant, roots), kMaxSolutions);
    int solutions = 0;
    for (int i = 0; i < count; ++i) {
      const Eigen::Matrix3d rows = power[0] + roots[i] * power[1] + roots[i] * roots[i] * power[2];
      const Eigen::Vector3d ab = rows.row(0).cross(rows.row(1)), bc = rows.row(1).cross(rows.row(2));
      const Eigen::Vector3d t = ab.squaredNorm() > bc.squaredNorm() ? ab : bc;
      if (!(t.norm() > 0.0)) continue;
      out[solutions++] << 2.0 * std::atan(roots[i]), t.normalized();
    }
    return solutions;
  }
  // Sampson's angle between the rays and the epipolar planes, in radians.
  static double Residual(const Parameters& pose, const double* point) {
    const Eigen::Map<const Eigen::Vector3d> a(point), b(point + 3);
    const Eigen::Vector3d turned = Turn(pose[0]) * a, t = pose.tail<3>();
    const double error = b.dot(t.cross(turned));
    const double squares = t.cross(turned).squaredNorm() + b.cross(t).squaredNorm() - 2.0 * error * error;
    return std::abs(error) / std::sqrt(std::max(squares, 1e-300));
  }
  static Eigen::Matrix3d Turn(double angle) { return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).matrix(); }
};

double Degrees(double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi; }

int main() {
  double focal, yaw;
  Eigen::Vector3d true_t;
  std::cin >> focal >> yaw >> true_t[0] >> true_t[1] >> true_t[2];
  std::vector<double> v;
  for (double x; std::cin >> x;) v.push_back(x);
  const PointMatrix points = Eigen::Map<const PointMatrix>(v.data(), static_cast<Eigen::Index>(v.size() / 6), 6);
  const auto found = diffsac::ransac::Search<UprightPose>(points, {.max_residual = 4.0 / focal, .seed = 7});
  if (!found.ok()) return 1;
  const double in_turn =
      std::abs(std::remainder(found.model[0] - yaw, 2.0 * std::numbers::pi)) * 180.0 / std::numbers::pi;
  const double in_direction = Degrees(std::abs(found.model.tail<3>().normalized().dot(true_t.normalized())));
  std::printf("%d matches, %d inliers, %d draws, sigma %.2f px, log10 of chance %.0f, errors %.2f %.2f degrees\n",
              static_cast<int>(points.rows()), found.num_inliers, static_cast<int>(found.iterations),
              focal * found.sigma, found.log10_nfa, in_turn, in_direction);
  return in_turn < 5.0 && in_direction < 10.0 ? 0 : 1;
}
