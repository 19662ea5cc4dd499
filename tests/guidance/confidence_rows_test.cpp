// Plain rows go the same way as tensors.
#include "diffsac/guidance/diffusion/confidence_rows.h"

#include <torch/torch.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "guidance/dummy_model.h"
#include "lab/torch/tensor_sampler.h"

using namespace diffsac;

namespace {

constexpr int kValues = 12;

ConfidenceRows Rows(int which) {
  ConfidenceRows rows{Eigen::ArrayXf(kValues)};
  for (int i = 0; i < kValues; ++i) rows.values[i] = std::sin(1.7f * static_cast<float>(i) + static_cast<float>(which));
  return rows;
}

torch::Tensor TensorOf(const ConfidenceRows& rows) {
  return torch::from_blob(const_cast<float*>(rows.values.data()), {kValues}).clone();
}

}  // namespace

TEST_CASE("every sampler takes plain rows where it takes tensors") {
  for (const char* kind : {"ddpm", "renoise", "ddim", "dpm_solver_pp"}) {
    ReverseSamplerOptions options;
    options.kind = FromString<ReverseSamplerKind>(kind);
    options.steps = 6;
    const auto schedule = MakeSchedule("cosine");
    const auto on_rows = MakeConfidenceSampler(options, schedule);
    const auto on_tensors = MakeReverseSampler(options, schedule);
    CHECK(on_rows->IsStochastic() == on_tensors->IsStochastic());
    const auto rows =
        on_rows->Sample([](const ConfidenceRows& c,
                           double t) { return ConfidenceRows{(c.values * static_cast<float>(1.0 - t / 200.0)).sin()}; },
                        Rows(0), [](int step) { return Rows(step + 1); });
    const auto tensors = on_tensors->Sample(
        [](const torch::Tensor& c, double t) { return (c * static_cast<float>(1.0 - t / 200.0)).sin(); },
        TensorOf(Rows(0)), [](int step) { return TensorOf(Rows(step + 1)); });
    CHECK((tensors - TensorOf(rows)).abs().max().item<double>() < 2e-5);
  }
}
