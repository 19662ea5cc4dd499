#include "diffsac/guidance/diffusion/noise_schedule.h"
#include "lab/config/yaml.h"

#include <torch/torch.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "diffsac/core/status.h"
#include "guidance/captured_log.h"
#include "guidance/dummy_model.h"
#include "lab/options/options.h"
#include "lab/torch/forward_process.h"

using namespace diffsac;

namespace {

NoiseSchedule Linear(int steps, double beta_end) {
  NoiseScheduleOptions options;
  options.kind = NoiseScheduleKind::kLinear;
  options.steps = steps;
  options.beta_end = beta_end;
  return NoiseSchedule(options);
}

}  // namespace

TEST_CASE("the linear schedule at T=100 has the measured values") {
  const auto schedule = MakeSchedule("linear");
  CHECK(schedule.alphas_bar()[0] == Approx(0.9999).margin(1e-12));
  CHECK(schedule.alphas_bar()[49] == Approx(0.77718).margin(5e-6));
  CHECK(schedule.alphas_bar()[99] == Approx(0.363563).margin(5e-7));
  CHECK(schedule.alpha(99) == Approx(0.603).margin(5e-4));
  CHECK(schedule.TerminalSnr() == Approx(0.571).margin(5e-4));
}

TEST_CASE("other linear ends have the measured terminal values") {
  CHECK(Linear(100, 0.05).alphas_bar().back() == Approx(0.078).margin(5e-4));
  CHECK(Linear(100, 0.1).alphas_bar().back() == Approx(0.0056).margin(5e-5));
  CHECK(Linear(100, 0.2).alphas_bar().back() == Approx(2.14e-5).margin(5e-8));
  CHECK(Linear(1000, 0.02).alphas_bar().back() == Approx(4.04e-5).margin(5e-8));
}

TEST_CASE("linear_scaled stretches both ends by 1000/T") {
  const auto schedule = MakeSchedule("linear_scaled");
  CHECK(schedule.betas().front() == Approx(1e-3));
  CHECK(schedule.betas().back() == Approx(0.2));
  CHECK(schedule.alphas_bar().back() == Approx(2.04e-5).margin(5e-8));
  CHECK(schedule.alpha(99) == Approx(0.0045).margin(5e-5));
}

TEST_CASE("the cosine schedule at T=100 has the measured values") {
  const auto schedule = MakeSchedule("cosine");
  CHECK(schedule.alphas_bar()[0] == Approx(0.999369).margin(5e-7));
  CHECK(schedule.alphas_bar()[49] == Approx(0.493844).margin(5e-7));
  CHECK(schedule.alphas_bar()[99] == Approx(2.43e-7).margin(5e-10));
  CHECK(schedule.betas()[97] == Approx(0.5554).margin(5e-5));
  CHECK(schedule.betas()[98] == Approx(0.7499).margin(5e-5));
  CHECK(schedule.betas()[99] == 0.999);
  CHECK(schedule.lambda(99) == Approx(-7.6).margin(0.05));
}

TEST_CASE("the zero-terminal-SNR rescale ends on pure noise and keeps the first step") {
  const auto schedule = MakeSchedule("linear", 100, true);
  CHECK(schedule.alphas_bar()[0] == Approx(0.9999).margin(1e-12));
  CHECK(schedule.alphas_bar()[49] == Approx(0.4925).margin(5e-5));
  CHECK(schedule.alphas_bar()[99] == 0.0);
  CHECK(schedule.betas()[99] == 1.0);
  CHECK(schedule.sigma(99) == 1.0);
  CHECK(schedule.TerminalSnr() == 0.0);
  CHECK(schedule.lambda(99) == -std::numeric_limits<double>::infinity());
}

TEST_CASE("every schedule falls from data to noise and is consistent with itself") {
  const char* kind = GENERATE("cosine", "linear", "linear_scaled");
  const bool zero = GENERATE(false, true);
  const int steps = GENERATE(25, 100, 1000);
  const auto schedule = MakeSchedule(kind, steps, zero);
  REQUIRE(schedule.steps() == steps);
  double product = 1.0;
  for (int t = 0; t < steps; ++t) {
    product *= schedule.alphas()[t];
    CHECK(schedule.alphas()[t] == Approx(1.0 - schedule.betas()[t]));
    CHECK(schedule.alphas_bar()[t] == Approx(product).margin(1e-15));
    CHECK(schedule.alpha(t) * schedule.alpha(t) + schedule.sigma(t) * schedule.sigma(t) == Approx(1.0));
    if (t > 0) CHECK(schedule.alphas_bar()[t] < schedule.alphas_bar()[t - 1]);
    if (t > 0) CHECK(schedule.lambda(t) < schedule.lambda(t - 1));
  }
}

TEST_CASE("only a schedule that leaves signal at the end warns, once a construction") {
  const auto count = [](const std::string& text) {
    int warnings = 0;
    for (auto at = text.find("signal-to-noise"); at != std::string::npos; at = text.find("signal-to-noise", at + 1)) {
      ++warnings;
    }
    return warnings;
  };
  const auto log = CapturedLog([] { MakeSchedule("linear"); });
  CHECK(count(log) == 1);
  CHECK(log.find("0.571") != std::string::npos);
  CHECK(CapturedLog([] {
          MakeSchedule("cosine");
          MakeSchedule("linear_scaled");
          MakeSchedule("linear", 1000);
          MakeSchedule("linear", 100, true);
        }).empty());
}

TEST_CASE("the forward process has the stated mean and variance") {
  const auto schedule = MakeSchedule("cosine");
  torch::manual_seed(3);
  const int t = 49;
  const std::int64_t count = 200000;
  const auto c0 = torch::full({1, count}, -1.0, torch::kFloat64);
  const auto c_t = AddNoise(schedule, c0, torch::randn({1, count}, torch::kFloat64), torch::full({1}, t, torch::kLong));
  CHECK(c_t.mean().item<double>() == Approx(-schedule.alpha(t)).margin(0.01));
  CHECK(c_t.var().item<double>() == Approx(1.0 - schedule.alphas_bar()[t]).margin(0.01));
}

TEST_CASE("steps of the chain q(c_t | c_t-1) add up to the closed form") {
  const auto schedule = MakeSchedule("cosine");
  double mean = 1.0;
  double variance = 0.0;
  for (int t = 0; t < 100; ++t) {
    mean *= std::sqrt(schedule.alphas()[t]);
    variance = schedule.alphas()[t] * variance + schedule.betas()[t];
    CHECK(mean == Approx(schedule.alpha(t)));
    CHECK(variance == Approx(schedule.sigma(t) * schedule.sigma(t)));
  }
}

TEST_CASE("AddNoise uses each example's own timestep and keeps the type") {
  const auto schedule = MakeSchedule("cosine");
  const auto c0 = torch::ones({2, 3, 5});
  const auto c_t = AddNoise(schedule, c0, torch::full_like(c0, 2.0), torch::tensor({0, 99}, torch::kLong));
  REQUIRE(c_t.sizes() == c0.sizes());
  CHECK(c_t.scalar_type() == torch::kFloat32);
  CHECK(torch::allclose(c_t[0], torch::full({3, 5}, schedule.alpha(0) + 2.0 * schedule.sigma(0))));
  CHECK(torch::allclose(c_t[1], torch::full({3, 5}, schedule.alpha(99) + 2.0 * schedule.sigma(99))));
}

TEST_CASE("AddNoise refuses wrong shapes and timesteps") {
  const auto schedule = MakeSchedule("cosine");
  const auto c0 = torch::ones({2, 3});
  CHECK_THROWS(AddNoise(schedule, c0, torch::ones({2, 4}), torch::zeros({2}, torch::kLong)));
  CHECK_THROWS(AddNoise(schedule, c0, c0, torch::zeros({3}, torch::kLong)));
  CHECK_THROWS(AddNoise(schedule, c0, c0, torch::full({2}, 100, torch::kLong)));
}

TEST_CASE("bad schedule options are errors") {
  const auto build = [](auto change) {
    NoiseScheduleOptions options;
    change(options);
    NoiseSchedule schedule(options);
  };
  CHECK_THROWS_AS(build([](auto& o) { o.kind = FromString<NoiseScheduleKind>("sigmoid"); }), Error);
  CHECK_THROWS_AS(build([](auto& o) { o.steps = 0; }), Error);
  CHECK_THROWS_AS(build([](auto& o) { o.kind = NoiseScheduleKind::kLinear, o.beta_start = 0.0; }), Error);
  CHECK_THROWS_AS(build([](auto& o) { o.kind = NoiseScheduleKind::kLinear, o.beta_end = 1.0; }), Error);
  CHECK_THROWS_AS(build([](auto& o) { o.beta_end = 1e-5; }), Error);
  CHECK_THROWS_AS(build([](auto& o) { o.kind = NoiseScheduleKind::kLinearScaled, o.steps = 20; }), Error);
  CHECK_THROWS_AS(build([](auto& o) { o.steps = 1, o.zero_terminal_snr = true; }), Error);
  CHECK_THROWS_WITH(ReadOptions<NoiseScheduleOptions>(ConfigFromYaml("kind: cosin\n")), Catch::Contains("cosine"));
  CHECK_THROWS_AS(ReadOptions<NoiseScheduleOptions>(ConfigFromYaml("steps: 0\n")), Error);
}

TEST_CASE("a timestep outside the schedule is an error") {
  const auto schedule = MakeSchedule("cosine");
  CHECK_THROWS_AS(schedule.alpha(-1), Error);
  CHECK_THROWS_AS(schedule.sigma(100), Error);
  CHECK_THROWS_AS(schedule.lambda(100), Error);
}
