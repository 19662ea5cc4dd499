#include "lab/images/estimate_photographs.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>

#include "core/temporary_folder.h"
#include "diffsac/core/random.h"
#include "lab/images/exif_test_util.h"

namespace diffsac {
namespace {

constexpr std::uint16_t kMake = 0x010F, kModel = 0x0110, kFocal = 0x920A, kWidth = 0xA002, kHeight = 0xA003;

std::string Photograph(const TemporaryFolder& folder, const std::string& name, const std::string& model,
                       std::uint32_t focal_mm) {
  std::vector<unsigned char> jpeg;
  cv::imencode(".jpg", cv::Mat(30, 40, CV_8UC1, cv::Scalar(90)), jpeg);
  ExifBytes exif;
  exif.texts = {{kMake, "Maker"}, {kModel, model}};
  exif.shorts = {{kWidth, 40}, {kHeight, 30}};
  exif.rationals = {{kFocal, {focal_mm, 1}}};
  WriteFileAtomically(folder.File(name), WithExif({jpeg.begin(), jpeg.end()}, exif.ToString()));
  return folder.File(name);
}

std::vector<SourceImage> Images(const std::vector<std::string>& paths) {
  std::vector<SourceImage> images;
  for (const std::string& path : paths) images.push_back({path, path, {}, {}});
  return images;
}

/// What a pair says of a length of 1000 px, drawn about `said`, when 900 px within 43 % was known before.
FocalsOfPair Saying(std::array<int, 2> images, double said1, double said2, Rng& rng) {
  constexpr double kSigma = 0.1, kPrior = 0.43;
  FocalsOfPair pair{images, {}};
  for (int k = 0; k < 2; ++k) {
    const double f = (k == 0 ? said1 : said2) * std::exp(kSigma * rng.Normal());
    pair.focal.focal_px[k] = f;
    pair.focal.low_px[k] = f * std::exp(-kSigma);
    pair.focal.high_px[k] = f * std::exp(kSigma);
    pair.focal.observable[k] = true;
    pair.focal.prior_focal_px[k] = 900.0;
    pair.focal.prior_log_sigma[k] = kPrior;
  }
  return pair;
}

/// All of one size, of which EXIF data say nothing.
PhotographCameras UnknownCameras(int images) {
  PhotographCameras cameras;
  for (int i = 0; i < images; ++i) cameras.camera.push_back(i);
  cameras.hints.resize(static_cast<std::size_t>(images));
  cameras.from.assign(static_cast<std::size_t>(images), FocalSource::kPrior);
  cameras.alike.assign(static_cast<std::size_t>(images), 0);
  return cameras;
}

/// Pairs of six images whose lengths are `focal` of each image: two views know the ratio far better than the lengths.
PhotographCameras Joined(const std::function<double(int)>& focal, PhotographCameras cameras) {
  Rng rng(5);
  std::vector<FocalsOfPair> pairs;
  for (int i = 0; i < 6; ++i)
    for (int j = i + 1; j < 6; ++j) {
      const double common = std::exp(0.2 * rng.Normal()), off = std::exp(0.03 * rng.Normal());
      FocalEstimate& said = pairs.emplace_back(Saying({i, j}, 1000.0, 1000.0, rng)).focal;
      said.log_correlation = 0.98;
      for (int k = 0; k < 2; ++k) {
        // One of the pairs is wrong.
        said.focal_px[k] =
            common * (pairs.size() == 4 ? 400.0 + 800.0 * k : focal(pairs.back().images[k]) * (k == 0 ? 1.0 : off));
        said.low_px[k] = said.focal_px[k] * std::exp(-0.2);
        said.high_px[k] = said.focal_px[k] * std::exp(0.2);
      }
    }
  JoinCameras(pairs, &cameras);
  return cameras;
}

PhotographCameras TwoCameras(int images) {
  PhotographCameras cameras;
  for (int i = 0; i < images; ++i) cameras.camera.push_back(i % 2);
  cameras.hints.resize(static_cast<std::size_t>(images));
  cameras.from.assign(static_cast<std::size_t>(images), FocalSource::kPrior);
  return cameras;
}

}  // namespace

TEST_CASE("photographs are of one camera where EXIF data say all the same, or who took them does") {
  const TemporaryFolder folder;
  const auto images =
      Images({Photograph(folder, "a.jpg", "Model One", 35), Photograph(folder, "b.jpg", "Model One", 35),
              Photograph(folder, "c.jpg", "Model One", 50), Photograph(folder, "d.jpg", "Model Two", 35),
              folder.File("none"), folder.File("neither")});
  const PhotographCameras cameras = CamerasOfPhotographs(images, {}, false);
  CHECK(cameras.camera == std::vector<int>{0, 0, 1, 2, 3, 4});
  CHECK_FALSE(cameras.IsOne());
  CHECK(CamerasOfPhotographs({images[0], images[1]}, {}, false).IsOne());
  CHECK_FALSE(CamerasOfPhotographs({images[4], images[5]}, {}, false).IsOne());
  CHECK(CamerasOfPhotographs(images, {}, true).IsOne());
  // Reduced, a photograph has another focal length; turned by a quarter it has not.
  CHECK(CamerasOfPhotographs({images[0], images[1]}, {{40, 30}, {20, 15}}, false).camera == std::vector<int>{0, 1});
  CHECK(CamerasOfPhotographs({images[0], images[1]}, {{40, 30}, {30, 40}}, false).IsOne());
}

TEST_CASE("many pairs know a camera's focal length better than one, some of them wrong") {
  Rng rng(1);
  for (int trial = 0; trial < 5; ++trial) {
    PhotographCameras cameras = TwoCameras(6);
    std::vector<FocalsOfPair> pairs;
    for (int i = 0; i < 6; ++i)
      for (int j = i + 1; j < 6; ++j) {
        const bool wrong = pairs.size() % 5 == 4;
        const auto truth = [&](int image) { return wrong ? 400.0 : cameras.camera[image] == 0 ? 1000.0 : 700.0; };
        pairs.push_back(Saying({i, j}, truth(i), truth(j), rng));
      }
    PoolFocals(pairs, &cameras);
    for (int i = 0; i < 6; ++i) {
      CAPTURE(trial, i);
      const FocalPrior pooled = cameras.hints[i].focal.value();
      CHECK(pooled.focal == Approx(i % 2 == 0 ? 1000.0 : 700.0).epsilon(0.09));
      CHECK(pooled.log_sigma < 0.07);
      CHECK(cameras.from[i] == FocalSource::kPairs);
      CHECK(pooled.focal == cameras.hints[i % 2].focal->focal);
    }
  }
}

TEST_CASE("images of one length have one camera") {
  const auto same = [](int) { return 1000.0; };
  const PhotographCameras one = Joined(same, UnknownCameras(6));
  CHECK(one.IsOne());
  CHECK_FALSE(one.AreDivided());
  PhotographCameras known = UnknownCameras(6);
  known.alike[2] = -1;  // EXIF data tell its camera.
  known.alike[3] = 1;   // Of another size.
  CHECK(Joined(same, known).camera == std::vector<int>{0, 0, 2, 3, 0, 0});
}

TEST_CASE("images of two lengths have two cameras") {
  const auto zoomed = [](int image) { return image % 2 == 0 ? 1000.0 : 1400.0; };
  const PhotographCameras two = Joined(zoomed, UnknownCameras(6));
  CHECK(two.camera == std::vector<int>{0, 1, 0, 1, 0, 1});
  CHECK(two.AreDivided());
}

TEST_CASE("lengths that no pair knows well stay unknown") {
  Rng rng(6);
  FocalsOfPair vague = Saying({0, 1}, 1000.0, 1000.0, rng);
  vague.focal.low_px.fill(1000.0 * std::exp(-0.4));
  vague.focal.high_px.fill(1000.0 * std::exp(0.4));
  PhotographCameras cameras = TwoCameras(2);
  PoolFocals({vague}, &cameras);
  CHECK_FALSE(cameras.hints[0].focal);
  CHECK(cameras.from[0] == FocalSource::kPrior);
}

TEST_CASE("what does not count or knows nothing is not pooled") {
  Rng rng(2);
  FocalsOfPair chance = Saying({0, 1}, 1000, 700, rng), unknown = chance;
  chance.counts = false;
  unknown.focal.observable = {};
  unknown.focal.low_px.fill(900.0 * std::exp(-0.43));
  unknown.focal.high_px.fill(900.0 * std::exp(0.43));
  PhotographCameras cameras = TwoCameras(2);
  PoolFocals({chance, unknown}, &cameras);
  CHECK_FALSE(cameras.hints[0].focal);
  CHECK(cameras.from[1] == FocalSource::kPrior);
}

}  // namespace diffsac
