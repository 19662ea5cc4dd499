#include "lab/data/point_files.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <set>
#include <string>

#include "core/errors.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/yaml.h"
#include "lab/data/example_test_util.h"
#include "lab/files/files.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

template <class T>
void Append(std::string* bytes, T value, bool big_endian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  bytes->append(raw, sizeof(T));
}

// A list element before the vertices, and colours between the coordinates.
std::string BinaryPly(bool big_endian) {
  std::string text = std::string("ply\nformat binary_") + (big_endian ? "big" : "little") +
                     "_endian 1.0\ncomment made by a test\nelement face 1\nproperty list uchar int vertex_indices\n"
                     "element vertex 2\nproperty double x\nproperty uchar red\nproperty float y\nproperty double z\n"
                     "end_header\n";
  Append<unsigned char>(&text, 2);
  for (int i = 0; i < 2; ++i) Append<int>(&text, i, big_endian);
  for (int i = 0; i < 2; ++i) {
    Append<double>(&text, 0.1 + i, big_endian);
    Append<unsigned char>(&text, 200);
    Append<float>(&text, 0.5f + i, big_endian);
    Append<double>(&text, -3.25 * i, big_endian);
  }
  return text;
}

PointMatrix ExpectedPly() {
  PointMatrix points(2, 3);
  points << 0.1, 0.5, 0.0, 1.1, 1.5, -3.25;
  return points;
}

std::string ReadErrorOf(const std::string& path) {
  return ErrorOf([&] { ReadPointFile(path); });
}

PointSetsOptions Options(const std::string& path, Task task = Task::kLine) {
  PointSetsOptions options;
  options.paths = {path};
  options.task = task;
  options.inlier_threshold = 0.1;
  return options;
}

}  // namespace

TEST_CASE("points that are not finite are left out") {
  TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 2000; ++i) text += i == 7 ? "7 nan\n" : std::to_string(i) + " " + std::to_string(i % 3) + "\n";
  WriteRaw(folder / "scan.csv", text);
  const Example read = MakePointSets(Options(folder / "scan.csv"))->Get(0);
  CHECK(CheckProblem(read.problem) == Status::kOk);
  REQUIRE(read.problem.points.rows() == 1999);
  CHECK(read.problem.points(6, 0) == 6.0);
  CHECK(read.problem.points(7, 0) == 8.0);
}

TEST_CASE("a file without points, or without a finite one, is an error that names it") {
  TemporaryFolder folder;
  WriteRaw(folder / "none.ply",
           "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nend_header\n");
  WriteRaw(folder / "nan.csv", "nan 1\n2 inf\n");
  CHECK(ErrorOf([&] { MakePointSets(Options(folder / "none.ply")); }) == folder / "none.ply: no points");
  CHECK(ErrorOf([&] { MakePointSets(Options(folder / "nan.csv")); }) == folder / "nan.csv: no finite points");
}

TEST_CASE("a random subset depends on the set's own name and scene, not on what is read before it") {
  TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 100; ++i) text += std::to_string(i) + " " + std::to_string(i * i) + "\n";
  WriteRaw(folder / "b.csv", text);
  PointSetsOptions options = Options(folder / "b.csv");
  options.max_points = 10;
  const Example alone = MakePointSets(options)->Get(0);
  WriteRaw(folder / "a.csv", text);
  options.paths = {folder.path()};
  const Example beside = MakePointSets(options)->Get(1);
  CHECK(alone.id == beside.id);
  CHECK(alone.problem.points == beside.problem.points);
  CHECK(ProblemName(alone) == "b.csv@" + PointDigest(alone.problem.points));
  options.seed = 1;
  CHECK(ProblemName(MakePointSets(options)->Get(1)) != ProblemName(beside));
}

TEST_CASE("text points: separators, header, comments, NaN") {
  TemporaryFolder folder;
  WriteRaw(folder / "a.csv", "x,y\r\n1,2\r\n-3.5, +4e1\r\n");
  WriteRaw(folder / "b.txt", "# made by hand\n1 2 3\n\n 4\t5 nan # last\n");
  WriteRaw(folder / "c.csv",
           "\xEF\xBB\xBF"
           "1;2\n3;inf");
  const PointMatrix a = ReadPointFile(folder / "a.csv")[0].points;
  CHECK(a == (PointMatrix(2, 2) << 1, 2, -3.5, 40).finished());
  const PointSet b = ReadPointFile(folder / "b.txt")[0];
  CHECK(b.name == "b.txt");
  CHECK(b.points.rows() == 2);
  CHECK(b.points.cols() == 3);
  CHECK(std::isnan(b.points(1, 2)));
  CHECK(std::isinf(ReadPointFile(folder / "c.csv")[0].points(1, 1)));
  const auto error = [&](const char* text) {
    WriteRaw(folder / "bad.csv", text);
    return ReadErrorOf(folder / "bad.csv");
  };
  CHECK(Has(error("1,2\n3\n"), "bad.csv:2"));
  CHECK(Has(error("1,2\n3,4,5\n"), "bad.csv:2"));
  CHECK(Has(error("x,y\n1,2\n\n3,four\n"), "bad.csv:4"));
  CHECK(Has(error("1,2,3,4\n"), "2 or 3 columns"));
  CHECK(Has(error("1\n"), "2 or 3 columns"));
  CHECK(Has(error(""), "no points"));
  CHECK(Has(error("x,y\n"), "no points"));
  CHECK(Has(ReadErrorOf(folder / "missing.csv"), "no such file"));
  WriteRaw(folder / "points.docx", "1,2");
  CHECK(Has(ReadErrorOf(folder / "points.docx"), "unknown kind"));
}

TEST_CASE("columns are taken by the names in a header, an index column is no coordinate") {
  TemporaryFolder folder;
  const auto read = [&](const std::string& text, const char* name = "a.csv") {
    WriteRaw(folder / name, text);
    return ReadPointFile(folder / name)[0].points;
  };
  const PointMatrix space = (PointMatrix(2, 3) << 1, 2, 3, 4, 5, 6).finished(), plane = space.leftCols<2>();
  for (const char* text :
       {"z,y,x\n3,2,1\n6,5,4\n", "id,Z,label,Y,X\n7,3,a,2,1\n8,6,\"b,c\",5,4\n",
        "\"z\" ; \"x\" ; \"y\"\n3;1;2\n6;4;5\n", "x [m],y (m),z{m}\n1,2,3\n4,5,6\n", "# x y z\n1 2 3\n4 5 6\n",
        "# z,y,x\n3,2,1\n6,5,4\n", ",x,y,z\n0,1,2,3\n1,4,5,6\n", "#,x,y,z\n0,1,2,3\n1,4,5,6\n",
        "//X Y Z R\n1 2 3 9\n4 5 6 9\n", "\"x\" \"y\" \"z\"\n\"1\" 1 2 3\n\"2\" 4 5 6\n", "x\ty\tz\n1 2 3\n4 5 6\n",
        "x,y,z,\n1,2,3,\n4,5,6 # last\n", "index,a,b,c\n0,1,2,3\n1,4,5,6\n", ",0,1,2\n0,1,2,3\n1,4,5,6\n",
        "east,north,up\n1,2,3\n4,5,6\n", "my scan\n1 2 3\n4 5 6\n"}) {
    CAPTURE(text);
    CHECK(read(text) == space);
  }
  for (const char* text : {"y,x,score\n2,1,9\n5,4,9\n", "Unnamed: 0,u,v\n0,1,2\n1,4,5\n", "id,y\n1,2\n4,5\n"}) {
    CAPTURE(text);
    CHECK(read(text) == plane);
  }
  CHECK(std::isnan(read("x,y,z\n1,,3\n")(0, 1)));
  CHECK(std::isnan(read("x,y,z\n1,NA,3\n")(0, 1)));
  CHECK(Has(ErrorOf([&] { read("x,y,x\n1,2,3\n"); }), "two columns are named x"));
  CHECK(Has(ErrorOf([&] { read("x,y,z\n1,2\n"); }), "a.csv:2: expected 3 columns as the header has, found 2"));
  CHECK(Has(ErrorOf([&] { read("x;y\n1,5;2\n"); }), "with a point, not a comma"));
  CHECK(Has(ErrorOf([&] { read("1,5;2\n"); }), "commas and semicolons in one line"));
  CHECK(Has(ErrorOf([&] { read(std::string("1\0,\0002\0\n\0", 8)); }), "UTF-16"));
  WriteRaw(folder / "id_xy.csv", "id,x,y\n1,2,3\n4,5,6\n");
  CHECK(ErrorOf([&] { MakePointSets(Options(folder / "id_xy.csv", Task::kPlane)); }) ==
        folder / "id_xy.csv: no column z, which the task plane needs; its columns are 'id', 'x', 'y'");
}

TEST_CASE("PLY points of another number than the header announces") {
  TemporaryFolder folder;
  const std::string path = folder / "a.ply",
                    header = "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n",
                    faces = "element face 1\nproperty list uchar int vertex_indices\n";
  const auto write = [&](const std::string& elements, const std::string& rows) {
    WriteRaw(path, "ply\nformat ascii 1.0\n" + elements + "end_header\n" + rows);
    return ErrorOf([&] { ReadPointFile(path); });
  };
  CHECK(write(header, "1 2 3\n4 5 6\n7 8 9\n") == "");
  CHECK(ReadPointFile(path)[0].points.rows() == 2);
  CHECK(write(header + faces, "1 2 3\n4 5 6\n7 8 9\n3 0 1 1\n") == "");
  CHECK(ReadPointFile(path)[0].points.rows() == 2);
  CHECK(Has(write(header, "1 2 3\n"), "truncated: the file ends at vertex 2 of 2"));
  // Faces were taken for points.
  CHECK(Has(write(header + faces, "1 2 3\n3 0 1 1\n"), "a.ply:11: vertex 2 of 2 has more values than the header says"));
  CHECK(Has(write(header, "1 2\n3 4 5\n6\n"), "vertex 1 of 2 has fewer values than the header says"));
}

TEST_CASE("PLY points: ascii and both byte orders") {
  TemporaryFolder folder;
  for (bool big : {false, true}) {
    WriteRaw(folder / "binary.ply", BinaryPly(big));
    CHECK(ReadPointFile(folder / "binary.ply")[0].points == ExpectedPly());
  }
  const std::string header =
      "ply\r\nformat ascii 1.0\r\nobj_info none\r\nelement vertex 2\r\nproperty float x\r\nproperty float y\r\n"
      "property list uchar int extra\r\nproperty float z\r\nend_header\r\n";
  WriteRaw(folder / "ascii.ply", header + "0.1 0.5 0 0\r\n1.1 1.5 2 7 8 -3.25\r\n");
  CHECK(ReadPointFile(folder / "ascii.ply")[0].points == ExpectedPly());
  WriteRaw(folder / "bad.ply", header + "0.1 0.5 0 0\n1.1 oops 0 1\n");
  CHECK(Has(ReadErrorOf(folder / "bad.ply"), "oops"));
  CHECK(Has(ReadErrorOf(folder / "bad.ply"), "bad.ply:11"));
  WriteRaw(folder / "flat.ply",
           "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n");
  CHECK(ReadPointFile(folder / "flat.ply")[0].points.cols() == 2);
}

TEST_CASE("PLY mistakes are named, at any place of a cut") {
  TemporaryFolder folder;
  const std::string whole = BinaryPly(false);
  const std::string path = folder / "cut.ply";
  for (std::size_t size = 1; size < whole.size(); size += 3) {
    WriteRaw(path, whole.substr(0, size));
    CHECK(Has(ReadErrorOf(path), "cut.ply"));
  }
  const auto error = [&](const std::string& text) {
    WriteRaw(path, text);
    return ReadErrorOf(path);
  };
  CHECK(Has(error(whole.substr(0, whole.size() - 1)), "truncated"));
  CHECK(Has(error("solid"), "not a PLY"));
  CHECK(Has(error("ply\nformat utf8 1.0\nend_header\n"), "format"));
  CHECK(Has(error("ply\nelement vertex 1\nend_header\n"), "format"));
  CHECK(Has(error("ply\nformat ascii 1.0\nend_header\n"), "vertex"));
  CHECK(Has(error("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"), "no property y"));
  CHECK(Has(error("ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n1\n"), "half"));
  CHECK(Has(error("ply\nformat ascii 1.0\nelement vertex -1\nend_header\n"), "element"));
  CHECK(Has(error("ply\nformat binary_little_endian 1.0\nelement vertex 99999999999999\nproperty float x\n"
                  "property float y\nend_header\nabc"),
            "truncated"));
}

TEST_CASE("folders are read in order, and thresholds follow the extent") {
  TemporaryFolder folder;
  WriteRaw(folder / "b.csv", "0 0\n3 4\nnan 1\n");
  WriteRaw(folder / "a.csv", "0 0\n6 8\n");
  WriteRaw(folder / "notes.md", "not points");
  PointSetsOptions options = Options(folder.path());
  options.inlier_threshold = 0.0;
  options.inlier_threshold_relative = 0.01;
  const auto dataset = MakePointSets(options);
  REQUIRE(dataset->size() == 2);
  CHECK(dataset->Get(0).id == "a.csv");
  CHECK(dataset->Get(0).problem.inlier_threshold == Approx(0.1));
  CHECK(dataset->Get(1).problem.inlier_threshold == Approx(0.05));
  options.paths.push_back(folder / "a.csv");  // twice the same file: ids stay unique
  CHECK(MakePointSets(options)->Get(2).id == "a.csv#2");
  // A file of a folder that cannot be read costs no other; one that is named is an error.
  WriteRaw(folder / "c.csv", "0 0\n1\n");
  CHECK(MakePointSets(options)->size() == 3);
  options.paths = {folder / "c.csv"};
  CHECK(Has(ErrorOf([&] { MakePointSets(options); }), "c.csv:2"));
  TemporaryFolder empty;
  CHECK(Has(ErrorOf([&] { MakePointSets(Options(empty.path())); }), "no point files"));
  CHECK(ErrorOf([&] {
          ReadOptions<PointSetsOptions>(
              ConfigFromYaml("paths: [a.csv]\ninlier_threshold: 1\n"
                             "inlier_threshold_relative: 0.1\n"));
        }) != "");
}

TEST_CASE("max_points keeps a random subset that the seed decides") {
  TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 500; ++i) text += std::to_string(i) + " " + std::to_string(i * i) + "\n";
  WriteRaw(folder / "a.csv", text);
  PointSetsOptions options = Options(folder / "a.csv");
  options.max_points = 60;
  const Example subset = MakePointSets(options)->Get(0);
  REQUIRE(subset.problem.points.rows() == 60);
  for (int i = 1; i < 60; ++i) CHECK(subset.problem.points(i - 1, 0) < subset.problem.points(i, 0));
  CHECK(MakePointSets(options)->Get(0).problem.points == subset.problem.points);
  options.seed = 1;
  CHECK_FALSE(testing::SamePoints(MakePointSets(options)->Get(0).problem.points, subset.problem.points));
  options.max_points = 1000;
  CHECK(MakePointSets(options)->Get(0).problem.points.rows() == 500);
}

TEST_CASE("the eight real scans can be read") {
  const std::string folder = std::string(DIFFSAC_SHARED_DATA) + "/pyransac3d_ply";
  if (!std::filesystem::is_directory(folder)) {
    WARN("skipped: no folder " << folder);
    return;
  }
  PointSetsOptions options = Options(folder, Task::kPlane);
  options.inlier_threshold = 0.0;
  options.inlier_threshold_relative = 0.01;
  options.max_points = 2000;
  const auto dataset = MakePointSets(options);
  REQUIRE(dataset->size() == 8);
  CHECK(ReadPlyPoints(folder + "/caixa.ply").points.rows() == 46370);
  std::set<std::string> ids;
  for (int i = 0; i < 8; ++i) {
    const Example example = dataset->Get(i);
    ids.insert(example.id);
    CHECK(example.problem.points.rows() == 2000);
    CHECK(CheckProblem(example.problem) == Status::kOk);
    CHECK(example.problem.inlier_threshold > 0.0);
    CHECK(example.problem.inlier_threshold < 1.0);
    CHECK(example.scene == "pyransac3d_ply");
  }
  CHECK(ids.size() == 8);
}

TEST_CASE("data of files says which of a file's points a problem has") {
  TemporaryFolder folder;
  std::string text = "nan,0\n";
  for (int i = 0; i < 30; ++i) text += std::to_string(i) + ",1\n";
  const std::string path = folder / "a.csv";
  WriteFileAtomically(path, text);
  PointSetsOptions options = Options(path);
  options.max_points = 10;
  const auto subset = MakePointSets(options);
  const PointSource& source = dynamic_cast<const HasPointSources&>(*subset).SourceOf(0);
  CHECK(source.path == path);
  CHECK(source.name == "a.csv");
  CHECK(source.total == 31);
  const Example example = subset->Get(0);
  REQUIRE(source.rows.size() == 10);
  for (std::size_t i = 0; i < 10; ++i)  // The first of the file has no finite value.
    CHECK(example.problem.points(static_cast<Eigen::Index>(i), 0) == source.rows[i] - 1.0);
  options.max_points = 0;
  const auto finite = MakePointSets(options);
  CHECK(dynamic_cast<const HasPointSources&>(*finite).SourceOf(0).rows.size() == 30);
  WriteFileAtomically(path, text.substr(text.find('\n') + 1));
  CHECK(dynamic_cast<const HasPointSources&>(*MakePointSets(options)).SourceOf(0).rows.empty());
}

}  // namespace diffsac
