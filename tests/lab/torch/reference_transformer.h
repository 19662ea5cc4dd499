#pragma once

#include <map>
#include <string>
#include <vector>

namespace diffsac {

/// Point-E's transformer written as plain loops over doubles, from the published description alone: no tensor library,
/// no code shared with lib/. The golden values of the denoiser tests come from it.
class ReferenceTransformer {
 public:
  /// Weights by name as the denoiser registers them; a matrix is row-major, out × in.
  using Weights = std::map<std::string, std::vector<double>>;

  ReferenceTransformer(Weights weights, int width, int heads, int encoder_layers, int layers);

  /// features: N × D row-major; c_t: N values; returns ĉ_0 (raw output), N values.
  std::vector<double> Run(const std::vector<double>& features, const std::vector<double>& c_t, double t) const;

 private:
  using Rows = std::vector<std::vector<double>>;
  Rows Linear(const std::string& name, const Rows& x) const;
  Rows Norm(const std::string& name, const Rows& x) const;
  Rows Mlp(const std::string& name, const Rows& x) const;
  Rows Attention(const std::string& name, const Rows& x) const;
  Rows Block(const std::string& name, Rows x) const;

  Weights weights_;
  int width_, heads_, encoder_layers_, layers_;
};

}  // namespace diffsac
