#pragma once

#include <string>

#include "lab/report/report.h"

namespace diffsac {

/// mAA against the conditions' values, one curve a method, the oracle as a dashed ceiling: `curve.png`. Nothing to draw
/// (fewer than two conditions with a value, no ground truth) is no picture and no warning; so for all of these.
bool PlotCurve(const Report& report, const std::string& folder);

/// mAA of the rows in `figures.bars` with its 95 % interval, a cluster of bars a condition; where poses are known two,
/// for rotation and translation on their own: `bars.png`.
bool PlotBars(const Report& report, const std::string& folder);

/// mAA against the number of hypotheses, one panel a condition, one curve a series: `budget.png`.
bool PlotBudget(const Report& report, const std::string& folder);
/// The same against the median time: `time.png`.
bool PlotTime(const Report& report, const std::string& folder);

/// The kept fits, a column a condition: points (inliers of the estimate coloured), the estimate and, where known, the
/// true model: `fits.png`. Planes are shown in perspective with the estimate as a mesh. Of several structures each that
/// is found has a colour, for its points and its line or mesh.
bool PlotFits(const ExperimentResults& results, const std::string& folder);

/// Two views: a picture for each kept fit, `matches_<condition>_<pair>_<method>.png`. Both images side by side (found
/// through `figures.images`, else empty canvases of their sizes); the estimate's inliers in green, those that are none
/// under the truth in red, true inliers that it misses in faint blue, other matches as grey points; errors and counts
/// in the title. Of several structures a colour each: those found in image 1 and, beside them, the true ones with the
/// colours of their partners (AlignedTruth); without a truth those found in both images. False for other tasks and
/// where no fits were kept; throws Error when a picture cannot be written.
bool PlotMatches(const ExperimentResults& results, const std::string& folder);

/// Points coloured by one copy's confidence, one panel a step (up to eight), the γ most confident points circled:
/// `path` (ending in .png). Matches of two views are shown where they are in image 1.
bool PlotConfidenceTrace(const Problem& problem, const ConfidenceTrace& trace, const std::string& path);

/// What probabilities say against how often it is so (ExperimentResults::reliability), a panel a condition, at
/// most four, evenly spread: `reliability.png`.
bool PlotReliability(const ExperimentResults& results, const std::string& folder);

/// mAA within the bins of a division, a panel for each of up to four conditions (StrataPanels), a curve a row:
/// `strata_inlier_share.png` and so on.
bool PlotStrata(const Report& report, const StrataReport& strata, const std::string& folder);
std::string StrataPicture(Quantity quantity);

/// What each level of the experiment's factors adds to the accuracy of the factor's first level, and by how much it
/// multiplies its milliseconds: a dot with its interval a level, grouped by factor, a colour for each of up to four
/// conditions: `effects.png`.
bool PlotEffects(const Report& report, const std::string& folder);

/// Pictures of examples, which need more than records: fits, matches, reverse steps.
void DrawExamples(const ExperimentResults& results, const std::string& folder);

/// Every picture that the experiment has something for.
void DrawFigures(const Report& report, const std::string& folder);

}  // namespace diffsac
