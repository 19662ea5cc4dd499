#include "diffsac/denoiser/checkpoint.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>

#include "core/temporary_folder.h"
#include "denoiser/test_networks.h"
#include "diffsac/core/files.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

void OneStep(Denoiser& network, torch::optim::Optimizer& optimizer) {
  optimizer.zero_grad();
  const auto context = network.Encode(BatchOf({RandomFeatures(6, 4, Rng(5))}));
  const auto out = network.Denoise(context, RandomTensor({1, 2, 6}, Rng(6)), torch::full({1, 1}, 3.0f));
  (out.square().mean() + context.inlier_logits.square().mean()).backward();
  optimizer.step();
}

}  // namespace

TEST_CASE("a checkpoint restores weights, average, optimiser and info") {
  const TemporaryFolder folder;
  auto a = MakeDenoiser(SmallOptions("pooled"), 4, Rng(1));
  FillWithWave(*a);
  ExponentialMovingAverage average(*a, 0.9);
  torch::optim::Adam optimizer(a->parameters(), torch::optim::AdamOptions(1e-2));
  OneStep(*a, optimizer);
  average.Update(*a);
  CheckpointInfo info{"task: line\n", "abc123", 17, 18446744073709551615ULL, 0.75};
  SaveCheckpoint(folder.File("c.pt"), info, *a, average, &optimizer);

  auto b = MakeDenoiser(SmallOptions("pooled"), 4, Rng(2));
  ExponentialMovingAverage other(*b, 0.9);
  torch::optim::Adam second(b->parameters(), torch::optim::AdamOptions(1e-2));
  const auto read = LoadCheckpoint(folder.File("c.pt"), *b, &other, &second);
  CHECK(read.config == info.config);
  CHECK(read.git_revision == "abc123");
  CHECK(read.iteration == 17);
  CHECK(read.seed == info.seed);
  CHECK(read.best_validation == 0.75);
  CHECK(other.updates() == 1);
  OneStep(*a, optimizer);
  OneStep(*b, second);  // equal only if Adam's moments came back too
  for (std::size_t i = 0; i < a->parameters().size(); ++i) {
    CHECK(torch::equal(a->parameters()[i], b->parameters()[i]));
    CHECK(torch::equal(average.shadow()[i], other.shadow()[i]));
  }
  auto c = MakeDenoiser(SmallOptions("pooled"), 4, Rng(3));
  LoadAverage(folder.File("c.pt"), *c);
  CHECK(torch::equal(c->parameters()[1], average.shadow()[1]));
}

TEST_CASE("a bad checkpoint is a clear error that names the file") {
  const TemporaryFolder folder;
  auto network = MakeDenoiser(SmallOptions("pooled"), 4, Rng(1));
  const ExponentialMovingAverage average(*network, 0.9);
  const auto path = folder.File("good.pt");
  SaveCheckpoint(path, {"", "", 0, 1, -1}, *network, average, nullptr);
  const auto content = ReadFile(path);

  CHECK_THROWS_WITH(ReadCheckpointInfo(folder.File("none.pt")), Catch::Contains("none.pt: no such checkpoint"));
  CHECK_THROWS_WITH(ReadCheckpointInfo(folder.path()), Catch::Contains("not a file"));
  for (const std::size_t size : {std::size_t{0}, std::size_t{10}, content.size() / 2, content.size() - 30}) {
    std::ofstream(folder.File("cut.pt"), std::ios::binary).write(content.data(), size);
    CHECK_THROWS_AS(ReadCheckpointInfo(folder.File("cut.pt")), Error);
    CHECK_THROWS_WITH(ReadCheckpointInfo(folder.File("cut.pt")), Catch::Contains("cut.pt"));
  }
  torch::serialize::OutputArchive foreign;
  foreign.write("x", torch::zeros({3}));
  foreign.save_to(folder.File("foreign.pt"));
  CHECK_THROWS_WITH(ReadCheckpointInfo(folder.File("foreign.pt")), Catch::Contains("not a DiffSAC checkpoint"));

  torch::optim::Adam optimizer(network->parameters(), torch::optim::AdamOptions(1e-2));
  CHECK_THROWS_WITH(LoadCheckpoint(path, *network, nullptr, &optimizer), Catch::Contains("optimiser"));
}

TEST_CASE("a checkpoint of another architecture is refused") {
  const TemporaryFolder folder;
  auto network = MakeDenoiser(SmallOptions("pooled"), 4, Rng(1));
  const ExponentialMovingAverage average(*network, 0.9);
  const auto path = folder.File("a.pt");
  SaveCheckpoint(path, {"", "", 0, 1, -1}, *network, average, nullptr);
  auto wider = MakeDenoiser(SmallOptions("pooled"), 5, Rng(1));
  CHECK_THROWS_WITH(LoadAverage(path, *wider),
                    Catch::Contains("input_points.weight") && Catch::Contains("architecture"));
  auto deeper = MakeDenoiser(SmallOptions("pooled", 3), 4, Rng(1));
  CHECK_THROWS_WITH(LoadAverage(path, *deeper), Catch::Contains("architecture"));
  auto other = MakeDenoiser(SmallOptions("point_transformer"), 4, Rng(1));
  CHECK_THROWS_AS(LoadAverage(path, *other), Error);
}

TEST_CASE("a checkpoint that cannot be written leaves the old one") {
  const TemporaryFolder folder;
  auto network = MakeDenoiser(SmallOptions("pooled"), 4, Rng(1));
  const ExponentialMovingAverage average(*network, 0.9);
  std::ofstream(folder.File("file")) << "x";
  CHECK_THROWS_AS(SaveCheckpoint(folder.File("file") + "/c.pt", {"", "", 0, 1, -1}, *network, average, nullptr), Error);
}

}  // namespace diffsac
