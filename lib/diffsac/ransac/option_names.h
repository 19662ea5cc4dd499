#pragma once

// The names of the loop's options in configurations, messages and tables.

#include "diffsac/core/enum_names.h"
#include "diffsac/ransac/consensus_options.h"

namespace diffsac {

template <>
inline constexpr auto kEnumNames<ScoreKind> = NamesOf<ScoreKind>({{ScoreKind::kInlierCount, "inlier_count"},
                                                                  {ScoreKind::kMsac, "msac"},
                                                                  {ScoreKind::kMlesac, "mlesac"},
                                                                  {ScoreKind::kMagsac, "magsac_pp"},
                                                                  {ScoreKind::kSigmaMarginalisedMsac,
                                                                   "sigma_marginalised_msac"}});

template <>
inline constexpr auto kEnumNames<LocalOptimization> =
    NamesOf<LocalOptimization>({{LocalOptimization::kNone, "none"},
                                {LocalOptimization::kInnerSamples, "lo_ransac"},
                                {LocalOptimization::kReweighted, "irls"},
                                {LocalOptimization::kGraphCut, "gc_ransac"},
                                {LocalOptimization::kRefinement, "lm"}});

template <>
inline constexpr auto kEnumNames<Refit> = NamesOf<Refit>({{Refit::kNone, "none"},
                                                          {Refit::kInliers, "inliers"},
                                                          {Refit::kIterated, "iterated"},
                                                          {Refit::kMixture, "em"},
                                                          {Refit::kReweighted, "irls"}});

template <>
inline constexpr auto kEnumNames<FinalRefinement> = NamesOf<FinalRefinement>({{FinalRefinement::kNone, "none"},
                                                                              {FinalRefinement::kRefinement, "lm"},
                                                                              {FinalRefinement::kMarginalised,
                                                                               "lm_marginalised"}});

template <>
inline constexpr auto kEnumNames<ThresholdKind> = NamesOf<ThresholdKind>({{ThresholdKind::kFixed, "fixed"},
                                                                          {ThresholdKind::kAdaptive, "adaptive"}});

template <>
inline constexpr auto kEnumNames<StopReason> = NamesOf<StopReason>({{StopReason::kNotRun, "not_run"},
                                                                    {StopReason::kBudget, "budget"},
                                                                    {StopReason::kConfidence, "confidence"},
                                                                    {StopReason::kExhausted, "exhausted"}});

template <>
inline constexpr auto kEnumNames<Stopping> = NamesOf<Stopping>({{Stopping::kBudget, "budget"},
                                                                {Stopping::kConfidence, "confidence"}});

}  // namespace diffsac
