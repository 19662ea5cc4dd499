#pragma once

#include <string>

namespace diffsac {

/// One line that says where a run's results are: the folder, and what of it a person opens or reads first.
std::string ResultsText(const std::string& folder);

}  // namespace diffsac
