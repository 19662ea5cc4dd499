#pragma once

#include <string>

#include "diffsac/core/status.h"

namespace diffsac {

/// Throws Error, "FIELD: expected EXPECTED", unless `ok`: for the options and inputs of diffsac.h.
inline void Require(bool ok, const std::string& field, const std::string& expected) {
  if (!ok) throw Error(field + ": expected " + expected);
}

}  // namespace diffsac
