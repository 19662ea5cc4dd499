#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace diffsac {

/// Colours of pictures and coloured points, "#RRGGBB". An inlier is green wherever it is shown; scripts/report has the
/// same values.
inline constexpr const char* kInlierColour = "#0A9440";
inline constexpr const char* kOutlierColour = "#9AA2AB";  ///< All other points.

/// Of one of several structures: colours that colour-blind readers can tell apart (Okabe and Ito, "Color universal
/// design", 2008). They repeat after six.
inline const char* InstanceColour(std::size_t index) {
  static constexpr std::array<const char*, 6> kColours = {"#0072B2", "#D55E00", "#009E73",
                                                          "#CC79A7", "#E69F00", "#56B4E9"};
  return kColours[index % kColours.size()];
}

/// Of a point by its label: 0 an outlier, 1 an inlier, or, where there are several structures, the number of its own.
inline const char* LabelColour(std::int32_t label, bool several) {
  if (label <= 0) return kOutlierColour;
  return several ? InstanceColour(static_cast<std::size_t>(label) - 1) : kInlierColour;
}

/// Red, green and blue.
constexpr std::array<std::uint8_t, 3> ColourParts(std::string_view colour) {
  const auto digit = [](char c) { return c <= '9' ? c - '0' : (c | 32) - 'a' + 10; };
  std::array<std::uint8_t, 3> parts{};
  for (std::size_t i = 0; i < 3; ++i)
    parts[i] = static_cast<std::uint8_t>(16 * digit(colour[1 + 2 * i]) + digit(colour[2 + 2 * i]));
  return parts;
}

}  // namespace diffsac
