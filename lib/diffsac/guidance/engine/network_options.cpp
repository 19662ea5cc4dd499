#include "diffsac/guidance/engine/network_options.h"

namespace diffsac {
namespace {

void Read(const StoredOptions& stored, PointFeaturesOptions* o) {
  stored.Read("kinds", &o->kinds);
  stored.Read("use_calibration", &o->use_calibration);
  stored.Read("descriptor_size", &o->descriptor_size, 1, 4096);
  stored.Read("descriptors_required", &o->descriptors_required);
  stored.Read("residual_draws", &o->residual_draws, 1, 1e5);
  stored.Read("residual_kept", &o->residual_kept, 1, 4096);
  stored.Read("residual_from", &o->residual_from);
  stored.Read("residual_choice", &o->residual_choice);
  stored.Require(!o->kinds.empty(), "kinds", "at least one");
}

void Read(const StoredOptions& stored, DenoiserOptions* o) {
  stored.Read("kind", &o->kind);
  stored.Read("width", &o->width, 8, 4096);
  stored.Read("heads", &o->heads, 1, 64);
  stored.Read("encoder_layers", &o->encoder_layers, 0, 64);
  stored.Read("layers", &o->layers, 1, 64);
  stored.Read("neighbors", &o->neighbors, 1, 1024);
  stored.Read("inlier_head", &o->inlier_head);
  stored.Read("relation", &o->relation);
  stored.Require(o->width % 2 == 0, "width", "an even number");
  stored.Require(o->kind != DenoiserKind::kPointTransformer || o->width % o->heads == 0, "heads", "a divisor of width");
  stored.Require(!o->inlier_head || o->encoder_layers > 0, "inlier_head", "false when encoder_layers is 0");
}

void Read(const StoredOptions& stored, NoiseScheduleOptions* o) {
  stored.Read("kind", &o->kind);
  stored.Read("steps", &o->steps, 1, 1e5);
  stored.Read("beta_start", &o->beta_start, 0.0, 0.999);
  stored.Read("beta_end", &o->beta_end, 0.0, 0.999);
  stored.Read("zero_terminal_snr", &o->zero_terminal_snr);
}

}  // namespace

NetworkOptions ReadNetworkOptions(const StoredOptions& network) {
  NetworkOptions options;
  Read(network.Sub("features"), &options.features);
  Read(network.Sub("denoiser"), &options.denoiser);
  Read(network.Sub("schedule"), &options.schedule);
  network.Read("loss", &options.loss);
  network.Read("direct", &options.direct);
  return options;
}

}  // namespace diffsac
