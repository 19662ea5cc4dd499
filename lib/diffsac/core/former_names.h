#pragma once

#include <string>

namespace diffsac {

/// Keys, values and columns that had another name in 0.2. Files and checkpoints of that version are still read; only
/// the current names are written. Both return a name that did not change as it is.
std::string CurrentName(const std::string& name);
/// The name of 0.2.
std::string FormerName(const std::string& name);

}  // namespace diffsac
