#include "lab/data/off_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "core/errors.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/example_test_util.h"
#include "lab/data/mesh_surface.h"
#include "lab/data/modelnet_planes.h"

namespace diffsac {
namespace {

constexpr const char* kVertices = "0 0 0\n2 0 0\n2 2 0\n0 2 0\n";
constexpr const char* kFaces = "3 0 1 2\n3 0 2 3\n";

class OffFile {
 public:
  explicit OffFile(const std::string& text) : path_(folder_ / "mesh.off") { WriteRaw(path_, text); }
  TriangleMesh Read() const { return ReadOff(path_); }

 private:
  TemporaryFolder folder_;
  std::string path_;
};

TriangleMesh Parse(const std::string& text) { return OffFile(text).Read(); }
std::string Mistake(const std::string& text) {
  const OffFile file(text);
  return ErrorOf([&] { file.Read(); });
}

std::string WithHeader(const std::string& header) { return header + kVertices + kFaces; }

}  // namespace

TEST_CASE("OFF headers may be glued, spread, commented and end in CR LF") {
  const TriangleMesh plain = Parse(WithHeader("OFF\n4 2 0\n"));
  REQUIRE(plain.vertices.size() == 4);
  REQUIRE(plain.triangles.size() == 2);
  CHECK(plain.vertices[2] == Eigen::Vector3d(2, 2, 0));
  CHECK(plain.triangles[1] == std::array<int, 3>{0, 2, 3});
  std::string crlf;
  for (char c : WithHeader("OFF\n4 2 0\n")) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  for (const std::string& text : {WithHeader("OFF4 2 0\n"), WithHeader("OFF 4 2 0\n"), WithHeader("OFF\n\n4 2\n"),
                                  WithHeader("# made by hand\nOFF # word\n# counts\n4 2 5 # numbers\n"), crlf}) {
    const TriangleMesh mesh = Parse(text);
    CHECK(mesh.vertices == plain.vertices);
    CHECK(mesh.triangles == plain.triangles);
  }
  CHECK(Parse(WithHeader("OFF4 2 0\n") + "rubbish behind the last face is not read").triangles.size() == 2);
}

TEST_CASE("OFF polygons become fans, colours are skipped") {
  const TriangleMesh mesh = Parse(std::string("OFF\n4 2 0\n") + kVertices + "4 0 1 2 3 255 0 0\n3 3 1 0 0.5 0.5 0.5\n");
  REQUIRE(mesh.triangles.size() == 3);
  CHECK(mesh.triangles[0] == std::array<int, 3>{0, 1, 2});
  CHECK(mesh.triangles[1] == std::array<int, 3>{0, 2, 3});
  CHECK(mesh.triangles[2] == std::array<int, 3>{3, 1, 0});
}

TEST_CASE("OFF mistakes name file and line") {
  const auto expect = [](const std::string& text, const std::string& line, const std::string& part) {
    const std::string error = Mistake(text);
    CAPTURE(text, error);
    CHECK(Has(error, "mesh.off:" + line));
    CHECK(Has(error, part));
    CHECK(!Has(error, "\n"));
  };
  expect("PLY\n", "1", "OFF");
  expect("COFF\n4 2 0\n", "1", "OFF");
  expect("", "0", "ends");
  expect("OFF\n", "1", "numbers of vertices");
  expect("OFF\n4\n", "2", "numbers of vertices");
  expect("OFF\n4 -2 0\n", "2", "number of faces");
  expect("OFFx 2 0\n", "1", "'x'");
  expect("OFF\n4 2 0\n0 0 0\n1 0\n", "4", "three coordinates");
  expect("OFF\n4 2 0\n0 0 zero\n", "3", "zero");
  expect("OFF\n4 2 0\n0 nan 0\n", "3", "finite");
  expect("OFF\n999999999 2 0\n0 0 0\n", "3", "vertex 1 of 999999999");
  expect(std::string("OFF\n4 3 0\n") + kVertices + kFaces, "8", "face 2 of 3");
  expect(std::string("OFF\n4 2 0\n") + kVertices + "3 0 1 4\n", "7", "from 0 to 3");
  expect(std::string("OFF\n4 2 0\n") + kVertices + "3 0 1 1.5\n", "7", "1.5");
  expect(std::string("OFF\n4 2 0\n") + kVertices + "3 0 1\n", "7", "3 corners");
  expect(std::string("OFF\n4 2 0\n") + kVertices + "2 0 1\n", "7", "corners");
  CHECK(Has(Mistake(std::string("OFF\n4 1 0\n") + kVertices + "3 0 1 1\n"), "area"));
  CHECK(Has(Mistake("OFF\n0 0 0\n"), "area"));
  CHECK(Has(ErrorOf([] { ReadOff("nowhere.off"); }), "nowhere.off"));
}

TEST_CASE("meshes are moved and scaled into the unit sphere") {
  TriangleMesh mesh = Parse(std::string("OFF\n5 2 0\n") + kVertices + "1000 0 0\n" + kFaces);
  for (double scale : {1e-6, 1.0, 1e6}) {
    TriangleMesh scaled = mesh;
    for (auto& vertex : scaled.vertices) vertex = scale * vertex + Eigen::Vector3d(5, 6, 7);
    const TriangleMesh unit = InUnitSphere(scaled);
    // The fifth vertex belongs to no triangle and does not count.
    CHECK(unit.vertices[0].norm() == Approx(1.0));
    CHECK((unit.vertices[0] + unit.vertices[2]).norm() < 1e-6);
  }
}

namespace {

constexpr int kBoxFaces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};

// Boxes of these sizes beside one another: their lower faces lie on one plane.
std::string Boxes(const std::vector<Eigen::Vector3d>& sizes) {
  std::ostringstream vertices, faces;
  double left = 0.0;
  int base = 0;
  for (const Eigen::Vector3d& size : sizes) {
    for (int k = 0; k < 8; ++k)
      vertices << left + (k & 1 ? size[0] : 0.0) << " " << (k & 2 ? size[1] : 0.0) << " " << (k & 4 ? size[2] : 0.0)
               << "\n";
    for (const auto& f : kBoxFaces)
      faces << "4 " << base + f[0] << " " << base + f[1] << " " << base + f[2] << " " << base + f[3] << "\n";
    base += 8;
    left += size[0] + 1.0;
  }
  return "OFF\n" + std::to_string(base) + " " + std::to_string(base / 8 * 6) + " 0\n" + vertices.str() + faces.str();
}

// A sphere of many small faces, of which none is a structure.
std::string Sphere() {
  constexpr int kAround = 40, kUp = 20;
  std::ostringstream text;
  text << "OFF\n" << kAround * (kUp + 1) << " " << kAround * kUp << " 0\n";
  for (int j = 0; j <= kUp; ++j)
    for (int i = 0; i < kAround; ++i) {
      const double a = 2.0 * M_PI * i / kAround, b = M_PI * j / kUp;
      text << std::sin(b) * std::cos(a) << " " << std::sin(b) * std::sin(a) << " " << std::cos(b) << "\n";
    }
  for (int j = 0; j < kUp; ++j)
    for (int i = 0; i < kAround; ++i) {
      const int next = (i + 1) % kAround;
      text << "4 " << j * kAround + i << " " << j * kAround + next << " " << (j + 1) * kAround + next << " "
           << (j + 1) * kAround + i << "\n";
    }
  return text.str();
}

ModelnetPlanesOptions Of(const std::string& path) {
  ModelnetPlanesOptions options;
  options.paths = {path};
  return options;
}

double Distance(const Example& example, Eigen::Index i, int structure) {
  const ModelParameters& model = example.truth.structures[structure];
  return std::abs(example.problem.points.row(i).dot(model.head<3>()) + model[3]);
}

}  // namespace

TEST_CASE("a mesh's planes hold all faces on them, the largest first") {
  const TemporaryFolder folder;
  WriteRaw(folder / "boxes.off", Boxes({{4, 3, 2}, {2, 3, 1}}));
  const PlanarMesh mesh(folder / "boxes.off");
  // Faces at z = 0 (12 + 6), y = 0 and y = 3 (8 + 2 each), z = 2 (12), four at the sides (6, 6, 3, 3), z = 1 (6).
  std::vector<double> shares;
  for (const MeshPlane& plane : mesh.planes()) shares.push_back(mesh.ShareOf(plane) * 74.0);
  REQUIRE(shares.size() == 9);
  CHECK(std::is_sorted(shares.rbegin(), shares.rend()));
  const std::vector<double> expected = {18, 12, 10, 10, 6, 6, 6, 3, 3};
  for (int k = 0; k < 9; ++k) CHECK(shares[k] == Approx(expected[k]));
  Rng rng(1);
  for (const MeshPlane& plane : mesh.planes())
    for (int i = 0; i < 20; ++i) CHECK(std::abs(plane.normal.dot(mesh.Sample(plane, rng)) + plane.offset) < 1e-9);
}

TEST_CASE("mesh planes: labels, models and inliers agree") {
  const TemporaryFolder folder;
  WriteRaw(folder / "boxes.off", Boxes({{4, 3, 2}, {2, 3, 1}}));
  ModelnetPlanesOptions options = Of(folder.path());
  options.outlier_ratio = 0.4;
  options.max_structures = 4;
  const auto dataset = MakeModelnetPlanes(options, 3);
  for (int index = 0; index < 10; ++index) {
    const Example example = dataset->Get(index);
    CHECK(CheckProblem(example.problem) == Status::kOk);
    REQUIRE(example.problem.points.rows() == 200);
    REQUIRE(example.truth.structures.size() == 4);
    CHECK(example.truth.model == example.truth.structures[0]);
    CHECK(CountLabelled(example) == 120);
    // By area: 18, 12, 10 and 10 of 50.
    const std::vector<int> sizes = StructureSizes(example);
    CHECK((sizes[0] == Approx(43).margin(1) && sizes[1] == Approx(29).margin(1) && sizes[3] == Approx(24).margin(1)));
    int clutter = 0;
    for (Eigen::Index i = 0; i < 200; ++i) {
      const int label = example.truth.assignment[i];
      CHECK(example.truth.inliers[i] == (label > 0));
      CHECK((example.problem.points.row(i).minCoeff() > -0.2 && example.problem.points.row(i).maxCoeff() < 10.2));
      if (label > 0) CHECK(Distance(example, i, label - 1) < 5.0 * 0.1 / 3.0);
      if (label > 0) continue;
      double nearest = 10.0;
      for (int k = 0; k < 4; ++k) nearest = std::min(nearest, Distance(example, i, k));
      clutter += nearest > 0.2 - 1e-9;
    }
    CHECK(clutter >= 60);  // of 80 outliers half are clutter, and few uniform ones are that near
  }
  CHECK(dataset->Get(0).truth.model != dataset->Get(1).truth.model);  // turned
}

TEST_CASE("mesh planes: faces nearer than they can be told apart are one structure, round meshes are passed over") {
  const TemporaryFolder folder;
  // In the cube of 10 this board is .02 thick.
  WriteRaw(folder / "board.off", Boxes({{4, 4, 0.01}}));
  const auto board = MakeModelnetPlanes(Of(folder / "board.off"), 3);
  CHECK(board->Get(0).truth.structures.size() == 1);
  WriteRaw(folder / "a_round.off", Sphere());
  const auto both = MakeModelnetPlanes(Of(folder.path()), 3);
  CHECK(Has(both->Get(0).id, "0/board"));
  CHECK(Has(both->Get(1).id, "1/board"));
  const auto round = MakeModelnetPlanes(Of(folder / "a_round.off"), 3);
  CHECK(Has(ErrorOf([&] { round->Get(0); }), "min_area_share"));
}

}  // namespace diffsac
