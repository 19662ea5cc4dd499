// What registers itself in an installed library is there: a dataset by its name.
#include <cstdio>

#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"

int main() {
  const auto dataset = diffsac::MakeDataset(diffsac::ConfigFromYaml("type: synthetic_line\nnum_points: 30\n"), 1);
  std::printf("points %d\n", static_cast<int>(dataset->Get(0).problem.points.rows()));
}
