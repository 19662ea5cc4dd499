#include "diffsac/estimate/second_search.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "diffsac/estimate/diagnose.h"
#include "diffsac/estimate/mirror_check.h"
#include "diffsac/estimate/pixel_length.h"
#include "diffsac/estimate/point_rows.h"
#include "diffsac/estimate/score_check.h"
#include "diffsac/estimate/static_overlay.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

/// Whether noise turned out to be far above where a wide range of scales begins.
bool IsNoiseFar(const PreparedProblem& prepared, const Estimate& estimate) {
  constexpr double kFar = 2.0;
  const NoiseRange& range = prepared.space().noise();
  return estimate.status == Status::kOk && range.least < range.greatest &&
         estimate.sigma > kFar * range.least * DefaultThreshold(prepared.problem().task);
}

/// The middle of the presets' scales is about ε / 1.5.
NoiseRange RangeAbout(double noise, Task task) {
  constexpr double kSuited = 1.5;
  const double factor = kSuited * noise / DefaultThreshold(task);
  return {factor, factor};
}

using Search = std::function<Estimate(const NormalizedProblem&, SearchReason)>;

Estimate SearchIn(const PreparedProblem& prepared, const Search& search, SearchReason reason) {
  Estimate estimate = search(prepared.space(), reason);
  AddSupport(prepared, &estimate);
  return estimate;
}

/// Either result costs what both searches did.
void JoinCosts(Estimate* second, Estimate* estimate) {
  AddCost(estimate->stats, &second->stats);
  estimate->stats = second->stats;
}

/// Takes the result of the second search where it is the better one.
bool Take(const PreparedProblem& prepared, Estimate second, Estimate* estimate) {
  Diagnose(prepared, &second);
  *estimate = std::move(second);
  return true;
}

bool SearchMoving(const PreparedProblem& prepared, const Search& search, Estimate* estimate) {
  const std::vector<int> rows = RowsThatMove(prepared.problem(), *estimate);
  const Problem part = PartOf(prepared.problem(), rows);
  const PreparedProblem moving(part, prepared.space().noise());
  Estimate second = SearchIn(moving, search, SearchReason::kStill);
  JoinCosts(&second, estimate);
  if (!IsBetterMoving(rows, second, *estimate)) return false;
  Diagnose(moving, &second);
  SpreadMoving(rows, static_cast<std::size_t>(prepared.problem().points.rows()), &second);
  *estimate = std::move(second);
  return true;
}

bool SearchMirrored(const PreparedProblem& prepared, const Search& search, Estimate* estimate) {
  const Problem problem = Mirrored(prepared.problem());
  const PreparedProblem mirrored(problem, prepared.space().noise());
  Estimate second = SearchIn(mirrored, search, SearchReason::kMirrored);
  AddCost(second.stats, &estimate->stats);
  Diagnose(mirrored, &second);
  if (IsBetterMirrored(second, *estimate)) SetMirrored(estimate);
  return false;
}

bool SearchWithoutScores(const PreparedProblem& prepared, const Search& search, Estimate* estimate) {
  Problem problem = prepared.problem();
  problem.snn_ratio = {};
  const PreparedProblem without(problem, prepared.space().noise());
  Estimate second = SearchIn(without, search, SearchReason::kScores);
  JoinCosts(&second, estimate);
  if (!IsBetterWithoutScores(prepared.problem(), second, *estimate)) return false;
  second.scores_ignored = true;
  return Take(without, std::move(second), estimate);
}

bool SearchAboutNoise(const PreparedProblem& prepared, const Search& search, Estimate* estimate) {
  const Problem& problem = prepared.problem();
  const PreparedProblem suited(problem, RangeAbout(estimate->sigma, problem.task));
  Estimate second = SearchIn(suited, search, SearchReason::kNoise);
  JoinCosts(&second, estimate);
  return second.status == Status::kOk && Take(suited, std::move(second), estimate);
}

}  // namespace

SearchReason ReasonToSearch(const PreparedProblem& prepared, const Estimate& estimate) {
  const Problem& problem = prepared.problem();
  if (!RowsThatMove(problem, estimate).empty()) return SearchReason::kStill;
  if (MayBeMirrored(prepared.space(), estimate)) return SearchReason::kMirrored;
  if (DoubtsScores(problem, estimate)) return SearchReason::kScores;
  return IsNoiseFar(prepared, estimate) ? SearchReason::kNoise : SearchReason::kNone;
}

bool SearchAgain(const PreparedProblem& prepared, const Search& search, Estimate* estimate) {
  switch (ReasonToSearch(prepared, *estimate)) {
    case SearchReason::kNone:
      return false;
    case SearchReason::kStill:
      return SearchMoving(prepared, search, estimate);
    case SearchReason::kMirrored:
      return SearchMirrored(prepared, search, estimate);
    case SearchReason::kScores:
      return SearchWithoutScores(prepared, search, estimate);
    case SearchReason::kNoise:
      return SearchAboutNoise(prepared, search, estimate);
  }
  return false;
}

NoiseRange NoiseRangeOf(const Problem& problem, bool searches_again) {
  constexpr double kLeastShare = 0.2;
  const Task task = problem.task;
  const double threshold = problem.inlier_threshold, unit = DefaultThreshold(task);
  if (IsOfTwoClouds(task)) return {threshold / unit, threshold / unit};
  if (!searches_again || !IsTwoView(task) || problem.points.cols() != 4) return {};
  if (problem.threshold_is_default) return {threshold / unit, threshold / unit};
  const double usual =
      unit * LengthInResiduals(task, problem.points.leftCols(2), problem.points.rightCols(2), ShareOfExtent);
  if (!(usual > 0.0)) return {threshold / unit, threshold / unit};
  return {std::min(threshold, usual) / unit, std::max(threshold, kLeastShare * usual) / unit};
}

}  // namespace diffsac
