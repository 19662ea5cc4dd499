#include "lab/torch/point_block.h"

#include "lab/torch/edge_block.h"
#include "lab/torch/mlp_block.h"
#include "lab/torch/pooled_block.h"

namespace diffsac {

std::shared_ptr<PointBlock> MakePointBlock(DenoiserKind kind, std::int64_t width, std::int64_t neighbors, Rng rng) {
  if (kind == DenoiserKind::kMlp) return std::make_shared<MlpBlock>(width, rng);
  if (kind == DenoiserKind::kDgcnn) return std::make_shared<EdgeBlock>(width, neighbors, rng);
  return std::make_shared<PooledBlock>(width, rng);
}

}  // namespace diffsac
