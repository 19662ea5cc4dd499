#include "lab/options/options.h"
#include "lab/torch/tensor_sampler.h"

#include <torch/torch.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "guidance/dummy_model.h"
#include "lab/config/yaml.h"

using namespace diffsac;

namespace {

constexpr double kNoClipping = -1000.0;

ReverseSamplerOptions Kind(const std::string& kind, int steps = 10) {
  ReverseSamplerOptions options;
  options.kind = FromString<ReverseSamplerKind>(kind);
  options.steps = steps;
  return options;
}

std::vector<ReverseSamplerOptions> EveryKind(int steps = 10) {
  std::vector<ReverseSamplerOptions> all = {Kind("ddpm", steps), Kind("renoise", steps), Kind("ddim", steps)};
  all.push_back(Kind("ddim", steps));
  all.back().ddim_eta = 0.7;
  for (const int order : {1, 2}) {
    all.push_back(Kind("dpm_solver_pp", steps));
    all.back().order = order;
  }
  return all;
}

torch::Tensor Normal(Rng rng, at::IntArrayRef shape) {
  auto x = torch::empty(shape);
  for (std::int64_t i = 0; i < x.numel(); ++i) x.data_ptr<float>()[i] = static_cast<float>(rng.Normal());
  return x;
}

const std::vector<std::int64_t> kShape = {2, 3, 7};  // [B, κ, N]

torch::Tensor StartNoise() { return Normal(Rng(11), kShape); }

NoiseFunction StepNoise(std::uint64_t seed = 12) {
  return [seed](int step) { return Normal(Rng(seed).Fork("step", step), kShape); };
}

torch::Tensor Run(const ReverseSamplerOptions& options, const DenoiseFunction& denoise,
                  const char* schedule = "cosine") {
  return MakeReverseSampler(options, MakeSchedule(schedule))->Sample(denoise, StartNoise(), StepNoise());
}

/// Some network: nonlinear, in (−1, 1).
torch::Tensor Network(const torch::Tensor& c, double t) { return torch::tanh(3.0 * c + 0.01 * t); }

}  // namespace

TEST_CASE("with a perfect denoiser every sampler returns the labels") {
  const auto labels = torch::where(Normal(Rng(1), kShape) > 0, torch::ones(kShape), -torch::ones(kShape));
  const int steps = GENERATE(1, 2, 10, 20, 100);
  for (auto options : EveryKind(steps)) {
    for (const char* spacing : {"linspace", "leading", "trailing"}) {
      for (const bool zero_snr : {false, true}) {
        options.timestep_spacing = FromString<TimestepSpacing>(spacing);
        CAPTURE(ToString(options.kind), options.order, spacing, steps, zero_snr);
        const auto sampler = MakeReverseSampler(options, MakeSchedule("cosine", 100, zero_snr));
        const auto c0 = sampler->Sample([&](const auto&, double) { return labels; }, StartNoise(), StepNoise());
        CHECK((c0 - labels).abs().max().item<float>() < 1e-5f);
      }
    }
  }
}

TEST_CASE("the answer keeps shape and type and is finite, from exactly no signal too") {
  for (auto options : EveryKind()) {
    options.lambda_min_clipped = kNoClipping;
    const auto schedule = MakeSchedule("cosine", 100, true);
    const auto c0 = MakeReverseSampler(options, schedule)->Sample(Network, StartNoise(), StepNoise());
    CHECK(c0.sizes() == at::IntArrayRef(kShape));
    CHECK(c0.scalar_type() == torch::kFloat32);
    CHECK(torch::isfinite(c0).all().item<bool>());
    CHECK_FALSE(c0.requires_grad());
  }
}

TEST_CASE("the same noise gives the same answer, other noise another") {
  for (const auto& options : EveryKind()) {
    const auto sampler = MakeReverseSampler(options, MakeSchedule("cosine"));
    const auto first = sampler->Sample(Network, StartNoise(), StepNoise());
    CHECK(torch::equal(first, sampler->Sample(Network, StartNoise(), StepNoise())));
    const auto other = sampler->Sample(Network, StartNoise(), StepNoise(13));
    CHECK(torch::equal(first, other) == !sampler->IsStochastic());
  }
}

TEST_CASE("a problem's answer does not depend on its batch mates") {
  for (const auto& options : EveryKind()) {
    const auto sampler = MakeReverseSampler(options, MakeSchedule("cosine"));
    const auto all = sampler->Sample(Network, StartNoise(), StepNoise());
    const auto noise = StepNoise();
    const auto one =
        sampler->Sample(Network, StartNoise().slice(0, 1, 2), [&](int step) { return noise(step).slice(0, 1, 2); });
    CHECK(torch::allclose(all.slice(0, 1, 2), one, 1e-6, 1e-6));
  }
}

TEST_CASE("the observer is called once a step") {
  for (const auto& options : EveryKind()) {
    const auto sampler = MakeReverseSampler(options, MakeSchedule("cosine"));
    std::vector<double> times;
    sampler->Sample(Network, StartNoise(), StepNoise(),
                    [&](int step, double t, const torch::Tensor& c_t, const torch::Tensor& c0_hat) {
                      CHECK(step == static_cast<int>(times.size()));
                      CHECK(torch::allclose(c0_hat, Network(c_t, t)));
                      times.push_back(t);
                    });
    REQUIRE(static_cast<int>(times.size()) == sampler->Steps());
    for (int i = 0; i < sampler->Steps(); ++i) CHECK(times[i] == sampler->grid()[i].t);
  }
}

TEST_CASE("a step is one call of the network") {
  for (const auto& options : EveryKind()) {
    int calls = 0;
    Run(options, [&](const torch::Tensor& c, double t) {
      ++calls;
      return Network(c, t);
    });
    CHECK(calls == MakeReverseSampler(options, MakeSchedule("cosine"))->Steps());
  }
}

TEST_CASE("ddim without noise is DPM-Solver++ of order 1") {
  auto dpm = Kind("dpm_solver_pp");
  dpm.order = 1;
  CHECK(torch::allclose(Run(Kind("ddim"), Network), Run(dpm, Network), 1e-4, 1e-5));
}

TEST_CASE("ddim with eta 1 is ddpm") {
  auto ddim = Kind("ddim");
  ddim.ddim_eta = 1.0;
  CHECK(torch::allclose(Run(ddim, Network), Run(Kind("ddpm"), Network), 1e-4, 1e-5));
}

TEST_CASE("ddpm over all steps uses the published posterior") {
  const auto schedule = MakeSchedule("linear_scaled");
  auto options = Kind("ddpm", 100);
  options.lambda_min_clipped = kNoClipping;
  auto c = StartNoise();
  for (int t = 99; t >= 0; --t) {
    const double previous = t > 0 ? schedule.alphas_bar()[t - 1] : 1.0;
    const double beta = schedule.betas()[t];
    const double rest = 1.0 - schedule.alphas_bar()[t];
    const auto mean =
        std::sqrt(previous) * beta / rest * Network(c, t) + std::sqrt(1.0 - beta) * (1.0 - previous) / rest * c;
    c = t > 0 ? mean + std::sqrt((1.0 - previous) / rest * beta) * StepNoise()(99 - t) : mean;
  }
  CHECK(torch::allclose(Run(options, Network, "linear_scaled"), c, 1e-4, 1e-4));
}

TEST_CASE("renoise is the paper's update") {
  const auto schedule = MakeSchedule("cosine");
  auto c = StartNoise();
  c = schedule.alpha(49) * Network(c, 98) + schedule.sigma(49) * StepNoise()(0);
  CHECK(torch::allclose(Run(Kind("renoise", 2), Network), Network(c, 49), 1e-5, 1e-5));
}

TEST_CASE("ddpm over a thousand steps with an exact denoiser draws from the data's distribution") {
  const auto schedule = MakeSchedule("cosine", 1000);  // its bias falls with the number of steps
  auto options = Kind("ddpm", 1000);
  options.clip_x0 = false;
  torch::manual_seed(7);
  const auto normal = [] { return torch::randn({10000}, torch::kFloat64); };
  // Data N(0.3, 0.2²): E[c_0 | c_t] in closed form.
  const auto denoise = [&](const torch::Tensor& c, double t) {
    const double alpha = schedule.alpha(static_cast<int>(t));
    const double sigma = schedule.sigma(static_cast<int>(t));
    return 0.3 + alpha * 0.04 / (alpha * alpha * 0.04 + sigma * sigma) * (c - alpha * 0.3);
  };
  const auto c0 = MakeReverseSampler(options, schedule)->Sample(denoise, normal(), [&](int) { return normal(); });
  CHECK(c0.mean().item<double>() == Approx(0.3).margin(0.01));
  CHECK(c0.std().item<double>() == Approx(0.2).margin(0.007));
}

TEST_CASE("clipping holds every prediction to the range of labels") {
  for (auto options : EveryKind()) {
    const auto wild = [](const torch::Tensor& c, double) { return 10.0 * c; };
    CHECK(Run(options, wild).abs().max().item<float>() <= 1.0f + 1e-6f);
    options.clip_x0 = false;
    CHECK(Run(options, wild).abs().max().item<float>() > 1.0f);
  }
}

TEST_CASE("one step is one prediction") {
  for (const auto& options : EveryKind(1)) CHECK(torch::allclose(Run(options, Network), Network(StartNoise(), 98)));
}

TEST_CASE("only samplers that draw noise ask for it") {
  for (const auto& options : EveryKind()) {
    const auto sampler = MakeReverseSampler(options, MakeSchedule("cosine"));
    if (sampler->IsStochastic()) {
      CHECK_THROWS_AS(sampler->Sample(Network, StartNoise()), Error);
    } else {
      CHECK_NOTHROW(sampler->Sample(Network, StartNoise()));
    }
  }
  CHECK_FALSE(MakeReverseSampler(Kind("renoise", 1), MakeSchedule("cosine"))->IsStochastic());
}

TEST_CASE("bad sampler options are errors") {
  const auto make = [](auto change) {
    ReverseSamplerOptions options;
    change(options);
    MakeReverseSampler(options, MakeSchedule("cosine"));
  };
  CHECK_THROWS_AS(make([](auto& o) { o.kind = FromString<ReverseSamplerKind>("euler"); }), Error);
  CHECK_THROWS_AS(make([](auto& o) { o.steps = 0; }), Error);
  CHECK_THROWS_AS(make([](auto& o) { o.steps = 101; }), Error);
  CHECK_THROWS_AS(make([](auto& o) { o.order = 3; }), Error);
  CHECK_THROWS_AS(make([](auto& o) { o.timestep_spacing = FromString<TimestepSpacing>("quadratic"); }), Error);
  CHECK_THROWS_AS(make([](auto& o) { o.final_sigma = FromString<FinalSigma>("tiny"); }), Error);
}

TEST_CASE("sampler options come from YAML and go back") {
  const auto options = ReadOptions<ReverseSamplerOptions>(ConfigFromYaml("kind: ddim\nsteps: 7\n"));
  CHECK(options.kind == ReverseSamplerKind::kDdim);
  CHECK(options.steps == 7);
  const auto again = ReadOptions<ReverseSamplerOptions>(ToConfig(options));
  CHECK(again.kind == ReverseSamplerKind::kDdim);
  CHECK(again.steps == 7);
  CHECK_THROWS_WITH(ReadOptions<ReverseSamplerOptions>(ConfigFromYaml("kind: ddmp\n")), Catch::Contains("ddpm"));
  CHECK_THROWS_AS(ReadOptions<ReverseSamplerOptions>(ConfigFromYaml("steps: 0\n")), Error);
}
