#pragma once

#include "diffsac/problem/chance_share.h"
#include "diffsac/problem/two_view_task.h"

namespace diffsac {

/// The pose that E chooses with the inliers of matches in normalised coordinates, by cheirality; nothing with fewer
/// than 5 inliers, or where none is before both cameras. noise: as ChoosePose.
std::optional<RigidMotion> EpipolarPose(const Eigen::Matrix3d& essential, const PointMatrix& points,
                                        const std::vector<std::uint8_t>& inliers, double noise = 0.0);

/// Takes those of the inliers out that lie behind a camera of their pose, however well they fit E: by more than noise
/// of `tolerance` explains (PassesCheirality). Returns which share that was. Points are in normalised coordinates.
double LeaveOutBehind(const RigidMotion& pose, const PointMatrix& points, double tolerance,
                      std::vector<std::uint8_t>* inliers);

/// How likely a match of nothing is within the threshold, in pixels, of epipolar geometry.
inline double EpipolarChanceShare(const Problem& problem, double threshold) {
  return EpipolarBandShare(ImageExtent(problem.size2, problem.points.rightCols(2)), threshold);
}

/// What fundamental and essential matrices share. `Description` adds
///   EssentialOf(model, cameras)   E of a model, for its poses
template <class Description, class Own, class... Others>
struct EpipolarTask : TwoViewTask<Own, Others...> {
  static std::optional<RigidMotion> Pose(const ModelParameters& model, const std::vector<std::uint8_t>& inliers,
                                         const NormalizedProblem& space) {
    const Problem& problem = space.problem();
    if (!problem.cameras) return std::nullopt;
    const Eigen::Matrix3d essential = Description::EssentialOf(ModelMatrix(model), *problem.cameras);
    const double noise = problem.inlier_threshold / problem.cameras->MeanFocal();
    if (space.is_normalized()) return EpipolarPose(essential, space.points(), inliers, noise);
    return EpipolarPose(essential, NormalizedCoordinates(problem.points, problem.cameras->K1, problem.cameras->K2),
                        inliers, noise);
  }
  static double ChanceShare(const Problem& problem, double threshold) {
    return EpipolarChanceShare(problem, threshold);
  }
};

}  // namespace diffsac
