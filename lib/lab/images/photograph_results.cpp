#include "lab/images/photograph_results.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <ostream>
#include <set>
#include <sstream>
#include <string_view>
#include <tuple>

#include "diffsac/problem/tasks.h"
#include "lab/colmap/create.h"
#include "lab/config/run_directory.h"
#include "lab/config/typed_options.h"
#include "lab/data/pair_dataset.h"
#include "lab/eval/example_files.h"
#include "lab/eval/export_colmap.h"
#include "lab/eval/format.h"
#include "lab/eval/report_script.h"
#include "lab/eval/run_files.h"
#include "lab/eval/runner.h"
#include "lab/files/files.h"
#include "lab/images/thumbnail.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

std::string PoseColumns(const std::optional<RigidMotion>& pose) {
  std::string text;
  for (const double value : PoseNumbers(pose)) text += "," + NumberText(value);
  return text;
}

std::string SourceColumns(const EstimatedPair& pair) {
  const bool known = pair.estimate.focal || pair.example.problem.cameras;
  return known ? "," + ToString(pair.focal_from[0]) + "," + ToString(pair.focal_from[1]) : ",,";
}

std::string FocalColumns(const EstimateRecord& record, const Problem& problem) {
  if (record.focal) return "," + NumberText(record.focal->focal_px[0]) + "," + NumberText(record.focal->focal_px[1]);
  if (!problem.cameras) return ",,";
  return "," + NumberText(problem.cameras->K1(0, 0)) + "," + NumberText(problem.cameras->K2(0, 0));
}

/// Numbers from 1, as people count.
std::string CameraColumns(const EstimatedPair& pair) {
  std::string text;
  for (const int camera : pair.camera) text += "," + (camera < 0 ? "" : std::to_string(camera + 1));
  return text;
}

/// Whether the pair's matches, or those of all pairs, know each length better than the prior does.
std::string ObservableColumns(const std::optional<FocalEstimate>& focal) {
  std::string text;
  for (int k = 0; k < 2; ++k) text += !focal ? "," : focal->observable[k] ? ",1" : ",0";
  return text;
}

/// 68 % of what the focal lengths may be.
std::string IntervalColumns(const std::optional<FocalEstimate>& focal) {
  std::string text;
  for (int k = 0; k < 2; ++k)
    text += "," + (focal ? NumberText(focal->low_px[k]) : "") + "," + (focal ? NumberText(focal->high_px[k]) : "");
  return text;
}

std::string Milliseconds(double value) { return Format("%.3g", value); }

/// Of COLMAP's camera of an image: as it was given; with the focal length that is known of it; or COLMAP's guess.
/// `from`: where the hint comes from; lengths that were found are where COLMAP may start, not what it may rely on.
ColmapCamera ColmapCameraOf(const SourceImage& image, const CameraPriorHint& hint, FocalSource from,
                            const ImageSize& size) {
  ColmapCamera colmap;
  colmap.size = size;
  const double middle_x = 0.5 * size.width, middle_y = 0.5 * size.height;
  if (!image.camera) {
    constexpr double kGuess = 1.2;
    colmap.has_prior_focal_length = hint.focal && from == FocalSource::kExif;
    colmap.model = ColmapModelNumber("SIMPLE_RADIAL").value();
    colmap.parameters = {hint.focal ? hint.focal->focal : kGuess * std::max(size.width, size.height), middle_x,
                         middle_y, 0.0};
    return colmap;
  }
  if (image.camera->colmap) return *image.camera->colmap;
  const Eigen::Matrix3d& K = image.camera->K;
  colmap.has_prior_focal_length = true;
  colmap.model = ColmapModelNumber("PINHOLE").value();
  colmap.parameters = {K(0, 0), K(1, 1), K(0, 2) + 0.5, K(1, 2) + 0.5};
  return colmap;
}

// As the database names them, where only images of pairs are: of two files that differ in their extension alone one may
// have been left out.
Photographs NamedByDatabase(Photographs photographs, std::vector<EstimatedPair>* pairs) {
  std::set<std::string> paired;
  for (const EstimatedPair& pair : *pairs) paired.insert({pair.example.image1, pair.example.image2});
  std::map<std::int64_t, std::string> files;
  std::vector<SourceImage*> images;
  for (std::size_t i = 0; i < photographs.source.images.size(); ++i) {
    SourceImage& image = photographs.source.images[i];
    if (!paired.contains(image.name)) {
      image.name.clear();
      continue;
    }
    images.push_back(&image);
    files[static_cast<std::int64_t>(images.size())] = photographs.files[i];
  }
  std::map<std::string, std::string> renamed;
  for (const auto& [id, name] : PairNames(files)) {
    std::string& old = images[static_cast<std::size_t>(id) - 1]->name;
    renamed[old] = name;
    old = name;
  }
  for (EstimatedPair& pair : *pairs) {
    Example& example = pair.example;
    example.image1 = renamed.at(example.image1);
    example.image2 = renamed.at(example.image2);
    example.id = example.image1 + "-" + example.image2;
  }
  return photographs;
}

// Images of a calibration that was given share a camera where it is the same, others where one took them.
NewColmapDatabase DatabaseOf(const Photographs& photographs, const FeatureStore& store,
                             const PhotographCameras& cameras, const std::vector<EstimatedPair>& pairs) {
  NewColmapDatabase database;
  std::set<std::string> paired;
  for (const EstimatedPair& pair : pairs) paired.insert({pair.example.image1, pair.example.image2});
  std::map<std::tuple<int, int, int, std::vector<double>>, std::size_t> shared;
  std::map<std::tuple<int, int, int>, std::size_t> of_camera;
  for (std::size_t i = 0; i < photographs.source.images.size(); ++i) {
    const SourceImage& image = photographs.source.images[i];
    if (!paired.contains(image.name)) continue;
    const ImageSize size = store.SizeOf(static_cast<int>(i));
    const ImageFeatures features = store.Load(static_cast<int>(i));
    const ColmapCamera camera = ColmapCameraOf(image, cameras.hints[i], cameras.from[i], size);
    std::size_t number = database.cameras.size();
    if (image.camera)
      number = shared.try_emplace({camera.model, size.width, size.height, camera.parameters}, number).first->second;
    else
      number = of_camera.try_emplace({cameras.camera[i], size.width, size.height}, number).first->second;
    if (number == database.cameras.size()) database.cameras.push_back(camera);
    database.images.push_back(
        {photographs.files[i], number, PointMatrix(features.positions.array() + 0.5), features.frames});
  }
  return database;
}

// Matches by the ids of the images that the database has.
void AddMatches(const std::vector<EstimatedPair>& pairs, NewColmapDatabase* database) {
  std::map<std::int64_t, std::string> files;
  for (std::size_t i = 0; i < database->images.size(); ++i)
    files[static_cast<std::int64_t>(i) + 1] = database->images[i].name;
  std::map<std::string, std::int64_t> ids;
  for (const auto& [id, name] : PairNames(files)) ids[name] = id;
  for (const EstimatedPair& pair : pairs) {
    const std::int64_t id1 = ids.at(pair.example.image1), id2 = ids.at(pair.example.image2);
    MatchIndices matches = pair.matches;
    if (id1 > id2) matches.col(0).swap(matches.col(1));
    database->matches[{std::min(id1, id2), std::max(id1, id2)}] = matches;
  }
}

std::string FolderOfMatches(const std::string& output, const std::string& scene) {
  return (fs::path(output) / "matches" / scene).string();
}

void WriteMatches(const std::vector<EstimatedPair>& pairs, const std::string& folder) {
  CorrespondenceSet set;
  const bool keypoints = std::all_of(pairs.begin(), pairs.end(), [](const EstimatedPair& pair) {
    return pair.matches.rows() == pair.example.problem.points.rows();
  });
  for (const EstimatedPair& pair : pairs) {
    set.pairs.push_back(pair.example);
    if (keypoints) set.match_indices.push_back(pair.matches);
  }
  MakeWritableFolder(folder);
  WriteCorrespondences(folder, set);
}

// As if diffsac_eval had run the row on the folder of the matches.
ExperimentResults ResultsOf(const std::vector<EstimatedPair>& pairs, ExperimentOptions experiment,
                            const std::string& scene, const std::string& folder, double inlier_threshold_px) {
  CorrespondencesOptions data;
  data.paths = {folder};
  data.pairs.task = experiment.task;
  data.pairs.inlier_threshold_px = inlier_threshold_px;
  experiment.conditions = {{"all", "all", {}, ToConfig(TypedOptions<CorrespondencesOptions>{"correspondences", data})}};
  ExperimentResults results;
  results.dataset = "correspondences";
  results.git_revision = GitRevision();
  results.machine = MachineText();
  results.problems = {pairs.size()};
  Cell cell;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    // As it is read again.
    Example example = pairs[i].example;
    example.index = i;
    example.scene = scene;
    example.id = scene + "/" + example.id;
    cell.records.push_back(MakeRecord(experiment, example, pairs[i].estimate));
  }
  results.cells = {std::move(cell)};
  results.experiment = std::move(experiment);
  return results;
}

// For diffsac_eval, which looks for paths beside the file.
void WriteConfiguration(ExperimentOptions experiment, const std::string& scene, const std::string& output) {
  Condition& all = experiment.conditions.at(0);
  auto data = ReadOptions(all.data, TypedOptions<CorrespondencesOptions>{"correspondences", {}});
  data.options.paths = {"matches/" + scene};
  all.data = ToConfig(data);
  RunDirectory(output, kPairProgram, WriteExperiment(experiment), experiment.seed);
}

/// Whether a focal length is what cameras in general have, and the motion depends on it.
bool IsGuess(const EstimatedPair& pair) {
  return FindsFocals(pair.example.problem.task) && pair.estimate.focal &&
         (pair.focal_from[0] == FocalSource::kPrior || pair.focal_from[1] == FocalSource::kPrior);
}

bool IsSure(const EstimatedPair& pair) {
  return pair.estimate.status == Status::kOk && !pair.estimate.MayBeChance() && !IsGuess(pair) &&
         !pair.estimate.focal_conflict;
}

/// The images of the pairs that sure ones join, largest group first; images of none are groups of their own.
std::vector<std::vector<std::string>> JoinedImages(const std::vector<EstimatedPair>& pairs,
                                                   const std::map<std::string, std::string>& files) {
  std::map<std::string, std::size_t> group;
  for (const EstimatedPair& pair : pairs)
    if (!pair.example.image1.empty())
      for (const std::string& name : {pair.example.image1, pair.example.image2}) group.emplace(name, group.size());
  for (const EstimatedPair& pair : pairs) {
    if (!IsSure(pair) || pair.example.image1.empty()) continue;
    const std::size_t into = group.at(pair.example.image1), from = group.at(pair.example.image2);
    for (auto& [name, of] : group)
      if (of == from) of = into;
  }
  std::map<std::size_t, std::vector<std::string>> members;
  for (const auto& [name, of] : group) members[of].push_back(files.contains(name) ? files.at(name) : name);
  std::vector<std::vector<std::string>> groups;
  for (auto& [of, names] : members) {
    std::sort(names.begin(), names.end());
    groups.push_back(std::move(names));
  }
  std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return groups;
}

std::string NamesText(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.size() > kMost ? text + " and " + std::to_string(names.size() - kMost) + " more" : text;
}

void SayGroups(const std::vector<EstimatedPair>& pairs, const std::map<std::string, std::string>& files,
               std::ostream& out) {
  std::vector<std::string> alone;
  for (const auto& group : JoinedImages(pairs, files))
    if (group.size() == 1)
      alone.push_back(group.front());
    else
      out << "  " << group.size() << " images belong together: " << NamesText(group) << "\n";
  if (!alone.empty()) out << "  " << alone.size() << " images belong to no other: " << NamesText(alone) << "\n";
}

void SayResults(const std::vector<EstimatedPair>& pairs, const std::map<std::string, std::string>& files,
                const std::string& output, const std::string& scene, std::ostream& out) {
  std::size_t models = 0, chance = 0, guessed = 0;
  for (const EstimatedPair& pair : pairs)
    if (pair.estimate.status == Status::kOk)
      (IsSure(pair) ? models : pair.estimate.MayBeChance() ? chance : guessed) += 1;
  const std::string folder = (fs::path(output) / "").string();
  out << scene << ": " << pairs.size() << " pairs: " << models << " are sure, " << chance << " may be chance, "
      << (guessed > 0 ? std::to_string(guessed) + " rest on a guessed focal length, " : "")
      << pairs.size() - models - chance - guessed << " have no model\n";
  SayGroups(pairs, files, out);
  if (chance > 0)
    out << "  pairs that may be chance: do not use their poses (may_be_chance in " << kPosesFile
        << ") unless their matches look right in " << kReportFile << "\n";
  out << "  " << folder << kPosesFile << ": R, t and inliers of each pair\n"
      << "  " << folder << kReportFile << ": the pairs and their matches, for a browser\n"
      << "  " << folder << kEstimatesFile << ": inliers, covariances and more\n"
      << "  " << folder << "matches: for diffsac_eval" << std::endl;
}

/// As a shell takes it for one word.
std::string ShellWord(const std::string& text) {
  const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || std::string_view("/._-+=:@%,").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (plain) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

/// All but the thumbnails and what `also` writes once there are results.
void WriteRun(std::vector<EstimatedPair>* pairs, std::size_t asked, const std::map<std::string, std::string>& files,
              const std::string& scene, ExperimentOptions experiment, double inlier_threshold_px,
              const std::string& output, const std::function<void(const ExperimentResults&)>& also) {
  // In the order in which the files list them.
  std::sort(pairs->begin(), pairs->end(),
            [](const EstimatedPair& a, const EstimatedPair& b) { return a.example.id < b.example.id; });
  const std::string method = experiment.methods.at(0).name, folder = FolderOfMatches(output, scene);
  const std::uint64_t seed = experiment.seed;
  WriteMatches(*pairs, folder);
  ExperimentResults results = ResultsOf(*pairs, std::move(experiment), scene, folder, inlier_threshold_px);
  results.partial = pairs->size() < asked;
  KeepEstimates(results, output);
  if (also) also(results);
  WritePairs(results, output);
  WriteConfiguration(results.experiment, scene, output);
  WriteFileAtomically((fs::path(output) / "problems.csv").string(), ProblemsCsv(results));
  EndResults(MakeReport(results), output);
  WriteFileAtomically((fs::path(output) / kPosesFile).string(), PosesCsv(*pairs, files, method, seed));
  WriteReport(output);  // It reads all of these.
}

}  // namespace

std::string PosesCsv(const std::vector<EstimatedPair>& pairs, const std::map<std::string, std::string>& files,
                     const std::string& method, std::uint64_t seed) {
  const auto file = [&](const std::string& name) {
    const auto found = files.find(name);
    return CsvText(found == files.end() ? name : found->second);
  };
  std::string text =
      "image1,image2,status,may_be_chance,method,seed,qw,qx,qy,qz,tx,ty,tz,focal1_px,focal2_px,matches,inliers,noise_"
      "px,"
      "ms_matching,ms_estimate,m11,m12,m13,m21,m22,m23,m31,m32,m33,degeneracy,focal1_source,focal2_source,other_qw,"
      "other_qx,"
      "other_qy,other_qz,other_tx,other_ty,other_tz,camera1,camera2,focal1_low_px,focal1_high_px,focal2_low_px,"
      "focal2_high_px,focal1_observable,focal2_observable\n";
  for (const EstimatedPair& pair : pairs) {
    const EstimateRecord record = RecordOf(pair.example, pair.estimate);
    const Example& example = pair.example;
    text += (example.image1.empty() ? CsvText(example.id) : file(example.image1)) + "," + file(example.image2) + "," +
            std::string(ToString(record.status)) + "," + (record.MayBeChance() ? "1" : "0") + "," + CsvText(method) +
            "," + std::to_string(seed) + PoseColumns(record.pose) + FocalColumns(record, pair.example.problem) + "," +
            std::to_string(record.points) + "," + std::to_string(record.inlier_rows.size()) + "," +
            NumberText(record.sigma) + "," + Milliseconds(pair.ms_matching) + "," +
            Milliseconds(pair.estimate.stats.ms_total);
    const bool has_matrix = record.model.size() > 0 && IsTwoView(example.problem.task);
    for (Eigen::Index i = 0; i < 9; ++i) text += "," + (has_matrix ? NumberText(record.model[i]) : "");
    text += "," + ToString(record.degeneracy) + SourceColumns(pair) + PoseColumns(record.ambiguous_pose) +
            CameraColumns(pair) + IntervalColumns(record.focal) + ObservableColumns(record.focal) + "\n";
  }
  return text;
}

void WritePhotographResults(const Photographs& given, const FeatureStore& store, const PhotographCameras& cameras,
                            std::vector<EstimatedPair> pairs, ExperimentOptions experiment, double inlier_threshold_px,
                            const std::string& output, std::ostream& out) {
  const std::size_t asked = pairs.size();
  std::erase_if(pairs, [](const EstimatedPair& pair) { return !pair.done; });
  const Photographs photographs = NamedByDatabase(given, &pairs);
  const std::string scene = given.source.scenes.at(0).name;
  MakeWritableFolder(FolderOfMatches(output, scene));
  std::vector<Example> examples;
  for (const EstimatedPair& pair : pairs) {
    examples.emplace_back();
    examples.back().image1 = pair.example.image1;
    examples.back().image2 = pair.example.image2;
  }
  WriteThumbnailsOf(photographs.source, examples, experiment.threads, FolderOfMatches(output, scene));
  std::map<std::string, std::string> files;
  for (std::size_t i = 0; i < photographs.files.size(); ++i)
    files[photographs.source.images[i].name] = photographs.files[i];
  const auto write_database = [&](const ExperimentResults& results) {
    NewColmapDatabase database = DatabaseOf(photographs, store, cameras, pairs);
    AddMatches(pairs, &database);
    const std::string path = (fs::path(output) / kDatabaseFile).string();
    CreateColmapDatabase(path, database);
    std::ostringstream said;
    ExportColmap(results, {.database = path}, said);
  };
  WriteRun(&pairs, asked, files, scene, std::move(experiment), inlier_threshold_px, output, write_database);
  SayResults(pairs, files, output, scene, out);
  const std::string folder = (fs::path(output) / "").string();
  out << "  " << folder << kDatabaseFile << ": mkdir model && colmap mapper --database_path "
      << ShellWord(folder + kDatabaseFile) << " --image_path " << ShellWord(photographs.folder)
      << " --output_path model" << std::endl;
}

void WriteGivenResults(std::vector<EstimatedPair> pairs, const std::map<std::string, std::string>& files,
                       const std::string& scene, ExperimentOptions experiment, double inlier_threshold_px,
                       const std::string& output, std::ostream& out) {
  const std::size_t asked = pairs.size();
  std::erase_if(pairs, [](const EstimatedPair& pair) { return !pair.done; });
  WriteRun(&pairs, asked, files, scene, std::move(experiment), inlier_threshold_px, output, {});
  SayResults(pairs, files, output, scene, out);
}

}  // namespace diffsac
