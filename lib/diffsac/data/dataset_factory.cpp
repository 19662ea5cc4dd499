#include "diffsac/data/dataset_factory.h"

#include <yaml-cpp/yaml.h>

#include "diffsac/data/point_files.h"
#include "diffsac/data/synthetic.h"
#include "diffsac/data/two_view_dataset.h"

namespace diffsac {
namespace {

constexpr char kTypeKey[] = "type";

void BindType(OptionsBinder& b, std::string& type) {
  b.Choice(kTypeKey, type, {"synthetic_line", "synthetic_plane", "point_sets", "correspondences"});
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
    throw Error(config.Where(kTypeKey) + ": missing; expected synthetic_line, synthetic_plane, point_sets or correspondences");
  return root[kTypeKey].IsScalar() ? root[kTypeKey].as<std::string>() : "";
}

}  // namespace

std::unique_ptr<Dataset> MakeDataset(const Config& config, std::uint64_t seed) {
  const std::string type = PeekType(config);
  if (type == "point_sets") return MakePointSets(ReadOptions<Typed<PointSetsOptions>>(config).options);
  if (type == "correspondences")
    return MakeCorrespondences(ReadOptions<Typed<CorrespondencesOptions>>(config).options);
  const auto read = ReadOptions<Typed<SyntheticOptions>>(config);
  return MakeSynthetic(read.type == "synthetic_line" ? Task::kLine : Task::kPlane, read.options, seed);
}

std::string WriteDatasetOptions(const Config& config) {
  const std::string type = PeekType(config);
  if (type == "point_sets") return WriteOptions(ReadOptions<Typed<PointSetsOptions>>(config));
  if (type == "correspondences") return WriteOptions(ReadOptions<Typed<CorrespondencesOptions>>(config));
  return WriteOptions(ReadOptions<Typed<SyntheticOptions>>(config));
}

}  // namespace diffsac
