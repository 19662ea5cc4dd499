#include "lab/data/correspondences_dataset.h"

#include <utility>

#include "lab/config/dataset_registry.h"

namespace diffsac {

void CorrespondencesOptions::Bind(OptionsBinder& b) {
  b.Field("paths", paths).Help("folders of correspondence files, or folders of such folders; a scene each");
  pairs.Bind(b, "max_ratio");
}

std::unique_ptr<Dataset> MakeCorrespondences(const CorrespondencesOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  std::vector<SceneFolder> scenes;
  for (const std::string& path : options.paths)
    for (SceneFolder& scene : FindScenes(path)) scenes.push_back(std::move(scene));
  return MakePairDataset(scenes, options.pairs, PairMemory::kAll, seed);
}

namespace {

const RegisteredDataset<CorrespondencesOptions> kCorrespondences(
    "correspondences", DataSource::kFiles,
    "Correspondence files, as `diffsac_prepare` writes them; all pairs are read at the start and kept.",
    MakeCorrespondences);

}  // namespace

}  // namespace diffsac
