#pragma once

#include <memory>
#include <string>

#include "diffsac/core/enum_names.h"
#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/diffsac_options.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

/// Named sets of options, which a table's row names by the key `preset` and changes key by key, and which C++ changes
/// field by field.
///   kDefault      "default": the plain method, as its paper or its name says; with a network, as its training says
///   kRecommended  "recommended": what to use for one model
///   kSeveral      "several": for several models at once, without being told how many; vanishing points by the network
///                 that chooses them where K is known
///   kPaper        "paper": DiffSAC as its paper describes it
enum class Preset { kDefault, kRecommended, kSeveral, kPaper };
template <>
inline constexpr auto kEnumNames<Preset> = NamesOf<Preset>({{Preset::kDefault, "default"},
                                                            {Preset::kRecommended, "recommended"},
                                                            {Preset::kSeveral, "several"},
                                                            {Preset::kPaper, "paper"}});

/// The recommended search without a network. Two views: PROSAC's samples (uniform ones without matching ratios), up to
/// 1000 until confident, scored by MSAC over noise scales between `least_scale` and `greatest_scale` pixels, for F and
/// E each match weighed by its ratio, F and H by how plausible a camera they make, the ten best hypotheses refined
/// before one is chosen; ε only caps the mask. Lines and planes: up to 420 uniform samples until confident, refits of
/// the mixture of inliers and outliers. Absolute poses: PROSAC until confident with local optimisation.
/// docs/two_view.md and docs/experiments.md have what each part is worth.
ClassicalOptions RecommendedClassical(Task task);

/// Learned PROSAC, the recommended search of two views with a network of models/: up to 500 samples drawn by the
/// geometric mean of the inlier head's probabilities and the ratios', then up to 500 of PROSAC's in that order, until
/// confident; scored and refined as RecommendedClassical. No reverse process runs.
DiffsacOptions LearnedProsac(Task task);

/// Several models: 1000 hypotheses of neighbouring points (NAPSAC), from which models are chosen one after the other
/// while chance would not give them. Vanishing points: VanishingPoints with the network for a known K.
ClassicalOptions SeveralInstances(Task task);

/// Vanishing points of 1500 samples drawn by the segments' lengths, chosen one after the other by a network that
/// learned from people's labels, while it is surer than .35 (docs/vanishing_points.md). chooser: its file (ChooserFile
/// below a folder of models). Empty: without a network, of 1000 samples the points of most length, while chance would
/// not give them.
ClassicalOptions VanishingPoints(const std::string& chooser);

/// The paper's estimator: the top-γ points of each of κ = 20 denoised confidence vectors, inlier count, one refit.
DiffsacOptions PaperDiffsac();

/// The paper's minimal samples, the top-γ points of each of κ = 20 denoised confidence vectors, by a network of
/// models/; scored and refined as RecommendedClassical, among all κ.
DiffsacOptions DiffusionGuided(Task task);

/// The file, below a folder of models, of the network that `task` is estimated with ("essential/model.safetensors").
/// rated: whether the matches have ratios; E and F have another network for those that have none.
std::string ModelFile(Task task, bool rated);

/// The file, below a folder of models, of the network that chooses vanishing points. calibrated: whether K is known.
std::string ChooserFile(bool calibrated);

}  // namespace diffsac
