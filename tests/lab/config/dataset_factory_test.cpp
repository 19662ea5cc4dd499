#include "lab/config/dataset_factory.h"

#include <catch2/catch.hpp>

#include "core/errors.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/yaml.h"

namespace diffsac {

TEST_CASE("the factory builds what the type says") {
  const auto line = MakeDataset(ConfigFromYaml("type: synthetic_line\nnum_points: 30\n"), 1);
  CHECK(line->task() == Task::kLine);
  CHECK(line->size() == -1);
  CHECK(line->Get(0).problem.points.rows() == 30);
  const auto plane = MakeDataset(ConfigFromYaml("type: synthetic_plane\nsize: 7\n"), 1);
  CHECK(plane->task() == Task::kPlane);
  CHECK(plane->size() == 7);
  CHECK(MakeDataset(ConfigFromYaml("type: synthetic_line"), 1)->Get(0).problem.points !=
        MakeDataset(ConfigFromYaml("type: synthetic_line"), 2)->Get(0).problem.points);
  TemporaryFolder folder;
  WriteRaw(folder / "a.csv", "1,2\n3,4\n");
  const auto files =
      MakeDataset(ConfigFromYaml("type: point_sets\npaths: [" + folder.path() + "]\ninlier_threshold: 0.5\n"), 1);
  CHECK(files->size() == 1);
  CHECK(files->Get(0).problem.inlier_threshold == 0.5);
}

TEST_CASE("the factory names mistakes") {
  const auto error = [](const char* yaml) { return ErrorOf([&] { MakeDataset(ConfigFromYaml(yaml, "my.yaml"), 1); }); };
  CHECK(Has(error("num_points: 30"), "type"));
  CHECK(Has(error(""), "type"));
  CHECK(Has(error("type: synthetic_lines"), "synthetic_line"));
  CHECK(Has(error("type: [1]"), "type"));
  CHECK(Has(error("type: synthetic_line\nnum_pointz: 3"), "num_points"));
  CHECK(Has(error("type: synthetic_line\nnum_pointz: 3"), "my.yaml:2"));
  CHECK(Has(error("type: point_sets\nnum_points: 3"), "num_points"));
  CHECK(Has(error("type: point_sets"), "paths"));
}

TEST_CASE("a key that cannot act is an error with its line") {
  const auto error = [](const char* yaml) {
    return ErrorOf([&] { WriteDatasetOptions(ConfigFromYaml(yaml, "my.yaml")); });
  };
  CHECK(error("type: correspondences\nmax_points: 9\ncap: random").empty());
  CHECK(Has(error("type: correspondences\ncap: random"), "my.yaml:2: cap: acts only with max_points above 0"));
  CHECK(Has(error("type: correspondences\ndominant_plane: true"), "task: homography"));
  CHECK(Has(error("type: kitti\nroot: a\ndescriptor_noise: 1"), "descriptors: true"));
  CHECK(Has(error("type: point_sets\npaths: [a]\nseed: 2"), "max_points"));
}

TEST_CASE("resolved dataset options can be read again") {
  const std::string text = WriteDatasetOptions(ConfigFromYaml("type: synthetic_line\nnum_points: [20, 40]\n"));
  CHECK(Has(text, "synthetic_line"));
  CHECK(WriteDatasetOptions(ConfigFromYaml(text)) == text);
}

}  // namespace diffsac
