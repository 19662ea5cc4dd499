#include "diffsac/core/enum_names.h"

#include <stdexcept>

#include "diffsac/core/nearest_word.h"
#include "diffsac/core/status.h"

namespace diffsac {

void ThrowUnknownName(const std::string& name, const std::vector<std::string>& names) {
  std::string expected;
  for (const std::string& known : names) expected += (expected.empty() ? "" : ", ") + known;
  throw Error("expected one of " + expected + ", got '" + name + "'; did you mean '" + NearestWord(name, names) + "'?");
}

void ThrowUnnamedValue(int value) {
  throw std::logic_error("an enum's value " + std::to_string(value) + " has no name in kEnumNames");
}

}  // namespace diffsac
