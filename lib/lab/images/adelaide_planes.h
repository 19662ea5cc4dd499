#pragma once

#include <optional>
#include <string>

#include "diffsac/geometry/points.h"
#include "diffsac/geometry/two_view.h"
#include "lab/files/correspondence_files.h"

namespace diffsac {

/// AdelaideRMF's tentative matches as problems of one homography: that of the plane of whose labelled matches most
/// tentative ones, within 3 px, are. `folder`: the scenes adelaidermf and adelaidermf_sift, which convert.py makes.
/// Left out are pairs whose truth is not sure: where another labelled plane has more than two thirds as many, so that
/// it is no mistake to find that one, and where the homographies of every other labelled match of the plane and of the
/// remaining ones differ by more than kLargestDisagreementPx on the mean over the pixels that both images show: a plane
/// that covers a corner of them says little of the rest. first: 0 or 1, the pairs at even or odd places among all, by
/// name. Throws Error.
CorrespondenceSet ReadAdelaidePlanes(const std::string& folder, int first);
inline constexpr double kLargestDisagreementPx = 4.0;

/// The homography of least squares on these labelled matches of a plane: the direct linear transformation, then
/// Sampson distances truncated at 3 px, since some labels are wrong. Nothing of fewer than 8 matches, or
/// where they determine none.
std::optional<Matrix3Parameters> FitLabelledPlane(const PointMatrix& matches);

}  // namespace diffsac
