#include "lab/images/pair_features.h"

#include <algorithm>
#include <map>

#include "diffsac/core/parallel.h"

namespace diffsac {

bool ForEachPair(const FeatureStore& store, const std::vector<SourcePair>& pairs, int threads,
                 const std::atomic<bool>& stop,
                 const std::function<void(std::int64_t, const ImageFeatures&, const ImageFeatures&)>& body) {
  const auto count = static_cast<std::int64_t>(pairs.size());
  std::map<int, std::int64_t> last_use;
  for (std::int64_t i = 0; i < count; ++i) last_use[pairs[i].image1] = last_use[pairs[i].image2] = i;
  const std::int64_t block = 8 * (threads > 0 ? threads : HardwareThreads());
  std::map<int, ImageFeatures> loaded;
  for (std::int64_t start = 0; start < count && !stop; start += block) {
    const std::int64_t end = std::min(count, start + block);
    std::vector<int> missing;
    for (std::int64_t i = start; i < end; ++i)
      for (int image : {pairs[i].image1, pairs[i].image2})
        if (loaded.try_emplace(image).second) missing.push_back(image);
    ParallelFor(static_cast<std::int64_t>(missing.size()), threads,
                [&](std::int64_t k) { loaded.at(missing[k]) = store.Load(missing[k]); });
    ParallelFor(end - start, threads, [&](std::int64_t k) {
      const SourcePair& pair = pairs[start + k];
      if (!stop) body(start + k, loaded.at(pair.image1), loaded.at(pair.image2));
    });
    std::erase_if(loaded, [&](const auto& entry) { return last_use.at(entry.first) < end; });
  }
  return !stop;
}

}  // namespace diffsac
