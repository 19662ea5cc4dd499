#pragma once

#include <Eigen/Core>

namespace diffsac {

/// σ, one coordinate's, of the noise of residuals (N lengths of `dimension` values each, 1 to 3) of a model of `free`
/// parameters: that of the Gaussian whose residuals within a threshold have the mean square of these, `free` of their
/// values being the model's. The threshold goes from the one given down to 2.5 σ, so that what else is within it hardly
/// counts and σ may be far below it. The threshold given where the noise is about that or more; NaN where the residuals
/// within it are no more than determine the model.
double NoiseOfInliers(const Eigen::VectorXd& residuals, int dimension, int free, double threshold);

}  // namespace diffsac
