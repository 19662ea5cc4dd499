#include "diffsac/data/dataset_factory.h"

#include <yaml-cpp/yaml.h>

#include "diffsac/data/modelnet.h"
#include "diffsac/data/point_files.h"
#include "diffsac/data/synthetic.h"
#include "diffsac/data/synthetic_two_view.h"
#include "diffsac/data/tutorial_dataset.h"
#include "diffsac/data/two_view_dataset.h"

namespace diffsac {
namespace {

constexpr char kTypeKey[] = "type";

void BindType(OptionsBinder& b, std::string& type) {
  b.Choice(kTypeKey, type,
           {"synthetic_line", "synthetic_plane", "synthetic_two_view", "modelnet40", "point_sets", "correspondences",
            "ransac_tutorial", "kitti"});
}

// The options of one type, with the type beside them.
template <class Options>
struct Typed {
  std::string type;
  Options options;
  void Bind(OptionsBinder& b) {
    BindType(b, type);
    options.Bind(b);
  }
};

// Which keys are valid depends on the type, so it is looked up before anything is bound. Mistakes in it are reported
// by the binder, which knows the line.
std::string PeekType(const Config& config) {
  const YAML::Node root = YAML::Load(config.Dump());
  if (!root.IsMap() || !root[kTypeKey])
    throw Error(config.Where(kTypeKey) +
                ": missing; expected synthetic_line, synthetic_plane, synthetic_two_view, modelnet40, point_sets, "
                "correspondences, ransac_tutorial or kitti");
  return root[kTypeKey].IsScalar() ? root[kTypeKey].as<std::string>() : "";
}

// Calls `use` with the options of the type, read, and the type.
template <class Use>
auto WithOptions(const Config& config, Use use) {
  const std::string type = PeekType(config);
  if (type == "point_sets") return use(ReadOptions<Typed<PointSetsOptions>>(config));
  if (type == "correspondences") return use(ReadOptions<Typed<CorrespondencesOptions>>(config));
  if (type == "synthetic_two_view") return use(ReadOptions<Typed<SyntheticTwoViewOptions>>(config));
  if (type == "ransac_tutorial") return use(ReadOptions<Typed<RansacTutorialOptions>>(config));
  if (type == "kitti") return use(ReadOptions<Typed<KittiOptions>>(config));
  if (type == "modelnet40") return use(ReadOptions<Typed<ModelnetOptions>>(config));
  return use(ReadOptions<Typed<SyntheticOptions>>(config));
}

std::unique_ptr<Dataset> Make(const Typed<PointSetsOptions>& read, std::uint64_t) {
  return MakePointSets(read.options);
}
std::unique_ptr<Dataset> Make(const Typed<CorrespondencesOptions>& read, std::uint64_t) {
  return MakeCorrespondences(read.options);
}
std::unique_ptr<Dataset> Make(const Typed<SyntheticTwoViewOptions>& read, std::uint64_t seed) {
  return MakeSyntheticTwoView(read.options, seed);
}
std::unique_ptr<Dataset> Make(const Typed<ModelnetOptions>& read, std::uint64_t seed) {
  return MakeModelnet(read.options, seed);
}
std::unique_ptr<Dataset> Make(const Typed<RansacTutorialOptions>& read, std::uint64_t seed) {
  return MakeRansacTutorial(read.options, seed);
}
std::unique_ptr<Dataset> Make(const Typed<KittiOptions>& read, std::uint64_t seed) {
  return MakeKitti(read.options, seed);
}
std::unique_ptr<Dataset> Make(const Typed<SyntheticOptions>& read, std::uint64_t seed) {
  return MakeSynthetic(read.type == "synthetic_line" ? Task::kLine : Task::kPlane, read.options, seed);
}

}  // namespace

std::unique_ptr<Dataset> MakeDataset(const Config& config, std::uint64_t seed) {
  return WithOptions(config, [&](const auto& read) { return Make(read, seed); });
}

std::string WriteDatasetOptions(const Config& config) {
  return WithOptions(config, [](const auto& read) { return WriteOptions(read); });
}

}  // namespace diffsac
