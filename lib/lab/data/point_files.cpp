#include "lab/data/point_files.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "lab/config/dataset_registry.h"
#include "lab/data/finite_points.h"
#include "lab/data/pair_filter.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr const char *kType = "point_sets", *kExtensions = ".ply, .csv, .txt, .xyz, .dat or .tsv";

enum class FileKind { kUnknown, kPly, kText };

FileKind KindOf(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".ply") return FileKind::kPly;
  for (const char* text : {".csv", ".txt", ".xyz", ".dat", ".tsv"})
    if (extension == text) return FileKind::kText;
  return FileKind::kUnknown;
}

// The readable files of a folder in the order of their names.
std::vector<std::string> FilesOf(const std::string& folder) {
  std::error_code code;
  std::vector<std::string> files;
  for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code))
    if (it->is_regular_file() && KindOf(it->path()) != FileKind::kUnknown) files.push_back(it->path().string());
  if (code) throw Error(folder + ": cannot list this folder: " + code.message());
  if (files.empty()) throw Error(folder + ": no point files here; expected " + kExtensions);
  std::sort(files.begin(), files.end());
  return files;
}

/// The sets of a file, or of the files of a folder; of several one that cannot be read costs no other.
std::vector<std::pair<std::string, PointSet>> ReadPath(const std::string& path) {
  const std::vector<std::string> files = fs::is_directory(path) ? FilesOf(path) : std::vector<std::string>{path};
  std::vector<std::pair<std::string, PointSet>> sets;
  std::string problem;
  for (const std::string& file : files) {
    try {
      for (PointSet& set : ReadPointFile(file)) sets.emplace_back(file, std::move(set));
    } catch (const Error& error) {
      problem = error.what();
      if (files.size() > 1) WarnOnce("left out: " + problem);
    }
  }
  if (sets.empty() && !problem.empty()) throw Error(problem);
  return sets;
}

double BoxDiagonal(const PointMatrix& points) {
  Eigen::RowVectorXd low = Eigen::RowVectorXd::Constant(points.cols(), std::numeric_limits<double>::infinity());
  Eigen::RowVectorXd high = -low;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (!points.row(i).allFinite()) continue;
    low = low.cwiseMin(points.row(i));
    high = high.cwiseMax(points.row(i));
  }
  return high[0] >= low[0] ? (high - low).norm() : 0.0;
}

double ThresholdFor(const PointSetsOptions& options, const PointSet& set) {
  if (options.inlier_threshold > 0.0) return options.inlier_threshold;
  if (options.inlier_threshold_relative > 0.0) {
    const double diagonal = BoxDiagonal(set.points);
    // Equal or unusable points have no extent; any positive threshold lets the estimators report them.
    return options.inlier_threshold_relative * (diagonal > 0.0 ? diagonal : 1.0);
  }
  throw Error(set.name + ": no inlier threshold: set inlier_threshold (data units) or inlier_threshold_relative");
}

/// Leaves a random subset of at most `count` points, in their order; `source->rows` are those of the points before.
void TakeSubset(int count, std::uint64_t seed, Example* example, PointSource* source) {
  const auto total = static_cast<int>(example->problem.points.rows());
  if (count <= 0 || total <= count) return;
  std::vector<int> kept(count);
  Rng(seed).Fork("max_points/" + example->scene + "/" + example->id).Distinct(total, count, kept.data());
  std::sort(kept.begin(), kept.end());
  *example = WithRows(*example, kept);
  example->digest = PointDigest(example->problem.points);
  std::vector<std::int32_t> rows;
  for (const int i : kept) rows.push_back(source->rows.empty() ? i : source->rows[static_cast<std::size_t>(i)]);
  source->rows = std::move(rows);
}

class PointSetsDataset : public Dataset, public HasPointSources {
 public:
  explicit PointSetsDataset(const PointSetsOptions& options) : task_(options.task) {
    for (const std::string& path : options.paths)
      for (auto& [file, set] : ReadPath(path)) Add(options, file, std::move(set));
  }

  Task task() const override { return task_; }
  std::int64_t size() const override { return static_cast<std::int64_t>(examples_.size()); }
  Example Get(std::uint64_t index) const override { return examples_.at(index); }
  const PointSource& SourceOf(std::uint64_t index) const override { return sources_.at(index); }

 private:
  void Add(const PointSetsOptions& options, const std::string& file, PointSet set) {
    if (set.points.cols() == 2 && PointDimension(task_) == 3 && !set.columns.empty())
      throw Error(file + ": no column z, which the task " + ToString(task_) + " needs; its columns are " + set.columns);
    if (set.points.cols() != PointDimension(task_))
      throw Error(file + ": " + std::to_string(set.points.cols()) + " columns, but the task " + ToString(task_) +
                  " needs " + std::to_string(PointDimension(task_)));
    Example example;
    example.id = UniqueId(set.name);
    example.scene = std::move(set.scene);
    example.problem.task = task_;
    example.problem.inlier_threshold = ThresholdFor(options, set);
    example.problem.points = std::move(set.points);
    if (example.problem.points.rows() == 0) throw Error(file + ": no points");
    PointSource source{file, set.name, {}, example.problem.points.rows()};
    const std::vector<int> finite = FiniteRows(example.problem.points);
    if (static_cast<std::int64_t>(finite.size()) < source.total) source.rows.assign(finite.begin(), finite.end());
    example = WithFinitePoints(std::move(example), file);
    if (example.problem.points.rows() == 0) throw Error(file + ": no finite points");
    TakeSubset(options.max_points, options.seed, &example, &source);
    example.index = examples_.size();
    examples_.push_back(std::move(example));
    sources_.push_back(std::move(source));
  }

  // Files of the same name in different folders get a number.
  std::string UniqueId(const std::string& name) {
    std::string id = name;
    for (int i = 2; !ids_.insert(id).second; ++i) id = name + "#" + std::to_string(i);
    return id;
  }

  Task task_;
  std::vector<Example> examples_;
  std::vector<PointSource> sources_;
  std::set<std::string> ids_;
};

}  // namespace

std::vector<PointSet> ReadPointFile(const std::string& path) {
  std::error_code code;
  if (!fs::exists(path, code)) throw Error(path + ": no such file");
  if (KindOf(path) == FileKind::kUnknown) throw Error(path + ": unknown kind of file; expected " + kExtensions);
  return {KindOf(path) == FileKind::kPly ? ReadPlyPoints(path) : ReadTextPoints(path)};
}

bool IsPointSets(const Config& data) { return data.Has("type") && data.Text("type") == kType; }

bool IsTextPointFile(const std::string& path) { return KindOf(path) == FileKind::kText; }

void PointSetsOptions::Bind(OptionsBinder& b) {
  b.Field("paths", paths)
      .Help("files, or folders whose readable files are taken in the order of their names (not recursively)");
  b.Field("task", task, {Task::kLine, Task::kPlane}).Help("2 or 3 columns");
  b.Field("inlier_threshold", inlier_threshold, AtLeast(0.0)).Help("ε in the data's unit; 0: as the next option says");
  b.Field("inlier_threshold_relative", inlier_threshold_relative, Within(0.0, 1.0))
      .Help("ε as a share of the diagonal of the set's bounding box (finite points); 0: not used");
  b.Field("unit", unit).Help("of the coordinates, as results name it (m, mm); empty: it is not said");
  b.Field("max_points", max_points, AtLeast(0))
      .Help("larger sets are reduced to a random subset of this size, in the order of the file; 0 keeps all points");
  b.Field("seed", seed)
      .OnlyIf(max_points > 0, "max_points above 0")
      .Help("of the random subsets; the seed of a run leaves them alone");
  b.Require(!paths.empty(), "paths", "at least one file or folder of points");
  b.Require(inlier_threshold == 0.0 || inlier_threshold_relative == 0.0, "inlier_threshold_relative",
            "only one of inlier_threshold and inlier_threshold_relative");
}

std::unique_ptr<Dataset> MakePointSets(const PointSetsOptions& options) {
  CheckOptions(options);
  return std::make_unique<PointSetsDataset>(options);
}

const RegisteredDataset<PointSetsOptions> kPointSets(kType, DataSource::kFiles,
                                                     "Points of your own: PLY or text files (lines and planes).",
                                                     [](const PointSetsOptions& options, std::uint64_t) {
                                                       return MakePointSets(options);
                                                     });

}  // namespace diffsac
