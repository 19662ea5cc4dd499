#include "diffsac/estimate/vanishing_point_chooser.h"

#include <cmath>
#include <filesystem>
#include <map>
#include <mutex>
#include <string_view>

#include "diffsac/core/embedded_models.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/learned_model.h"
#include "diffsac/guidance/engine/checkpoint_info.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/problem/vanishing_point_pool.h"

namespace diffsac {
namespace {

constexpr const char* kMethod = "structure_chooser";

/// Presets name it below `models/`, as configurations do, which have found it already.
std::string PlaceOf(const std::string& file) {
  constexpr std::string_view kModels = "models/";
  const bool named = file.starts_with(kModels) && !std::filesystem::exists(file);
  return named ? ModelPlace(file.substr(kModels.size())) : file;
}

std::shared_ptr<const SetScorer> LoadScorer(const std::string& file) {
  const TrainedConfig trained = ReadTrainedConfig(file, kMethod, Task::kVanishingPoint);
  const SetScorerOptions options = ReadSetScorerOptions(GroupOf(trained, "network"));
  RequireWeights(file, std::int64_t{options.layers} * options.width * options.width);
  SafetensorsFile checkpoint = OpenCheckpoint(file);
  const auto read = [&](const std::string& name, const std::vector<std::int64_t>& shape, std::span<float> values) {
    checkpoint.Read(kAverageTensors + name, shape, values);
  };
  return std::make_shared<SetScorer>(options, kPoolFeatures, kPoolPairs, read);
}

}  // namespace

Eigen::VectorXd PoolLengths(const Eigen::VectorXd& weights) {
  // The diagonal of a 4:3 image in halves of its longer side.
  return 2.5 * weights;
}

ChosenInstances VanishingPointChooser::Choose(const PointMatrix& points, const Eigen::VectorXd& weights,
                                              const std::vector<ModelParameters>& hypotheses, int most,
                                              double least) const {
  if (points.cols() != VanishingPoint::kDimension || weights.size() != points.rows()) return {};  // Of another task.
  std::vector<Eigen::Vector3d> solved;
  for (const ModelParameters& hypothesis : hypotheses)
    if (hypothesis.size() == 3 && hypothesis.allFinite() && hypothesis.norm() > 0.0) solved.emplace_back(hypothesis);
  const Eigen::VectorXd lengths = PoolLengths(weights);
  const VanishingPointPool pool = MakeVanishingPointPool(points, lengths, solved);
  if (pool.models.empty()) return {};
  ChosenInstances chosen;
  std::vector<Eigen::Vector3d> models;
  const SetScorer::Set set(*scorer_, pool.features, pool.pairs);
  std::vector<std::uint8_t> taken(pool.models.size(), 0);
  while (static_cast<int>(models.size()) < most && models.size() < pool.models.size()) {
    const Eigen::VectorXf logits = set.Score(taken);
    int best = -1;
    for (int i = 0; i < static_cast<int>(taken.size()); ++i)
      if (taken[i] == 0 && (best < 0 || logits[i] > logits[best])) best = i;
    const double value = 1.0 / (1.0 + std::exp(-static_cast<double>(logits[best])));
    if (!(value >= least)) break;
    taken[best] = 1;
    models.push_back(pool.models[best]);
    chosen.values.push_back(value);
  }
  chosen.models = RefineOnLongest(points, lengths, models);
  return chosen;
}

void LoadChooser(InstanceSearchOptions* options) {
  if (options->search != InstanceSearch::kChosen || options->chosen_by != nullptr) return;
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<const SetScorer>> loaded;
  const std::lock_guard lock(mutex);
  std::shared_ptr<const SetScorer> scorer = loaded[options->chooser].lock();
  if (scorer == nullptr) loaded[options->chooser] = scorer = LoadScorer(PlaceOf(options->chooser));
  options->chosen_by = std::make_shared<VanishingPointChooser>(scorer);
}

}  // namespace diffsac
