#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "lab/files/files.h"

namespace diffsac {

/// EXIF data as TIFF holds it (CIPA DC-008): one directory with the texts and the pointer to a second one, whose fields
/// are the others, of 16 bits, or of a numerator and a denominator.
class ExifBytes {
 public:
  std::map<std::uint16_t, std::uint16_t> shorts = {};
  std::map<std::uint16_t, std::pair<std::uint32_t, std::uint32_t>> rationals = {};
  bool big_endian = false;
  std::map<std::uint16_t, std::string> texts = {};

  std::string ToString() const {
    const std::size_t count = shorts.size() + rationals.size(), second = 26 + 12 * texts.size();
    const std::size_t behind = second + 2 + 12 * count + 4;
    std::string out = big_endian ? "MM" : "II", values;
    const auto place = [&] { return static_cast<std::uint32_t>(behind + values.size()); };
    out += Bytes(42, 2) + Bytes(8, 4) + Bytes(static_cast<std::uint32_t>(texts.size()) + 1, 2);
    for (const auto& [tag, text] : texts) {
      const auto size = static_cast<std::uint32_t>(text.size()) + 1;
      out += Bytes(tag, 2) + Bytes(kAscii, 2) + Bytes(size, 4) + Bytes(place(), 4);
      values += text + std::string(size % 2 == 0 ? 1 : 2, '\0');
    }
    out += Bytes(kExifPointer, 2) + Bytes(kLong, 2) + Bytes(1, 4) + Bytes(static_cast<std::uint32_t>(second), 4);
    out += Bytes(0, 4) + Bytes(static_cast<std::uint32_t>(count), 2);
    std::map<std::uint16_t, std::string> entries;
    for (const auto& [tag, value] : shorts)
      entries[tag] = Bytes(tag, 2) + Bytes(kShort, 2) + Bytes(1, 4) + Bytes(value, 2) + Bytes(0, 2);
    for (const auto& [tag, value] : rationals) {
      entries[tag] = Bytes(tag, 2) + Bytes(kRational, 2) + Bytes(1, 4) + Bytes(place(), 4);
      values += Bytes(value.first, 4) + Bytes(value.second, 4);
    }
    for (const auto& [tag, entry] : entries) out += entry;
    return out + Bytes(0, 4) + values;
  }

 private:
  static constexpr std::uint32_t kAscii = 2, kShort = 3, kLong = 4, kRational = 5, kExifPointer = 0x8769;

  std::string Bytes(std::uint32_t value, int size) const {
    std::string bytes;
    for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> (8 * i));
    if (big_endian) std::reverse(bytes.begin(), bytes.end());
    return bytes;
  }
};

/// A JPEG file as it is, with these bytes as its EXIF data.
inline std::string WithExif(const std::string& jpeg, const std::string& exif) {
  const std::string body = std::string("Exif\0\0", 6) + exif;
  const std::size_t size = body.size() + 2;
  const std::string marker{'\xFF', '\xE1', static_cast<char>(size >> 8), static_cast<char>(size)};
  return jpeg.substr(0, 2) + marker + body + jpeg.substr(2);
}

}  // namespace diffsac
