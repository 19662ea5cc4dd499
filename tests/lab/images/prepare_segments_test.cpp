#include "lab/images/vanishing_text.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/errors.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/files/files.h"
#include "lab/ground_truth/task_truth.h"
#include "lab/images/exif_test_util.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

/// A white room with lines towards (200, 100), on 320 × 240 pixels.
void WriteLines(const std::string& path) {
  cv::Mat image(240, 320, CV_8U, cv::Scalar(255));
  for (const auto& [x, y] : {std::pair{10, 20}, {15, 200}, {40, 230}, {310, 230}, {300, 15}})
    cv::line(image, {x, y}, {(x + 200) / 2, (y + 100) / 2}, cv::Scalar(0), 3);
  cv::imwrite(path, image);
}

}  // namespace

TEST_CASE("segments of a photograph lie along its lines, longest first") {
  const TemporaryFolder folder;
  WriteLines(folder / "room.png");
  const Photograph photograph = ReadPhotograph(folder / "room.png", {});
  CHECK_FALSE(photograph.K.has_value());
  const ImageSegments image = DetectSegments(photograph.gray, 0);
  CHECK(image.size == ImageSize{320, 240});
  const PointMatrix& segments = image.segments;
  REQUIRE(segments.rows() >= 5);
  double last = 1e9;
  for (Eigen::Index i = 0; i < 5; ++i) {
    CHECK(VanishingPoint::Residual({200, 100, 1}, segments.data() + 4 * i) < 0.05);
    const double length = (segments.row(i).tail<2>() - segments.row(i).head<2>()).norm();
    CHECK(length <= last);
    last = length;
  }
  const auto half = DetectSegments(cv::imread(folder / "room.png", cv::IMREAD_GRAYSCALE), 160);
  REQUIRE(half.segments.rows() >= 5);
  CHECK(half.size == ImageSize{320, 240});
  for (Eigen::Index i = 0; i < 5; ++i)
    CHECK(VanishingPoint::Residual({200, 100, 1}, half.segments.data() + 4 * i) < 0.1);
}

TEST_CASE("a photograph is upright and has EXIF's focal length, unless a calibration is given") {
  const TemporaryFolder folder;
  const std::string path = folder / "portrait.jpg";
  cv::imwrite(path, cv::Mat(240, 320, CV_8U, cv::Scalar(255)));
  ExifBytes exif;
  exif.shorts[0xA405] = 43;  // FocalLengthIn35mmFilm
  WriteRaw(path, WithExif(ReadFile(path), exif.ToString()));
  const Photograph plain = ReadPhotograph(path, {});
  CHECK(plain.gray.cols == 320);
  REQUIRE(plain.K);
  CHECK(plain.exif);
  CHECK((*plain.K)(0, 0) == Approx(43 / 43.26661531 * 400));
  CHECK((*plain.K)(0, 2) == 159.5);
  GivenCalibration given;
  given.focal = 300.0;
  const Photograph focal = ReadPhotograph(path, given);
  CHECK_FALSE(focal.exif);
  CHECK(*focal.K == (Eigen::Matrix3d() << 300, 0, 159.5, 0, 300, 119.5, 0, 0, 1).finished());
  given.center = {100.0, 90.0};
  CHECK((*ReadPhotograph(path, given).K)(1, 2) == 90.0);
  given.focal = 0.0;
  CHECK(Has(ErrorOf([&] { ReadPhotograph(path, given); }), "positive --focal"));
}

TEST_CASE("the orientation flag turns an image, but not one that a calibration is of") {
  const TemporaryFolder folder;
  const std::string path = folder / "turned.jpg";
  cv::imwrite(path, cv::Mat(240, 320, CV_8U, cv::Scalar(255)));
  // A directory of one field, Orientation, 6: turned by 90 degrees.
  const std::string exif("II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0", 26);
  WriteRaw(path, WithExif(ReadFile(path), exif));
  CHECK(ReadPhotograph(path, {}).gray.size() == cv::Size(240, 320));
  GivenCalibration given;
  given.focal = 300.0;
  given.center = {160.0, 120.0};
  CHECK(ReadPhotograph(path, given).gray.size() == cv::Size(320, 240));
}

TEST_CASE("the dataset of vanishing points labels segments by the nearest, and gives K only where it is told to") {
  const TemporaryFolder folder;
  ImageSegments image{"a", PointMatrix(4, 4), {{1000.0, 100.0, 1.0}, {0.0, 1.0, 0.0}}, {}, {640, 480}};
  image.segments << 0, 100, 50, 100, 10, 0, 10, 60, 20, 10, 20.1, 90, 0, 0, 40, 40;
  image.K = (Eigen::Matrix3d() << 500, 0, 320, 0, 500, 240, 0, 0, 1).finished();
  fs::create_directories(folder / "scene");
  WriteSegments(folder / "scene/segments.h5", {image});
  const auto example = [&](const std::string& more) {
    const std::string yaml = "{type: vanishing_points, paths: ['" + folder.path() + "']" + more + "}";
    return MakeDataset(ConfigFromYaml(yaml, "a.yaml"), 1)->Get(0);
  };
  const Example plain = example("");
  CHECK(plain.id == "scene/a");
  CHECK_FALSE(plain.problem.cameras.has_value());
  // Two segments are of the second point, which comes first then.
  CHECK(plain.truth.assignment == std::vector<std::int32_t>{2, 1, 1, 0});
  CHECK((VanishingPointTask::PixelPoint(plain.truth.instances[1], plain.problem) -
         Eigen::Vector3d(1000, 100, 1).normalized())
            .norm() < 1e-9);
  const Example calibrated = example(", calibrated: true, min_length_px: 55");
  CHECK(calibrated.problem.cameras->K1 == *image.K);
  CHECK(calibrated.problem.points.rows() == 3);
  CHECK(
      TruthOf(Task::kVanishingPoint)
          .instance_angle(calibrated.truth.instances[0], calibrated.truth.instances[1], calibrated) ==
      Approx(TruthOf(Task::kVanishingPoint).instance_angle(plain.truth.instances[0], plain.truth.instances[1], plain)));
  CHECK(Has(ErrorOf([&] { example(", paths: []"); }), "paths"));
}

TEST_CASE("a damaged file of segments is named with its object") {
  const TemporaryFolder folder;
  ImageSegments image{"a", PointMatrix::Zero(2, 4), {{0.0, 0.0, 0.0}}, {}, {}};
  WriteSegments(folder / "segments.h5", {image});
  CHECK(Has(ErrorOf([&] { ReadSegments(folder / "segments.h5"); }), "segments.h5:/a/vanishing_points"));
  WriteRaw(folder / "segments.h5", "");
  CHECK(Has(ErrorOf([&] { ReadSegments(folder / "segments.h5"); }), "segments.h5"));
}

}  // namespace diffsac
