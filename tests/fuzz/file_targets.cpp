// Files that others made, but for those in HDF5: an input is a file, or a bundle of files (fuzz_target.h).

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "diffsac/core/safetensors.h"
#include "diffsac/estimate/diffsac_model.h"
#include "diffsac/guidance/engine/checkpoint_info.h"
#include "fuzz/fuzz_target.h"
#include "lab/colmap/colmap_test_util.h"
#include "lab/colmap/lens.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/data/off_mesh.h"
#include "lab/data/point_files.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/eval/experiment.h"
#include "lab/eval/run_files.h"
#include "lab/files/files.h"
#include "lab/images/run_pairs.h"

namespace diffsac::testing {
namespace {

// ---- Points and meshes as text: "ply ..." is a PLY file, "OFF ..." a mesh, all else lines of numbers.

void CheckPoints(const PointMatrix& points) {
  Require(points.cols() == 2 || points.cols() == 3, "points have two or three columns");
}

void CheckMesh(const TriangleMesh& mesh) {
  for (const auto& triangle : mesh.triangles)
    for (const int corner : triangle)
      Require(corner >= 0 && corner < static_cast<int>(mesh.vertices.size()), "a corner is a vertex");
}

void RunPoints(const std::string& content) {
  if (content.starts_with("OFF")) {
    const std::string path = WriteScratch("fuzz.off", content);
    Parses({path}, [&] { CheckMesh(InUnitSphere(ReadOff(path))); });
    return;
  }
  const std::string path = WriteScratch(content.starts_with("ply") ? "fuzz.ply" : "fuzz.csv", content);
  Parses({path}, [&] {
    for (const PointSet& set : ReadPointFile(path)) CheckPoints(set.points);
  });
}

const AddTarget kPoints{"points", [] { return SeedsIn("points"); }, RunPoints};

// ---- What diffsac_prepare reads of images' cameras and poses: a bundle whose first line is the format.

void ReadSource(const ImageFormat& format, const Bundle& bundle) {
  PairsRequest request;
  request.format = bundle.kind;
  request.input = Scratch();
  request.sequence = "00";
  if (bundle.Find("pairs.txt") != nullptr) request.choice.pairs_file = Scratch() + "/pairs.txt";
  if (bundle.Find("K.txt") != nullptr && format.takes_calibration) request.calibration.file = Scratch() + "/K.txt";
  ImageSource source = format.read(request);
  if (!format.chooses_pairs && !request.choice.pairs_file.empty()) ChoosePairs(request.choice, request.input, &source);
  const auto images = static_cast<int>(source.images.size());
  for (const SourceScene& scene : source.scenes)
    for (const SourcePair& pair : scene.pairs)
      Require(pair.image1 >= 0 && pair.image1 < images && pair.image2 >= 0 && pair.image2 < images,
              "a pair is of two images");
  for (const SourceImage& image : source.images) {
    Require(!image.pose || (image.pose->rotation.allFinite() && image.pose->translation.allFinite()),
            "a pose is finite");
    Require(!image.camera || image.camera->K.allFinite(), "a calibration is finite");
  }
}

void Read(const Bundle& bundle) {
  const auto& formats = Registry<ImageFormat>::Instance();
  if (formats.Has(bundle.kind) && formats.Find(bundle.kind, "").read) ReadSource(formats.Find(bundle.kind, ""), bundle);
}

void RunScenes(const std::string& bytes) {
  const Bundle bundle = ParseBundle(bytes);
  WriteBundle(bundle);
  Parses({Scratch()}, [&] { Read(bundle); });
}

const AddTarget kScenes{"scenes", [] { return SeedsIn("scenes"); }, RunScenes};

// ---- A COLMAP database.

std::vector<std::string> DatabaseSeeds() {
  std::filesystem::remove(Scratch() + "/seed.db");
  const std::string path = Scratch() + "/seed.db";
  {
    DatabaseMaker maker(path);
    // As small as SQLite's pages get, so that a change more often meets what is read.
    maker.Run("PRAGMA page_size = 512");
    maker.Run("VACUUM");
    maker.AddCamera(1, 2, {500, 320, 240, 0.1});
    maker.AddImage(1, "a.jpg");
    maker.AddImage(2, "b.jpg");
    for (const int image : {1, 2}) maker.AddKeypoints(image, PointMatrix::Ones(4, 2), 2);
  }
  return {ReadFile(path)};
}

void ReadDatabase(const std::string& path) {
  const ColmapDatabase database(path);
  PairNames(database);
  for (const auto& [id, image] : database.images()) {
    database.Keypoints(id);
    database.Descriptors(id);
    database.KeypointCount(id);
    const ColmapCamera& camera = database.CameraOf(id);
    Parses({path}, [&] { ColmapLens(camera, path).Undistort({3.0, 4.0}); });
  }
  for (const ColmapPair& pair : database.MatchedPairs()) database.Matches(pair);
}

void RunDatabase(const std::string& bytes) {
  const std::string path = WriteScratch("fuzz.db", bytes);
  Parses({path}, [&] { ReadDatabase(path); });
}

const AddTarget kDatabase{"database", DatabaseSeeds, RunDatabase};

// ---- Checkpoints: the safetensors reader, the texts about a network, its configuration, and the network itself where
// it runs without LibTorch.

constexpr const char* kConfig =
    "method: diffsac\ntask: line\nnetwork:\n  features: {kinds: [coordinates]}\n"
    "  denoiser: {kind: pooled, width: 16, encoder_layers: 1, layers: 1}\n"
    "train: {iterations: 10, batch_size: 4}\n";

/// As CpuDenoiser reads them: the least network there is.
void AddNetwork(SafetensorsWriter* writer) {
  constexpr std::int64_t kWidth = 16, kHeads = 4;
  const auto add = [&](const std::string& name, const std::vector<std::int64_t>& shape) {
    std::int64_t size = 1;
    for (const std::int64_t extent : shape) size *= extent;
    writer->Add(kAverageTensors + name, shape, std::vector<float>(static_cast<std::size_t>(size), 0.25f));
  };
  const auto linear = [&](const std::string& name, std::int64_t in, std::int64_t out) {
    add(name + ".weight", {out, in});
    add(name + ".bias", {out});
  };
  const auto norm = [&](const std::string& name) {
    add(name + ".weight", {kWidth});
    add(name + ".bias", {kWidth});
  };
  linear("input_points", 2, kWidth);
  for (const std::string block : {"encoder0", "decoder0"}) {
    norm(block + ".norm");
    linear(block + ".attention", kWidth, kHeads);
    linear(block + ".set", (2 + kHeads) * kWidth, 2 * kWidth);
    linear(block + ".point", kWidth, 2 * kWidth);
    linear(block + ".output", 2 * kWidth, kWidth);
  }
  for (const char* name : {"ln_encoder", "ln_post"}) norm(name);
  linear("input_confidence", 1, kWidth);
  linear("time_hidden", kWidth, kWidth);
  linear("time_output", kWidth, kWidth);
  linear("inlier_proj", kWidth, 1);
  linear("output_proj", kWidth, 1);
}

std::string Checkpoint(bool network) {
  SafetensorsWriter writer;
  WriteInfo({.method = "diffsac", .task = "line", .config = kConfig, .git_revision = "0", .iteration = 3, .seed = 1},
            &writer);
  WriteLossSums({.sums = {0.5, 0.25}, .steps = 2}, &writer);
  const std::vector<float> values = {1.0f, 2.0f};
  const std::vector<std::int64_t> step = {3};
  if (network) {
    AddNetwork(&writer);
  } else {
    writer.Add("network.a.weight", {2}, values);
    writer.Add("optimizer.step.a.weight", {1}, step);
  }
  return writer.Content();
}

void ReadTensors(const std::string& path) {
  SafetensorsFile file(path);
  for (const auto& [name, tensor] : file.tensors()) {
    std::size_t count = 1;
    for (const std::int64_t size : tensor.shape) count *= static_cast<std::size_t>(size);
    if (tensor.type == "F32") {
      std::vector<float> values(count);
      file.Read(name, tensor.shape, values);
    } else if (tensor.type == "I64") {
      std::vector<std::int64_t> values(count);
      file.Read(name, tensor.shape, values);
    }
  }
}

void RunCheckpoint(const std::string& bytes) {
  const std::string path = WriteScratch("fuzz.safetensors", bytes);
  Parses({path}, [&] { ReadTensors(path); });
  Parses({path}, [&] {
    const TrainedConfig trained = ReadTrainedConfig(path);
    LoadDiffsac(trained, NetworkEngine::kAuto, "cpu");
  });
}

std::vector<std::string> CheckpointSeeds() {
  const std::vector<std::string> seeds = {Checkpoint(false), Checkpoint(true)};
  // Throws where the network is not the one that its configuration says any more.
  LoadDiffsac(ReadTrainedConfig(WriteScratch("seed.safetensors", seeds[1])), NetworkEngine::kFused, "cpu");
  return seeds;
}

const AddTarget kCheckpoint{"checkpoint", CheckpointSeeds, RunCheckpoint};

// ---- What --update reads back: a folder's config.yaml, run.json and problems.csv, as a bundle.

Bundle RunSeed() {
  Bundle bundle{"run", {}};
  const ExperimentResults results = MadeUpResults();
  const std::string folder = Scratch() + "/seed";
  std::filesystem::create_directories(folder);
  WriteFileAtomically(folder + "/config.yaml", "# program: x\n\n" + WriteExperiment(results.experiment));
  WriteRun(results, {}, folder);
  for (const char* name : {"config.yaml", kRunFile, "problems.csv"})
    bundle.files.push_back({std::string("a/") + name, FilesBelow(folder, name, 1 << 20).at(0)});
  return bundle;
}

void RunResults(const std::string& bytes) {
  const Bundle bundle = ParseBundle(bytes);
  std::vector<std::string> names = {Scratch()};
  for (const Bundle::File& file : bundle.files) names.push_back(file.name);
  WriteBundle(bundle);
  Parses(names, [&] {
    const ExperimentOptions experiment = MadeUpResults().experiment;
    if (IsMade(experiment, {}, {}, Scratch() + "/a")) UpdateCaptions(experiment, Scratch() + "/a");
  });
}

const AddTarget kResults{"results", [] { return std::vector{BundleText(RunSeed())}; }, RunResults};

// ---- A whole configuration of diffsac_eval: YAML, in which lines "#--set KEY=VALUE" are what the command line adds,
// read as the program does up to where data and networks are opened.

std::vector<std::string> ConfigSeeds() {
  std::vector<std::string> seeds = SeedsIn("config");
  // With what they include, which stays behind.
  for (const auto& entry : std::filesystem::directory_iterator(DIFFSAC_SOURCE_DIR "/configs/tables"))
    seeds.push_back(ToYaml(ConfigFromFile(entry.path().string())));
  std::sort(seeds.begin(), seeds.end());
  return seeds;
}

constexpr const char* kConfigName = "fuzz.yaml";

Config ReadConfig(const std::string& text) {
  Config config = ConfigFromYaml(text, kConfigName);
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("#--set ")) SetYaml(&config, line.substr(7));
  return config;
}

void ReadTable(const std::string& text) {
  const Config config = ReadConfig(text);
  Require(ToYaml(ConfigFromYaml(ToYaml(config))) == ToYaml(config), "what is written reads back");
  const ExperimentOptions experiment = ReadExperiment(config);
  // Rows and data throw by themselves, so that one that is wrong does not hide the others.
  for (const Condition& condition : experiment.conditions)
    Parses({kConfigName, "--set"}, [&] { WriteDatasetOptions(condition.data); });
  for (const EstimatorRow& row : experiment.methods)
    Parses({}, [&] { ResolvedRow(row.config, experiment.task, EstimatorContext{}); });
}

const AddTarget kTable{"config", ConfigSeeds, [](const std::string& text) {
                         Parses({kConfigName, "--set"}, [&] { ReadTable(text); });
                       }};

}  // namespace
}  // namespace diffsac::testing
