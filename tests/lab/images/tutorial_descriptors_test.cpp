#include "lab/images/tutorial_descriptors.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/errors.h"
#include "lab/files/correspondence_files.h"
#include "lab/images/image_test_util.h"
#include "lab/images/prepare_pairs.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

const std::atomic<bool> kNeverStop{false};
constexpr ImageSize kSize{320, 240};

// A scene as the tutorial has it: matches of three views and their images, but neither descriptors nor sizes. Those
// that `pairs` finds are returned.
std::vector<DescriptorMatrix> WriteTutorialScene(const std::string& scene) {
  const cv::Mat texture = Texture(900, 700, 5);
  ImageSource source;
  LensCamera camera;
  camera.K = Calibration(300, 310, 158, 121);
  fs::create_directories(scene + "/images");
  for (int i = 0; i < 3; ++i) {
    const std::string name = "im_" + std::to_string(i), path = scene + "/images/" + name + ".png";
    WriteImage(path, Render(texture, camera, NearbyPose(i), kSize));
    source.images.push_back({name, path, camera, NearbyPose(i)});
  }
  source.scenes.push_back({fs::path(scene).filename().string(), AllPairs(3)});
  PrepareOptions options;
  options.descriptors = true;
  PreparePairs(source, options, fs::path(scene).parent_path().string(), kNeverStop);
  CorrespondenceOptions with;
  with.descriptors = true;
  std::vector<DescriptorMatrix> descriptors;
  const CorrespondenceScene written(scene, with);
  for (int i = 0; i < 3; ++i) descriptors.push_back(written.Read(i).problem.descriptors);
  fs::remove(scene + "/descriptors.h5");
  fs::remove(scene + "/sizes.h5");
  return descriptors;
}

double ShareAlike(const DescriptorMatrix& a, const DescriptorMatrix& b) {
  REQUIRE(a.rows() == b.rows());
  REQUIRE(a.cols() == b.cols());
  return ((a - b).rowwise().norm().array() < 1e-5f).cast<double>().mean();
}

}  // namespace

TEST_CASE("tutorial: descriptors come back from the images") {
  TemporaryFolder folder;
  const std::string scene = folder / "val/scene";
  const std::vector<DescriptorMatrix> expected = WriteTutorialScene(scene);
  TutorialRequest request;
  request.input = scene;
  TutorialResult result = AddTutorialDescriptors(request, kNeverStop);
  CHECK((result.finished && !result.already_there));
  CHECK((result.pairs == 3 && result.images == 3));
  CHECK(result.places > 200);
  CHECK(result.found == result.places);
  CorrespondenceOptions with;
  with.descriptors = true;
  {
    const CorrespondenceScene read(scene, with);
    for (int i = 0; i < 3; ++i) {
      const Problem problem = read.Read(i).problem;
      CHECK(problem.size1 == kSize);
      // A place with two orientations has two descriptors, of which the strongest is taken.
      CHECK(ShareAlike(problem.descriptors, expected[i]) > 0.7);
    }
  }
  CHECK(AddTutorialDescriptors(request, kNeverStop).already_there);

  // Places half-way between keypoints and pixels far away are described as well.
  Example moved;
  {
    const CorrespondenceScene read(scene);
    CorrespondenceSet set;
    for (int i = 0; i < 3; ++i) set.pairs.push_back(read.Read(i));
    set.pairs[0].problem.points.row(0) << -300.5, 20.25, 100.5, 5000.0;
    set.pairs[0].problem.points.row(1).array() += 0.3;
    for (const char* name : {"im_0", "im_1", "im_2"}) set.cameras[name] = {};
    WriteCorrespondences(scene, set);
    moved = read.Read(0);
  }
  request.features.kind = FeatureKind::kSift;
  result = AddTutorialDescriptors(request, kNeverStop);
  CHECK(result.found >= result.places - 4);
  CHECK(result.found < result.places);
  const DescriptorMatrix rows = CorrespondenceScene(scene, with).Read(0).problem.descriptors;
  CHECK((rows.leftCols(128).rowwise().norm().array() - 1.0f).abs().maxCoeff() < 1e-5f);
  CHECK(ShareAlike(rows, expected[0]) < 0.1);
}

TEST_CASE("tutorial: a request to stop writes nothing, and mistakes are named") {
  TemporaryFolder folder;
  const std::string scene = folder / "val/scene";
  WriteTutorialScene(scene);
  TutorialRequest request;
  request.input = scene;
  const std::atomic<bool> stop{true};
  CHECK(!AddTutorialDescriptors(request, stop).finished);
  CHECK(!fs::exists(scene + "/descriptors.h5"));

  const auto error = [&](const TutorialRequest& r) { return ErrorOf([&] { AddTutorialDescriptors(r, kNeverStop); }); };
  request.images = folder / "nowhere";
  CHECK(Has(error(request), "nowhere: no such folder"));
  request.images = "";
  request.features.kind = FeatureKind::kOrb;
  CHECK(Has(error(request), "sift or rootsift"));
  request.features.kind = FeatureKind::kSift;
  WriteRaw(scene + "/images/im_1.png", "no image");
  CHECK(Has(error(request), "im_1.png"));
  fs::remove(scene + "/images/im_2.png");
  CHECK(Has(error(request), "there is no image im_2"));
  request.input = folder / "nowhere";
  CHECK(Has(error(request), "nowhere"));
}

}  // namespace diffsac
