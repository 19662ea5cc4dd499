#include "lab/data/modelnet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "core/errors.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/depth_buffer.h"
#include "lab/data/example_test_util.h"
#include "lab/data/off_mesh.h"

namespace diffsac {
namespace {

void AppendBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high, TriangleMesh* mesh) {
  const int base = static_cast<int>(mesh->vertices.size());
  for (int k = 0; k < 8; ++k)
    mesh->vertices.emplace_back(k & 1 ? high[0] : low[0], k & 2 ? high[1] : low[1], k & 4 ? high[2] : low[2]);
  constexpr int kFaces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
  for (const auto& f : kFaces) {
    mesh->triangles.push_back({base + f[0], base + f[1], base + f[2]});
    mesh->triangles.push_back({base + f[0], base + f[2], base + f[3]});
  }
}

// Three boxes that hide one another.
TriangleMesh Boxes() {
  TriangleMesh mesh;
  AppendBox({-1, -1, -1}, {1, 1, -0.2}, &mesh);
  AppendBox({-0.3, -0.3, 0.1}, {0.3, 0.5, 0.9}, &mesh);
  AppendBox({0.5, -0.9, 0.0}, {0.9, -0.4, 1.0}, &mesh);
  return mesh;
}

std::string OffText(const TriangleMesh& mesh) {
  std::ostringstream text;
  text.precision(17);
  text << "OFF" << mesh.vertices.size() << " " << mesh.triangles.size() << " 0\r\n";
  for (const auto& v : mesh.vertices) text << v[0] << " " << v[1] << " " << v[2] << "\r\n";
  for (const auto& t : mesh.triangles) text << "3 " << t[0] << " " << t[1] << " " << t[2] << "\r\n";
  return text.str();
}

// Where the ray from `start` to `end` first meets the mesh, as a share of the way; beyond 1 where it does not before
// (Möller and Trumbore, 1997).
double FirstHit(const TriangleMesh& mesh, const Eigen::Vector3d& start, const Eigen::Vector3d& end) {
  const Eigen::Vector3d way = end - start;
  double nearest = 2.0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]], u = mesh.vertices[t[1]] - a, v = mesh.vertices[t[2]] - a;
    const Eigen::Vector3d p = way.cross(v);
    const double det = u.dot(p);
    if (std::abs(det) < 1e-14) continue;
    const Eigen::Vector3d s = start - a, q = s.cross(u);
    const double b1 = s.dot(p) / det, b2 = way.dot(q) / det, at = v.dot(q) / det;
    if (b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0 && at > 0.0) nearest = std::min(nearest, at);
  }
  return nearest;
}

VirtualCamera Camera() {
  VirtualCamera camera;
  camera.size = {640, 480};
  camera.K << 600, 0, 320, 0, 600, 240, 0, 0, 1;
  return camera;
}

// The folder of the development meshes, or "" after saying that the test is skipped.
std::string SharedMeshes() {
  const std::string root = std::string(DIFFSAC_SHARED_DATA) + "/modelnet_off";
  if (std::filesystem::is_directory(root)) return root;
  WARN("skipped: no folder " << root);
  return "";
}

}  // namespace

TEST_CASE("the depth buffer agrees with rays about what is seen") {
  const TriangleMesh mesh = InUnitSphere(Boxes());
  Rng rng(3);
  int seen = 0, agreed = 0, total = 0;
  for (int view = 0; view < 6; ++view) {
    const Eigen::Vector3d position = 3.0 * RandomDirection(rng);
    RigidMotion pose;
    pose.rotation = Eigen::Quaterniond::FromTwoVectors(-position, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    pose.translation = -(pose.rotation * position);
    const DepthBuffer buffer(mesh, Camera(), pose);
    for (int i = 0; i < 500; ++i) {
      const int triangle = static_cast<int>(rng.Below(mesh.triangles.size()));
      double s = rng.Uniform(), t = rng.Uniform();
      if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
      const auto& c = mesh.triangles[triangle];
      const Eigen::Vector3d a = mesh.vertices[c[0]];
      const Eigen::Vector3d point = a + s * (mesh.vertices[c[1]] - a) + t * (mesh.vertices[c[2]] - a);
      const bool by_ray = FirstHit(mesh, position, point) > 1.0 - 1e-6;
      const bool by_buffer = buffer.Sees(point, triangle, 0.01);
      seen += by_buffer;
      agreed += by_ray == by_buffer;
      ++total;
    }
  }
  CHECK(agreed >= 0.98 * total);
  CHECK((seen > 0.2 * total && seen < 0.8 * total));
}

TEST_CASE("the depth buffer holds depths and nothing where nothing is") {
  TriangleMesh wall;
  wall.vertices = {{-1, -1, 5}, {1, -1, 5}, {1, 1, 5}, {-1, 1, 5}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  const DepthBuffer buffer(wall, Camera(), {});
  CHECK(buffer.DepthAt(320, 240) == Approx(5.0));
  CHECK(std::isinf(buffer.DepthAt(0, 0)));
  // 600 px · 1 / 5 = 120 px around the middle.
  CHECK(buffer.DepthAt(200, 240) == Approx(5.0));
  CHECK(std::isinf(buffer.DepthAt(199, 240)));
  CHECK(buffer.Sees({0.0, 0.0, 5.0}, 0, 0.0));
  CHECK(!buffer.Sees({0.0, 0.1, 5.5}, 7, 0.1));
  CHECK(buffer.Sees({0.0, 0.1, 5.5}, 7, 0.6));
  CHECK(!buffer.Sees({0.0, 0.0, -5.0}, 0, 1.0));
  CHECK(!buffer.Sees({9.0, 0.0, 5.0}, 0, 1.0));
}

TEST_CASE("the depth buffer draws a triangle that holds the centre of one pixel alone") {
  // Pixel (400, 100), whose centre is at (400.5, 100.5), at depth 2.
  const auto at = [](double x, double y) { return Eigen::Vector3d((x - 320.0) / 300.0, (y - 240.0) / 300.0, 2.0); };
  for (const double size : {0.3, 0.7}) {
    TriangleMesh speck;
    speck.vertices = {at(400.5 - size, 100.5 - size), at(400.5 + size, 100.5 - size), at(400.5, 100.5 + size)};
    speck.triangles = {{0, 1, 2}};
    const DepthBuffer buffer(speck, Camera(), {});
    int drawn = 0;
    for (int y = 98; y < 103; ++y)
      for (int x = 398; x < 403; ++x) drawn += std::isfinite(buffer.DepthAt(x, y));
    CHECK(drawn == 1);
    CHECK(buffer.DepthAt(400, 100) == Approx(2.0));
  }
}

TEST_CASE("the depth buffer draws nothing beyond the image's borders, nor on the other side") {
  // Rectangles at depth 2 that reach over one border each.
  const auto drawn = [](double left, double top, double right, double bottom) {
    const auto at = [](double x, double y) { return Eigen::Vector3d((x - 320.0) / 300.0, (y - 240.0) / 300.0, 2.0); };
    TriangleMesh sheet;
    sheet.vertices = {at(left, top), at(right, top), at(right, bottom), at(left, bottom)};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
    const DepthBuffer buffer(sheet, Camera(), {});
    int wrong = 0;
    for (int y = 0; y < 480; ++y)
      for (int x = 0; x < 640; ++x) {
        const bool inside = x + 0.5 > left && x + 0.5 < right && y + 0.5 > top && y + 0.5 < bottom;
        wrong += std::isfinite(buffer.DepthAt(x, y)) != inside;
      }
    return wrong;
  };
  CHECK(drawn(600.2, 100.2, 700.2, 200.3) == 0);
  CHECK(drawn(-50.2, 100.2, 20.7, 200.3) == 0);
  CHECK(drawn(100.2, -50.2, 200.3, 10.6) == 0);
  CHECK(drawn(100.2, 400.4, 200.3, 600.2) == 0);
  CHECK(drawn(100.2, 100.8, 200.7, 200.2) == 0);
}

TEST_CASE("modelnet views: exact points fit the truth, are seen by both, and come in the asked numbers") {
  const TemporaryFolder folder;
  const TriangleMesh mesh = Boxes();
  WriteRaw(folder / "boxes.off", OffText(mesh));
  for (const Task task : {Task::kFundamental, Task::kEssential}) {
    ModelnetOptions options;
    options.paths = {folder.path()};
    options.task = task;
    options.matches.noise_px = 0.0;
    const auto dataset = MakeModelnet(options, 3);
    CHECK(dataset->task() == task);
    for (int index = 0; index < 10; ++index) {
      const Example example = dataset->Get(index);
      const Problem& problem = example.problem;
      CHECK(CheckProblem(problem) == Status::kOk);
      CHECK(problem.points.rows() == 200);
      CHECK(CountInliers(example) >= 80);
      CHECK(CountInliers(example) <= 180);
      CHECK(problem.inlier_threshold == 4.0);
      CHECK(problem.size1 == ImageSize{640, 480});
      CHECK(problem.snn_ratio.size() == 0);
      const CameraPair& cameras = *problem.cameras;
      const PointMatrix normalized = NormalizedCoordinates(problem.points, cameras.K1, cameras.K2);
      const PointMatrix& points = problem.task == Task::kEssential ? normalized : problem.points;
      for (Eigen::Index i = 0; i < 200; ++i)
        if (example.truth.inliers[i])
          CHECK(Fundamental::Residual(Matrix3Parameters(example.truth.model), points.data() + 4 * i) < 1e-6);
      const Eigen::Matrix3d essential =
          problem.task == Task::kEssential
              ? AsMatrix(example.truth.model)
              : EssentialFromFundamental(AsMatrix(example.truth.model), cameras.K1, cameras.K2);
      const PoseChoice pose = ChoosePose(essential, normalized, example.truth.inliers);
      CHECK(pose.in_front == CountInliers(example));
      CHECK(RotationAngleDegrees(pose.pose.rotation, example.truth.pose->rotation) < 1e-5);
      CHECK(DirectionAngleDegrees(pose.pose.translation, example.truth.pose->translation) < 1e-5);
      for (Eigen::Index i = 0; i < 200; ++i)
        if (example.truth.inliers[i]) CHECK(InFront(*example.truth.pose, normalized.data() + 4 * i));
    }
  }
}

// The image of a plane keeps its orientation where both cameras are on the same side of it: on a box, where both see
// it.
TEST_CASE("modelnet views: the first camera sees each match as well as the second") {
  const TemporaryFolder folder;
  TriangleMesh box;
  AppendBox({-1, -1, -1}, {1, 1, 1}, &box);
  WriteRaw(folder / "box.off", OffText(box));
  ModelnetOptions options;
  options.paths = {folder.path()};
  options.matches.noise_px = 0.0;
  options.matches.num_points = 400;
  const auto dataset = MakeModelnet(options, 3);
  int kept = 0, all = 0;
  for (int index = 0; index < 5; ++index) {
    const Example example = dataset->Get(index);
    std::vector<Eigen::RowVector4d> seen;
    for (Eigen::Index i = 0; i < 400; ++i)
      if (example.truth.inliers[i]) seen.push_back(example.problem.points.row(i));
    for (const Eigen::RowVector4d& match : seen) {
      const auto nearer = [&](const auto& a, const auto& b) {
        return (a - match).template head<2>().squaredNorm() < (b - match).template head<2>().squaredNorm();
      };
      std::vector<Eigen::RowVector4d> nearest = seen;
      std::partial_sort(nearest.begin(), nearest.begin() + 3, nearest.end(), nearer);
      const Eigen::RowVector4d u = nearest[1] - match, v = nearest[2] - match;
      kept += (u[0] * v[1] - u[1] * v[0] > 0.0) == (u[2] * v[3] - u[3] * v[2] > 0.0);
      ++all;
    }
  }
  CHECK(kept > 0.9 * all);
}

TEST_CASE("modelnet views do not depend on the mesh's scale, and meshes are chosen by their folder") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "box/train");
  std::filesystem::create_directories(folder / "box/test");
  WriteRaw(folder / "box/train/a.off", OffText(Boxes()));
  TriangleMesh large = Boxes();
  for (auto& vertex : large.vertices) vertex *= 4096.0;
  WriteRaw(folder / "box/test/b.off", OffText(large));
  ModelnetOptions options;
  options.paths = {folder.path()};
  options.cached_meshes = 1;
  CHECK(Has(MakeModelnet(options, 5)->Get(0).id, "0/b"));
  CHECK(Has(MakeModelnet(options, 5)->Get(1).id, "1/a"));
  // The same index with the mesh of another scale: a power of two, so nothing is rounded.
  options.subset = "train";
  const Example small = MakeModelnet(options, 5)->Get(0);
  CHECK(Has(small.id, "/a"));
  options.subset = "test";
  const Example big = MakeModelnet(options, 5)->Get(0);
  CHECK(Has(big.id, "/b"));
  CHECK(big.problem.points == small.problem.points);
  options.subset = "other";
  CHECK(Has(ErrorOf([&] { MakeModelnet(options, 5); }), "subset other"));
}

TEST_CASE("modelnet noise and outliers are as asked") {
  const TemporaryFolder folder;
  WriteRaw(folder / "boxes.off", OffText(Boxes()));
  ModelnetOptions options;
  options.paths = {folder / "boxes.off"};
  options.matches.outlier_ratio = 0.4;
  options.matches.noise_px = 0.7;
  double squares = 0.0;
  int count = 0;
  const auto dataset = MakeModelnet(options, 8);
  for (int index = 0; index < 20; ++index) {
    const Example example = dataset->Get(index);
    CHECK(CountInliers(example) == 120);
    for (Eigen::Index i = 0; i < 200; ++i) {
      if (!example.truth.inliers[i]) continue;
      squares += std::pow(
          Fundamental::Residual(Matrix3Parameters(example.truth.model), example.problem.points.data() + 4 * i), 2);
      ++count;
    }
  }
  CHECK(std::sqrt(squares / count) == Approx(0.7).epsilon(0.06));
}

TEST_CASE("modelnet views: a mesh that cannot be read is named") {
  const TemporaryFolder folder;
  WriteRaw(folder / "broken.off", "OFF\n3 1 0\n0 0 0\n1 0 0\nx 1 0\n3 0 1 2\n");
  ModelnetOptions options;
  options.paths = {folder.path()};
  const auto dataset = MakeModelnet(options, 1);
  CHECK(Has(ErrorOf([&] { dataset->Get(0); }), "broken.off:5"));
}

TEST_CASE("the development meshes give problems") {
  const std::string root = SharedMeshes();
  if (root.empty()) return;
  ModelnetOptions options;
  options.paths = {root};
  const auto dataset = MakeModelnet(options, 2);
  for (int index = 0; index < 12; ++index) {
    const Example example = dataset->Get(index);
    CAPTURE(example.id);
    CHECK(example.problem.points.rows() == 200);
    CHECK(CheckProblem(example.problem) == Status::kOk);
  }
}

// Hidden: prints the times of docs/generators.md. The first round reads the meshes.
TEST_CASE("cost of modelnet views", "[.][cost]") {
  const std::string root = SharedMeshes();
  if (root.empty()) return;
  ModelnetOptions options;
  options.paths = {root};
  const auto dataset = MakeModelnet(options, 1);
  for (int index = 0; index < 36; ++index) {
    const auto start = std::chrono::steady_clock::now();
    const Example example = dataset->Get(index);
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
    std::printf("%s: %.1f ms\n", example.id.c_str(), elapsed.count());
  }
}

}  // namespace diffsac
