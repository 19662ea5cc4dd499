#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "diffsac/diffsac.h"
#include "lab/files/segment_files.h"

namespace diffsac {

/// A grey image, at most 1600 pixels wide or high, with its segments in the colour of their vanishing point (grey: of
/// none), the horizon, the vanishing points that are in the picture, and a legend below. labels: of each vanishing
/// point, for the legend; colours: "#RRGGBB", as many as they.
cv::Mat DrawVanishingPoints(const cv::Mat& gray, const PointMatrix& segments, const VanishingPointsEstimate& estimate,
                            const std::vector<std::string>& labels, const std::vector<std::string>& colours);

}  // namespace diffsac
