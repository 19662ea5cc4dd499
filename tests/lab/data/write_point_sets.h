#pragma once

#include <string>
#include <vector>

#include "lab/truth/example.h"

namespace diffsac::testing {

/// Writes examples as groups that ReadHdf5Points reads back without loss: double precision, order, id, scene,
/// threshold.
void WritePointSets(const std::string& path, const std::vector<Example>& examples);

}  // namespace diffsac::testing
