#pragma once

#include <optional>
#include <string>

namespace diffsac {

/// How many times the diagonal of a camera's sensor is shorter than that of 36 mm by 24 mm, by the maker and model that
/// EXIF data name. From the data of lensfun (https://lensfun.github.io), which knows about a thousand cameras; nothing
/// for others, and in a build without that library. Thread-safe.
std::optional<double> CropFactor(const std::string& maker, const std::string& model);

}  // namespace diffsac
