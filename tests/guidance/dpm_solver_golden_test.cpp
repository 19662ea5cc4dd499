#include <torch/torch.h>

#include <catch2/catch.hpp>
#include <functional>
#include <limits>

#include "guidance/dummy_model.h"
#include "lab/torch/forward_process.h"
#include "lab/torch/tensor_sampler.h"

using namespace diffsac;

// Values of Hugging Face diffusers' tests/schedulers/test_scheduler_dpm_multi.py (float32, so compared to 1e-4), and,
// to six digits, of an independent float64 computation of the same rules.

namespace {

constexpr double kNoClipping = -1000.0;

/// x0 from the model's output at a point.
using ToX0 = std::function<torch::Tensor(const torch::Tensor& x, const torch::Tensor& output, const TimePoint& at)>;

torch::Tensor FromSample(const torch::Tensor&, const torch::Tensor& output, const TimePoint&) { return output; }
torch::Tensor FromEpsilon(const torch::Tensor& x, const torch::Tensor& output, const TimePoint& at) {
  return (x - at.sigma * output) / at.alpha;
}
torch::Tensor FromV(const torch::Tensor& x, const torch::Tensor& output, const TimePoint& at) {
  return at.alpha * x - at.sigma * output;
}

/// diffusers' full loop with 10 steps of order 2 on T = 1000, beginning at a point of the grid.
torch::Tensor FullLoop(const ToX0& to_x0, const char* spacing, torch::Tensor x, std::size_t first = 0) {
  auto grid = MakeTimeGrid(MakeSchedule("linear", 1000),
                           {10, FromString<TimestepSpacing>(spacing), FinalSigma::kSigmaMin, kNoClipping});
  grid.erase(grid.begin(), grid.begin() + first);
  DpmSolverOptions options;
  options.lower_order_final = false;
  int calls = 0;
  const auto denoise = [&](const torch::Tensor& c, double t) { return to_x0(c, DummyModel(c, t), grid[calls++]); };
  return RunDpmSolver(grid, options, denoise, std::move(x));
}

struct Row {
  int steps, order;
  const char* spacing;
  double linear_sigma_min, linear_zero, cosine_sigma_min, cosine_zero;
};

double SampleDummy(const char* kind, const char* final_sigma, const Row& row) {
  ReverseSamplerOptions options;
  options.steps = row.steps;
  options.order = row.order;
  options.timestep_spacing = FromString<TimestepSpacing>(row.spacing);
  options.final_sigma = FromString<FinalSigma>(final_sigma);
  options.lambda_min_clipped = kNoClipping;
  options.clip_x0 = false;
  return MeanAbs(MakeReverseSampler(options, MakeSchedule(kind))->Sample(DummyModel, DummySample()));
}

}  // namespace

TEST_CASE("2M agrees with diffusers for epsilon, v and sample prediction") {
  CHECK(MeanAbs(FullLoop(FromEpsilon, "linspace", DummySample())) == Approx(0.330147).margin(6e-7));
  CHECK(MeanAbs(FullLoop(FromV, "linspace", DummySample())) == Approx(0.225099).margin(6e-7));
  CHECK(MeanAbs(FullLoop(FromSample, "linspace", DummySample())) == Approx(1.102924).margin(6e-7));
}

TEST_CASE("2M agrees with diffusers with thresholding") {
  // Their dynamic threshold, max 0.5, always ends at 0.5 and divides by it.
  const auto thresholded = [](const torch::Tensor& x, const torch::Tensor& output, const TimePoint& at) {
    return FromEpsilon(x, output, at).clamp(-0.5, 0.5) / 0.5;
  };
  CHECK(MeanAbs(FullLoop(thresholded, "linspace", DummySample())) == Approx(1.1364).margin(1e-4));
}

TEST_CASE("2M agrees with diffusers from the middle of the schedule") {
  const auto schedule = MakeSchedule("linear", 1000);
  const auto noisy =
      AddNoise(schedule, DummySample().view({1, -1}), DummyNoise().view({1, -1}), torch::full({1}, 500, torch::kLong));
  const auto x = FullLoop(FromEpsilon, "linspace", noisy, 5);
  CHECK(x.abs().sum().item<double>() == Approx(318.413).margin(6e-4));
  CHECK(MeanAbs(x) == Approx(0.414600).margin(6e-7));
}

TEST_CASE("2M has the golden values of T=100 with x0 prediction") {
  const Row row = GENERATE(values<Row>({
      {1, 2, "linspace", .496854, .494355, .506740, .494355},
      {2, 2, "linspace", .545490, .543899, .696267, .688618},
      {4, 2, "linspace", .577135, .575516, .824785, .818657},
      {5, 1, "linspace", .556667, .554779, .808245, .802019},
      {5, 2, "linspace", .573577, .571632, .850039, .843491},
      {10, 2, "linspace", .534541, .529460, .842134, .829062},
      {20, 2, "linspace", .379468, .452138, .654800, .722523},
      {5, 2, "trailing", .572692, .570636, .849664, .842967},
      {10, 2, "trailing", .527440, .521411, .833001, .817863},
  }));
  CAPTURE(row.steps, row.order, row.spacing);
  CHECK(SampleDummy("linear", "sigma_min", row) == Approx(row.linear_sigma_min).margin(6e-7));
  CHECK(SampleDummy("linear", "zero", row) == Approx(row.linear_zero).margin(6e-7));
  CHECK(SampleDummy("cosine", "sigma_min", row) == Approx(row.cosine_sigma_min).margin(6e-7));
  CHECK(SampleDummy("cosine", "zero", row) == Approx(row.cosine_zero).margin(6e-7));
}
