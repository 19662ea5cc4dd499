#include <torch/torch.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "lab/torch/tensor_sampler.h"

using namespace diffsac;

// Data distributed as N(0.3, 0.2²) has an exact denoiser and an exact solution of the probability-flow equation.

namespace {

constexpr double kMean = 0.3;
constexpr double kDeviation = 0.2;
constexpr double kFirstLambda = -5.0;
constexpr double kLastLambda = 4.0;

TimePoint AtLambda(double lambda) {
  return {lambda, 1.0 / std::sqrt(1.0 + std::exp(-2.0 * lambda)), 1.0 / std::sqrt(1.0 + std::exp(2.0 * lambda)),
          lambda};
}

/// Equal steps in λ; the network is told λ itself.
TimeGrid UniformLambda(int steps) {
  TimeGrid grid;
  for (int i = 0; i <= steps; ++i) {
    const double lambda = kFirstLambda + (kLastLambda - kFirstLambda) * i / steps;
    grid.push_back(AtLambda(lambda));
  }
  return grid;
}

double Spread(const TimePoint& at) {
  return std::sqrt(at.alpha * at.alpha * kDeviation * kDeviation + at.sigma * at.sigma);
}

torch::Tensor ExactDenoiser(const torch::Tensor& x, double lambda) {
  const TimePoint at = AtLambda(lambda);
  const double gain = at.alpha * kDeviation * kDeviation / (Spread(at) * Spread(at));
  return kMean + gain * (x - at.alpha * kMean);
}

torch::Tensor Start() { return torch::tensor({-1.5, -0.5, 0.0, 0.7, 1.9}, torch::kFloat64); }

torch::Tensor ExactSolution() {
  const TimePoint s = AtLambda(kFirstLambda);
  const TimePoint t = AtLambda(kLastLambda);
  return t.alpha * kMean + Spread(t) / Spread(s) * (Start() - s.alpha * kMean);
}

torch::Tensor Solve(int steps, const DpmSolverOptions& options) {
  return RunDpmSolver(UniformLambda(steps), options, ExactDenoiser, Start());
}

std::vector<double> Errors(DpmSolverOptions options) {
  std::vector<double> errors;
  for (const int steps : {5, 10, 20, 40, 80, 160}) {
    errors.push_back((Solve(steps, options) - ExactSolution()).abs().max().item<double>());
  }
  return errors;
}

DpmSolverOptions Options(int order) {
  DpmSolverOptions options;
  options.order = order;
  options.lower_order_final = false;
  return options;
}

void CheckDigits(const std::vector<double>& errors, const std::vector<double>& expected, double relative) {
  for (std::size_t i = 0; i < expected.size(); ++i) CHECK(errors[i] == Approx(expected[i]).epsilon(relative));
}

}  // namespace

TEST_CASE("order 1 converges linearly with the measured errors") {
  const auto errors = Errors(Options(1));
  CheckDigits(errors, {.1393, .07627, .04024, .02068, .01048, .005278}, 4e-4);
  CHECK(errors[4] / errors[5] == Approx(2.0).margin(0.05));
}

TEST_CASE("2M converges quadratically with the measured errors") {
  const auto errors = Errors(Options(2));
  CheckDigits(errors, {.04478, .005504, .003876, .001101, .0002828, .00007127}, 4e-4);
  CHECK(errors[3] / errors[4] == Approx(4.0).margin(0.15));
  CHECK(errors[4] / errors[5] == Approx(4.0).margin(0.1));
}

TEST_CASE("2M has the golden values of ten steps") {
  const auto expected = torch::tensor({-0.00602340, 0.19768415, 0.29953793, 0.44213322, 0.68658229}, torch::kFloat64);
  CHECK((Solve(10, Options(2)) - expected).abs().max().item<double>() < 6e-9);
}
