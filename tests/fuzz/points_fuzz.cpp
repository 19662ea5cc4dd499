// Points and meshes as text: "ply ..." is a PLY file, "OFF ..." a mesh, all else lines of numbers.

#include "fuzz/fuzz_target.h"
#include "lab/data/off_mesh.h"
#include "lab/data/point_files.h"

namespace diffsac::testing {

std::vector<std::string> Seeds() { return SeedFiles("points"); }

namespace {

void CheckPoints(const PointMatrix& points) {
  Require(points.cols() == 2 || points.cols() == 3, "points have two or three columns");
}

void CheckMesh(const TriangleMesh& mesh) {
  for (const auto& triangle : mesh.triangles)
    for (const int corner : triangle)
      Require(corner >= 0 && corner < static_cast<int>(mesh.vertices.size()), "a corner is a vertex");
}

}  // namespace
}  // namespace diffsac::testing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diffsac::testing;
  const std::string_view content(reinterpret_cast<const char*>(data), size);
  if (content.starts_with("OFF")) {
    const std::string path = WriteScratch("fuzz.off", content);
    Parses({path}, [&] { CheckMesh(diffsac::InUnitSphere(diffsac::ReadOff(path))); });
    return 0;
  }
  const std::string path = WriteScratch(content.starts_with("ply") ? "fuzz.ply" : "fuzz.csv", content);
  Parses({path}, [&] {
    for (const diffsac::PointSet& set : diffsac::ReadPointFile(path)) CheckPoints(set.points);
  });
  return 0;
}
