#include "diffsac/network/engine/network_options.h"

namespace diffsac {

void DenoiserOptions::Bind(OptionsBinder& b) {
  b.Field("kind", kind)
      .Help(
          "`point_transformer`: the paper's; `pooled`: point-wise layers with pooled context, for CPUs; the others of "
          "the paper's ablation: `mlp`, each point by itself, `dgcnn`, edge convolutions over nearest points in "
          "feature space");
  const bool transformer = kind == DenoiserKind::kPointTransformer;
  b.Field("width", width, Within(8, 4096)).Help("channels of a point");
  b.Field("heads", heads, Within(1, 64)).OnlyIf(transformer, "kind: point_transformer").Help("attention heads");
  b.Field("encoder_layers", encoder_layers, Within(0, 64))
      .Help("blocks before c_t enters, computed once a problem; 0 is the paper's joint network");
  b.Field("layers", layers, Within(1, 64)).Help("blocks after c_t has entered, computed for each copy and step");
  b.Field("neighbors", neighbors, Within(1, 1024))
      .OnlyIf(kind == DenoiserKind::kDgcnn, "kind: dgcnn")
      .Help("of a point");
  b.Field("inlier_head", inlier_head)
      .Help("a second output: each point's inlier probability, for the learned refit and the inlier head's sets");
  b.Field("relation", relation)
      .Help(
          "each point also sees how much it agrees with the points that are confident now, for several structures; "
          "needs features.kinds: [preference]");
  b.Require(width % 2 == 0, "width", "an even number");
  b.Require(!transformer || width % heads == 0, "heads", "a divisor of width");
  b.Require(!inlier_head || encoder_layers > 0, "inlier_head",
            "false when encoder_layers is 0 (nothing to read it from)");
}

void NetworkOptions::Bind(OptionsBinder& b) {
  b.Field("features", features).Help("what the network sees of a point");
  b.Field("denoiser", denoiser).Help("the network's layers");
  b.Field("schedule", schedule).Help("the forward process");
  b.Field("loss", loss)
      .Help("`mse`: the network's output is ĉ_0 (Algorithm 1); `bce`: it is the logit of \"c_0 = +1\"");
  b.Field("direct", direct)
      .Help("no diffusion: trained without noise to predict c_0 from the points at once, and called once");
}

}  // namespace diffsac
