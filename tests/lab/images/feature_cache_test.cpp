#include "lab/images/feature_cache.h"

#include <catch2/catch.hpp>

#include "core/errors.h"
#include "lab/files/files.h"
#include "lab/images/image_test_util.h"

namespace diffsac {

TEST_CASE("keypoints in files are read back as they were, others are not taken") {
  TemporaryFolder folder;
  WriteImage(folder / "a.png", Texture(160, 120, 3));
  WriteImage(folder / "flat.png", cv::Mat(64, 64, CV_8U, cv::Scalar(100)));
  FeatureOptions options;
  const FeatureCache cache(folder / "cache", options);
  RawFeatures read;
  CHECK(!cache.Read("a", folder / "a.png", &read));
  for (const std::string name : {"a", "flat"}) {
    const std::string path = folder / (name + ".png");
    const RawFeatures raw = ExtractRawFeatures(path, options);
    cache.Write(name, path, raw);
    REQUIRE(cache.Read(name, path, &read));
    CHECK((read.size == raw.size && read.positions == raw.positions && read.bytes == raw.bytes));
    CHECK(read.frames == raw.frames);
    CHECK((name == "flat") == (read.bytes.rows() == 0));
  }
  options.kind = FeatureKind::kSift;
  CHECK(FeatureCache(folder / "cache", options).Read("a", folder / "a.png", &read));
  options.max_keypoints = 10;
  CHECK(!FeatureCache(folder / "cache", options).Read("a", folder / "a.png", &read));
  CHECK(!cache.Read("a", folder / "flat.png", &read));
  const std::string file = folder / "cache/a.bin", content = ReadFile(file);
  for (std::size_t size : {std::size_t{0}, std::size_t{40}, content.size() / 2, content.size() - 1}) {
    WriteRaw(file, content.substr(0, size));
    CHECK(!cache.Read("a", folder / "a.png", &read));
  }
}

}  // namespace diffsac
