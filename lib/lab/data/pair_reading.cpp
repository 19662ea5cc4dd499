#include "lab/data/pair_reading.h"

#include <deque>
#include <filesystem>
#include <map>
#include <tuple>
#include <utility>

#include "lab/data/finite_points.h"
#include "lab/data/fitted_truth.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kKeptBytes = std::size_t{512} << 20;

std::size_t BytesOf(const Example& pair) {
  const Problem& problem = pair.problem;
  return sizeof(Example) +
         sizeof(double) * static_cast<std::size_t>(problem.points.size() + problem.snn_ratio.size() +
                                                   problem.scale_rotation_changes.size()) +
         sizeof(float) * static_cast<std::size_t>(problem.descriptors.size()) +
         sizeof(std::int32_t) * pair.truth.assignment.size();
}

// The pairs that were read last, whoever reads them.
class RecentPairs {
 public:
  static RecentPairs& Instance() {
    static RecentPairs recent;
    return recent;
  }

  void Add(const PairReading* reading, std::shared_ptr<const Example> pair) {
    const std::lock_guard lock(mutex_);
    bytes_ += BytesOf(*pair);
    pairs_.push_back({reading, std::move(pair)});
    while (bytes_ > kKeptBytes && pairs_.size() > 1) {
      bytes_ -= BytesOf(*pairs_.front().pair);
      pairs_.pop_front();
    }
  }

  void Remove(const PairReading* reading) {
    const std::lock_guard lock(mutex_);
    std::erase_if(pairs_, [&](const Entry& entry) {
      if (entry.reading != reading) return false;
      bytes_ -= BytesOf(*entry.pair);
      return true;
    });
  }

 private:
  struct Entry {
    const PairReading* reading;
    std::shared_ptr<const Example> pair;
  };

  std::mutex mutex_;
  std::deque<Entry> pairs_;
  std::size_t bytes_ = 0;
};

// The readings that are in use.
class OpenReadings {
 public:
  std::shared_ptr<const PairReading> Get(const SceneFolder& scene, const PairReadingOptions& options) {
    const Key key = KeyOf(scene, options);
    const std::lock_guard lock(mutex_);
    if (const auto found = readings_.find(key); found != readings_.end())
      if (auto reading = found->second.lock()) return reading;
    std::erase_if(readings_, [](const auto& entry) { return entry.second.expired(); });
    auto reading = std::make_shared<const PairReading>(scene, options);
    readings_[key] = reading;
    return reading;
  }

 private:
  // Name, folder, when its files were written (matches.h5 comes last), options.
  using Key = std::tuple<std::string, std::string, fs::file_time_type, PairReadingOptions>;

  static Key KeyOf(const SceneFolder& scene, const PairReadingOptions& options) {
    std::error_code code;
    const fs::path whole = fs::weakly_canonical(scene.folder, code);
    const fs::path folder = code ? fs::path(scene.folder) : whole;
    const auto written = fs::last_write_time(folder / "matches.h5", code);
    return {scene.name, folder.string(), code ? fs::file_time_type{} : written, options};
  }

  std::mutex mutex_;
  std::map<Key, std::weak_ptr<const PairReading>> readings_;
};

}  // namespace

std::shared_ptr<const PairReading> PairReading::Open(const SceneFolder& scene, const PairReadingOptions& options) {
  static OpenReadings open;
  return open.Get(scene, options);
}

PairReading::PairReading(const SceneFolder& scene, const PairReadingOptions& options)
    : name_(scene.name),
      options_(options),
      files_(scene.folder, {options.descriptors}),
      pairs_(static_cast<std::size_t>(files_.size())) {}

PairReading::~PairReading() { RecentPairs::Instance().Remove(this); }

std::string PairReading::Where(std::int64_t position) const {
  return files_.folder() + "/matches.h5: " + files_.pairs().at(static_cast<std::size_t>(position));
}

std::shared_ptr<const Example> PairReading::Pair(std::int64_t position) const {
  std::weak_ptr<const Example>& place = pairs_.at(static_cast<std::size_t>(position));
  {
    const std::lock_guard lock(mutex_);
    if (auto pair = place.lock()) return pair;
  }
  // Reading and refining take long, so others need not wait for them; two may read the same pair.
  std::shared_ptr<const Example> pair = Read(position);
  const std::lock_guard lock(mutex_);
  if (auto other = place.lock()) return other;
  place = pair;
  RecentPairs::Instance().Add(this, pair);
  return pair;
}

std::shared_ptr<const Example> PairReading::Read(std::int64_t position) const {
  auto pair = std::make_shared<Example>(WithFinitePoints(files_.Read(position), Where(position)));
  pair->scene = name_;
  pair->id = name_ + "/" + pair->id;
  GroundTruth& truth = pair->truth;
  if (options_.refine_truth_px > 0.0) RefineEpipolarTruth(pair->problem, options_.refine_truth_px, &truth);
  if (options_.dominant_plane_px > 0.0) {
    truth.homography = DominantHomography(pair->problem, truth, options_.dominant_plane_px, pair->id);
    // Labels are those of the whole scene, and F is no truth of a homography.
    truth.assignment.clear();
    if (!truth.homography) truth.fundamental.reset();
  }
  if (options_.instances_px > 0.0) FitInstances(options_.instances_task, pair->problem, options_.instances_px, &truth);
  return pair;
}

}  // namespace diffsac
