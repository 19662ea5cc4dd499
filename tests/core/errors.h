#pragma once

#include <fstream>
#include <string>
#include <string_view>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"

namespace diffsac {

inline void WriteRaw(const std::string& path, std::string_view content) {
  std::ofstream(path, std::ios::binary) << content;
}

/// The message of the Error that `call` throws, "" when it throws none.
template <class Call>
std::string ErrorOf(Call call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

inline bool Has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace diffsac
