#pragma once

#include "lab/report/html_page.h"
#include "lab/report/problem_list.h"

namespace diffsac {

/// What a page may take for pictures, in bytes of the page.
struct PictureLimits {
  std::size_t pairs = 1000;              ///< Pairs with a picture.
  std::size_t match_bytes = 15'000'000;  ///< Their matches.
  std::size_t image_bytes = 8'000'000;   ///< Photographs, which are made smaller where there are many.
};

/// Adds the matches of two-view problems to a page, each pair with the inliers of every method that kept them
/// (estimates, or kept fits where there are none), true inliers, and the photographs where they are known; report.js
/// draws them when they are asked for. The pairs are read again from the conditions' data, one after the other. Those
/// with the largest errors come first where there are too many; `notes` says what was left out.
PictureNumbers AddPairPictures(const ExperimentResults& results, const ProblemList& list, const PictureLimits& limits,
                               HtmlPage* page, std::vector<std::string>* notes);

}  // namespace diffsac
