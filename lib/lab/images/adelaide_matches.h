#pragma once

#include <string>

#include "lab/files/correspondence_files.h"

namespace diffsac {

/// AdelaideRMF's labelled matches as MATLAB files, one a pair (the folders F and H of data/AdelaideRMF of Pham et al.,
/// "The random cluster model for robust geometric fitting", PAMI 2014): `data` 6 × N, x1 y1 1 x2 y2 1; `label` 1 × N, 0
/// an outlier, k ≥ 1 of structure k; `img1`, `img2`. Pairs have labels and no other truth; they are named
/// `<name>A-<name>B`, by file. Throws Error with one line that names the file.
CorrespondenceSet ReadAdelaideMatches(const std::string& folder);

}  // namespace diffsac
