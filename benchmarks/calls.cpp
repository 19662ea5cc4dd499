// What one call of a function of diffsac.h costs where the problem is small: EstimateEssential of 20 matches, and
// EstimateLine, EstimatePlane and EstimateHomography of 100 points or matches, of which half are right, many times over
// on one thread, in its processor time.

#include <Eigen/Geometry>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/diffsac.h"

namespace {

constexpr int kProblems = 100;

/// diffsac::Matches are views.
struct OwnedMatches {
  Eigen::Matrix<double, Eigen::Dynamic, 2> points1, points2;
  Eigen::VectorXd snn_ratio;
  operator diffsac::Matches() const { return {points1, points2, snn_ratio}; }
};

/// estimate: of a problem by its number, returns one of the model's numbers.
template <class Estimate>
void Time(const char* name, int calls, const Estimate& estimate) {
  estimate(0);  // Reads the network.
  double sum = 0.0;
  const std::clock_t start = std::clock();
  for (int i = 0; i < calls; ++i) sum += estimate(static_cast<std::size_t>(i % kProblems));
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::printf("%s: %.1f us a call, %d calls, sum of a number of the models %.17g\n", name, 1e6 * seconds / calls, calls,
              sum);
}

/// Every second point is near a line or plane through the middle, the others are anywhere in [-1, 1].
template <int kDimension>
std::vector<Eigen::Matrix<double, Eigen::Dynamic, kDimension>> Clouds(diffsac::Rng& rng) {
  using Vector = Eigen::Matrix<double, kDimension, 1>;
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, kDimension>> clouds(kProblems);
  const auto anywhere = [&] { return Vector(Vector::NullaryExpr([&] { return rng.Uniform(-1.0, 1.0); })); };
  for (auto& cloud : clouds) {
    cloud.resize(100, kDimension);
    const Vector normal = anywhere().normalized();
    for (int i = 0; i < 100; ++i) {
      Vector point = anywhere();
      if (i % 2 == 0) point += (rng.Uniform(-0.01, 0.01) - point.dot(normal)) * normal;
      cloud.row(i) = point.transpose();
    }
  }
  return clouds;
}

void TimePoints(int calls) {
  diffsac::Rng rng(2);
  const auto lines = Clouds<2>(rng);
  const auto planes = Clouds<3>(rng);
  const diffsac::PointOptions options{.max_residual = 0.02};
  Time("line, N = 100", calls, [&](std::size_t i) { return diffsac::EstimateLine(lines[i], options).model[0]; });
  Time("plane, N = 100", calls, [&](std::size_t i) { return diffsac::EstimatePlane(planes[i], options).model[0]; });
}

void TimeHomographies(int calls) {
  diffsac::Rng rng(3);
  std::vector<OwnedMatches> problems(kProblems);
  for (OwnedMatches& matches : problems) {
    matches.points1.resize(100, 2);
    matches.points2.resize(100, 2);
    const double turn = rng.Uniform(-0.2, 0.2);
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector2d point(rng.Uniform(0.0, 640.0), rng.Uniform(0.0, 480.0)),
          moved = Eigen::Rotation2Dd(turn) * point;
      matches.points1.row(i) = point.transpose();
      matches.points2.row(i) = moved.transpose();
      if (i % 2 == 1)
        matches.points2.row(i) << rng.Uniform(0.0, 640.0), rng.Uniform(0.0, 480.0);
      else
        matches.points2.row(i).array() += rng.Uniform(-0.5, 0.5);
    }
  }
  Time("homography, N = 100", calls,
       [&](std::size_t i) { return diffsac::EstimateHomography(problems[i]).model(0, 1); });
}

void TimeEssentials(int calls) {
  constexpr int kMatches = 20, kRight = 10;
  const Eigen::Matrix3d K = (Eigen::Matrix3d() << 800.0, 0.0, 320.0, 0.0, 800.0, 240.0, 0.0, 0.0, 1.0).finished();
  std::vector<OwnedMatches> problems(kProblems);
  diffsac::Rng rng(1);
  for (OwnedMatches& matches : problems) {
    matches.points1.resize(kMatches, 2);
    matches.points2.resize(kMatches, 2);
    matches.snn_ratio.resize(kMatches);
    for (int i = 0; i < kMatches; ++i) {
      const Eigen::Vector3d point(rng.Uniform(-2.0, 2.0), rng.Uniform(-1.5, 1.5), rng.Uniform(4.0, 8.0));
      const Eigen::Vector3d moved = point + Eigen::Vector3d(0.5, 0.1, 0.05);
      matches.points1.row(i) = (K * point).hnormalized().transpose();
      matches.points2.row(i) = (K * moved).hnormalized().transpose();
      if (i >= kRight) matches.points2.row(i) << rng.Uniform(0.0, 640.0), rng.Uniform(0.0, 480.0);
      matches.snn_ratio[i] = i < kRight ? rng.Uniform(0.4, 0.8) : rng.Uniform(0.7, 1.0);
    }
  }
  for (const int budget : {0, 100, 1}) {
    diffsac::ImageOptions options;
    if (budget > 0) options.max_iterations = budget;
    Time(("essential matrix, N = 20, max_iterations " + std::to_string(budget)).c_str(), calls, [&](std::size_t i) {
      return diffsac::EstimateEssential(problems[i], {K, K}, options).model(0, 1);
    });
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int calls = argc > 1 ? std::atoi(argv[1]) : 10000;
  TimeEssentials(calls);
  TimePoints(calls);
  TimeHomographies(calls);
}
