#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "lab/data/pair_scenes.h"
#include "lab/files/correspondence_files.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// What decides the pairs that are read from a scene, before any match is left out.
struct PairReadingOptions {
  bool descriptors = false;        ///< Whether descriptors.h5 is read where it is there.
  double refine_truth_px = 0.0;    ///< RefineEpipolarTruth (lab/data/fitted_truth.h) with this loss; 0: not.
  double dominant_plane_px = 0.0;  ///< DominantHomography (lab/data/fitted_truth.h) with this threshold; 0: not.
  double instances_px = 0.0;       ///< FitInstances (lab/data/fitted_truth.h) of the labels with this loss; 0: not.
  Task instances_task = {};        ///< Of which models these are.
  auto operator<=>(const PairReadingOptions&) const = default;
};

/// The pairs of a scene as they stand in its files, with refined truth where that is asked for. Datasets that differ by
/// a filter alone share one reading: Open returns the one that is in use, as long as the files have not been written
/// anew. A pair is read once for as long as someone holds it; the pairs that were read last, of all scenes together up
/// to 512 MiB, are held here too until the reading goes. Thread-safe.
class PairReading {
 public:
  /// Reads the names of the pairs alone. Throws Error naming the file.
  static std::shared_ptr<const PairReading> Open(const SceneFolder& scene, const PairReadingOptions& options);

  explicit PairReading(const SceneFolder& scene, const PairReadingOptions& options);
  ~PairReading();
  PairReading(const PairReading&) = delete;
  PairReading& operator=(const PairReading&) = delete;

  std::int64_t size() const { return files_.size(); }
  /// "<folder>/matches.h5: <pair>", for messages.
  std::string Where(std::int64_t position) const;
  /// A pair: its id is "<scene>/<pair>", its problem of no task yet (SetTask). Throws Error naming file and key.
  std::shared_ptr<const Example> Pair(std::int64_t position) const;
  /// The same as its file has it, not kept: no truth is refined and no match left out.
  Example Raw(std::int64_t position) const { return files_.Read(position); }
  const std::string& folder() const { return files_.folder(); }
  /// Closes the files until the next pair is read, so that many scenes can be held.
  void CloseFiles() const { files_.CloseFiles(); }

 private:
  std::shared_ptr<const Example> Read(std::int64_t position) const;

  std::string name_;
  PairReadingOptions options_;
  CorrespondenceScene files_;
  mutable std::mutex mutex_;
  mutable std::vector<std::weak_ptr<const Example>> pairs_;
};

}  // namespace diffsac
