// What one call of a function of diffsac.h costs where the problem is small: EstimateEssential of 20 matches, of which
// half are right, many times over on one thread, in its processor time.

#include <Eigen/Geometry>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/diffsac.h"

int main(int argc, char** argv) {
  const int calls = argc > 1 ? std::atoi(argv[1]) : 10000;
  constexpr int kMatches = 20, kRight = 10, kProblems = 100;
  const Eigen::Matrix3d K = (Eigen::Matrix3d() << 800.0, 0.0, 320.0, 0.0, 800.0, 240.0, 0.0, 0.0, 1.0).finished();
  std::vector<diffsac::Matches> problems(kProblems);
  diffsac::Rng rng(1);
  for (diffsac::Matches& matches : problems) {
    matches.points1.resize(kMatches, 2);
    matches.points2.resize(kMatches, 2);
    matches.match_ratios.resize(kMatches);
    for (int i = 0; i < kMatches; ++i) {
      const Eigen::Vector3d point(rng.Uniform(-2.0, 2.0), rng.Uniform(-1.5, 1.5), rng.Uniform(4.0, 8.0));
      const Eigen::Vector3d moved = point + Eigen::Vector3d(0.5, 0.1, 0.05);
      matches.points1.row(i) = (K * point).hnormalized().transpose();
      matches.points2.row(i) = (K * moved).hnormalized().transpose();
      if (i >= kRight) matches.points2.row(i) << rng.Uniform(0.0, 640.0), rng.Uniform(0.0, 480.0);
      matches.match_ratios[i] = i < kRight ? rng.Uniform(0.4, 0.8) : rng.Uniform(0.7, 1.0);
    }
  }
  for (const int budget : {0, 100, 1}) {
    diffsac::ImageOptions options;
    options.max_iterations = budget;
    diffsac::EstimateEssential(problems[0], {K, K}, options);  // Reads the network.
    double sum = 0.0;
    const std::clock_t start = std::clock();
    for (int i = 0; i < calls; ++i)
      sum += diffsac::EstimateEssential(problems[static_cast<std::size_t>(i % kProblems)], {K, K}, options).model(0, 1);
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    std::printf("max_iterations %d: %.1f us a call, %d calls, sum of E(0, 1) %.17g\n", budget, 1e6 * seconds / calls,
                calls, sum);
  }
}
