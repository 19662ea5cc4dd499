#include "lab/images/image_sets.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "lab/files/correspondence_files.h"
#include "lab/files/files.h"
#include "lab/files/segment_files.h"
#include "lab/images/feature_file_test_util.h"
#include "lab/images/image_test_util.h"

namespace diffsac {
namespace {

using Catch::Contains;

// Whether the sets are made; not where there is no Python with what the converter needs.
bool PreparedByConverter(const SetsRequest& request, const std::atomic<bool>& stop) {
  try {
    REQUIRE(PrepareSets(request, stop));
    return true;
  } catch (const Error& error) {
    REQUIRE_THAT(error.what(), Contains("no python3"));
    WARN("skipped: " << error.what());
    return false;
  }
}

TEST_CASE("image sets are read, those with descriptors are sets of their own") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("sets.yaml"), R"(
sets:
  - {name: a, input: [a, other/a], convert: strecha, format: colmap, output: runs/test, scenes: [a], described: test, steps: [1, 2]}
  - {name: b, input: [b], format: images, scenes: ["b_*"], described: train}
)");
  const std::vector<ImageSet> sets = ReadImageSets(folder.File("sets.yaml"));
  REQUIRE(sets.size() == 5);
  CHECK(sets[0].pairs.choice.steps == std::vector<int>{1, 2});
  CHECK(sets[1].name == "a_rootsift");
  CHECK(sets[1].output == "runs/descriptors/rootsift/test");
  CHECK(sets[1].pairs.options.descriptors);
  CHECK(sets[2].pairs.options.features.kind == FeatureKind::kOrb);
  CHECK(sets[4].output == "runs/descriptors/orb/train");
}

TEST_CASE("a set is meant by its name and by the folders that it makes") {
  ImageSet set;
  set.name = "kitti_01";
  set.output = "runs/pairs/test";
  set.scenes = {"kitti_01_step_*"};
  for (const char* wanted :
       {"kitti_01", "kitti_*", "runs/pairs/test", "runs/pairs", "runs/pairs/test/kitti_01_step_05"}) {
    INFO(wanted);
    CHECK(Makes(set, wanted));
  }
  for (const char* other : {"kitti_0", "runs/pairs/te", "runs/pairs/test/kitti_00_step_05", "runs/pairs/train"}) {
    INFO(other);
    CHECK_FALSE(Makes(set, other));
  }
}

TEST_CASE(
    "a set takes features that were made elsewhere from a file below the folder of data, and is left out without it") {
  const TemporaryFolder folder;
  MakeFolder(folder.File("data/room"));
  MakeFolder(folder.File("data/features"));
  for (const char* name : {"1.png", "2.png"})
    WriteImage(folder.File("data/room/") + name, cv::Mat(240, 320, CV_8U, cv::Scalar(90)));
  WriteFileAtomically(folder.File("sets.yaml"),
                      "sets:\n  - {name: room_learned, input: [room], format: images, scenes: [room], "
                      "import_descriptors: features/room.h5, output: " +
                          folder.File("pairs") + "}\n");
  SetsRequest request;
  request.config = folder.File("sets.yaml");
  request.data = folder.File("data");
  const std::atomic<bool> stop{false};
  CHECK_THROWS_WITH(PrepareSets(request, stop), Contains("none of the sets"));
  Eigen::MatrixXd keypoints(12, 2);
  for (int i = 0; i < 12; ++i) keypoints.row(i) << 20.0 * i + 7.5, 15.0 * i + 3.25;
  WriteFeatureFile(folder.File("data/features/room.h5"), [&](FeatureFile& file) {
    for (const std::string name : {"1.png", "2.png"}) {
      file.Put(name + "/keypoints", keypoints);
      file.Put(name + "/descriptors", Eigen::MatrixXd::Identity(12, 12));
    }
  });
  REQUIRE(PrepareSets(request, stop));
  const Problem problem = CorrespondenceScene(folder.File("pairs/room")).Read(0).problem;
  REQUIRE(problem.points.rows() == 12);
  CHECK(problem.points.leftCols(2).isApprox(keypoints));
  CHECK(problem.points.rightCols(2).isApprox(keypoints));
}

TEST_CASE("a set that is converted needs no format, what cannot be converted is named") {
  const TemporaryFolder folder;
  MakeFolder(folder.File("data/rooms"));
  WriteFileAtomically(folder.File("data/rooms/lsd_lines_0000.csv"),
                      "point1_x point1_y point2_x point2_y\n10.5 20.25 30 40\n");
  WriteFileAtomically(folder.File("data/rooms/vps_0000.csv"), "X Y\n100 200\n");
  WriteFileAtomically(folder.File("sets.yaml"), "sets: [{name: rooms, input: [rooms], convert: nyu_vp, output: " +
                                                    folder.File("segments") + "}]\n");
  SetsRequest request;
  request.config = folder.File("sets.yaml");
  request.data = folder.File("data");
  const std::atomic<bool> stop{false};
  if (!PreparedByConverter(request, stop)) return;
  CHECK(ReadSegments(folder.File("segments/nyu_vp_train/segments.h5")).size() == 1);
  WriteFileAtomically(folder.File("data/rooms/vps_0000.csv"), "X Z\n100 200\n");
  CHECK_THROWS_WITH(PrepareSets(request, stop), Contains("vps_0000.csv:1: there is no column Y"));
}

TEST_CASE("regression: a set's calibration is the converter's, not the converted model's as well") {
  const TemporaryFolder folder;
  MakeFolder(folder.File("data/room"));
  for (const std::string name : {"0", "1"}) {
    WriteImage(folder.File("data/room/" + name + ".color.png"), cv::Mat(240, 320, CV_8U, cv::Scalar(90)));
    WriteFileAtomically(folder.File("data/room/" + name + ".pose.txt"),
                        "1 0 0 " + name + "\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  }
  WriteFileAtomically(
      folder.File("sets.yaml"),
      "sets: [{name: room, input: [room], convert: poses, format: colmap, scene: regression_room, focal: 300, "
      "center: [160, 120], output: " +
          folder.File("pairs") + "}]\n");
  SetsRequest request;
  request.config = folder.File("sets.yaml");
  request.data = folder.File("data");
  const std::atomic<bool> stop{false};
  if (!PreparedByConverter(request, stop)) return;
  std::filesystem::remove_all("runs/converted/regression_room");
  CHECK(CorrespondenceScene(folder.File("pairs/regression_room")).size() == 1);
}

TEST_CASE("mistakes in a list of sets name the file, the line and the nearest key") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    WriteFileAtomically(folder.File("sets.yaml"), text);
    return ReadImageSets(folder.File("sets.yaml"));
  };
  CHECK_THROWS_WITH(read("sets:\n  - {name: a, inputs: [a]}\n"), Contains("sets.yaml:2") && Contains("'input'"));
  CHECK_THROWS_WITH(read("sets:\n  - {name: a, input: [a], format: colmapp}\n"), Contains("'colmap'"));
  CHECK_THROWS_WITH(read("sets: []\n"), Contains("a list of image sets"));
}

TEST_CASE("the shipped sets can be read, and none of what is asked for is an error") {
  const TemporaryFolder folder;
  SetsRequest request;
  request.config = DIFFSAC_SOURCE_DIR "/configs/sets.yaml";
  request.data = folder.path();
  const std::vector<ImageSet> sets = ReadImageSets(request.config);
  CHECK(sets.size() > 28);
  for (const ImageSet& set : sets) {
    INFO(set.name);
    const std::string list = set.pairs.choice.pairs_file, file = list.substr(0, list.find('#'));
    REQUIRE(std::filesystem::exists(std::string(DIFFSAC_SOURCE_DIR "/") + file));
    if (!list.empty())
      CHECK_THAT(ReadTextFile(std::string(DIFFSAC_SOURCE_DIR "/") + file),
                 Contains("\n[" + list.substr(file.size() + 1) + "]\n"));
  }
  const std::atomic<bool> stop{false};
  CHECK_THROWS_WITH(PrepareSets(request, stop), Contains("none of the sets"));
  request.only = {"nobody"};
  CHECK(PrepareSets(request, stop));
}

}  // namespace
}  // namespace diffsac
