#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "diffsac/core/former_names.h"

namespace diffsac {
/// A value of an enum with its name.
template <class Enum>
struct EnumName {
  Enum value;        ///< The value.
  const char* name;  ///< Its name.
};

/// The names of an enum's values in YAML, in messages and in tables. Written once, beside the enum:
/// ```
/// enum class Noise { kGaussian, kUniform };
/// template <>
/// inline constexpr auto kEnumNames<Noise> =
///     NamesOf<Noise>({{Noise::kGaussian, "gaussian"}, {Noise::kUniform, "uniform"}});
/// ```
/// Then `b.Field("noise", noise)` binds it, and ToString and FromString<Noise> convert it.
template <class Enum>
inline constexpr auto kEnumNames = nullptr;
/// The names of kEnumNames as an array.
template <class Enum, std::size_t kSize>
constexpr std::array<EnumName<Enum>, kSize> NamesOf(const EnumName<Enum> (&names)[kSize]) {
  return std::to_array(names);
}

template <class Enum>
concept NamedEnum =
    std::is_enum_v<Enum> && !std::is_same_v<std::remove_cv_t<decltype(kEnumNames<Enum>)>, std::nullptr_t>;

/// Used by FromString: throws Error naming the nearest of `names`.
[[noreturn]] void ThrowUnknownName(const std::string& name, const std::vector<std::string>& names);
/// Used by ToString: throws std::logic_error.
[[noreturn]] void ThrowUnnamedValue(int value);

/// Every name of an enum, in the table's order.
template <NamedEnum Enum>
std::vector<std::string> NamesOf() {
  std::vector<std::string> names;
  for (const auto& entry : kEnumNames<Enum>) names.push_back(entry.name);
  return names;
}
/// The value's name.
template <NamedEnum Enum>
std::string ToString(Enum value) {
  for (const auto& entry : kEnumNames<Enum>)
    if (entry.value == value) return entry.name;
  ThrowUnnamedValue(static_cast<int>(value));
}

/// The value of a name, or of a former name (former_names.h). Throws Error naming the nearest for a name that is none.
template <NamedEnum Enum>
Enum FromString(const std::string& name) {
  for (const auto& entry : kEnumNames<Enum>)
    if (name == entry.name) return entry.value;
  const std::string current = CurrentName(name);
  for (const auto& entry : kEnumNames<Enum>)
    if (current == entry.name) return entry.value;
  ThrowUnknownName(name, NamesOf<Enum>());
}

}  // namespace diffsac
