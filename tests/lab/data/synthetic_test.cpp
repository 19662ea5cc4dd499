#include "lab/data/synthetic.h"
#include "diffsac/core/range.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/box_section.h"
#include "lab/data/example_test_util.h"

namespace diffsac {
namespace {

// Signed distances of the points with the given mark to the ground truth.
std::vector<double> Residuals(const Example& example, int mark) {
  std::vector<double> residuals;
  const auto& points = example.problem.points;
  const Eigen::Index d = points.cols();
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (example.truth.inliers[i] == mark)
      residuals.push_back(points.row(i).dot(example.truth.model.head(d)) + example.truth.model[d]);
  return residuals;
}

SyntheticOptions Fixed(int points, double ratio) {
  SyntheticOptions options;
  options.num_points = points;
  options.outlier_ratio = ratio;
  return options;
}

double Variance(const std::vector<double>& values) {
  double sum = 0.0;
  for (double v : values) sum += v * v;
  return sum / values.size();
}

template <class Section>
double MeanExtent(Section (*random)(double, Rng&, ModelSampling), int count, double* smallest) {
  Rng rng(5);
  double sum = 0.0;
  *smallest = 1e9;
  for (int i = 0; i < count; ++i) {
    const double extent = random(10.0, rng, ModelSampling::kIsotropic).extent();
    sum += extent;
    *smallest = std::min(*smallest, extent);
  }
  return sum / count;
}

}  // namespace

TEST_CASE("normals of random planes are unit vectors, uniform on the sphere") {
  Rng rng(21);
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  constexpr int kTimes = 4000;
  for (int k = 0; k < kTimes; ++k) {
    const auto normal = PlaneSection::Random(10.0, rng).normal();
    const Eigen::Vector3d n(normal[0], normal[1], normal[2]);
    CHECK(n.norm() == Approx(1.0));
    squares += n * n.transpose();
  }
  CHECK((squares / kTimes - Eigen::Matrix3d::Identity() / 3.0).cwiseAbs().maxCoeff() < 0.03);
}

TEST_CASE("a section's points lie on it, inside the box, and spread uniformly") {
  Rng rng(1);
  for (int trial = 0; trial < 200; ++trial) {
    const LineSection line = LineSection::Random(10.0, rng);
    const PlaneSection plane = PlaneSection::Random(10.0, rng);
    for (int i = 0; i < 20; ++i) {
      const auto p = line.Sample(rng);
      CHECK(std::abs(p[0] * line.normal()[0] + p[1] * line.normal()[1] + line.offset()) < 1e-9);
      for (double v : p) CHECK((v > -1e-9 && v < 10.0 + 1e-9));
      if (plane.extent() == 0.0) continue;
      const auto q = plane.Sample(rng);
      const auto& n = plane.normal();
      CHECK(std::abs(q[0] * n[0] + q[1] * n[1] + q[2] * n[2] + plane.offset()) < 1e-9);
      for (double v : q) CHECK((v > -1e-9 && v < 10.0 + 1e-9));
    }
  }
}

TEST_CASE("a plane section's extent is the root of its area") {
  Rng rng(22);
  for (int trial = 0; trial < 6; ++trial) {
    PlaneSection plane = PlaneSection::Random(10.0, rng);
    while (plane.extent() < 6.0) plane = PlaneSection::Random(10.0, rng);
    // The share of a square of the plane that is inside the cube; it holds all of the section.
    const Eigen::Vector3d n(plane.normal()[0], plane.normal()[1], plane.normal()[2]), centre(5.0, 5.0, 5.0);
    const Eigen::Vector3d u = n.unitOrthogonal(), v = n.cross(u), foot = centre - (n.dot(centre) + plane.offset()) * n;
    constexpr int kTimes = 40000;
    constexpr double kSide = 18.0;
    int inside = 0;
    for (int k = 0; k < kTimes; ++k) {
      const Eigen::Vector3d p = foot + kSide * ((rng.Uniform() - 0.5) * u + (rng.Uniform() - 0.5) * v);
      inside += p.minCoeff() >= 0.0 && p.maxCoeff() <= 10.0;
    }
    CHECK(plane.extent() * plane.extent() == Approx(kSide * kSide * inside / kTimes).epsilon(0.05));
  }
}

TEST_CASE("a section's mean extent follows from its distribution") {
  // With width w(θ) = side (|cos θ| + |sin θ|) across the normal, a uniform offset gives the mean chord side² / w(θ);
  // over uniform angles that is side · (2/π) · √2 · ln(1 + √2) = 7.935.
  double smallest = 0.0;
  CHECK(MeanExtent<LineSection>(&LineSection::Random, 40000, &smallest) == Approx(7.935).margin(0.05));
  CHECK(smallest >= 0.0);
  CHECK(MeanExtent<PlaneSection>(&PlaneSection::Random, 4000, &smallest) > 5.0);
  CHECK(smallest >= 0.0);
}

TEST_CASE("sampling in a plane's polygon is uniform") {
  // Moments of the sample against those of an independent route: rejection from the box.
  Rng rng(3);
  PlaneSection plane = PlaneSection::Random(10.0, rng);
  while (plane.extent() < 8.0) plane = PlaneSection::Random(10.0, rng);
  const auto& n = plane.normal();
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(n[k]) > std::abs(n[axis])) axis = k;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  // Rejection: a uniform point of the box's face, lifted onto the plane, kept when it is inside the box.
  double mean_u = 0.0, mean_v = 0.0, mean_uu = 0.0;
  int kept = 0;
  for (int i = 0; i < 60000; ++i) {
    const double a = rng.Uniform(0.0, 10.0), b = rng.Uniform(0.0, 10.0);
    const double lifted = -(plane.offset() + n[u] * a + n[v] * b) / n[axis];
    if (lifted < 0.0 || lifted > 10.0) continue;
    mean_u += a, mean_v += b, mean_uu += a * a, ++kept;
  }
  double sample_u = 0.0, sample_v = 0.0, sample_uu = 0.0;
  for (int i = 0; i < 60000; ++i) {
    const auto p = plane.Sample(rng);
    sample_u += p[u], sample_v += p[v], sample_uu += p[u] * p[u];
  }
  CHECK(sample_u / 60000 == Approx(mean_u / kept).margin(0.08));
  CHECK(sample_v / 60000 == Approx(mean_v / kept).margin(0.08));
  CHECK(sample_uu / 60000 == Approx(mean_uu / kept).margin(0.8));
}

TEST_CASE("examples have the asked sizes, ratios and unit models") {
  for (Task task : {Task::kLine, Task::kPlane}) {
    for (double ratio : {0.0, 0.1, 0.5, 0.8}) {
      const auto dataset = MakeSynthetic(task, Fixed(100, ratio), 7);
      for (int i = 0; i < 20; ++i) {
        const Example example = dataset->Get(i);
        CHECK(example.problem.points.rows() == 100);
        CHECK(example.problem.points.cols() == PointDimension(task));
        CHECK(example.problem.points.allFinite());
        CHECK(CountInliers(example) == std::lround(100 * (1.0 - ratio)));
        CHECK(example.truth.model.head(PointDimension(task)).norm() == Approx(1.0));
        CHECK(example.problem.task == task);
        CHECK(CheckProblem(example.problem) == Status::kOk);
      }
    }
    // However high the ratio, a model needs γ + 1 points to be more than an accident.
    CHECK(CountInliers(MakeSynthetic(task, Fixed(50, 1.0), 7)->Get(0)) == MinimalSetSize(task) + 1);
  }
}

TEST_CASE("ranges of sizes and ratios are drawn over their whole width") {
  SyntheticOptions options;
  options.num_points = Range(50, 53);
  options.outlier_ratio = Range(0.2, 0.6);
  const auto dataset = MakeSynthetic(Task::kLine, options, 1);
  std::set<int> sizes;
  double low = 1.0, high = 0.0;
  for (int i = 0; i < 300; ++i) {
    const Example example = dataset->Get(i);
    const auto count = static_cast<int>(example.problem.points.rows());
    sizes.insert(count);
    const double ratio = 1.0 - static_cast<double>(CountInliers(example)) / count;
    low = std::min(low, ratio), high = std::max(high, ratio);
  }
  CHECK(sizes == std::set<int>{50, 51, 52, 53});
  CHECK(low >= 0.18);
  CHECK(low < 0.23);
  CHECK(high <= 0.62);
  CHECK(high > 0.57);
}

TEST_CASE("inlier noise has the documented scale") {
  for (Task task : {Task::kLine, Task::kPlane}) {
    SyntheticOptions options = Fixed(200, 0.1);
    std::vector<double> all;
    const auto collect = [&] {
      all.clear();
      const auto dataset = MakeSynthetic(task, options, 3);
      for (int i = 0; i < 100; ++i) {
        const auto r = Residuals(dataset->Get(i), 1);
        all.insert(all.end(), r.begin(), r.end());
      }
    };
    collect();  // default: gaussian, ε/3
    CHECK(std::sqrt(Variance(all)) == Approx(0.1 / 3.0).epsilon(0.03));
    options.sigma = 0.05;
    collect();
    CHECK(std::sqrt(Variance(all)) == Approx(0.05).epsilon(0.03));
    options.sigma = 0.0;
    options.noise = NoiseKind::kUniform;  // default ± ε
    collect();
    CHECK(std::sqrt(Variance(all)) == Approx(0.1 / std::sqrt(3.0)).epsilon(0.03));
    CHECK(*std::max_element(all.begin(), all.end()) <= 0.1 + 1e-12);
    CHECK(*std::max_element(all.begin(), all.end()) > 0.099);
  }
}

TEST_CASE("the extent rule holds and inliers cover the whole chord") {
  SyntheticOptions options = Fixed(2000, 0.0);
  options.sigma = 1e-9;
  for (double least : {5.0, 9.0}) {
    options.min_extent = least;
    const auto dataset = MakeSynthetic(Task::kLine, options, 11);
    for (int i = 0; i < 40; ++i) {
      const Example example = dataset->Get(i);
      const auto& p = example.problem.points;
      const Eigen::Vector2d direction(-example.truth.model[1], example.truth.model[0]);
      Eigen::VectorXd t = p * direction;
      const double span = t.maxCoeff() - t.minCoeff();
      CHECK(span > 0.99 * least);
      // Uniform on [a, b]: mean in the middle, variance (b − a)²/12.
      CHECK(t.mean() == Approx(0.5 * (t.maxCoeff() + t.minCoeff())).margin(0.04 * span));
      CHECK((t.array() - t.mean()).square().mean() == Approx(span * span / 12.0).epsilon(0.1));
      // Both ends reach the border of the picture.
      for (const Eigen::Index end : {0, 1}) {
        Eigen::Index at = 0;
        end == 0 ? t.minCoeff(&at) : t.maxCoeff(&at);
        const Eigen::Vector2d corner = p.row(at);
        const double to_border = std::min(corner.minCoeff(), (10.0 - corner.array()).minCoeff());
        CHECK(to_border < 0.01 * span);
      }
    }
  }
}

TEST_CASE("uniform outliers fill the box, also next to the model") {
  const auto dataset = MakeSynthetic(Task::kLine, Fixed(1000, 0.9), 2);
  int near = 0, total = 0;
  double sum = 0.0, square = 0.0;
  for (int i = 0; i < 20; ++i) {
    const Example example = dataset->Get(i);
    for (double r : Residuals(example, 0)) near += std::abs(r) < 0.1, ++total;
    for (Eigen::Index k = 0; k < example.problem.points.rows(); ++k) {
      if (example.truth.inliers[k]) continue;
      CHECK((example.problem.points.row(k).minCoeff() >= 0.0 && example.problem.points.row(k).maxCoeff() <= 10.0));
      sum += example.problem.points(k, 0), square += std::pow(example.problem.points(k, 0), 2);
    }
  }
  // Uniform on [0, 10]: mean 5, second moment 100/3; the band of width 0.2 around a chord of 5 to 14 holds 1 to 3 %.
  CHECK(sum / total == Approx(5.0).margin(0.1));
  CHECK(square / total == Approx(100.0 / 3.0).margin(1.0));
  CHECK(near > 0.008 * total);
  CHECK(near < 0.035 * total);
}

TEST_CASE("aggregated outliers stand in clusters inside the box") {
  for (Task task : {Task::kLine, Task::kPlane}) {
    SyntheticOptions options = Fixed(400, 0.5);
    options.outliers = OutlierKind::kAggregated;
    options.clusters = 2;
    options.cluster_sigma = 0.2;
    const auto dataset = MakeSynthetic(task, options, 4);
    double nearest = 0.0;
    int count = 0;
    for (int i = 0; i < 10; ++i) {
      const Example example = dataset->Get(i);
      const auto& p = example.problem.points;
      for (Eigen::Index a = 0; a < p.rows(); ++a) {
        if (example.truth.inliers[a]) continue;
        CHECK((p.row(a).minCoeff() >= 0.0 && p.row(a).maxCoeff() <= 10.0));
        double best = 1e9;
        for (Eigen::Index b = 0; b < p.rows(); ++b)
          if (b != a && !example.truth.inliers[b]) best = std::min(best, (p.row(a) - p.row(b)).norm());
        nearest += best, ++count;
      }
    }
    // 200 uniform points would be 0.35 (square) and 0.95 (cube) apart.
    CHECK(nearest / count < (task == Task::kLine ? 0.06 : 0.15));
  }
}

TEST_CASE("conditions are paired: another noise or outlier kind keeps the models") {
  SyntheticOptions noisy = Fixed(100, 0.5), clean = noisy, clustered = noisy;
  noisy.sigma = 0.2;
  clustered.outliers = OutlierKind::kAggregated;
  for (int i = 0; i < 5; ++i) {
    const Example base = MakeSynthetic(Task::kLine, clean, 1)->Get(i);
    CHECK(MakeSynthetic(Task::kLine, noisy, 1)->Get(i).truth.model == base.truth.model);
    CHECK(MakeSynthetic(Task::kLine, clustered, 1)->Get(i).truth.model == base.truth.model);
  }
}

TEST_CASE("Models through a uniform point have longer chords than isotropic ones") {
  double isotropic = 0.0, through_point = 0.0;
  Rng rng(1);
  for (int i = 0; i < 4000; ++i) {
    isotropic += LineSection::Random(10.0, rng).extent();
    through_point += LineSection::Random(10.0, rng, ModelSampling::kThroughPoint).extent();
  }
  // A length-biased draw has mean E[L²]/E[L], which is larger than E[L].
  CHECK(through_point > 1.05 * isotropic);
}

}  // namespace diffsac
