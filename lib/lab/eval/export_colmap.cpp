#include "lab/eval/export_colmap.h"

#include <algorithm>
#include <map>
#include <memory>
#include <ostream>

#include "diffsac/core/status.h"
#include "diffsac/geometry/two_view.h"
#include "diffsac/problem/tasks.h"
#include "lab/colmap/two_view_geometries.h"
#include "lab/data/pair_dataset.h"
#include "lab/data/pair_filter.h"
#include "lab/data/pair_scenes.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

constexpr const char* kDataType = "correspondences";

template <class Item, class NameOf>
std::string Names(const std::vector<Item>& items, NameOf name_of) {
  std::string names;
  for (const Item& item : items) names += (names.empty() ? "" : ", ") + name_of(item);
  return names;
}

// A pair with what lies behind its matches.
struct SourcePair {
  Example example;        // as it stands in the files
  std::vector<int> rows;  // which of its matches the problem had, in the problem's order
  MatchIndices keypoints;
};

// The correspondence files behind a condition's problems.
class SourcePairs {
 public:
  explicit SourcePairs(const Config& data)
      : options_(ReadOptions(data, TypedOptions<CorrespondencesOptions>{kDataType, {}}).options) {
    for (const std::string& path : options_.paths)
      for (const SceneFolder& folder : FindScenes(path)) {
        Scene& scene = scenes_[folder.name];
        if (scene.files)
          throw Error("--export-colmap: two scenes are named " + folder.name + ": " + scene.files->folder() + " and " +
                      folder.folder);
        scene.files = std::make_unique<CorrespondenceScene>(folder.folder);
        const std::vector<std::string>& pairs = scene.files->pairs();
        for (std::size_t i = 0; i < pairs.size(); ++i) scene.positions[pairs[i]] = static_cast<std::int64_t>(i);
      }
  }

  SourcePair Read(const EstimateRecord& record) const {
    const Scene& scene = scenes_.at(record.scene);
    const std::string name = record.id.substr(record.scene.size() + 1);
    SourcePair pair{scene.files->Read(scene.positions.at(name)), {}, {}};
    pair.keypoints = scene.files->ReadMatchIndices(name, pair.example.problem.points.rows());
    pair.example.id = record.id;
    pair.rows = KeptRows(pair.example, options_.pairs.filter);
    if (static_cast<int>(pair.rows.size()) != record.points)
      throw Error(scene.files->folder() + ": " + name + ": its matches are others than those of the run");
    return pair;
  }

 private:
  struct Scene {
    std::unique_ptr<CorrespondenceScene> files;
    std::map<std::string, std::int64_t> positions;
  };

  CorrespondencesOptions options_;
  std::map<std::string, Scene> scenes_;
};

// The matrix of a two-view model in our pixels.
Eigen::Matrix3d PixelMatrix(Task task, const ModelParameters& model, const Problem& problem) {
  return DispatchDescription(task, [&]<class Description>() -> Eigen::Matrix3d {
    if constexpr (Description::kTwoView) return AsMatrix(Description::PixelModel(model, problem));
    return Eigen::Matrix3d::Zero();
  });
}

// A focal length that was found here is not the database's: E of it would be wrong there.
ColmapGeometry GeometryOfRecord(Task task, const EstimateRecord& record, const Problem& problem) {
  FoundGeometry found{problem.points, record.inlier_rows, record.degeneracy, record.pose};
  // Of matches by chance nothing shows parallax, nor anything else.
  if (record.MayBeChance()) found.degeneracy = Degeneracy::kNotTested;
  if (task == Task::kHomography) {
    found.homography = AsMatrix(record.model);
  } else {
    found.fundamental = PixelMatrix(task, record.model, problem);
    if (task == Task::kEssential) found.essential = AsMatrix(record.model);
  }
  return GeometryOf(found);
}

// Images of a database by the names that pairs have.
class ImageIds {
 public:
  explicit ImageIds(const ColmapDatabase& database) : path_(database.path()) {
    for (const auto& [id, name] : PairNames(database)) ids_[name] = id;
  }
  std::int64_t Of(const std::string& name, const std::string& pair) const {
    const auto found = ids_.find(name);
    if (found == ids_.end())
      throw Error(path_ + ": it has no image '" + name + "' of the pair " + pair + ": is the pair from this database?");
    return found->second;
  }

 private:
  std::string path_;
  std::map<std::string, std::int64_t> ids_;
};

/// A pair that is not verified has a geometry without matches, so that COLMAP does not try it again.
ColmapGeometry GeometryOfPair(Task task, const EstimateRecord& record, const SourcePair& pair, const ImageIds& ids,
                              bool chance) {
  const bool verified = record.status == Status::kOk && (!record.MayBeChance() || chance);
  ColmapGeometry geometry = verified ? GeometryOfRecord(task, record, pair.example.problem) : ColmapGeometry();
  geometry.pair = {ids.Of(pair.example.image1, record.id), ids.Of(pair.example.image2, record.id)};
  if (!verified) return geometry;
  geometry.inliers.resize(static_cast<Eigen::Index>(record.inlier_rows.size()), 2);
  for (std::size_t i = 0; i < record.inlier_rows.size(); ++i)
    geometry.inliers.row(static_cast<Eigen::Index>(i)) = pair.keypoints.row(pair.rows.at(record.inlier_rows[i]));
  return geometry;
}

}  // namespace

void CheckColmapExport(const ExperimentOptions& experiment, const ColmapExport& target) {
  if (target.database.empty()) return;
  if (!experiment.estimates) throw Error("--export-colmap needs estimates: true in the experiment");
  if (!IsTwoView(experiment.task))
    throw Error("--export-colmap is for tasks of two views, not for " + ToString(experiment.task));
  if (experiment.methods.size() != 1)
    throw Error("--export-colmap writes the estimates of one row; choose it with --methods: " +
                Names(experiment.methods, [](const EstimatorRow& row) { return row.name; }));
  if (experiment.conditions.size() != 1)
    throw Error("--export-colmap writes the estimates of one condition, but the experiment has " +
                Names(experiment.conditions, [](const Condition& condition) { return condition.name; }));
  const Config& data = experiment.conditions[0].data;
  if (const std::string type = data.Has("type") ? data.Text("type") : ""; type != kDataType)
    throw Error(data.Where("type") + ": --export-colmap needs data of type correspondences, not " + type);
  const ColmapDatabase database(target.database);
}

void ExportColmap(const ExperimentResults& results, const ColmapExport& target, std::ostream& out) {
  if (target.database.empty()) return;
  const ExperimentOptions& experiment = results.experiment;
  const SourcePairs source(experiment.conditions.at(0).data);
  const ColmapDatabase database(target.database, SqliteDatabase::Access::kWrite);
  const ImageIds ids(database);
  std::vector<ColmapGeometry> geometries;
  const std::vector<ProblemRecord>& records = results.cells.at(0).records;
  for (const ProblemRecord& record : records)
    geometries.push_back(GeometryOfPair(experiment.task, record, source.Read(record), ids, target.chance));
  WriteGeometries(database, geometries, target.overwrite);
  const auto by_chance = std::count_if(records.begin(), records.end(), [](const auto& r) { return r.MayBeChance(); });
  std::int64_t verified = 0, inliers = 0;
  for (const ColmapGeometry& geometry : geometries) {
    if (geometry.inliers.rows() < kColmapMinInliers) continue;
    verified += 1;
    inliers += geometry.inliers.rows();
  }
  out << target.database << ": " << verified << " of " << geometries.size() << " pairs verified, " << inliers
      << " inliers" << std::endl;
  if (by_chance > 0 && !target.chance)
    out << by_chance << " pairs have no more inliers than unlike images would give and are left out (--export-chance)"
        << std::endl;
}

}  // namespace diffsac
