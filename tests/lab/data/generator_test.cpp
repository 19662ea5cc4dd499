// What holds of all generators alike.
#include "lab/data/generator.h"

#include <catch2/catch.hpp>
#include <set>
#include <stdexcept>
#include <vector>

#include "core/errors.h"
#include "diffsac/core/parallel.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/example_test_util.h"

namespace diffsac {
namespace {

struct Generator {
  std::string yaml;
  std::string ids, behind;  // of an example's id, before its split and behind its number
};

// With a mesh of one box.
struct Generators {
  TemporaryFolder folder;
  std::vector<Generator> all;

  Generators() {
    WriteRaw(folder / "box.off",
             "OFF\n8 6 0\n0 0 0\n4 0 0\n0 3 0\n4 3 0\n0 0 2\n4 0 2\n0 3 2\n4 3 2\n"
             "4 0 1 3 2\n4 4 5 7 6\n4 0 1 5 4\n4 2 3 7 6\n4 0 2 6 4\n4 1 3 7 5\n");
    const std::string meshes = "\npaths: [\"" + folder.path() + "\"]";
    all = {{"type: synthetic_line", "line/", ""},
           {"type: synthetic_plane", "plane/", ""},
           {"type: synthetic_structures", "structures_line/", ""},
           {"type: synthetic_structures\ntask: plane", "structures_plane/", ""},
           {"type: synthetic_two_view\ntask: homography", "two_view_homography/", ""},
           {"type: synthetic_two_view", "two_view_fundamental/", ""},
           {"type: synthetic_two_view\ntask: essential", "two_view_essential/", ""},
           {"type: modelnet40" + meshes, "modelnet40_fundamental/", "/box"}};
  }
};

std::unique_ptr<Dataset> Make(const std::string& yaml, std::uint64_t seed = 5) {
  return MakeDataset(ConfigFromYaml(yaml + "\n", "my.yaml"), seed);
}

bool SamePoints(const Example& a, const Example& b) { return testing::SamePoints(a.problem.points, b.problem.points); }

}  // namespace

TEST_CASE("examples of generators depend on seed, split and index alone, and are shuffled") {
  constexpr int kCount = 12;
  const Generators generators;
  for (const auto& [yaml, ids, behind] : generators.all) {
    CAPTURE(yaml);
    const std::string text = yaml + "\noutlier_ratio: 0.5\nsize: 12";
    const auto dataset = Make(text), again = Make(text), seeded = Make(text, 6);
    CHECK(dataset->size() == kCount);
    std::vector<Example> examples(kCount);
    ParallelFor(kCount, 4, [&](std::int64_t i) { examples[i] = dataset->Get(i); });
    std::set<std::string> names;
    for (int i = kCount - 1; i >= 0; --i) {
      const Example &one = examples[i], other = again->Get(i);
      CHECK(SamePoints(one, other));
      CHECK(one.problem.snn_ratio == other.problem.snn_ratio);
      CHECK(one.truth.model == other.truth.model);
      CHECK(one.truth.inliers == other.truth.inliers);
      CHECK(one.truth.assignment == other.truth.assignment);
      CHECK(one.truth.instances == other.truth.instances);
      CHECK(one.index == static_cast<std::uint64_t>(i));
      CHECK(one.id == ids + "train/" + std::to_string(i) + behind);
      CHECK_FALSE(SamePoints(one, seeded->Get(i)));
      std::size_t changes = 0;
      for (std::size_t k = 1; k < one.truth.inliers.size(); ++k)
        changes += one.truth.inliers[k] != one.truth.inliers[k - 1];
      CHECK(changes > one.truth.inliers.size() / 4);
    }
    CHECK_THROWS_AS(dataset->Get(kCount), std::out_of_range);
    const auto validation = Make(text + "\nsplit: validation");
    CHECK(validation->Get(3).id == ids + "validation/3" + behind);
    for (int i = 0; i < kCount; ++i) {
      const Example other = validation->Get(i);
      for (const Example& example : examples) CHECK_FALSE(SamePoints(example, other));
    }
    const std::string written = WriteDatasetOptions(ConfigFromYaml(text));
    CHECK(WriteDatasetOptions(ConfigFromYaml(written)) == written);
  }
}

TEST_CASE("generators name mistakes in their options") {
  const struct {
    std::string type;
    std::vector<std::pair<std::string, std::string>> mistakes;  // what is written, and a part of the error
  } kTypes[] = {
      {"synthetic_plane",
       {{"num_points: 3", "at least 4"},
        {"num_points: 50.5", "whole"},
        {"outlier_ratio: 1.2", "outlier_ratio"},
        {"noise: cauchy", "gaussian"},
        {"inlier_threshold: 0", "inlier_threshold"},
        {"noise_scal: 1", "noise_scale"}}},
      {"synthetic_structures",
       {{"task: homography", "my.yaml:2"},
        {"structures: 0", "structures"},
        {"structures: [1.5, 3]", "whole"},
        {"size_ratio: 0.5", "size_ratio"},
        {"num_points: 23", "at least 24, 4 for each of up to 6 structures"},
        {"num_points: [50.5, 60]", "whole"},
        {"inlier_threshold: 2", "inlier_threshold"},
        {"noise: uniform", "noise"}}},
      {"synthetic_two_view",
       {{"task: line", "my.yaml:2"},
        {"general: 0\nplanar: 0\nmixed: 0\nforward: 0", "weight"},
        {"num_points: 7", "at least 8"},
        {"num_points: [20.5, 30]", "whole"}}},
      {"modelnet40",
       {{"subset: train", "paths"}, {"paths: [nowhere]", "nowhere"}, {"paths: [a]\ntask: homography", "my.yaml:3"}}}};
  for (const auto& [type, mistakes] : kTypes)
    for (const auto& [written, part] : mistakes) {
      CAPTURE(type, written);
      CHECK(Has(ErrorOf([&, type = type, written = written] { Make("type: " + type + "\n" + written); }), part));
    }
}

}  // namespace diffsac
