#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "diffsac/estimate/cameras.h"
#include "diffsac/estimate/guidance.h"

namespace diffsac {

struct ClassicalOptions;
struct DiffsacOptions;

/// What the options structs of diffsac.h have in common, which map themselves to it: all that an Estimator is made
/// from. An empty optional is the preset's own value (presets.h).
struct EstimateOptions {
  static constexpr int kMostIterations = 10'000'000;     ///< Upper limit of max_iterations and min_iterations.
  static constexpr double kMostConfidence = 1.0 - 1e-9;  ///< Upper limit of confidence.
  /// Upper limit of the number of minimal samples. If absent: 1000; lines and planes 420; registration 10000.
  std::optional<int> max_iterations = {};
  /// The search does not stop before so many samples. At most max_iterations; without that, raises it where necessary.
  std::optional<int> min_iterations = {};
  /// The search stops once a better model would have been sampled with this probability. If absent: 0.9999.
  std::optional<double> confidence = {};
  /// Threads of one search; 0: one for each core. Results do not depend on it.
  int num_threads = 1;
  Guidance guidance = Guidance::kNetwork;   ///< Where minimal samples come from.
  Cameras cameras = Cameras::kPhotographs;  ///< F: prior knowledge of the cameras, if the images' sizes are known.
  /// A folder like the project's models/, whose networks are used. If empty: those that the library carries.
  std::string models_folder = {};
  std::uint64_t seed = 0;  ///< Seed of all random draws.
  /// Every field is equal.
  bool operator==(const EstimateOptions&) const = default;
  /// Throws Error naming the field and what was expected.
  void Check() const;
};

/// Changes a preset as the options ask. Searches for several models take max_iterations alone: they draw all of it.
void Apply(const EstimateOptions& options, ClassicalOptions* preset);
/// The same of a preset with a network, whose samples are half guided by the network and half PROSAC's.
void Apply(const EstimateOptions& options, DiffsacOptions* preset);

}  // namespace diffsac
