// A circle in an image's edge points: an own model of thirty lines, estimated by ransac::Search. The image is drawn
// here, a disc over stripes and a box with noise, so that the circle is known. Fails where the estimate is off.
#include <diffsac/ransac/search.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <vector>

using diffsac::PointMatrix;

struct Circle {
  using Parameters = Eigen::Vector3d;  // x, y, radius
  static constexpr int kDimension = 2;
  static constexpr int kMinimalSize = 3;

  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
    const auto weights = [&](Eigen::Index row) { return row == set[0] || row == set[1] || row == set[2] ? 1.0 : 0.0; };
    return FitRows(points, weights, out) ? 1 : 0;
  }
  static double Residual(const Parameters& circle, const double* point) {
    return std::abs(std::hypot(point[0] - circle[0], point[1] - circle[1]) - circle[2]);
  }
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
    return FitRows(
        points, [&](Eigen::Index row) { return weights[row]; }, out);
  }

 private:
  // x² + y² = 2 x cx + 2 y cy + (r² − cx² − cy²), linear in three numbers.
  template <class Weights>
  static bool FitRows(const PointMatrix& points, const Weights& weights, Parameters* out) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      if (weights(i) == 0.0) continue;
      const Eigen::Vector3d row(2.0 * points(i, 0), 2.0 * points(i, 1), 1.0);
      normal += weights(i) * row * row.transpose();
      right += weights(i) * points.row(i).squaredNorm() * row;
    }
    const Eigen::Vector3d x = normal.ldlt().solve(right);
    *out << x[0], x[1], std::sqrt(x[2] + x[0] * x[0] + x[1] * x[1]);
    return out->allFinite();
  }
};

constexpr int kWidth = 240, kHeight = 180;
const Eigen::Vector3d kTruth(121.3, 84.6, 47.7);

Eigen::MatrixXd DrawImage() {
  Eigen::MatrixXd image(kHeight, kWidth);
  diffsac::Rng rng(1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      double gray = (x + 2 * y) / 23 % 2 == 0 ? 60.0 : 110.0;
      if (x > 20 && x < 90 && y > 95 && y < 160) gray = 150.0;
      const double inside = kTruth[2] - std::hypot(x - kTruth[0], y - kTruth[1]);
      gray += std::clamp(inside + 0.5, 0.0, 1.0) * (200.0 - gray);
      image(y, x) = gray + 6.0 * rng.Normal();
    }
  return image;
}

// Where the gradient is steep and steepest along itself, between pixels by a parabola.
PointMatrix EdgePoints(const Eigen::MatrixXd& image) {
  Eigen::MatrixXd steep = Eigen::MatrixXd::Zero(kHeight, kWidth);
  const auto slope_x = [&](int y, int x) {
    return image.block<3, 1>(y - 1, x + 1).sum() - image.block<3, 1>(y - 1, x - 1).sum();
  };
  const auto slope_y = [&](int y, int x) {
    return image.block<1, 3>(y + 1, x - 1).sum() - image.block<1, 3>(y - 1, x - 1).sum();
  };
  for (int y = 1; y < kHeight - 1; ++y)
    for (int x = 1; x < kWidth - 1; ++x) steep(y, x) = std::hypot(slope_x(y, x), slope_y(y, x));
  std::vector<Eigen::Vector2d> edges;
  for (int y = 2; y < kHeight - 2; ++y)
    for (int x = 2; x < kWidth - 2; ++x) {
      const bool across = std::abs(slope_x(y, x)) > std::abs(slope_y(y, x));
      const double before = across ? steep(y, x - 1) : steep(y - 1, x), here = steep(y, x);
      const double after = across ? steep(y, x + 1) : steep(y + 1, x);
      if (here < 80.0 || here <= before || here < after) continue;
      const double shift = 0.5 * (before - after) / (before - 2.0 * here + after);
      edges.emplace_back(x + (across ? shift : 0.0), y + (across ? 0.0 : shift));
    }
  PointMatrix points(edges.size(), 2);
  for (std::size_t i = 0; i < edges.size(); ++i) points.row(i) = edges[i];
  return points;
}

int main() {
  const PointMatrix points = EdgePoints(DrawImage());
  const auto found = diffsac::ransac::Search<Circle>(points, {.max_residual = 2.0, .confidence = 0.9999, .seed = 7});
  if (!found.ok()) return 1;
  const double error = (found.model - kTruth).cwiseAbs().maxCoeff();
  std::printf("%d edge points, %d on the circle, after %d draws\n", static_cast<int>(points.rows()), found.num_inliers,
              static_cast<int>(found.iterations));
  std::printf("centre %.2f %.2f radius %.2f, truth %.2f %.2f %.2f\n", found.model[0], found.model[1], found.model[2],
              kTruth[0], kTruth[1], kTruth[2]);
  std::printf("sigma %.2f, log10 of chance %.0f\n", found.sigma, found.log10_nfa);
  return error < 0.3 && found.log10_nfa < -10.0 ? 0 : 1;
}
