#pragma once

#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/enum_names.h"
#include "diffsac/core/random.h"
#include "diffsac/problem/normalized_problem.h"

namespace diffsac {

/// χ: what the network sees of one problem.
struct FeatureSet {
  /// N × width, row-major.
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values;
  /// Models solved and scored to make the features; they count in every budget.
  int hypotheses = 0;
  /// The kept hypotheses, best first (up to M, from distinct minimal sets; empty for `coordinates`), and their MSAC
  /// scores in [0, N] at 1.5 ε.
  std::vector<ModelParameters> models;
  std::vector<double> scores;
};

/// Columns that may describe a point (PointFeatures).
/// A checkpoint names its kinds, so that a new one may stand anywhere; networks take the columns of preference for the
/// last.
enum class PointFeature { kCoordinates, kRatio, kNeighborhood, kDescriptors, kSimilarity, kResidual };
template <>
inline constexpr auto kEnumNames<PointFeature> = NamesOf<PointFeature>({{PointFeature::kCoordinates, "coordinates"},
                                                                        {PointFeature::kRatio, "coordinates_ratio"},
                                                                        {PointFeature::kNeighborhood, "neighborhood"},
                                                                        {PointFeature::kDescriptors,
                                                                         "coordinates_descriptors"},
                                                                        {PointFeature::kSimilarity, "similarity"},
                                                                        {PointFeature::kResidual, "residual"}});

/// Where the minimal sets of residual features come from.
///   kUniform  "uniform"
///   kNapsac   "napsac": a point and its neighbours (ransac/samplers/napsac_sampler.h): where structures lie apart,
///             far more of these sets are of one
enum class ResidualDraws { kUniform, kNapsac };
template <>
inline constexpr auto kEnumNames<ResidualDraws> = NamesOf<ResidualDraws>({{ResidualDraws::kUniform, "uniform"},
                                                                          {ResidualDraws::kNapsac, "napsac"}});

/// Which hypotheses are kept as residual features.
///   kBest    "best": of highest score
///   kSpread  "spread": one after another, each the one that adds most to what the earlier ones explain, so that no
///            structure takes all columns
enum class ResidualChoice { kBest, kSpread };
template <>
inline constexpr auto kEnumNames<ResidualChoice> = NamesOf<ResidualChoice>({{ResidualChoice::kBest, "best"},
                                                                            {ResidualChoice::kSpread, "spread"}});

struct PointFeaturesOptions {
  /// Their columns stand side by side in the order of the enumeration, those of the coordinates once.
  std::vector<PointFeature> kinds = {PointFeature::kResidual};
  /// Two views: whether coordinates are those of the calibrated camera where it is known; else by the images' sizes.
  bool use_calibration = true;
  /// coordinates_descriptors: values of one descriptor; 128 for SIFT, which makes the paper's 260 columns.
  int descriptor_size = 128;
  /// coordinates_descriptors: whether a problem without any is an error; else its columns are 0, for generated problems
  /// in a mixture.
  bool descriptors_required = true;
  /// Preference: how many minimal sets are drawn, and how many of the best-scored are kept as columns (M).
  int residual_draws = 100;
  int residual_kept = 16;
  ResidualDraws residual_from = ResidualDraws::kUniform;
  ResidualChoice residual_choice = ResidualChoice::kBest;
  bool Has(PointFeature kind) const;
};

/// Computes point features. Stateless and thread-safe.
///
/// `coordinates`, D columns: the description's FeatureCoordinates (problem/task_description.h). Lines and planes:
/// centred on the median (CentredCoordinates); two views: so that neither image size nor focal length matters
/// (MatchCoordinates; see use_calibration).
///
/// `coordinates_ratio`, two views, 5 columns: these and (matching ratio − 0.7) / 0.25, mean and spread on real pairs; 0
/// where the data has none.
///
/// `neighborhood`, two views, 3 columns: how far the good matches around a match move as it does
/// (problem/neighborhood_features.h). They need all matches: training computes them before it draws a subset.
///
/// `coordinates_descriptors`, two views, 4 + 2 · descriptor_size columns: these and the descriptors of image 1, then of
/// image 2, each scaled to unit root mean square. Compute throws Error when the problem has no such descriptors (see
/// descriptors_required).
///
/// `similarity`, two views, 6 columns: whether the difference of the keypoints' sizes and angles
/// (Problem::scale_rotation_changes) agrees with the matches around and with all good ones
/// (problem/similarity_features.h); 0 where the data has none. Like those of neighborhoods they need all matches.
///
/// `residual`, 3·M columns, three for each kept hypothesis j, best first (after Toldo and Fusiello, "Robust multiple
/// structures estimation with J-linkage", ECCV 2008, and Magri and Fusiello, "T-linkage", CVPR 2014), r its residual:
///   3j      exp(−r² / 2(ε/2)²), soft agreement
///   3j + 1  log1p(r/ε) / 4, compressed distance
///   3j + 2  the hypothesis's MSAC score / N, the same for all points
/// Two views: r is the Sampson distance (F; E in normalised coordinates with ε over the mean focal length) or the
/// symmetric transfer error (H), at most 1e6 ε; of a set's solutions the best counts, all are counted as hypotheses.
/// With fewer than M distinct hypotheses the missing columns repeat the best one; with none they are 0. With
/// `residual_choice: spread` the order is that of the choice, and the first is still the best.
class PointFeatures {
 public:
  /// Throws Error for kinds that the task has not.
  PointFeatures(PointFeaturesOptions options, Task task);
  /// D, the number of columns.
  int width() const;
  /// First column of image 1's descriptor, image 2's stands behind it; -1 without descriptors.
  int first_descriptor() const;
  int descriptor_size() const { return options_.descriptor_size; }
  /// First column of the neighborhood features, -1 without any.
  int first_neighborhood() const;
  /// First column of the residual features, behind which 3·M stand; -1 without any.
  int first_residual() const;
  /// The problem must have at least γ finite points (callers check; see CheckSpace). rng decides the drawn hypotheses.
  FeatureSet Compute(const NormalizedProblem& space, Rng rng) const;
  FeatureSet Compute(const Problem& problem, Rng rng) const { return Compute(NormalizedProblem(problem), rng); }
  /// The same from given minimal sets (γ ascending indices each) instead of drawn ones. The features of permuted points
  /// with correspondingly renamed sets are the permuted features.
  FeatureSet ComputeFromSets(const NormalizedProblem& space, const std::vector<int>& sets) const;

 private:
  PointFeaturesOptions options_;
  Task task_;
};

}  // namespace diffsac
