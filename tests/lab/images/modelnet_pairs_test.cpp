#include "lab/images/modelnet_pairs.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/errors.h"
#include "lab/files/correspondence_files.h"
#include "lab/truth/pair_truth.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

const std::atomic<bool> kNeverStop{false};

}  // namespace

TEST_CASE("modelnet: virtual views as files, with what is true of them") {
  TemporaryFolder folder;
  fs::create_directories(folder / "meshes/train");
  // A tetrahedron and a box without its lid.
  const std::string tetrahedron = "OFF4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n";
  WriteRaw(folder / "meshes/train/tetra-1.off", tetrahedron);
  WriteRaw(folder / "meshes/broken.off", "OFF\n3 1 0\n0 0 0\n");
  ModelnetRequest request;
  request.input = folder / "meshes";
  request.output = folder / "out";
  request.pairs = 6;
  request.points = 60;
  request.outlier_ratio = {0.25};
  request.threads = 2;
  PrepareResult result = WriteModelnetPairs(request, kNeverStop);
  CHECK(result.written == 1);
  REQUIRE(result.left_out.size() == 1);
  CHECK(Has(result.left_out[0], "broken.off"));
  const CorrespondenceScene scene(folder / "out/modelnet40");
  REQUIRE(scene.size() == 3);
  CHECK(Has(scene.pairs()[0], "tetra_1_1-"));
  for (int i = 0; i < 3; ++i) {
    const Example pair = scene.Read(i);
    REQUIRE(pair.problem.points.rows() == 60);
    CHECK(pair.problem.cameras);
    CHECK(pair.problem.size1.width == 640);
    const Eigen::VectorXd distances = TruthDistances(pair.problem, pair.truth);
    int inliers = 0;
    for (Eigen::Index k = 0; k < 60; ++k) {
      if (pair.truth.assignment[k] == 0) continue;
      inliers += 1;
      CHECK(distances[k] < 1.5);
    }
    CHECK(inliers == 45);
  }
  CHECK(WriteModelnetPairs(request, kNeverStop).already_there == 1);
  request.overwrite = true;
  request.threads = 1;
  const PointMatrix before = scene.Read(2).problem.points;
  REQUIRE(WriteModelnetPairs(request, kNeverStop).written == 1);
  CHECK(CorrespondenceScene(folder / "out/modelnet40").Read(2).problem.points == before);
  request.subset = "train";
  REQUIRE(WriteModelnetPairs(request, kNeverStop).left_out.empty());
  CHECK(CorrespondenceScene(folder / "out/modelnet40").size() == 6);
  const std::atomic<bool> stop{true};
  request.scene = "stopped";
  CHECK(!WriteModelnetPairs(request, stop).finished);
  CHECK(!fs::exists(folder / "out/stopped"));

  const auto error = [&](auto change) {
    ModelnetRequest wrong = request;
    change(wrong);
    return ErrorOf([&] { WriteModelnetPairs(wrong, kNeverStop); });
  };
  CHECK(Has(error([](auto& r) { r.pairs = 0; }), "--pairs"));
  CHECK(Has(error([](auto& r) { r.outlier_ratio = {1.0}; }), "--outlier-ratio"));
  CHECK(Has(error([](auto& r) { r.outlier_ratio = {0.5, 0.1}; }), "--outlier-ratio"));
  CHECK(Has(error([](auto& r) { r.outlier_ratio = {}; }), "--outlier-ratio"));
  CHECK(Has(error([&](auto& r) { r.input = folder / "nowhere"; }), "nowhere"));
  CHECK(Has(error([&](auto& r) { r.subset = "test"; }), "test"));
  CHECK(Has(error([&](auto& r) { r.input = folder / "meshes/broken.off", r.subset = ""; }), "broken.off"));
}

}  // namespace diffsac
