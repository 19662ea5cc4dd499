#pragma once

#include <vector>

#include "diffsac/core/random.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// For training: groups of correct matches become wrong ones that move together, as where one window of a front is
/// taken for the next. One to three groups; a group is the neighbourhood in image 1 of a random inlier, 5 to 30 % of
/// the inliers, of which a share between a half and all is moved in image 2 by one vector of .5 to 3 times the group's
/// extent there, scaled by up to 5 %. Every second moved match takes the ratio of a random outlier. What is moved is no
/// inlier any more unless it is still within ε of the true model; what would leave image 2 stays. Returns one flag for
/// each match, whether it was moved. Nothing is moved without known inliers or a true model.
std::vector<char> MoveGroups(Rng rng, Example* example);

}  // namespace diffsac
