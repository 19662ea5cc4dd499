#include "lab/baselines/dgsac.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/scores/scorer.h"
#include "lab/baselines/density_guide.h"
#include "lab/baselines/residual_density.h"

namespace diffsac {
namespace {

/// Of the budget at most a quarter is drawn between two looks at the densities, so that three quarters are guided
/// however few sets there are. The paper draws one for each point that is not explained.
constexpr int kRoundsOfBudget = 4;
/// A point is explained once a round with a set of its own raises its explanation (DensityGuide) by no more than this
/// share.
constexpr double kExplainedChange = 0.01;
/// T, hypotheses that a point prefers.
constexpr int kPreferred = 5;
/// Least contrast of a hypothesis (InlierExtent); less is a flat density.
constexpr double kMinContrast = 3.0;
/// Correlation from which two hypotheses stand for one structure.
constexpr double kSameInstance = 0.15;
constexpr std::size_t kMostInstances = 20;

/// One run over one point set: sampling in rounds, then selection, then the refit.
template <MinimalModel Model>
class DgsacRun {
 public:
  using Parameters = typename Model::Parameters;

  DgsacRun(const PointMatrix& points, const DgsacOptions& options, const Rng& rng)
      : options_(options), rng_(rng), scorer_(points), guide_(static_cast<int>(points.rows()), kPreferred) {}

  void Sample() {
    std::vector<int> active = rng_.Fork("first_points").Permutation(scorer_.size());
    Eigen::VectorXd explained = Eigen::VectorXd::Zero(scorer_.size());
    stop_ = StopReason::kBudget;
    for (std::uint64_t round = 0; drawn_ < options_.max_iterations; ++round) {
      const std::vector<int> firsts = FirstPoints(active, round);
      DrawRound(firsts);
      if (round == 0) guided_from_ = drawn_;
      active = Unexplained(active, firsts, &explained);
      if (!active.empty()) continue;
      if (options_.stopping == DgsacStopping::kExplained) {
        stop_ = StopReason::kConfidence;
        return;
      }
      active = rng_.Fork("first_points", round + 1).Permutation(scorer_.size());
    }
  }

  void Finish(DgsacResult* result) {
    result->stop = stop_;
    result->guided_from = guided_from_;
    result->unique_minimal_sets = CountUniqueSets(sets_, Model::kMinimalSize);
    result->first_sets = FirstSets(sets_, Model::kMinimalSize);
    std::vector<Candidate> instances = Instances(Candidates());
    if (options_.refit_rounds > 0) {
      for (Candidate& instance : instances) Refit(&instance);
      instances = Instances(std::move(instances));
    }
    result->instances = static_cast<int>(std::count_if(instances.begin(), instances.end(),
                                                       [&](const Candidate& instance) { return IsClear(instance); }));
    if (!instances.empty()) Report(instances.front(), result);
    result->hypotheses = hypotheses_;
    result->sets = std::move(sets_);
  }

 private:
  struct Candidate {
    Parameters model;
    DensityHypothesis density;
  };

  /// The points that get a set of their own in this round.
  std::vector<int> FirstPoints(const std::vector<int>& active, std::uint64_t round) const {
    const int limit = (options_.max_iterations + kRoundsOfBudget - 1) / kRoundsOfBudget;
    const int size = static_cast<int>(active.size());
    const int count = std::min({size, limit, options_.max_iterations - drawn_});
    if (count == size) return active;
    std::vector<int> chosen(count);
    rng_.Fork("round", round).Distinct(size, count, chosen.data());
    for (int& index : chosen) index = active[index];
    return chosen;
  }

  void DrawRound(const std::vector<int>& firsts) {
    guide_.StartRound();
    std::vector<int> set(Model::kMinimalSize);
    for (const int first : firsts) {
      Rng rng = DrawRng(rng_, drawn_++);
      guide_.Draw(first, Model::kMinimalSize, rng, set.data());
      sets_.insert(sets_.end(), set.begin(), set.end());
      Solve(set.data());
    }
  }

  void Solve(const int* set) {
    Parameters solved[Model::kMaxSolutions];
    const int count = Model::SolveMinimal(scorer_.points(), set, solved);
    hypotheses_ += std::max(1, count);
    for (int i = 0; i < count; ++i) {
      const ResidualDensity density = Density(solved[i]);
      if (density.order.empty()) continue;
      guide_.Add(density.AtPoints());
      models_.push_back(solved[i]);
    }
  }

  ResidualDensity Density(const Parameters& model) const {
    return ComputeResidualDensity(scorer_.Residuals(model), Model::kMinimalSize);
  }

  /// The points that the next round is for: those that the last one explained better, and those that had no set in it.
  /// Empty when fewer than γ of the points that were asked about are left. Brings *explained up to date.
  std::vector<int> Unexplained(const std::vector<int>& active, const std::vector<int>& firsts,
                               Eigen::VectorXd* explained) const {
    const int size = scorer_.size();
    std::vector<char> is_waiting(size, 0), is_active(size, 0);
    for (const int point : active) is_active[point] = is_waiting[point] = 1;
    for (const int point : firsts) is_waiting[point] = 0;
    int open = 0;
    std::vector<int> next;
    for (int i = 0; i < size; ++i) {
      const double now = guide_.Explanation(i);
      const bool changed = std::abs(now - (*explained)[i]) > kExplainedChange * (*explained)[i];
      (*explained)[i] = now;
      if (!changed && !is_waiting[i]) continue;
      next.push_back(i);
      open += is_active[i];
    }
    if (open < Model::kMinimalSize) next.clear();
    return next;
  }

  Candidate Describe(const Parameters& model) const {
    return {model, DescribeHypothesis(Density(model), Model::kMinimalSize)};
  }

  /// The clear ones among the hypotheses that some point prefers; where none is, the one of greatest evidence. The
  /// others are not kept: there can be thousands.
  std::vector<Candidate> Candidates() const {
    std::vector<Candidate> clear, evident;
    for (const int h : guide_.Preferred()) {
      Candidate candidate = Describe(models_[h]);
      const InlierExtent& inliers = candidate.density.inliers;
      if (inliers.count == 0) continue;
      if (IsClear(candidate)) {
        clear.push_back(std::move(candidate));
      } else if (evident.empty() || inliers.evidence > evident[0].density.inliers.evidence) {
        evident.assign(1, std::move(candidate));
      }
    }
    return clear.empty() ? evident : clear;
  }

  bool IsClear(const Candidate& candidate) const { return candidate.density.inliers.contrast >= kMinContrast; }

  /// One candidate for each structure, at most kMostStructures, the densest; where no candidate is clear, the one of
  /// greatest evidence, so that hard data have an answer too.
  std::vector<Candidate> Instances(std::vector<Candidate> candidates) const {
    std::vector<DensityHypothesis> densities;
    for (Candidate& candidate : candidates) densities.push_back(std::move(candidate.density));
    std::vector<int> selected = SelectInstances(densities, kMinContrast, kSameInstance);
    if (selected.empty() && !candidates.empty()) {
      const auto by_evidence = [](const auto& a, const auto& b) { return a.inliers.evidence < b.inliers.evidence; };
      selected.push_back(
          static_cast<int>(std::max_element(densities.begin(), densities.end(), by_evidence) - densities.begin()));
    }
    std::stable_sort(selected.begin(), selected.end(),
                     [&](int a, int b) { return Goodness(densities[a]) > Goodness(densities[b]); });
    if (selected.size() > kMostInstances) selected.resize(kMostInstances);
    std::vector<Candidate> result;
    for (const int s : selected) result.push_back({candidates[s].model, std::move(densities[s])});
    return result;
  }

  void Refit(Candidate* best) {
    for (int round = 0; round < options_.refit_rounds; ++round) {
      const DensityHypothesis& now = best->density;
      Eigen::VectorXd weights = Eigen::VectorXd::Zero(scorer_.size());
      for (int k = 0; k < now.inliers.count; ++k) weights[now.order[k]] = 1.0;
      Parameters model = best->model;
      ++hypotheses_;
      if (!FitAgain<Model>(scorer_.points(), weights, &model) || model == best->model) return;
      Candidate next = Describe(model);
      // Noise moves the evidence of models that are as good; a clear fall means that the inliers were lost.
      if (next.density.inliers.evidence < now.inliers.evidence - std::log(scorer_.size())) return;
      if (next.density.inliers.count == 0) return;
      *best = std::move(next);
    }
  }

  void Report(const Candidate& best, DgsacResult* result) const {
    result->status = Status::kOk;
    result->model = best.model;
    const InlierExtent& inliers = best.density.inliers;
    const std::vector<int>& order = best.density.order;
    result->extent = inliers.residual;
    result->evidence = inliers.evidence;
    result->inliers.assign(scorer_.size(), 0);
    const Eigen::VectorXd residuals = scorer_.Residuals(best.model);
    double squares = 0.0;
    for (int k = 0; k < inliers.count; ++k) {
      result->inliers[order[k]] = 1;
      squares += residuals[order[k]] * residuals[order[k]];
    }
    result->sigma = std::sqrt(squares / std::max(1, inliers.count - Model::kMinimalSize));
  }

  const DgsacOptions& options_;
  Rng rng_;
  Scorer<Model> scorer_;
  DensityGuide guide_;
  std::vector<Parameters> models_;
  std::vector<int> sets_;
  int drawn_ = 0;
  int guided_from_ = 0;
  int hypotheses_ = 0;
  StopReason stop_ = StopReason::kNotRun;
};

}  // namespace

template <MinimalModel Model>
DgsacResult EstimateDgsac(const PointMatrix& points, const DgsacOptions& options, const Rng& rng) {
  DgsacResult result;
  result.status = CheckPoints<Model>(points);
  if (result.status == Status::kOk && points.rows() > kMostDgsacPoints) result.status = Status::kTooManyPoints;
  if (result.status != Status::kOk) return result;
  result.status = Status::kNoModel;
  // Every hypothesis goes through all γ points: their residuals say nothing.
  if (points.rows() <= Model::kMinimalSize) return result;
  DgsacRun<Model> run(points, options, rng);
  run.Sample();
  run.Finish(&result);
  return result;
}

template DgsacResult EstimateDgsac<Line>(const PointMatrix&, const DgsacOptions&, const Rng&);
template DgsacResult EstimateDgsac<Plane>(const PointMatrix&, const DgsacOptions&, const Rng&);
template DgsacResult EstimateDgsac<Homography>(const PointMatrix&, const DgsacOptions&, const Rng&);
template DgsacResult EstimateDgsac<Fundamental>(const PointMatrix&, const DgsacOptions&, const Rng&);
template DgsacResult EstimateDgsac<Fundamental8>(const PointMatrix&, const DgsacOptions&, const Rng&);
template DgsacResult EstimateDgsac<Essential>(const PointMatrix&, const DgsacOptions&, const Rng&);
template DgsacResult EstimateDgsac<AbsolutePose>(const PointMatrix&, const DgsacOptions&, const Rng&);
template DgsacResult EstimateDgsac<SharedFocal>(const PointMatrix&, const DgsacOptions&, const Rng&);
template DgsacResult EstimateDgsac<OneFocal>(const PointMatrix&, const DgsacOptions&, const Rng&);
template DgsacResult EstimateDgsac<TwoFocals>(const PointMatrix&, const DgsacOptions&, const Rng&);
template DgsacResult EstimateDgsac<VanishingPoint>(const PointMatrix&, const DgsacOptions&, const Rng&);
template DgsacResult EstimateDgsac<Rigid>(const PointMatrix&, const DgsacOptions&, const Rng&);
template DgsacResult EstimateDgsac<Similarity>(const PointMatrix&, const DgsacOptions&, const Rng&);

void DgsacOptions::Bind(OptionsBinder& b) {
  b.Field("max_iterations", max_iterations, Within(1, 1e6))
      .Help("minimal sets: at most, or exactly so many with stopping: budget");
  b.Field("stopping", stopping).Help("explained, the paper's: once another round explains fewer than γ points better");
  b.Field("refit_rounds", refit_rounds, AtLeast(0))
      .Help("of each structure, on the inliers that its density tells; at most");
}

}  // namespace diffsac
