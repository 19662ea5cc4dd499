// A dominant plane: where the plain loop finds the plane and any epipole, the degeneracy hook finds both.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "diffsac/consensus/make_source.h"
#include "diffsac/consensus/mixture_impl.h"
#include "diffsac/consensus/sample_consensus_impl.h"
#include "diffsac/consensus/two_view_consensus.h"
#include "geometry/planar_scene.h"

namespace diffsac {

namespace {

/// A model without its degeneracy hook.
template <class Model>
struct Plain {
  using Parameters = typename Model::Parameters;
  static constexpr int kDimension = Model::kDimension;
  static constexpr int kMinimalSize = Model::kMinimalSize;
  static constexpr int kMaxSolutions = Model::kMaxSolutions;
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
    return Model::SolveMinimal(points, set, out);
  }
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
    return Model::Fit(points, weights, out);
  }
  static bool Determined(const PointMatrix& points) { return Model::Determined(points); }
  static bool Refine(const PointMatrix& points, double threshold, Parameters* model) {
    return Model::Refine(points, threshold, model);
  }
  static double Residual(const Parameters& model, const double* point) { return Model::Residual(model, point); }
};
using PlainFundamental = Plain<Fundamental>;
using PlainFundamental8 = Plain<Fundamental8>;
static_assert(HasDegeneracyRecovery<Fundamental> && HasDegeneracyRecovery<Fundamental8>);
static_assert(!HasDegeneracyRecovery<PlainFundamental>);

}  // namespace

DIFFSAC_MIXTURE_TEMPLATES(, PlainFundamental)
DIFFSAC_CONSENSUS_TEMPLATES(, PlainFundamental)
DIFFSAC_MIXTURE_TEMPLATES(, PlainFundamental8)
DIFFSAC_CONSENSUS_TEMPLATES(, PlainFundamental8)

namespace {

using testing::MakePlanarScene;
using testing::PlanarScene;
using testing::PoseErrorDegrees;

constexpr double kThreshold = 2.0;

/// LO-RANSAC to a confidence of 99 %, Levenberg-Marquardt at the end.
ConsensusOptions Options() {
  ConsensusOptions options;
  options.score = options.final_score = "msac";
  options.score_threshold_factor = 1.5;
  options.local_optimization = "lo_ransac";
  options.stopping = "confidence";
  options.max_iterations = 500;
  options.refit = "none";
  options.final_refinement = "lm";
  return options;
}

template <class Model>
int Successes(int count, double on_plane, double outliers, int scenes, const ConsensusOptions& options) {
  int good = 0;
  for (int i = 0; i < scenes; ++i) {
    Rng rng = Rng(7).Fork("scene", i);
    const PlanarScene scene = MakePlanarScene(count, on_plane, outliers, 0.5, rng);
    const ConsensusResult result =
        SampleConsensus<Model>(scene.views.pixels, kThreshold, UniformSource(), options, Rng(i));
    good += result.status == Status::kOk && PoseErrorDegrees(scene.views, result.model, result.inliers) < 5.0 ? 1 : 0;
  }
  return good;
}

TEST_CASE("A dominant plane: the hook finds the pose where the plain loop does not") {
  struct Case {
    int count;
    double on_plane, outliers;
    int scenes;
  };
  for (const Case& c :
       {Case{200, 0.95, 0.0, 50}, Case{200, 0.95, 0.2, 50}, Case{200, 0.98, 0.0, 50}, Case{1000, 0.95, 0.2, 25}}) {
    CAPTURE(c.count, c.on_plane, c.outliers);
    const int mended = Successes<Fundamental>(c.count, c.on_plane, c.outliers, c.scenes, Options());
    const int plain = Successes<PlainFundamental>(c.count, c.on_plane, c.outliers, c.scenes, Options());
    const int mended8 = Successes<Fundamental8>(c.count, c.on_plane, c.outliers, c.scenes, Options());
    const int plain8 = Successes<PlainFundamental8>(c.count, c.on_plane, c.outliers, c.scenes, Options());
    WARN(c.count << " " << c.on_plane << " " << c.outliers << ": " << mended << " " << plain << " " << mended8 << " "
                 << plain8 << " of " << c.scenes);
  }
}

}  // namespace
}  // namespace diffsac
