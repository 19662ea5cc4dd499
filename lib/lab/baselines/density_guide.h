#pragma once

#include <Eigen/Core>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {

/// What the densities of the hypotheses so far say of each point, and minimal sets drawn by it (the guided sampling of
/// DGSAC, residual_density.h). Every point prefers the T hypotheses in which its density is highest; two points belong
/// together as far as they prefer the same ones.
class DensityGuide {
 public:
  /// preferred: T ≥ 1.
  DensityGuide(int num_points, int preferred);

  int num_points() const { return static_cast<int>(preferences_.size()); }

  /// Takes in the next hypothesis, whose index is the number of those before it. density: δ of each point (N values).
  void Add(const Eigen::VectorXd& density);

  /// The sum of the densities that a point's preferred hypotheses give it: how well it is explained.
  double Explanation(int point) const;

  /// The hypotheses that some point prefers, ascending.
  std::vector<int> Preferred() const;

  /// Makes what was added so far count for Draw. Sets of one round so depend on earlier rounds alone.
  void StartRound();

  /// A set of `size` distinct points, ascending, with `first` among them: the others one by one, by their correlation
  /// with `first`; uniformly among the rest where none is left.
  void Draw(int first, int size, Rng& rng, int* set);

 private:
  struct Preference {
    double density;
    int hypothesis;
  };

  int preferred_;
  int hypotheses_ = 0;
  std::vector<std::vector<Preference>> preferences_;  ///< of each point, densest first
  std::vector<std::vector<int>> supporters_;          ///< of each hypothesis at the round's start, the points
  std::vector<std::vector<int>> round_;               ///< of each point at the round's start, the hypotheses
  Eigen::VectorXd weights_;
};

}  // namespace diffsac
