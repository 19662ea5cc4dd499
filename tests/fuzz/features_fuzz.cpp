// Features and matches that others made, in hloc's layout. The first byte says which of the two files is hostile, the
// others change it (ChangeHdf5).

#include <filesystem>
#include <mutex>

#include "diffsac/core/files.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/hdf5_edits.h"
#include "lab/images/feature_file_test_util.h"
#include "lab/images/hloc_files.h"
#include "lab/images/imported_features.h"

namespace diffsac::testing {
namespace {

constexpr const char* kFiles[] = {"features.h5", "matches.h5"};

std::string MakeFeatures() {
  const std::string path = WriteScratch("seed.h5", "");
  WriteFeatureFile(path, [](FeatureFile& file) {
    for (const std::string name : {"a.png", "b.png"}) {
      file.Put(name + "/keypoints", Eigen::MatrixXd::Ones(5, 2));
      file.Put(name + "/descriptors", Eigen::MatrixXd::Ones(4, 5));
      file.Put(name + "/scores", Eigen::VectorXd::Ones(5), true);
      file.Put(name + "/image_size", Eigen::Vector2d(10, 8), true);
    }
  });
  return ReadFile(path);
}

std::string MakeMatches() {
  const std::string path = WriteScratch("seed.h5", "");
  WriteFeatureFile(path, [](FeatureFile& file) {
    Eigen::VectorXd matches(5);
    matches << -1, 2, -1, 0, 1;
    file.Put("a.png/b.png/matches0", matches, true);
    file.Put("a.png/b.png/matching_scores0", Eigen::VectorXd::Ones(5), true);
  });
  return ReadFile(path);
}

const std::string (&SoundFiles())[2] {
  static const std::string files[2] = {MakeFeatures(), MakeMatches()};
  return files;
}

}  // namespace

std::vector<std::string> Seeds() { return EditSeeds(2); }

}  // namespace diffsac::testing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diffsac::testing;
  ByteReader reader(data, size);
  const int hostile = reader.Below(2);
  std::string paths[2];
  for (int i = 0; i < 2; ++i) paths[i] = WriteScratch(kFiles[i], SoundFiles()[i]);
  ChangeHdf5(paths[hostile], &reader);
  const auto read = [&](const char* image) {
    Parses({paths[0]}, [&] {
      diffsac::ImportedFeatures(paths[0]).Read(Scratch() + "/" + image, diffsac::ImageSize{10, 8}, 3);
    });
  };
  if (hostile == 0) read("a.png"), read("b.png");
  Parses({paths[0], paths[1]}, [&] { diffsac::ReadHlocFiles(paths[0], paths[1]); });
  Parses({paths[hostile]}, [&] { diffsac::KindOfHlocFile(paths[hostile]); });
  return 0;
}
