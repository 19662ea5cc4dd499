// HDF5 files that others made: the first byte of an input says which sound file is hostile, the others change it
// (EditHdf5).

#include <H5Cpp.h>

#include <array>
#include <filesystem>
#include <mutex>

#include "fuzz/fuzz_target.h"
#include "fuzz/hdf5_edits.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/two_view_test_util.h"
#include "lab/files/correspondence_files.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/images/feature_file_test_util.h"
#include "lab/images/feature_store.h"

namespace diffsac::testing {
namespace {

// ---- Absolute poses.

std::string MakePoses() {
  const std::string path = WriteScratch("seed.h5", "");
  {
    const std::lock_guard lock(Hdf5Mutex());
    H5::H5File file(path, H5F_ACC_TRUNC);
    const H5::Group group = file.createGroup("a");
    const std::vector<double> points(20, 1.0), ratios(4, 0.5), K = {100, 0, 0, 0, 100, 0, 0, 0, 1};
    const std::vector<double> pose = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5};
    WriteNumbers(group, "points", points.data(), {4, 5});
    WriteNumbers(group, "ratios", ratios.data(), {4});
    WriteNumbers(group, "K", K.data(), {3, 3});
    WriteNumbers(group, "pose", pose.data(), {3, 4});
  }
  return ReadFile(path);
}

void RunPoints(const std::string& bytes) {
  static const std::string file = MakePoses();
  ByteReader reader(bytes);
  EditHdf5(WriteScratch("scene/scene_points.h5", file), &reader);
  Parses({Scratch()},
         [&] { MakeDataset(ConfigFromYaml("{type: absolute_poses, paths: [" + Scratch() + "/scene]}"), 1); });
}

// ---- A scene of correspondences.

constexpr std::array<const char*, 13> kSceneFiles = {
    "matches.h5", "match_conf.h5",    "K1_K2.h5",       "R.h5",     "T.h5",
    "Egt.h5",     "Fgt.h5",           "Hgt.h5",         "sizes.h5", "descriptors.h5",
    "labels.h5",  "match_indices.h5", "similarities.h5"};
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
    for (const char* name : kSceneFiles) bytes_.push_back(ReadFile(folder_ + "/" + name));
  }

  const std::string& folder() const { return folder_; }
  const std::vector<std::string>& bytes() const { return bytes_; }
  void Put(std::size_t file, std::string_view content) const {
    WriteScratch(std::string("kitti_00_step_01/val/") + kSceneFiles[file], content);
  }

 private:
  std::string folder_;
  std::vector<std::string> bytes_;
};

void ReadScene(const std::string& folder) {
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
}

/// What filters, normalises and labels pairs.
void LoadPairs(const std::string& data) {
  Parses({Scratch()}, [&] {
    const auto dataset = MakeDataset(ConfigFromYaml("{" + data + "}"), 1);
    for (std::int64_t i = 0; i < std::min<std::int64_t>(dataset->size(), 4); ++i)
      dataset->Get(static_cast<std::uint64_t>(i));
  });
}

void RunCorrespondences(const std::string& bytes) {
  static const Scene scene;
  ByteReader reader(bytes);
  const std::size_t first = reader.Byte(), file = first % kSceneFiles.size();
  EditHdf5(scene.folder() + "/" + kSceneFiles[file], &reader);
  switch (first / kSceneFiles.size() % 4) {
    case 0:
      ReadScene(scene.folder());
      break;
    case 1:
      LoadPairs("type: ransac_tutorial, root: " + Scratch() + ", task: essential, descriptors: true");
      break;
    case 2:
      LoadPairs("type: kitti, root: " + Scratch() + ", task: fundamental");
      break;
    default:
      LoadPairs("type: correspondences, paths: [" + scene.folder() + "], task: homography");
  }
  scene.Put(file, scene.bytes()[file]);
}

// ---- Features in hloc's layout.

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

void RunFeatures(const std::string& bytes) {
  static const std::string file = MakeFeatures();
  ByteReader reader(bytes);
  const std::string path = WriteScratch("features.h5", file);
  EditHdf5(path, &reader);
  for (const char* image : {"a.png", "b.png"})
    Parses({path}, [&] { ImportedFeatures(path).Read(Scratch() + "/" + image, ImageSize{10, 8}, 3); });
}

template <int kChoices>
std::vector<std::string> Seeds() {
  return EditSeeds(kChoices);
}

const AddTarget kTargets[] = {{"points_hdf5", Seeds<2>, RunPoints},
                              {"correspondences", Seeds<4 * static_cast<int>(kSceneFiles.size())>, RunCorrespondences},
                              {"features", Seeds<2>, RunFeatures}};

}  // namespace
}  // namespace diffsac::testing
