#pragma once

#include <concepts>
#include <cstdint>
#include <vector>

#include "diffsac/core/type_list.h"
#include "diffsac/problem/normalized_problem.h"

namespace diffsac {

/// The name of a geometry model in YAML and in messages, said beside the description that lists it.
template <class Model>
inline constexpr const char* kModelName = nullptr;

/// What everything above geometry asks of a task: a struct of static members, one a task, derived from
/// TaskDescriptionOf<Models...> and named in the list of problem/tasks.h. That is all that knows it: names, sizes and
/// dispatch follow from the list, features, methods and learners from the members. What needs the truth (labels,
/// errors) is in a table of the lab (lab/ground_truth/task_truth.h).
///
///   Model, Models         the task's own geometry model (geometry/model.h), whose kModelName names the task, and all
///                         by which its minimal sets can be solved (key `model`), the own first
///   kTwoView              the points are matches x1 y1 x2 y2 of two images, in pixels
///   Accepts(problem)      whether the problem has what the task needs beside its points: the calibration, say
///   FeatureCoordinates(space)
///                         what a network sees of the points: N × kDimension, about unit size, independent of the
///                         data's unit
///   ChanceShare(problem, threshold)
///                         how likely a point anywhere is within the threshold, in the data's unit, of a model
///                         (problem/chance_share.h)
///
/// Where it has them:
///   Pose(model, inliers, space)
///                         the motion of a finite model, if it has one (PoseOfEstimate)
///   PoseCovariance(model, pose, space, fit)
///                         the covariance of that motion (Estimate::pose_covariance); fit: how the model was refined
///   Parallax(model, inliers, space)
///                         whether the inliers determine it, of two views (ParallaxOfEstimate)
///   LeaveOutBehind(model, pose, space, threshold, inliers)
///                         takes inliers that lie behind a camera out of *inliers, and returns their share of all that
///                         fit but for that (Estimate::cheirality_failure_ratio); threshold: theirs, in the space's
///                         unit
///   ImagePoints(problem)  where the points are in the (first) image, N × 2 pixels, for pictures
///   PointWeights(problem) N values in [0, 1], how much each point says: weights in scores
///                         (consensus.inlier_prior_power), of draws (sampler `weighted`) and their order (`prosac`)
///   Normalize(problem, unit)
///                         the points in the coordinates in which the models are solved; sets *unit, how much of the
///                         data's unit is one unit there (NormalizedProblem). Absent: the points as they are.
template <class T>
concept TaskDescription = requires(const Problem& problem, const NormalizedProblem& space) {
  typename T::Model;
  typename T::Models;
  requires(kModelName<typename T::Model> != nullptr);
  { T::kTwoView } -> std::convertible_to<bool>;
  { T::Accepts(problem) } -> std::same_as<bool>;
  { T::FeatureCoordinates(space) } -> std::same_as<PointMatrix>;
  { T::ChanceShare(problem, 1.0) } -> std::same_as<double>;
};

/// The members that are alike for most tasks.
template <class Own, class... Others>
struct TaskDescriptionOf {
  using Model = Own;
  using Models = TypeList<Own, Others...>;
  static constexpr bool kTwoView = false;
  static bool Accepts(const Problem&) { return true; }
};

}  // namespace diffsac
