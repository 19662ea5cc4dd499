#pragma once

#include <array>
#include <optional>
#include <string>

#include "diffsac/core/enum_names.h"
#include "diffsac/diffsac.h"
#include "diffsac/problem/tasks.h"
#include "lab/files/correspondence_files.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// Where a focal length comes from: a calibration; the matches of its pair; those of all pairs of its camera; EXIF
/// data; what cameras in general have.
enum class FocalSource { kGiven, kMatches, kPairs, kExif, kPrior };
template <>
inline constexpr auto kEnumNames<FocalSource> = NamesOf<FocalSource>({{FocalSource::kGiven, "given"},
                                                                      {FocalSource::kMatches, "matches"},
                                                                      {FocalSource::kPairs, "pairs"},
                                                                      {FocalSource::kExif, "exif"},
                                                                      {FocalSource::kPrior, "prior"}});

/// What is estimated of every pair, and the options of diffsac.h that programs offer. Absent ones are the library's.
struct PairOptions {
  Task task = Task::kEssential;  ///< Of two views, or absolute_pose.
  std::optional<double> threshold_px = {};
  std::optional<int> max_iterations = {}, min_iterations = {};
  std::optional<double> confidence = {};
  Guidance guidance = Guidance::kNetwork;
  std::string models_folder = {};
  std::uint64_t seed = 0;  ///< Of every pair, so that two photographs alone give the same as in their folder.
  int threads = 0;         ///< Of all pairs together; 0: all cores. What comes out does not depend on it.
};

/// What the task's function of diffsac.h says of a pair.
struct PairEstimate : UnknownFocalEstimate {
  /// E of the cameras that were given or found, F or H in pixels; of an absolute pose `pose` alone is set.
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Task task = Task::kEssential;
  Guidance guidance = Guidance::kNone;  ///< That was used: none for scores and unknown focal lengths.
  std::uint64_t seed = 0;
  /// Where the focal length of either image comes from.
  std::array<FocalSource, 2> focal_from = {FocalSource::kPrior, FocalSource::kPrior};

  bool MayBeChance() const { return verdict == Verdict::kUnsupported; }
  /// Whether R and t depend on a length that cameras in general have.
  bool IsGuess(int image) const { return FindsFocals(task) && focal && focal_from[image] == FocalSource::kPrior; }
  /// Whether it may be used: a model that is more than chance, by focal lengths that something says and that the
  /// matches do not contradict.
  bool IsSure() const { return ok() && !MayBeChance() && !IsGuess(0) && !IsGuess(1) && !diagnostics.focal_conflict; }
};

/// Two images, their matches and what was estimated of them.
struct ImagePair {
  Example example;       ///< Its id is "NAME1-NAME2". What `problem` has is given to the estimate, its task included.
  MatchIndices matches;  ///< Keypoints of image 1 and 2 behind each of the points; none where they are not known.
  double ms_keypoints = 0.0, ms_matching = 0.0;
  std::array<FocalSource, 2> hints_from = {FocalSource::kExif, FocalSource::kExif};  ///< The problem's camera priors.
  std::array<int, 2> images = {-1, -1};                                              ///< Of many, their places.
  std::array<int, 2> camera = {-1, -1};  ///< Of many: which camera took either, from 0; -1: its calibration is given.
  bool done = false;                     ///< Whether it was estimated.
  PairEstimate estimate = {};
};

/// Estimates a pair by the functions of diffsac.h. Throws Error as they do.
void EstimatePair(const PairOptions& options, ImagePair* pair);

}  // namespace diffsac
