#include "lab/torch/checkpoint.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <span>

#include "core/errors.h"
#include "core/temporary_folder.h"
#include "diffsac/core/safetensors.h"
#include "diffsac/core/status.h"
#include "lab/files/files.h"
#include "lab/torch/test_networks.h"

namespace diffsac {
namespace {

void OneStep(Denoiser& network, torch::optim::Optimizer& optimizer) {
  optimizer.zero_grad();
  const auto context = network.Encode(BatchOf({RandomFeatures(6, 4, Rng(5))}));
  const auto out = network.Denoise(context, RandomTensor({1, 2, 6}, Rng(6)), torch::full({1, 1}, 3.0f));
  (out.square().mean() + context.inlier_logits.square().mean()).backward();
  optimizer.step();
}

// A checkpoint taken apart, for changes to it.
struct Parts {
  std::map<std::string, std::string> texts;
  std::map<std::string, std::pair<std::vector<std::int64_t>, std::vector<float>>> floats;
  std::map<std::string, std::int64_t> integers;
  void Remove(const std::string& name) {
    floats.erase(name);
    integers.erase(name);
  }
};
using Change = std::function<void(Parts*)>;

Parts ReadParts(const std::string& path) {
  SafetensorsFile file(path);
  Parts parts;
  for (const char* key : {"format", "version", "method", "task", "config", "git_revision", "iteration", "seed",
                          "best_validation", "average_updates"})
    parts.texts[key] = file.Text(key);
  for (const auto& [name, tensor] : file.tensors()) {
    if (tensor.type == "I64") {
      file.Read(name, {}, std::span(&parts.integers[name], 1));
      continue;
    }
    auto& [shape, values] = parts.floats[name];
    shape = tensor.shape;
    values.resize((tensor.end - tensor.begin) / sizeof(float));
    file.Read(name, shape, values);
  }
  return parts;
}

void WriteChanged(const std::string& from, const Change& change, const std::string& to) {
  Parts parts = ReadParts(from);
  change(&parts);
  SafetensorsWriter writer;
  for (const auto& [key, text] : parts.texts) writer.AddText(key, text);
  for (const auto& [name, array] : parts.floats) writer.Add(name, array.first, array.second);
  for (const auto& [name, value] : parts.integers) writer.Add(name, {}, std::span(&value, 1));
  WriteFileAtomically(to, writer.Content());
}

}  // namespace

TEST_CASE("a checkpoint restores weights, average, optimiser and info") {
  const TemporaryFolder folder;
  auto a = std::make_shared<Denoiser>(SmallOptions("pooled"), 4, Rng(1));
  FillWithWave(*a);
  ExponentialMovingAverage average(*a, 0.9);
  torch::optim::Adam optimizer(a->parameters(), torch::optim::AdamOptions(1e-2));
  OneStep(*a, optimizer);
  average.Update(*a);
  const CheckpointInfo info{"diffsac",         "line", "task: line\n", "abc123", 17, 18446744073709551615ULL, 0.75,
                            {{0.1, 1e-300}, 3}};
  SaveCheckpoint(folder.File("c.safetensors"), info, *a, average, &optimizer);

  auto b = std::make_shared<Denoiser>(SmallOptions("pooled"), 4, Rng(2));
  ExponentialMovingAverage other(*b, 0.9);
  torch::optim::Adam second(b->parameters(), torch::optim::AdamOptions(1e-2));
  const auto read = LoadCheckpoint(folder.File("c.safetensors"), *b, &other, &second);
  CHECK(read.method == "diffsac");
  CHECK(read.task == "line");
  CHECK(read.config == info.config);
  CHECK(read.git_revision == "abc123");
  CHECK(read.iteration == 17);
  CHECK(read.seed == info.seed);
  CHECK(read.best_validation == 0.75);
  CHECK(read.losses.sums == info.losses.sums);
  CHECK(read.losses.steps == 3);
  CHECK(other.updates() == 1);
  OneStep(*a, optimizer);
  OneStep(*b, second);  // equal only if Adam's moments came back too
  for (std::size_t i = 0; i < a->parameters().size(); ++i) {
    CHECK(torch::equal(a->parameters()[i], b->parameters()[i]));
    CHECK(torch::equal(average.shadow()[i], other.shadow()[i]));
  }
  auto c = std::make_shared<Denoiser>(SmallOptions("pooled"), 4, Rng(3));
  LoadAverage(folder.File("c.safetensors"), *c);
  CHECK(torch::equal(c->parameters()[1], average.shadow()[1]));
}

TEST_CASE("a bad checkpoint is a clear error that names the file") {
  const TemporaryFolder folder;
  auto network = std::make_shared<Denoiser>(SmallOptions("pooled"), 4, Rng(1));
  const ExponentialMovingAverage average(*network, 0.9);
  const auto path = folder.File("good.safetensors");
  SaveCheckpoint(path, {}, *network, average, nullptr);
  const auto content = ReadFile(path);

  CHECK_THROWS_WITH(ReadCheckpointInfo(folder.File("none.safetensors")),
                    Catch::Contains("none.safetensors: no such checkpoint"));
  CHECK_THROWS_WITH(ReadCheckpointInfo(folder.path()), Catch::Contains("not a file"));
  for (const std::size_t size : {std::size_t{0}, std::size_t{10}, content.size() / 2, content.size() - 30}) {
    std::ofstream(folder.File("cut.safetensors"), std::ios::binary).write(content.data(), size);
    CHECK_THROWS_AS(ReadCheckpointInfo(folder.File("cut.safetensors")), Error);
    CHECK_THROWS_WITH(ReadCheckpointInfo(folder.File("cut.safetensors")), Catch::Contains("cut.safetensors"));
  }
  torch::serialize::OutputArchive archive;
  archive.write("x", torch::zeros({3}));
  archive.save_to(folder.File("old.pt"));
  CHECK_THROWS_WITH(ReadCheckpointInfo(folder.File("old.pt")),
                    Catch::Contains("old.pt: not a safetensors file: a zip archive") && Catch::Contains("train again"));
  torch::optim::Adam optimizer(network->parameters(), torch::optim::AdamOptions(1e-2));
  ExponentialMovingAverage other(*network, 0.9);
  CHECK_THROWS_WITH(LoadCheckpoint(path, *network, &other, &optimizer), Catch::Contains("optimiser"));
}

TEST_CASE("a checkpoint that training does not go on from holds the average alone") {
  const TemporaryFolder folder;
  auto network = std::make_shared<Denoiser>(SmallOptions("pooled"), 4, Rng(1));
  const ExponentialMovingAverage average(*network, 0.9);
  SaveCheckpoint(folder.File("c.safetensors"), {}, *network, average, nullptr);
  const SafetensorsFile file(folder.File("c.safetensors"));
  CHECK(file.tensors().size() == network->parameters().size());
  for (const auto& [name, tensor] : file.tensors()) CHECK_THAT(name, Catch::StartsWith(kAverageTensors));
}

TEST_CASE("a checkpoint of another architecture is refused") {
  const TemporaryFolder folder;
  auto network = std::make_shared<Denoiser>(SmallOptions("pooled"), 4, Rng(1));
  const ExponentialMovingAverage average(*network, 0.9);
  const auto path = folder.File("a.safetensors");
  SaveCheckpoint(path, {}, *network, average, nullptr);
  auto wider = std::make_shared<Denoiser>(SmallOptions("pooled"), 5, Rng(1));
  CHECK_THROWS_WITH(LoadAverage(path, *wider),
                    Catch::Contains("input_points.weight") && Catch::Contains("architecture"));
  auto deeper = std::make_shared<Denoiser>(SmallOptions("pooled", 3), 4, Rng(1));
  CHECK_THROWS_WITH(LoadAverage(path, *deeper), Catch::Contains("architecture"));
  auto other = std::make_shared<Denoiser>(SmallOptions("point_transformer"), 4, Rng(1));
  CHECK_THROWS_AS(LoadAverage(path, *other), Error);
}

TEST_CASE("a checkpoint's parts are whole, and there are no others") {
  const TemporaryFolder folder;
  auto network = std::make_shared<Denoiser>(SmallOptions("pooled"), 4, Rng(1));
  ExponentialMovingAverage average(*network, 0.9);
  torch::optim::Adam optimizer(network->parameters(), torch::optim::AdamOptions(1e-2));
  const auto path = folder.File("c.safetensors");
  SaveCheckpoint(path, {}, *network, average, &optimizer);
  const auto load = [&](const Change& change) {
    WriteChanged(path, change, folder.File("changed.safetensors"));
    return ErrorOf([&] { LoadCheckpoint(folder.File("changed.safetensors"), *network, &average, &optimizer); });
  };
  CHECK(load([](Parts*) {}).empty());
  const std::string weight = network->named_parameters()[0].key();
  for (const char* part : {"network.", "average.", "optimizer.exp_avg.", "optimizer.exp_avg_sq.", "optimizer.step."}) {
    const std::string name = part + weight;
    CHECK_THAT(load([&](Parts* p) { p->Remove(name); }),
               Catch::Contains("changed.safetensors") && Catch::Contains(part) && Catch::Contains("architecture"));
    CHECK_THAT(load([&](Parts* p) {
                 p->floats[part + std::string("more")] = {{1}, {0.0f}};
               }),
               Catch::Contains(part) && Catch::Contains("architecture"));
    CHECK_THAT(load([&](Parts* p) {
                 p->Remove(name);
                 p->floats[name] = {{2, 1, 1}, {0.0f, 1.0f}};
               }),
               Catch::Contains(name) && Catch::Contains("is [2, 1, 1], expected "));
  }
  CHECK_THAT(load([](Parts* p) { p->floats["other"] = {{1}, {0.0f}}; }), Catch::Contains("tensor 'other'"));
  CHECK_THAT(load([&](Parts* p) { p->integers["optimizer.step." + weight] = -1; }), Catch::Contains("is negative"));
}

TEST_CASE("a checkpoint's metadata is checked") {
  const TemporaryFolder folder;
  auto network = std::make_shared<Denoiser>(SmallOptions("pooled"), 4, Rng(1));
  ExponentialMovingAverage average(*network, 0.9);
  torch::optim::Adam optimizer(network->parameters(), torch::optim::AdamOptions(1e-2));
  const auto path = folder.File("c.safetensors");
  SaveCheckpoint(path, {}, *network, average, &optimizer);
  const auto with = [&](const char* key, const std::string& text) {
    WriteChanged(
        path, [&](Parts* parts) { parts->texts[key] = text; }, folder.File("changed.safetensors"));
    return ErrorOf([&] { LoadCheckpoint(folder.File("changed.safetensors"), *network, &average, &optimizer); });
  };
  CHECK_THAT(with("format", "pt"), Catch::Contains("changed.safetensors: not a DiffSAC checkpoint"));
  CHECK_THAT(with("version", "1"), Catch::Contains("checkpoint version '1', this program reads version '2'"));
  for (const char* text : {"", "x", "1x", " 1", "99999999999999999999", "-1"}) {
    CHECK_THAT(with("iteration", text), Catch::Contains("its iteration"));
    CHECK_THAT(with("seed", text), Catch::Contains("its seed"));
    CHECK_THAT(with("average_updates", text), Catch::Contains("its average_updates"));
  }
  CHECK_THAT(with("best_validation", "good"), Catch::Contains("its best_validation 'good': expected a number"));
  for (const char* text : {"", "x", "-1 0.5", "1 y", "1 0.5,"})
    CHECK_THAT(with("loss_sums", text), Catch::Contains("its loss_sums"));
  for (const char* key : {"format", "version", "method", "task", "config", "git_revision", "iteration", "seed",
                          "best_validation", "average_updates"}) {
    WriteChanged(
        path, [&](Parts* parts) { parts->texts.erase(key); }, folder.File("changed.safetensors"));
    CHECK_THROWS_AS(LoadCheckpoint(folder.File("changed.safetensors"), *network, &average, &optimizer), Error);
  }
}

TEST_CASE("a checkpoint of the same state is the same file") {
  const TemporaryFolder folder;
  auto network = std::make_shared<Denoiser>(SmallOptions("pooled"), 4, Rng(1));
  ExponentialMovingAverage average(*network, 0.9);
  torch::optim::Adam optimizer(network->parameters(), torch::optim::AdamOptions(1e-2));
  OneStep(*network, optimizer);
  const auto path = [&](const char* name) { return folder.File(name); };
  const CheckpointInfo info{"diffsac", "line", "task: line\n", "abc123", 17, 5, 1.0 / 3.0};
  SaveCheckpoint(path("a"), info, *network, average, &optimizer);
  auto other = std::make_shared<Denoiser>(SmallOptions("pooled"), 4, Rng(2));
  ExponentialMovingAverage other_average(*other, 0.9);
  torch::optim::Adam second(other->parameters(), torch::optim::AdamOptions(1e-2));
  const auto read = LoadCheckpoint(path("a"), *other, &other_average, &second);
  SaveCheckpoint(path("b"), read, *other, other_average, &second);
  CHECK(ReadFile(path("a")) == ReadFile(path("b")));
}

TEST_CASE("a checkpoint that cannot be written leaves the old one") {
  const TemporaryFolder folder;
  auto network = std::make_shared<Denoiser>(SmallOptions("pooled"), 4, Rng(1));
  const ExponentialMovingAverage average(*network, 0.9);
  std::ofstream(folder.File("file")) << "x";
  CHECK_THROWS_AS(SaveCheckpoint(folder.File("file") + "/c.safetensors", {}, *network, average, nullptr), Error);
}

}  // namespace diffsac
