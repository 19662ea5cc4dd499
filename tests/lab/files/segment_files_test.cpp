#include "lab/files/segment_files.h"

#include <H5Cpp.h>

#include <catch2/catch.hpp>
#include <mutex>

#include "core/temporary_folder.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

ImageSegments Image(const std::string& name) {
  ImageSegments image{name, PointMatrix(2, 4), {}, {}, {640, 480}};
  image.segments << 1, 2, 3, 4, 5.5, 6.5, 7.5, 8.5;
  return image;
}

VanishingPointsEstimate Found() {
  VanishingPointsEstimate estimate;
  estimate.status = Status::kOk;
  estimate.points = {{0.6, 0.0, 0.8}, {0.0, 1.0, 0.0}};
  estimate.values = {0.9, 0.4};
  estimate.assignment = {2, 0};
  return estimate;
}

}  // namespace

TEST_CASE("a file of segments with what was estimated is one of segments, and has all of it") {
  const TemporaryFolder folder;
  const std::string path = folder.File("all.h5");
  VanishingPointsEstimate with_camera = Found(), nothing;
  with_camera.K = Eigen::Matrix3d{{500, 0, 320}, {0, 500, 240}, {0, 0, 1}};
  with_camera.directions = {{0.0, 0.0, 1.0}, {0.0, -1.0, 0.0}};
  with_camera.horizon.emplace().line = {0.0, 1.0, -240.0};
  nothing.status = Status::kTooFewPoints;
  WriteSegments(path, {Image("a"), Image("b"), Image("c")}, {with_camera, Found(), nothing});
  const std::vector<ImageSegments> images = ReadSegments(path);
  REQUIRE(images.size() == 3);
  CHECK(images[1].segments == Image("b").segments);
  CHECK(images[1].size == ImageSize{640, 480});
  // An estimate is no truth.
  CHECK(images[0].vanishing_points.empty());
  CHECK_FALSE(images[0].K);

  const std::lock_guard lock(Hdf5Mutex());
  const H5::H5File file = OpenHdf5(path);
  const H5::Group a = file.openGroup("a/estimate"), b = file.openGroup("b/estimate"), c = file.openGroup("c/estimate");
  const auto numbers = [](const H5::Group& group, const char* name) {
    return ReadNumbers(group.openDataSet(name), name);
  };
  const auto status = [](const H5::Group& group) {
    const H5::Attribute attribute = group.openAttribute("status");
    std::string text;
    attribute.read(attribute.getStrType(), text);
    return text;
  };
  CHECK(status(a) == "ok");
  CHECK(numbers(a, "vanishing_points").shape == std::vector<hsize_t>{2, 3});
  CHECK(numbers(a, "vanishing_points").values == std::vector<double>{0.6, 0.0, 0.8, 0.0, 1.0, 0.0});
  CHECK(numbers(a, "assignment").values == std::vector<double>{2.0, 0.0});
  CHECK(numbers(a, "values").values == std::vector<double>{0.9, 0.4});
  CHECK(numbers(a, "directions").values == std::vector<double>{0.0, 0.0, 1.0, 0.0, -1.0, 0.0});
  CHECK(numbers(a, "K").values == std::vector<double>{500, 0, 320, 0, 500, 240, 0, 0, 1});
  CHECK(numbers(a, "horizon").values == std::vector<double>{0.0, 1.0, -240.0});
  for (const char* name : {"directions", "K", "horizon"}) CHECK_FALSE(b.nameExists(name));
  CHECK(status(c) == "too_few_points");
  CHECK(numbers(c, "vanishing_points").shape == std::vector<hsize_t>{0, 3});
}

}  // namespace diffsac
