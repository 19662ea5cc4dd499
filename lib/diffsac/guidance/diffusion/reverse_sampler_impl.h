#pragma once

// The samplers behind reverse_sampler.h, for the files that instantiate them for a kind of value.

#include <functional>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/guidance/diffusion/ancestral_samplers.h"
#include "diffsac/guidance/diffusion/dpm_solver_impl.h"
#include "diffsac/guidance/diffusion/reverse_sampler.h"

namespace diffsac {

/// ddpm, renoise and ddim: they differ in three numbers a step.
template <class Value>
class LinearSampler : public ReverseSamplerOf<Value> {
 public:
  using Base = ReverseSamplerOf<Value>;
  using Update = std::function<LinearUpdate(const TimePoint& s, const TimePoint& t)>;

  LinearSampler(TimeGrid grid, bool clip_x0, const Update& update) : Base(std::move(grid), clip_x0) {
    for (int step = 0; step < this->Steps(); ++step)
      updates_.push_back(update(this->grid()[step], this->grid()[step + 1]));
  }

  bool IsStochastic() const override {
    for (const LinearUpdate& update : updates_) {
      if (update.from_noise > 0.0) return true;
    }
    return false;
  }

 protected:
  Value Run(const typename Base::DenoiseFunction& denoise, Value c, const typename Base::NoiseFunction& noise,
            const typename Base::StepObserver& observer) const override {
    for (int step = 0; step < this->Steps(); ++step) {
      const LinearUpdate& update = updates_[step];
      const double t = this->grid()[step].t;
      const Value c0_hat = denoise(c, t);
      if (observer) observer(step, t, c, c0_hat);
      Value next = update.from_x * c + update.from_x0 * c0_hat;
      if (update.from_noise > 0.0) next = next + update.from_noise * noise(step);
      c = next;
    }
    return c;
  }

 private:
  std::vector<LinearUpdate> updates_;
};

template <class Value>
class DpmSolverSampler : public ReverseSamplerOf<Value> {
 public:
  using Base = ReverseSamplerOf<Value>;

  DpmSolverSampler(TimeGrid grid, bool clip_x0, const DpmSolverOptions& options)
      : Base(std::move(grid), clip_x0), options_(options) {}

  bool IsStochastic() const override { return false; }

 protected:
  Value Run(const typename Base::DenoiseFunction& denoise, Value c, const typename Base::NoiseFunction&,
            const typename Base::StepObserver& observer) const override {
    return RunDpmSolver<Value>(this->grid(), options_, denoise, std::move(c), observer);
  }

 private:
  DpmSolverOptions options_;
};

template <class Value>
Value ReverseSamplerOf<Value>::Sample(const DenoiseFunction& denoise, Value c_T, const NoiseFunction& noise,
                                      const StepObserver& observer) const {
  if (IsStochastic() && !noise) throw Error("sampler: a stochastic sampler was given no noise");
  [[maybe_unused]] const typename SampledValue<Value>::Scope scope;
  if (!clip_x0_) return Run(denoise, std::move(c_T), noise, observer);
  const auto clipped = [&denoise](const Value& c, double t) { return SampledValue<Value>::Clamp(denoise(c, t)); };
  return Run(clipped, std::move(c_T), noise, observer);
}

template <class Value>
std::unique_ptr<ReverseSamplerOf<Value>> MakeReverseSamplerOf(const ReverseSamplerOptions& options,
                                                              const NoiseSchedule& schedule) {
  if (options.steps < 1) throw Error("sampler: steps: expected at least 1");
  if (options.order < 1 || options.order > 2) throw Error("sampler: order: expected 1 or 2");
  auto grid = MakeTimeGrid(schedule,
                           {options.steps, options.timestep_spacing, options.final_sigma, options.lambda_min_clipped});
  if (options.kind == ReverseSamplerKind::kDpmSolverPp) {
    const DpmSolverOptions solver{options.order, options.lower_order_final};
    return std::make_unique<DpmSolverSampler<Value>>(std::move(grid), options.clip_x0, solver);
  }
  typename LinearSampler<Value>::Update update = DdpmUpdate;
  if (options.kind == ReverseSamplerKind::kRenoise) update = RenoiseUpdate;
  if (options.kind == ReverseSamplerKind::kDdim) {
    update = [eta = options.ddim_eta](const TimePoint& s, const TimePoint& t) { return DdimUpdate(s, t, eta); };
  }
  return std::make_unique<LinearSampler<Value>>(std::move(grid), options.clip_x0, update);
}

}  // namespace diffsac
