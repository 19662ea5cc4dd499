#include "diffsac/diffusion/reverse_sampler.h"

#include <torch/torch.h>

#include <functional>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/diffusion/ancestral_samplers.h"
#include "diffsac/diffusion/dpm_solver.h"

namespace diffsac {
namespace {

/// ddpm, renoise and ddim: they differ in three numbers a step.
class LinearSampler : public ReverseSampler {
 public:
  using Update = std::function<LinearUpdate(const TimePoint& s, const TimePoint& t)>;

  LinearSampler(TimeGrid grid, bool clip_x0, const Update& update) : ReverseSampler(std::move(grid), clip_x0) {
    for (int step = 0; step < Steps(); ++step) updates_.push_back(update(this->grid()[step], this->grid()[step + 1]));
  }

  bool IsStochastic() const override {
    for (const LinearUpdate& update : updates_) {
      if (update.from_noise > 0.0) return true;
    }
    return false;
  }

 protected:
  torch::Tensor Run(const DenoiseFunction& denoise, torch::Tensor c, const NoiseFunction& noise,
                    const StepObserver& observer) const override {
    for (int step = 0; step < Steps(); ++step) {
      const LinearUpdate& update = updates_[step];
      const auto c0_hat = denoise(c, grid()[step].t);
      if (observer) observer(step, grid()[step].t, c, c0_hat);
      auto next = update.from_x * c + update.from_x0 * c0_hat;
      if (update.from_noise > 0.0) next = next + update.from_noise * noise(step);
      c = next;
    }
    return c;
  }

 private:
  std::vector<LinearUpdate> updates_;
};

class DpmSolverSampler : public ReverseSampler {
 public:
  DpmSolverSampler(TimeGrid grid, bool clip_x0, const DpmSolverOptions& options, const NoiseSchedule& schedule)
      : ReverseSampler(std::move(grid), clip_x0), options_(options), schedule_(schedule) {}

  // One step onto clean data adds no noise.
  bool IsStochastic() const override { return options_.sde && (Steps() > 1 || grid().back().sigma > 0.0); }

 protected:
  torch::Tensor Run(const DenoiseFunction& denoise, torch::Tensor c, const NoiseFunction& noise,
                    const StepObserver& observer) const override {
    const auto to_point = [this](double lambda) {
      return TimePoint::FromLambda(schedule_.TimestepOfLambda(lambda), lambda);
    };
    return RunDpmSolver(grid(), options_, denoise, std::move(c), noise, observer, to_point);
  }

 private:
  DpmSolverOptions options_;
  NoiseSchedule schedule_;
};

}  // namespace

void SamplerOptions::Bind(OptionsBinder& b) {
  b.Choice("kind", kind, {"ddpm", "renoise", "ddim", "dpm_solver_pp"});
  b.Field("steps", steps, AtLeast(1));
  b.Field("order", order, Within(1, 2));
  b.Choice("variant", variant, {"2M", "2S"});
  b.Choice("timestep_spacing", timestep_spacing, {"linspace", "leading", "trailing", "uniform_lambda", "karras", "lu"});
  b.Choice("final_sigma", final_sigma, {"zero", "sigma_min"});
  b.Field("lower_order_final", lower_order_final);
  b.Field("lambda_min_clipped", lambda_min_clipped);
  b.Field("ddim_eta", ddim_eta, Within(0.0, 1.0));
  b.Field("sde", sde);
  b.Field("clip_x0", clip_x0);
  b.Require(!sde || order == 1 || variant == "2M", "sde", "variant 2M or order 1");
}

void SamplerOptions::Check() const {
  const auto require = [](bool ok, const std::string& message) {
    if (!ok) throw Error("sampler: " + message);
  };
  require(kind == "ddpm" || kind == "renoise" || kind == "ddim" || kind == "dpm_solver_pp",
          "kind '" + kind + "' is not one of ddpm, renoise, ddim, dpm_solver_pp");
  require(steps >= 1, "steps must be at least 1");
  require(order == 1 || order == 2, "order must be 1 or 2");
  require(variant == "2M" || variant == "2S", "variant '" + variant + "' is not one of 2M, 2S");
  require(ddim_eta >= 0.0 && ddim_eta <= 1.0, "ddim_eta must be in [0, 1]");
  require(!sde || order == 1 || variant == "2M", "sde works with variant 2M or order 1 only");
}

torch::Tensor ReverseSampler::Sample(const DenoiseFunction& denoise, torch::Tensor c_T, const NoiseFunction& noise,
                                     const StepObserver& observer) const {
  if (IsStochastic() && !noise) throw Error("sampler: a stochastic sampler was given no noise");
  const torch::NoGradGuard no_grad;
  if (!clip_x0_) return Run(denoise, std::move(c_T), noise, observer);
  const auto clipped = [&denoise](const torch::Tensor& c, double t) { return denoise(c, t).clamp(-1.0, 1.0); };
  return Run(clipped, std::move(c_T), noise, observer);
}

std::unique_ptr<ReverseSampler> MakeReverseSampler(const SamplerOptions& options, const NoiseSchedule& schedule) {
  options.Check();
  auto grid = MakeTimeGrid(schedule,
                           {options.steps, options.timestep_spacing, options.final_sigma, options.lambda_min_clipped});
  if (options.kind == "dpm_solver_pp") {
    const DpmSolverOptions solver{options.order, options.variant == "2M", options.lower_order_final, options.sde};
    return std::make_unique<DpmSolverSampler>(std::move(grid), options.clip_x0, solver, schedule);
  }
  LinearSampler::Update update = DdpmUpdate;
  if (options.kind == "renoise") update = RenoiseUpdate;
  if (options.kind == "ddim") {
    update = [eta = options.ddim_eta](const TimePoint& s, const TimePoint& t) { return DdimUpdate(s, t, eta); };
  }
  return std::make_unique<LinearSampler>(std::move(grid), options.clip_x0, update);
}

}  // namespace diffsac
