#include "lab/train/two_view_transform.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "diffsac/estimate/point_prior.h"
#include "lab/data/pair_filter.h"
#include "lab/data/repeated_structures.h"

namespace diffsac {
namespace {

// Correct matches that thinning leaves at least.
constexpr int kFewestCorrect = 12;
// Standard deviations of the turns of augmentation, degrees.
constexpr double kCommonTurnDeg = 10.0, kRelativeTurnDeg = 5.0;

double Radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

std::vector<int> AllRows(Eigen::Index count) {
  std::vector<int> rows(static_cast<std::size_t>(count));
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

// Matches of at most the drawn ratio; all where there are too few of them.
std::vector<int> PointsWithin(const Problem& problem, double max_ratio, int fewest) {
  const int count = static_cast<int>(problem.points.rows());
  std::vector<int> kept;
  if (problem.snn_ratio.size() == count)
    for (int i = 0; i < count; ++i)
      if (problem.snn_ratio[i] <= max_ratio) kept.push_back(i);
  return static_cast<int>(kept.size()) < fewest ? AllRows(count) : kept;
}

// The sets whose points are all `present`, as places among `rows`.
MinimalSets SetsWithin(const MinimalSets& sets, const std::vector<char>& present, const std::vector<int>& rows) {
  MinimalSets within;
  for (const auto& set : sets) {
    if (!std::all_of(set.begin(), set.end(), [&](int i) { return present[i] != 0; })) continue;
    within.push_back(set);
    for (int& i : within.back()) i = PlaceOf(i, rows);
  }
  return within;
}

// The points of the sets and random others of `among` (ascending), `count` in all, ascending.
std::vector<int> RandomSubset(const std::vector<int>& among, const MinimalSets& sets, int count, Rng rng) {
  std::vector<int> must;
  for (const auto& set : sets) must.insert(must.end(), set.begin(), set.end());
  std::sort(must.begin(), must.end());
  must.erase(std::unique(must.begin(), must.end()), must.end());
  std::vector<int> others;
  std::set_difference(among.begin(), among.end(), must.begin(), must.end(), std::back_inserter(others));
  std::vector<int> subset = must;
  for (std::size_t i = 0; static_cast<int>(subset.size()) < count && i < others.size(); ++i) {
    std::swap(others[i], others[i + rng.Below(others.size() - i)]);
    subset.push_back(others[i]);
  }
  std::sort(subset.begin(), subset.end());
  return subset;
}

// Rows without so many of the correct matches that `share` of what is left is correct. Those of one of the sets stay,
// so that there is a label.
std::vector<int> Thinned(const std::vector<int>& rows, const std::vector<std::uint8_t>& inliers,
                         const MinimalSets& sets, double share, Rng rng) {
  std::vector<int> correct;
  for (const int i : rows)
    if (inliers[i]) correct.push_back(i);
  const double wrong = static_cast<double>(rows.size() - correct.size());
  const auto left = std::max(kFewestCorrect, static_cast<int>(std::lround(share / (1.0 - share) * wrong)));
  const int drop = static_cast<int>(correct.size()) - left;
  if (drop <= 0) return rows;
  std::vector<char> stays(inliers.size(), 1);
  const std::vector<int> none;
  const std::vector<int>& kept = sets.empty() ? none : sets[rng.Below(sets.size())];
  int dropped = 0;
  for (const int k : rng.Permutation(static_cast<int>(correct.size()))) {
    if (dropped == drop) break;
    if (std::find(kept.begin(), kept.end(), correct[k]) != kept.end()) continue;
    stays[correct[k]] = 0;
    ++dropped;
  }
  std::vector<int> thinned;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(thinned), [&](int i) { return stays[i] != 0; });
  return thinned;
}

// Where a camera looks, in its image, and what makes its rays' first two coordinates of steps from there.
struct ImageAxes {
  Eigen::RowVector2d centre = Eigen::RowVector2d::Zero();
  Eigen::Matrix2d pixels = Eigen::Matrix2d::Identity();  // of one unit of the coordinates
};

ImageAxes AxesOf(const Problem& problem, int image) {
  if (!problem.cameras) {
    const ImageSize& size = image == 0 ? problem.size1 : problem.size2;
    return {0.5 * Eigen::RowVector2d(size.width, size.height)};
  }
  const Eigen::Matrix3d& K = image == 0 ? problem.cameras->K1 : problem.cameras->K2;
  return {K.topRightCorner<2, 1>().transpose(), K.topLeftCorner<2, 2>()};
}

// Turns a camera about its axis, after it was mirrored.
void Turn(bool mirrored, double angle, int image, Problem* problem) {
  const ImageAxes axes = AxesOf(*problem, image);
  const Eigen::Matrix2d turn =
      Eigen::Rotation2Dd(angle).toRotationMatrix() * Eigen::Vector2d(mirrored ? -1.0 : 1.0, 1.0).asDiagonal();
  const Eigen::Matrix2d map = axes.pixels * turn * axes.pixels.inverse();
  auto points = problem->points.middleCols(2 * image, 2);
  points = (((points.rowwise() - axes.centre) * map.transpose()).rowwise() + axes.centre).eval();
}

template <class Columns>
void ExchangeHalves(Columns& columns) {
  const Eigen::Index half = columns.cols() / 2;
  const auto kept = columns.leftCols(half).eval();
  columns.leftCols(half) = columns.rightCols(half).eval();
  columns.rightCols(half) = kept;
}

void ExchangeImages(Problem* problem) {
  ExchangeHalves(problem->points);
  ExchangeHalves(problem->descriptors);
  problem->scale_rotation_changes *= -1.0;
  if (problem->cameras) std::swap(problem->cameras->K1, problem->cameras->K2);
  std::swap(problem->size1, problem->size2);
  std::swap(problem->camera_prior1, problem->camera_prior2);
}

}  // namespace

void TwoViewTrainingOptions::Bind(OptionsBinder& b) {
  b.Field("max_points", max_points, AtLeast(0))
      .Help("at most so many matches: those of the drawn labels and random others; 0 keeps all");
  b.Field("max_ratios", max_ratios, Within(0.01, 1.0))
      .Help("one is drawn for each item, and only matches of at most this ratio are kept; empty: all matches");
  b.Field("augment", augment)
      .Help("both images mirrored and turned together, one turned a little more, the images exchanged");
  b.Field("repeats", repeats, Within(0.0, 1.0))
      .Help("share of the items in which groups of correct matches become wrong ones (lab/data/repeated_structures.h)");
  b.Field("thinned", thinned, Within(0.0, 1.0))
      .Help("share of the items in which correct matches are left out until few of the matches are correct");
  b.Field("thinned_to", thinned_to, Within(0.001, 0.999))
      .OnlyIf(thinned > 0.0, "thinned > 0")
      .Help("so few: the share that is left is drawn between these, its logarithm uniform");
  b.Field("likeliest", likeliest, AtLeast(0))
      .OnlyIf(max_points > 0, "max_points > 0")
      .Help("the matches of max_points are among so many of highest prior, as with `max_encoded_points`; 0: among all");
  b.Require(thinned_to.size() == 2 && thinned_to[0] <= thinned_to[1], "thinned_to", "two shares, the smaller first");
  b.Require(max_points == 0 || max_points >= 16, "max_points", "0 or at least 16");
}

int PlaceOf(int row, const std::vector<int>& rows) {
  return static_cast<int>(std::lower_bound(rows.begin(), rows.end(), row) - rows.begin());
}

LabelledExample Restricted(const TwoViewTrainingOptions& options, LabelledExample drawn,
                           const std::function<MinimalSets(const Example&)>& search, const Rng& rng) {
  Example& example = drawn.example;
  if (!IsTwoView(example.problem.task)) return drawn;
  std::vector<char> moved(static_cast<std::size_t>(example.problem.points.rows()), 0);
  if (options.repeats > 0.0 && rng.Fork("repeats").Uniform() < options.repeats)
    moved = MoveGroups(rng.Fork("moved_groups"), &example);
  std::vector<int> rows = AllRows(example.problem.points.rows());
  if (!options.max_ratios.empty()) {
    Rng choice = rng.Fork("max_ratio");
    rows = PointsWithin(example.problem, options.max_ratios[choice.Below(options.max_ratios.size())],
                        MinimalSetSize(example.problem.task) + 1);
  }
  if (options.thinned > 0.0 && rng.Fork("thinned").Uniform() < options.thinned) {
    Rng choice = rng.Fork("thinned_to");
    const double share = std::exp(choice.Uniform(std::log(options.thinned_to[0]), std::log(options.thinned_to[1])));
    rows = Thinned(rows, example.truth.inliers, *drawn.sets, share, choice);
  }
  std::vector<char> present(moved.size(), 0);
  for (const int i : rows) present[i] = !moved[i];
  if (rows.size() < moved.size()) example = WithRows(example, rows);
  if (drawn.sets->empty()) return drawn;
  MinimalSets usable = SetsWithin(*drawn.sets, present, rows);
  // Where none of the kept sets lies within, others are searched for among what is left.
  if (usable.empty()) usable = search(example);
  drawn.sets = std::make_shared<const MinimalSets>(std::move(usable));
  return drawn;
}

std::vector<int> ShownRows(const TwoViewTrainingOptions& options, const NormalizedProblem& space,
                           const PointFeatures& kinds, const FeatureSet& features, const MinimalSets& sets,
                           const Rng& rng) {
  const Problem& problem = space.problem();
  const std::vector<int> all = AllRows(problem.points.rows());
  if (!IsTwoView(problem.task) || options.max_points == 0 || static_cast<int>(all.size()) <= options.max_points)
    return all;
  if (options.likeliest == 0) return RandomSubset(all, sets, options.max_points, rng);
  return RandomSubset(LikeliestPoints(PointPrior(space, features, kinds), options.likeliest), sets, options.max_points,
                      rng);
}

Problem Augmented(Problem problem, Rng rng) {
  if (rng.Uniform() < 0.5) ExchangeImages(&problem);
  const bool mirrored = rng.Uniform() < 0.5;
  const double common = 90.0 * static_cast<double>(rng.Below(4)) + kCommonTurnDeg * rng.Normal();
  const double relative = kRelativeTurnDeg * rng.Normal();
  Turn(mirrored, Radians(common), 0, &problem);
  Turn(mirrored, Radians(common + relative), 1, &problem);
  for (Eigen::Index i = 0; i < problem.scale_rotation_changes.rows(); ++i) {
    double& turn = problem.scale_rotation_changes(i, 1);
    turn = std::remainder((mirrored ? -turn : turn) + Radians(relative), 2.0 * std::numbers::pi);
  }
  return problem;
}

}  // namespace diffsac
