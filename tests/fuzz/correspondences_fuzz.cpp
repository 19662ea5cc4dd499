// A scene of correspondences in which one file is hostile: the first byte says which, and who reads it; the others
// change it (ChangeHdf5).

#include <array>
#include <filesystem>

#include "diffsac/core/files.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/hdf5_edits.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/two_view_test_util.h"
#include "lab/files/correspondence_files.h"
#include "lab/files/thumbnails.h"

namespace diffsac::testing {
namespace {

constexpr std::array<const char*, 14> kFiles = {"matches.h5",    "match_conf.h5",  "K1_K2.h5",  "R.h5",
                                                "T.h5",          "Egt.h5",         "Fgt.h5",    "Hgt.h5",
                                                "sizes.h5",      "descriptors.h5", "labels.h5", "match_indices.h5",
                                                "thumbnails.h5", "similarities.h5"};
constexpr int kMatches = 9;

/// The scene as the tutorial's and KITTI's loaders look for it, and its files' bytes.
class Scene {
 public:
  Scene() : folder_(Scratch() + "/kitti_00_step_01/val") {
    CorrespondenceSet set = SyntheticSet(2, kMatches, Rng(1));
    for (Example& pair : set.pairs) {
      pair.truth.homography = Eigen::Matrix3d::Identity();
      set.match_indices.push_back(MatchIndices::Zero(kMatches, 2));
    }
    std::filesystem::create_directories(folder_);
    WriteCorrespondences(folder_, set);
    WriteThumbnails(folder_, {"im_000"}, [](std::size_t) { return std::string("JPEG"); });
    for (const char* name : kFiles) bytes_.push_back(ReadFile(folder_ + "/" + name));
  }

  const std::string& folder() const { return folder_; }
  const std::vector<std::string>& bytes() const { return bytes_; }
  void Put(std::size_t file, std::string_view content) const {
    WriteScratch(std::string("kitti_00_step_01/val/") + kFiles[file], content);
  }

 private:
  std::string folder_;
  std::vector<std::string> bytes_;
};

const Scene& TheScene() {
  static const Scene scene;
  return scene;
}

void ReadAll(const std::string& folder) {
  Parses({folder}, [&] {
    CorrespondenceOptions options;
    options.descriptors = true;
    const CorrespondenceScene scene(folder, options);
    for (std::int64_t i = 0; i < std::min<std::int64_t>(scene.size(), 4); ++i) {
      const Example example = scene.Read(i);
      Require(example.problem.points.cols() == 4, "a match has four coordinates");
      scene.ReadMatchIndices(example.id, example.problem.points.rows());
    }
  });
  Parses({folder}, [&] { ReadThumbnail(folder, "im_000"); });
}

/// What filters, normalises and labels pairs.
void LoadAll(const std::string& data) {
  Parses({Scratch()}, [&] {
    const auto dataset = MakeDataset(ConfigFromYaml("{" + data + "}"), 1);
    for (std::int64_t i = 0; i < std::min<std::int64_t>(dataset->size(), 4); ++i)
      dataset->Get(static_cast<std::uint64_t>(i));
  });
}

}  // namespace

std::vector<std::string> Seeds() { return EditSeeds(4 * static_cast<int>(kFiles.size())); }

}  // namespace diffsac::testing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diffsac::testing;
  const Scene& scene = TheScene();
  ByteReader reader(data, size);
  const std::size_t first = reader.Byte(), file = first % kFiles.size();
  ChangeHdf5(scene.folder() + "/" + kFiles[file], &reader);
  switch (first / kFiles.size() % 4) {
    case 0:
      ReadAll(scene.folder());
      break;
    case 1:
      LoadAll("type: ransac_tutorial, root: " + Scratch() + ", task: essential, descriptors: true");
      break;
    case 2:
      LoadAll("type: kitti, root: " + Scratch() + ", task: fundamental");
      break;
    default:
      LoadAll("type: correspondences, paths: [" + scene.folder() + "], task: homography");
  }
  scene.Put(file, scene.bytes()[file]);
  return 0;
}
