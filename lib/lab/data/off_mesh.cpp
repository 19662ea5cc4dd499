#include "lab/data/off_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string_view>

#include "diffsac/core/status.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"

namespace diffsac {
namespace {

constexpr std::string_view kSeparators = " \t";
constexpr std::string_view kWord = "OFF";

using Words = std::vector<std::string_view>;

class OffReader {
 public:
  explicit OffReader(const std::string& path) : path_(path), content_(ReadTextFile(path)), rest_(content_) {}

  TriangleMesh Read() {
    ReadCounts();
    TriangleMesh mesh;
    // A count that the file cannot hold is an early end, not an allocation.
    mesh.vertices.reserve(std::min<std::size_t>(vertices_, content_.size()));
    for (std::int64_t i = 0; i < vertices_; ++i) mesh.vertices.push_back(ReadVertex(i));
    for (std::int64_t i = 0; i < faces_; ++i) ReadFace(i, &mesh.triangles);
    return mesh;
  }

  [[noreturn]] void Fail(const std::string& message) const {
    throw Error(path_ + ":" + std::to_string(line_) + ": " + message);
  }

 private:
  // The words of the next line that has any.
  Words NextWords(const std::string& expected) {
    std::string_view line;
    while (TakeLine(&rest_, &line)) {
      ++line_;
      Words words = SplitWords(line.substr(0, std::min(line.find('#'), line.size())), kSeparators);
      if (!words.empty()) return words;
    }
    Fail("the file ends where " + expected + " is expected");
  }

  double Number(std::string_view word) const {
    double value = 0.0;
    if (!ParseNumber(word, &value)) Fail("expected a number, found '" + std::string(word) + "'");
    return value;
  }

  std::int64_t Whole(std::string_view word, std::int64_t low, std::int64_t high, const char* what) const {
    const double value = Number(word);
    if (!(value >= static_cast<double>(low) && value < static_cast<double>(high)) || value != std::floor(value))
      Fail(std::string("expected ") + what + " from " + std::to_string(low) + " to " + std::to_string(high - 1) +
           ", found '" + std::string(word) + "'");
    return static_cast<std::int64_t>(value);
  }

  void ReadCounts() {
    Words words = NextWords("the word OFF");
    if (!words[0].starts_with(kWord))
      Fail("expected the word OFF, found '" + std::string(words[0].substr(0, 20)) + "'");
    words[0].remove_prefix(kWord.size());
    if (words[0].empty()) words.erase(words.begin());
    if (words.empty()) words = NextWords("the numbers of vertices and faces");
    if (words.size() < 2 || words.size() > 3) Fail("expected the numbers of vertices, faces and edges");
    constexpr std::int64_t kMost = 1'000'000'000;
    vertices_ = Whole(words[0], 0, kMost, "a number of vertices");
    faces_ = Whole(words[1], 0, kMost, "a number of faces");
  }

  Eigen::Vector3d ReadVertex(std::int64_t index) {
    const Words words = NextWords("vertex " + std::to_string(index) + " of " + std::to_string(vertices_));
    if (words.size() < 3) Fail("expected three coordinates of a vertex");
    const Eigen::Vector3d vertex(Number(words[0]), Number(words[1]), Number(words[2]));
    if (!vertex.allFinite()) Fail("a coordinate is not finite");
    return vertex;
  }

  void ReadFace(std::int64_t index, std::vector<std::array<int, 3>>* triangles) {
    const Words words = NextWords("face " + std::to_string(index) + " of " + std::to_string(faces_));
    const std::int64_t corners = Whole(words[0], 3, 1'000'000, "a number of corners");
    if (static_cast<std::int64_t>(words.size()) <= corners)
      Fail("expected " + std::to_string(corners) + " corners of a face, found " + std::to_string(words.size() - 1));
    const auto corner = [&](std::int64_t k) {
      return static_cast<int>(Whole(words[static_cast<std::size_t>(k) + 1], 0, vertices_, "the index of a vertex"));
    };
    const int first = corner(0);
    int before = corner(1);
    for (std::int64_t k = 2; k < corners; ++k) {
      const int next = corner(k);
      triangles->push_back({first, before, next});
      before = next;
    }
  }

  std::string path_;
  std::string content_;
  std::string_view rest_;
  int line_ = 0;
  std::int64_t vertices_ = 0, faces_ = 0;
};

bool HasArea(const TriangleMesh& mesh) {
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const std::array<int, 3>& t) {
    const Eigen::Vector3d& a = mesh.vertices[t[0]];
    return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm() > 0.0;
  });
}

}  // namespace

TriangleMesh ReadOff(const std::string& path) {
  TriangleMesh mesh = OffReader(path).Read();
  if (!HasArea(mesh)) throw Error(path + ": a mesh without any area");
  return mesh;
}

TriangleMesh InUnitSphere(TriangleMesh mesh) {
  if (mesh.triangles.empty()) return mesh;
  Eigen::Vector3d low = mesh.vertices[mesh.triangles[0][0]], high = low;
  for (const auto& triangle : mesh.triangles)
    for (int corner : triangle) {
      low = low.cwiseMin(mesh.vertices[corner]);
      high = high.cwiseMax(mesh.vertices[corner]);
    }
  const Eigen::Vector3d centre = 0.5 * (low + high);
  double radius = 0.0;
  for (const auto& triangle : mesh.triangles)
    for (int corner : triangle) radius = std::max(radius, (mesh.vertices[corner] - centre).norm());
  if (!(radius > 0.0)) radius = 1.0;
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex = (vertex - centre) / radius;
  return mesh;
}

MeshSurface::MeshSurface(const std::string& path) : mesh_(InUnitSphere(ReadOff(path))) {
  double area = 0.0;
  for (const auto& t : mesh_.triangles) {
    const Eigen::Vector3d& a = mesh_.vertices[t[0]];
    area += 0.5 * (mesh_.vertices[t[1]] - a).cross(mesh_.vertices[t[2]] - a).norm();
    cumulative_area_.push_back(area);
  }
}

Eigen::Vector3d MeshSurface::Sample(Rng& rng, int* triangle) const {
  const double pick = rng.Uniform() * cumulative_area_.back();
  const auto at = std::upper_bound(cumulative_area_.begin(), cumulative_area_.end() - 1, pick);
  *triangle = static_cast<int>(at - cumulative_area_.begin());
  // The unit square folded over its diagonal.
  double s = rng.Uniform(), t = rng.Uniform();
  if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
  const auto& corners = mesh_.triangles[*triangle];
  const Eigen::Vector3d& a = mesh_.vertices[corners[0]];
  return a + s * (mesh_.vertices[corners[1]] - a) + t * (mesh_.vertices[corners[2]] - a);
}

}  // namespace diffsac
