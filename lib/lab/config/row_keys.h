#pragma once

#include <initializer_list>

#include "diffsac/estimate/learned_model.h"
#include "lab/options/config.h"

namespace diffsac {

/// A key that a row may write, and whether it changes anything there. For what depends on the network; what depends on
/// other keys alone is the binder's (OnlyIf).
struct RowKey {
  const char* key;
  bool acts;
  const char* reason;             ///< Why it does not, for the message.
  const char* neutral = nullptr;  ///< A value that may be written all the same: it switches off what is inherited.
};

/// Throws Error with the line of the first key that the row itself writes and that cannot act there. What a row
/// inherits from its checkpoint is no error.
void CheckRowKeys(const Config& row, std::initializer_list<RowKey> keys);

/// That for the keys that all learned rows share.
void CheckSharedKeys(const Config& row, const LearnedModel& network);

}  // namespace diffsac
