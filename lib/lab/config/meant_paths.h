#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "lab/options/config.h"

namespace diffsac {

/// A document with every key filled in, and the path that it stands at ("methods.ransac").
using PlacedConfig = std::pair<std::string, Config>;

/// The message of an Error; where it says of one of these --set that there is no such key, with the paths that end as
/// it does, or in its last key, in the place of the nearest word.
std::string WithMeantPaths(const Error& error, const std::vector<std::string>& assignments,
                           const std::function<std::vector<PlacedConfig>()>& documents);

}  // namespace diffsac
