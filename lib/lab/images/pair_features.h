#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "lab/images/feature_store.h"

namespace diffsac {

/// Calls `body(i, first, second)` with the features of each pair's images, on up to `threads` threads (0: all cores),
/// in no fixed order within a block of pairs. Of the images, only those that the block and later pairs need are in
/// memory. False when `stop` turned true; pairs that have begun are finished.
bool ForEachPair(const FeatureStore& store, const std::vector<SourcePair>& pairs, int threads,
                 const std::atomic<bool>& stop,
                 const std::function<void(std::int64_t, const ImageFeatures&, const ImageFeatures&)>& body);

}  // namespace diffsac
