#pragma once

#include <string>

#include "lab/images/estimate_pair.h"
#include "lab/images/json_values.h"

namespace diffsac {

/// What an estimate says of two images, for a terminal: matrix, pose where it has one, inliers, noise, milliseconds by
/// stage. Without an estimate, why.
std::string PairText(const ImagePair& pair);

/// A line each: x1 y1 x2 y2 ratio, with all digits; ratio 1 where it is unknown. Where similarities are known
/// (Problem::scale_rotation_changes) theirs follow.
std::string MatchesText(const Problem& problem);

/// The same as one JSON object, with the images' files, the guidance as `method`, the seed, K where it is known and the
/// rows of the inliers.
Json PairJson(const ImagePair& pair, const std::string& image1, const std::string& image2);

/// x1 y1 x2 y2 of each match, to a ten thousandth of a pixel, and its ratio or score where that is known.
Json CorrespondencesJson(const Problem& problem);

}  // namespace diffsac
