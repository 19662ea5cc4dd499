#include "diffsac/core/former_names.h"

namespace diffsac {
namespace {

struct RenamedWord {
  const char* former;
  const char* current;
};

constexpr RenamedWord kRenamed[] = {
    {"basins", "lo_starts"},
    {"copies", "num_diffusion_samples"},
    {"edge_ratios", "length_ratio_consistency"},
    {"edges", "length_consistency"},
    {"energy", "pearl"},
    {"extra_sets", "num_uniform_samples"},
    {"gaussian_uniform", "mlesac"},
    {"has_other_pose", "has_ambiguous_pose"},
    {"head_sets", "num_guided_samples"},
    {"log_false_alarms", "log10_nfa"},
    {"marginalised_msac", "sigma_marginalised_msac"},
    {"noise_scale", "sigma"},
    {"other_pose", "ambiguous_pose"},
    {"polish", "lo_restarts"},
    {"preference", "residual"},
    {"preference_choice", "residual_choice"},
    {"preference_draws", "residual_draws"},
    {"preference_from", "residual_from"},
    {"preference_kept", "residual_kept"},
    {"refine_finalists", "num_finalists"},
    {"repeated_rows", "num_duplicates"},
    {"rows_left_out", "num_nonfinite"},
    {"share_behind", "cheirality_failure_ratio"},
    {"structure_cost", "instance_cost"},
    {"structures", "instances"},
    {"translation", "degeneracy"},
    {"turn_in_place", "pure_rotation"},
    {"turn_weight", "keypoint_orientation_weight"},
};

}  // namespace

std::string CurrentName(const std::string& name) {
  for (const RenamedWord& word : kRenamed)
    if (name == word.former) return word.current;
  return name;
}

std::string FormerName(const std::string& name) {
  for (const RenamedWord& word : kRenamed)
    if (name == word.current) return word.former;
  return name;
}

}  // namespace diffsac
