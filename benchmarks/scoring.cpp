// Residuals scored a second, for each score and model on one thread, beside what this machine can do at most: its rate
// of multiply-adds in registers and its rate of reading memory. Points that fit the cache show the first limit,
// four million points the second.
//
//   diffsac_scoring [points]...      defaults: 2000 4000000

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/geometry/hyperplane.h"
#include "diffsac/ransac/option_names.h"
#include "diffsac/ransac/scores/scorer.h"

namespace diffsac {
namespace {

constexpr double kThreshold = 0.1;
/// Keeps the compiler from dropping what is measured.
volatile double sink = 0.0;

/// Seconds that one call takes: the best of five runs of a tenth of a second at least.
double SecondsPerCall(const std::function<double()>& call) {
  using Clock = std::chrono::steady_clock;
  double best = 1e300;
  for (int run = 0; run < 5; ++run) {
    int calls = 0;
    const auto start = Clock::now();
    double seconds = 0.0;
    for (; seconds < 0.1; ++calls) {
      sink = sink + call();
      seconds = std::chrono::duration<double>(Clock::now() - start).count();
    }
    best = std::min(best, seconds / calls);
  }
  return best;
}

/// Multiplications with an addition a second, in as many independent chains as hide their latency.
double MultiplyAddRate() {
  constexpr int kChains = 16, kSteps = 100000;
  const double seconds = SecondsPerCall([] {
    double values[kChains];
    for (int i = 0; i < kChains; ++i) values[i] = 1.0 + 1e-3 * i;
    for (int step = 0; step < kSteps; ++step)
      for (int i = 0; i < kChains; ++i) values[i] = values[i] * 0.999999 + 1e-6;
    double sum = 0.0;
    for (double value : values) sum += value;
    return sum;
  });
  return static_cast<double>(kChains) * kSteps / seconds;
}

/// Bytes read a second from memory that no cache holds, in four streams as a scorer reads its columns.
double MemoryRate() {
  constexpr Eigen::Index kLength = Eigen::Index{1} << 22;
  const Eigen::VectorXd values = Eigen::VectorXd::Ones(4 * kLength);
  const double seconds = SecondsPerCall([&] {
    const auto stream = [&](int i) { return values.segment(i * kLength, kLength); };
    return (stream(0) + stream(1) + stream(2) + stream(3)).sum();
  });
  return static_cast<double>(values.size()) * sizeof(double) / seconds;
}

/// Half the points near x = 0, half anywhere, so that scores see both.
template <int D>
PointMatrix MakePoints(int count) {
  Rng rng(1);
  PointMatrix points(count, D);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < D; ++j) points(i, j) = j == 0 && i % 2 == 0 ? 0.03 * rng.Normal() : rng.Uniform(-5.0, 5.0);
  return points;
}

template <MinimalModel Model>
void Measure(const char* model_name, const typename Model::Parameters& model, int count, double multiply_adds,
             double bytes) {
  constexpr int D = Model::kDimension;
  const PointMatrix points = MakePoints<D>(count);
  const Scorer<Model> scorer(points);
  for (const auto& [kind, name] : kEnumNames<ScoreKind>) {
    const Score score(kind, kThreshold, kThreshold / 3.0, 20.0, 4, 0.2 * kThreshold);
    const double rate = count / SecondsPerCall([&] { return scorer(model, score); });
    std::printf("%-11s %8d  %-20s %8.0f M/s  %6.2f multiply-adds  %5.1f %% of the memory rate\n", model_name, count,
                name, rate / 1e6, multiply_adds / rate, 100.0 * rate * D * sizeof(double) / bytes);
  }
}

void Main(const std::vector<int>& counts) {
  const double multiply_adds = MultiplyAddRate(), bytes = MemoryRate();
  std::printf("one thread: %.2f G multiply-adds/s, %.2f GB/s read from memory\n", multiply_adds / 1e9, bytes / 1e9);
  std::printf("each line: residuals scored a second, and the multiply-adds that fit into the time of one\n");
  for (int count : counts) {
    Measure<Line>("line", Line::Parameters::UnitX(), count, multiply_adds, bytes);
    Measure<Plane>("plane", Plane::Parameters::UnitX(), count, multiply_adds, bytes);
  }
}

}  // namespace
}  // namespace diffsac

int main(int argc, char** argv) {
  std::vector<int> counts;
  for (int i = 1; i < argc; ++i) {
    counts.push_back(std::atoi(argv[i]));
    if (counts.back() > 0) continue;
    std::fprintf(stderr, "diffsac_scoring: '%s' is no number of points\n", argv[i]);
    return 1;
  }
  if (counts.empty()) counts = {2000, 4000000};
  diffsac::Main(counts);
  return 0;
}
