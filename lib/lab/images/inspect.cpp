#include "lab/images/inspect.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "diffsac/problem/deduplicated_points.h"
#include "lab/config/progress.h"
#include "lab/files/correspondence_files.h"
#include "lab/ground_truth/pair_truth.h"

namespace diffsac {
namespace {

constexpr double kOutsideShare = 0.1;
// Of 1 − |cos| between two matrices as vectors of nine.
constexpr double kDisagreement = 1e-4;
constexpr std::size_t kMaxProblemsShown = 20;

Spread SpreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
  };
  return {at(0.0), at(0.1), at(0.5), at(0.9), at(1.0)};
}

double Mean(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

bool Inside(const PointMatrix& points, int column, const ImageSize& size) {
  if (size.width == 0) return true;
  const double x = kOutsideShare * size.width, y = kOutsideShare * size.height;
  return ((points.col(column).array() > -x) && (points.col(column).array() < size.width + x) &&
          (points.col(column + 1).array() > -y) && (points.col(column + 1).array() < size.height + y))
      .all();
}

bool Agree(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return 1.0 - std::abs((a.array() * b.array()).sum()) / (a.norm() * b.norm()) < kDisagreement;
}

// Matrices in pixels have entries of very different size, so F is compared as the E that it stands for.
bool TruthAgrees(const Example& pair) {
  const GroundTruth& truth = pair.truth;
  if (truth.motion && truth.essential && !Agree(EssentialFromMotion(*truth.motion), *truth.essential)) return false;
  if (!truth.essential || !truth.fundamental || !pair.problem.cameras) return true;
  return Agree(pair.problem.cameras->K2.transpose() * *truth.fundamental * pair.problem.cameras->K1, *truth.essential);
}

std::string ContentsOf(const Example& pair) {
  std::string text;
  const auto add = [&](bool has, const char* name) {
    if (has) text += (text.empty() ? "" : " ") + std::string(name);
  };
  add(pair.problem.snn_ratio.size() > 0, pair.problem.scored ? "score" : "ratio");
  add(pair.problem.scale_rotation_changes.size() > 0, "similarities");
  add(pair.problem.size1.width > 0, "sizes");
  add(pair.problem.cameras.has_value(), "K");
  add(pair.truth.motion.has_value(), "pose");
  add(pair.truth.essential.has_value(), "E");
  add(pair.truth.fundamental.has_value(), "F");
  add(pair.truth.homography.has_value(), "H");
  add(!pair.truth.assignment.empty(), "labels");
  return text;
}

// Collects what the pairs of a scene have in common.
class Inspector {
 public:
  explicit Inspector(double threshold_px) : threshold_px_(threshold_px) {}

  void Add(const Example& pair) {
    const Problem& problem = pair.problem;
    summary_.pairs += 1;
    if (summary_.contents.empty()) summary_.contents = ContentsOf(pair);
    counts_.push_back(static_cast<double>(problem.points.rows()));
    summary_.repeats += DeduplicatedPoints(problem).repeated();
    AddShares(pair);
    Check(pair, problem.points.allFinite(), "a coordinate is not finite");
    Check(pair, Inside(problem.points, 0, problem.size1) && Inside(problem.points, 2, problem.size2),
          "a point lies outside its image");
    Check(pair, (problem.snn_ratio.array() >= 0.0).all() && (problem.snn_ratio.array() <= 1.0).all(),
          problem.scored ? "a score is not in [0, 1]" : "a ratio is not in [0, 1]");
    Check(pair, TruthAgrees(pair), "E, F, the poses and K disagree");
  }

  SceneSummary Finish(const std::string& scene) {
    summary_.scene = scene;
    summary_.matches = SpreadOf(counts_);
    summary_.has_truth = !shares_.empty();
    summary_.mean_share = Mean(shares_);
    summary_.share = SpreadOf(shares_);
    if (!labelled_.empty()) summary_.labelled_share = Mean(labelled_);
    return summary_;
  }

 private:
  void AddShares(const Example& pair) {
    const Eigen::VectorXd distances = TruthDistances(pair.problem, pair.truth);
    const double count = std::max(1.0, static_cast<double>(pair.problem.points.rows()));
    if (pair.truth.homography || pair.truth.fundamental) {
      const auto near = static_cast<double>((distances.array() <= threshold_px_).count());
      shares_.push_back(near / count);
      Check(pair, near > 0.0, "no match is near the truth");
    }
    const auto& labels = pair.truth.assignment;
    if (!labels.empty())
      labelled_.push_back(
          static_cast<double>(std::count_if(labels.begin(), labels.end(), [](int l) { return l > 0; })) / count);
  }

  void Check(const Example& pair, bool good, const char* problem) {
    if (!good) summary_.problems.push_back(pair.id + ": " + problem);
  }

  double threshold_px_;
  SceneSummary summary_;
  std::vector<double> counts_, shares_, labelled_;
};

template <class... Values>
std::string Format(const char* format, Values... values) {
  char text[512];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

std::string Percent(double share) { return Format("%.1f", 100.0 * share); }

}  // namespace

SceneSummary InspectScene(const std::string& folder, double threshold_px, const std::atomic<bool>& stop) {
  const CorrespondenceScene scene(folder);
  Inspector inspector(threshold_px);
  Progress progress(scene.scene(), scene.size());
  for (std::int64_t i = 0; i < scene.size() && !stop; ++i) {
    inspector.Add(scene.Read(i));
    progress.Advance();
  }
  return inspector.Finish(scene.scene());
}

std::string SummaryText(const std::vector<SceneSummary>& summaries, double threshold_px) {
  std::string text = Format(
      "share: matches within %g px of the true model, %% (Sampson distance; transfer error for H)\n", threshold_px);
  text += Format("%-24s %6s  %-20s %6s  %-24s %8s %7s  %-8s %s\n", "scene", "pairs", "matches min/med/max", "mean",
                 "share p10/median/p90", "labelled", "repeats", "checks", "contents");
  for (const SceneSummary& s : summaries) {
    const std::string matches = Format("%.0f/%.0f/%.0f", s.matches.min, s.matches.median, s.matches.max);
    const std::string share =
        s.has_truth ? Percent(s.share.p10) + "/" + Percent(s.share.median) + "/" + Percent(s.share.p90) : "-";
    const std::string checks = s.problems.empty() ? "ok" : std::to_string(s.problems.size()) + " bad";
    text += Format("%-24s %6d  %-20s %6s  %-24s %8s %7lld  %-8s %s\n", s.scene.c_str(), s.pairs, matches.c_str(),
                   s.has_truth ? Percent(s.mean_share).c_str() : "-", share.c_str(),
                   s.labelled_share >= 0.0 ? Percent(s.labelled_share).c_str() : "-", static_cast<long long>(s.repeats),
                   checks.c_str(), s.contents.c_str());
  }
  for (const SceneSummary& s : summaries) {
    for (std::size_t i = 0; i < std::min(s.problems.size(), kMaxProblemsShown); ++i)
      text += s.scene + ": " + s.problems[i] + "\n";
    if (s.problems.size() > kMaxProblemsShown)
      text += s.scene + ": and " + std::to_string(s.problems.size() - kMaxProblemsShown) + " more\n";
  }
  return text;
}

}  // namespace diffsac
