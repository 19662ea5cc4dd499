#include "lab/data/off_mesh.h"

#include <catch2/catch.hpp>

#include "core/errors.h"

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

}  // namespace diffsac
