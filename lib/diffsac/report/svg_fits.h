#pragma once

#include <string>

#include "diffsac/eval/results.h"

namespace diffsac {

/// A kept fit as SVG to stand in a page of HtmlPage: points in the colours of right, wrong and missed inliers, with the
/// estimated and the true line; planes as if seen from afar, the estimate a quadrangle around its inliers; absolute
/// poses as points of the image. Empty for two views (report/pair_pictures.h).
std::string SvgOfFit(const KeptFit& fit);

/// What stands below it: whose problem, error, counts of inliers.
std::string FitCaption(const KeptFit& fit, const ExperimentOptions& experiment);

}  // namespace diffsac
