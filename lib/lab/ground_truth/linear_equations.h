#pragma once

#include "diffsac/problem/normalized_problem.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// A linear fit of one problem's points: the model is the unit vector v that minimises Σ w (row · v)².
struct LinearEquations {
  PointMatrix rows;
  int rows_per_point = 1;
  bool about_mean = false;  ///< Rows are taken about their weighted mean first.
  Eigen::VectorXd truth;    ///< The true v, of any length; empty without one.
};

/// The points about their weighted mean, by their spread: v is the normal.
LinearEquations HyperplaneEquations(const NormalizedProblem& space, const GroundTruth& truth);

/// Of matches in the solver's coordinates, each image's normalised to centroid 0 and root mean square distance √2: two
/// transfer equations a match (homography), or the epipolar one.
LinearEquations HomographyEquations(const NormalizedProblem& space, const GroundTruth& truth);
LinearEquations EpipolarEquations(const NormalizedProblem& space, const GroundTruth& truth);

}  // namespace diffsac
