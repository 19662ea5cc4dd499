#include "lab/images/photograph_results.h"

#include <Eigen/LU>
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <ostream>
#include <string_view>
#include <tuple>

#include "lab/colmap/database.h"
#include "lab/colmap/two_view_geometries.h"
#include "lab/config/report_script.h"
#include "lab/config/run_directory.h"
#include "lab/eval/format.h"
#include "lab/files/files.h"
#include "lab/images/pair_text.h"
#include "lab/images/pictures.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

/// Columns of poses.csv, and where their values are in a pair of pairs.json.
struct Columns {
  const char* names;
  std::vector<const char*> places;
};
const std::vector<Columns> kColumns = {
    {"image1,image2,status,may_be_chance,method,seed",
     {"/image1", "/image2", "/status", "/may_be_chance", "/method", "/seed"}},
    {"qw,qx,qy,qz,tx,ty,tz",
     {"/pose/q/0", "/pose/q/1", "/pose/q/2", "/pose/q/3", "/pose/t/0", "/pose/t/1", "/pose/t/2"}},
    {"focal1_px,focal2_px", {"/focal/px/0", "/focal/px/1"}},
    {"matches,inliers,noise_px,ms_matching,ms_estimate",
     {"/matches", "/num_inliers", "/sigma_px", "/ms/matching", "/ms/estimate"}},
    {"m11,m12,m13,m21,m22,m23,m31,m32,m33",
     {"/model/0", "/model/1", "/model/2", "/model/3", "/model/4", "/model/5", "/model/6", "/model/7", "/model/8"}},
    {"degeneracy,focal1_source,focal2_source", {"/degeneracy", "/focal/source/0", "/focal/source/1"}},
    {"other_qw,other_qx,other_qy,other_qz,other_tx,other_ty,other_tz",
     {"/ambiguous_pose/q/0", "/ambiguous_pose/q/1", "/ambiguous_pose/q/2", "/ambiguous_pose/q/3", "/ambiguous_pose/t/0",
      "/ambiguous_pose/t/1", "/ambiguous_pose/t/2"}},
    {"camera1,camera2", {"/camera1", "/camera2"}},
    {"focal1_low_px,focal1_high_px,focal2_low_px,focal2_high_px",
     {"/focal/low_px/0", "/focal/high_px/0", "/focal/low_px/1", "/focal/high_px/1"}},
    {"focal1_observable,focal2_observable", {"/focal/observable/0", "/focal/observable/1"}},
    {"verdict,focal_conflict", {"/verdict", "/contradicts_focal"}}};

/// Empty where there is nothing.
std::string CellText(const Json& pair, const char* place) {
  const Json::json_pointer pointer(place);
  if (!pair.contains(pointer)) return "";
  const Json& value = pair.at(pointer);
  if (value.is_string()) return CsvText(value.get<std::string>());
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  return value.is_number_float() ? NumberText(value.get<double>()) : value.is_null() ? "" : value.dump();
}

/// What a file calls an image; empty where it has no name.
const std::string& FileOf(const PhotographsRun& run, int image) {
  return run.photographs.files.at(static_cast<std::size_t>(image));
}

/// Of a pair without images its own name.
std::string FirstOf(const PhotographsRun& run, const ImagePair& pair) {
  const std::string& file = FileOf(run, pair.images[0]);
  return file.empty() ? pair.example.id : file;
}

Json JsonOf(const ImagePair& pair, const PhotographsRun& run) {
  Json json = PairJson(pair, FirstOf(run, pair), FileOf(run, pair.images[1]));
  // Cameras are counted from 1, as people do.
  json["camera1"] = pair.camera[0] < 0 ? Json(nullptr) : Json(pair.camera[0] + 1);
  json["camera2"] = pair.camera[1] < 0 ? Json(nullptr) : Json(pair.camera[1] + 1);
  json["contradicts_focal"] = !json["focal_conflict"].is_null();
  json["names"] = {pair.example.image1, pair.example.image2};
  return json;
}

Json RunJson(std::vector<Json> pairs, const PhotographsRun& run, bool partial) {
  const std::string scene = run.photographs.source.scenes.at(0).name;
  return {{"program", kPairProgram},
          {"version", VersionText(kPairProgram)},
          {"machine", MachineText()},
          {"name", scene},
          {"task", ToString(run.options.task)},
          {"method", ToString(run.options.guidance)},
          {"seed", run.options.seed},
          {"partial", partial},
          {"matches", "matches/" + scene},
          {"pairs", std::move(pairs)}};
}

/// Of COLMAP's camera of an image: as it was given; with the focal length that is known of it; or COLMAP's guess.
/// Lengths that were found are where COLMAP may start, not what it may rely on.
ColmapCamera ColmapCameraOf(const PhotographsRun& run, std::size_t i, const ImageSize& size) {
  const SourceImage& image = run.photographs.source.images[i];
  ColmapCamera colmap;
  colmap.size = size;
  if (!image.camera) {
    constexpr double kGuess = 1.2;
    const auto& focal = run.cameras.hints[i].focal;
    colmap.has_prior_focal_length = focal && run.cameras.from[i] == FocalSource::kExif;
    colmap.model = ColmapModelNumber("SIMPLE_RADIAL").value();
    colmap.parameters = {focal ? focal->focal : kGuess * std::max(size.width, size.height), 0.5 * size.width,
                         0.5 * size.height, 0.0};
    return colmap;
  }
  if (image.camera->colmap) return *image.camera->colmap;
  const Eigen::Matrix3d& K = image.camera->K;
  colmap.has_prior_focal_length = true;
  colmap.model = ColmapModelNumber("PINHOLE").value();
  colmap.parameters = {K(0, 0), K(1, 1), K(0, 2) + 0.5, K(1, 2) + 0.5};
  return colmap;
}

ColmapGeometry GeometryOfPair(const ImagePair& pair, const ColmapPair& ids) {
  const PairEstimate& estimate = pair.estimate;
  const Problem& problem = pair.example.problem;
  ColmapGeometry geometry;
  if (estimate.ok() && !estimate.MayBeChance()) {
    FoundGeometry found{problem.points, {}, estimate.diagnostics.degeneracy, estimate.pose};
    for (std::size_t i = 0; i < estimate.inliers.size(); ++i)
      if (estimate.inliers[i] != 0) found.inliers.push_back(static_cast<std::int32_t>(i));
    found.fundamental = estimate.model;
    if (problem.task == Task::kHomography) found.homography = estimate.model;
    if (problem.task == Task::kEssential) {
      found.essential = estimate.model;
      found.fundamental = problem.cameras->K2.inverse().transpose() * estimate.model * problem.cameras->K1.inverse();
    }
    geometry = GeometryOf(found);
    geometry.inliers = pair.matches(found.inliers, Eigen::all);
  }
  geometry.pair = ids;
  return geometry;
}

/// Of the images of pairs. Those of a calibration that was given share a camera where it is the same, others where one
/// took them.
void WriteDatabase(const std::vector<ImagePair>& pairs, const PhotographsRun& run) {
  NewColmapDatabase database;
  std::map<int, std::int64_t> ids;  // By image; in the images' order.
  for (const ImagePair& pair : pairs)
    for (const int image : pair.images) ids[image] = 0;
  std::map<std::tuple<int, int, int, std::vector<double>>, std::size_t> shared;
  for (auto& [image, id] : ids) {
    const auto i = static_cast<std::size_t>(image);
    const ImageSize size = run.store->SizeOf(image);
    const ImageFeatures features = run.store->Load(image);
    const ColmapCamera camera = ColmapCameraOf(run, i, size);
    const bool given = run.photographs.source.images[i].camera.has_value();
    const std::size_t number =
        given ? shared.try_emplace({camera.model, size.width, size.height, camera.parameters}, shared.size())
                    .first->second
              : shared.try_emplace({-1 - run.cameras.camera[i], size.width, size.height, {}}, shared.size())
                    .first->second;
    if (number == database.cameras.size()) database.cameras.push_back(camera);
    database.images.push_back(
        {FileOf(run, image), number, PointMatrix(features.positions.array() + 0.5), features.frames});
    id = std::ssize(database.images);
  }
  std::vector<ColmapGeometry> geometries;
  for (const ImagePair& pair : pairs) {
    const ColmapPair of{ids.at(pair.images[0]), ids.at(pair.images[1])};
    MatchIndices matches = pair.matches;
    if (of.image1 > of.image2) matches.col(0).swap(matches.col(1));
    database.matches[{std::min(of.image1, of.image2), std::max(of.image1, of.image2)}] = matches;
    geometries.push_back(GeometryOfPair(pair, of));
  }
  const std::string path = (fs::path(run.output) / kDatabaseFile).string();
  CreateColmapDatabase(path, database);
  WriteGeometries(ColmapDatabase(path, SqliteDatabase::Access::kWrite), geometries, false);
}

void WriteMatches(const std::vector<ImagePair>& pairs, const PhotographsRun& run) {
  const ImageSource& source = run.photographs.source;
  const std::string folder = (fs::path(run.output) / "matches" / source.scenes.at(0).name).string();
  CorrespondenceSet set;
  const bool keypoints = std::all_of(pairs.begin(), pairs.end(), [](const ImagePair& pair) {
    return pair.matches.rows() == pair.example.problem.points.rows();
  });
  for (const ImagePair& pair : pairs) {
    set.pairs.push_back(pair.example);
    if (keypoints) set.match_indices.push_back(pair.matches);
  }
  MakeWritableFolder(folder);
  if (run.store != nullptr) WriteThumbnailsOf(source, set.pairs, run.options.threads, folder);
  WriteCorrespondences(folder, set);
}

/// The files of the images that sure pairs join, the largest group first; an image of none is a group of its own.
std::vector<std::vector<std::string>> JoinedImages(const std::vector<ImagePair>& pairs, const PhotographsRun& run) {
  std::map<int, int> group;
  for (const ImagePair& pair : pairs)
    if (!FileOf(run, pair.images[0]).empty())
      for (const int image : pair.images) group[image] = image;
  for (const ImagePair& pair : pairs) {
    if (!pair.estimate.IsSure() || !group.contains(pair.images[0])) continue;
    const int into = group.at(pair.images[0]), from = group.at(pair.images[1]);
    for (auto& [image, of] : group)
      if (of == from) of = into;
  }
  std::map<int, std::vector<std::string>> members;
  for (const auto& [image, of] : group) members[of].push_back(FileOf(run, image));
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

void SayResults(const std::vector<ImagePair>& pairs, const PhotographsRun& run, std::ostream& out) {
  std::size_t sure = 0, chance = 0, guessed = 0;
  for (const ImagePair& pair : pairs)
    if (pair.estimate.ok()) (pair.estimate.IsSure() ? sure : pair.estimate.MayBeChance() ? chance : guessed) += 1;
  out << run.photographs.source.scenes.at(0).name << ": " << pairs.size() << " pairs: " << sure << " are sure, "
      << chance << " may be chance, "
      << (guessed > 0 ? std::to_string(guessed) + " rest on a guessed focal length, " : "")
      << pairs.size() - sure - chance - guessed << " have no model\n";
  std::vector<std::string> alone;
  for (const auto& group : JoinedImages(pairs, run))
    if (group.size() == 1)
      alone.push_back(group.front());
    else
      out << "  " << group.size() << " images belong together: " << NamesText(group) << "\n";
  if (!alone.empty()) out << "  " << alone.size() << " images belong to no other: " << NamesText(alone) << "\n";
  if (chance > 0)
    out << "  pairs that may be chance: do not use their poses (may_be_chance in " << kPosesFile
        << ") unless their matches look right in " << kReportFile << "\n";
  const std::string folder = (fs::path(run.output) / "").string();
  out << "  " << folder << kPosesFile << ": R, t and inliers of each pair\n"
      << "  " << folder << kReportFile << ": the pairs and their matches, for a browser\n"
      << "  " << folder << kPairsJson << ": inliers, covariances and more\n"
      << "  " << folder << "matches: for diffsac_eval" << std::endl;
  if (run.store != nullptr)
    out << "  " << folder << kDatabaseFile << ": mkdir model && colmap mapper --database_path "
        << ShellWord(folder + kDatabaseFile) << " --image_path " << ShellWord(run.photographs.folder)
        << " --output_path model" << std::endl;
}

}  // namespace

std::string PosesCsv(const std::vector<Json>& pairs) {
  std::string text;
  for (const Columns& columns : kColumns) text += (text.empty() ? "" : ",") + std::string(columns.names);
  for (const Json& pair : pairs) {
    std::string line;
    for (const Columns& columns : kColumns)
      for (const char* place : columns.places) line += (line.empty() ? "\n" : ",") + CellText(pair, place);
    text += line;
  }
  return text + "\n";
}

void WritePhotographResults(const PhotographsRun& run, std::vector<ImagePair> pairs, std::ostream& out) {
  const bool partial = std::erase_if(pairs, [](const ImagePair& pair) { return !pair.done; }) > 0;
  // In the order in which the files list them.
  std::sort(pairs.begin(), pairs.end(),
            [](const ImagePair& a, const ImagePair& b) { return a.example.id < b.example.id; });
  const auto file = [&](const char* name) { return (fs::path(run.output) / name).string(); };
  RemoveFile(file(kPairsJson));
  WriteMatches(pairs, run);
  if (run.store != nullptr) WriteDatabase(pairs, run);
  std::vector<Json> json;
  for (const ImagePair& pair : pairs) json.push_back(JsonOf(pair, run));
  WriteFileAtomically(file(kPosesFile), PosesCsv(json));
  WriteFileAtomically(file(kPairsJson), JsonText(RunJson(std::move(json), run, partial), 0));
  WriteReport(run.output);  // It reads all of these.
  SayResults(pairs, run, out);
}

}  // namespace diffsac
