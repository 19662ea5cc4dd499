#include <catch2/catch.hpp>
#include <filesystem>

#include "diffsac/problem/point_features.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/synthetic_two_view.h"
#include "lab/ground_truth/labels.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

// The data, the labels and the features of a configuration agree with one another.
void CheckConfig(const std::string& path) {
  CAPTURE(path);
  const Config config = ConfigFromFile(path);
  const Task task = TaskFromString(config.Text("task"));
  // Mixtures are training's (tests/train).
  if (config.Text("data.type") != "mixture") {
    CHECK_FALSE(WriteDatasetOptions(config.Sub("data")).empty());
    if (IsGenerated(config.Sub("data")) && !config.Has("data.paths")) {
      CHECK(MakeDataset(config.Sub("data"), 1)->task() == task);
    } else if (IsTwoView(task)) {
      CHECK(config.Text("data.task") == config.Text("task"));
    }
  }
  ReadOptions<LabelOptions>(config.Sub("labels"));
  CHECK(PointFeatures(ReadOptions<PointFeaturesOptions>(config.Sub("network.features")), task).width() > 0);
}

}  // namespace

TEST_CASE("every shipped configuration's data, labels and features can be read") {
  int count = 0;
  for (const char* folder : {"/configs", "/configs/data", "/configs/paper"})
    for (const auto& entry : std::filesystem::directory_iterator(DIFFSAC_SOURCE_DIR + std::string(folder)))
      if (entry.path().extension() == ".yaml" && ConfigFromFile(entry.path().string()).Has("data")) {
        CheckConfig(entry.path().string());
        ++count;
      }
  CHECK(count >= 19);
}

TEST_CASE("synthetic configurations give features and labels as training asks for them") {
  for (const char* name : {"fundamental", "essential", "homography"}) {
    const Config config = ConfigFromFile(DIFFSAC_SOURCE_DIR + std::string("/configs/data/synthetic_") + name + ".yaml");
    const auto dataset = MakeDataset(config.Sub("data"), 1);
    const auto labels = ReadOptions<LabelOptions>(config.Sub("labels"));
    const PointFeatures features(ReadOptions<PointFeaturesOptions>(config.Sub("network.features")), dataset->task());
    for (int i = 0; i < 20; ++i) {
      const Example example = dataset->Get(i);
      const FeatureSet set = features.Compute(example.problem, Rng(1));
      CHECK(set.values.cols() == 5);
      CHECK(set.values.allFinite());
      CHECK(set.values.cwiseAbs().maxCoeff() < 10.0f);
      CHECK(OptimalMinimalSets(example, labels, labels.top_m).size() == 8);
    }
  }
}

}  // namespace diffsac
