#pragma once

#include <memory>
#include <string>

#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/options/config.h"

namespace diffsac {

/// The row of a type with options as an experiment's file gives them ("test.yaml" in messages).
inline std::unique_ptr<RobustEstimator> MakeRow(const std::string& type, Task task, const std::string& yaml = "{}") {
  Config config = ConfigFromYaml(yaml, "test.yaml");
  SetYaml(&config, "type=" + type);
  return MakeEstimator(config, task, {});
}

}  // namespace diffsac
