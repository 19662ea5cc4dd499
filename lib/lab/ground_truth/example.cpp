#include "lab/ground_truth/example.h"

#include <cstdio>

namespace diffsac {

std::string PointDigest(const PointMatrix& points) {
  // FNV-1a (Fowler, Noll, Vo).
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&](const void* bytes, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      hash = (hash ^ static_cast<const unsigned char*>(bytes)[i]) * 0x100000001b3u;
  };
  const std::int64_t columns = points.cols();
  add(&columns, sizeof(columns));
  add(points.data(), sizeof(double) * static_cast<std::size_t>(points.size()));
  char text[9];
  std::snprintf(text, sizeof(text), "%08x", static_cast<unsigned>(hash ^ (hash >> 32)));
  return text;
}

std::string ProblemName(const Example& example) {
  return example.digest.empty() ? example.id : example.id + "@" + example.digest;
}

std::string Dataset::FolderOf(const std::string&) const { return ""; }

}  // namespace diffsac
