#include "diffsac/consensus/structures/structures.h"

namespace diffsac {

void StructureSearchOptions::Bind(OptionsBinder& b) {
  b.Field("search", search)
      .Help(
          "`one` model; several: `sequential`, each search on the points that are left; `at_once`, from one pool of "
          "hypotheses; `chosen`, of that pool by a network that learned from labels; `energy`, of that pool by an "
          "energy of all labels, and "
          "of models that are drawn within the structures found");
  const bool several = Several();
  const char* only = "structures.search other than one";
  b.Field("most", most, Within(1, 1000)).OnlyIf(several, only).Help("structures that are looked for at most");
  const bool chosen = search == StructureSearch::kChosen, energy = search == StructureSearch::kEnergy;
  const char* by_chance = "structures.search other than one, chosen and energy";
  b.Field("log_false_alarms", log_false_alarms)
      .OnlyIf(several && !chosen && !energy, by_chance)
      .Help("a structure is taken while chance gives fewer than 10 to this power of its like");
  b.Field("least_chance", least_chance, Within(0.0, 1.0))
      .OnlyIf(several && !chosen && !energy, by_chance)
      .Help(
          "a point anywhere is within ε of a model with this probability at least; what uniform points say where that "
          "is more");
  b.Field("rounds", rounds, Within(0, 100))
      .OnlyIf(several && !chosen, "structures.search other than one and chosen")
      .Help(
          "of assigning points to the nearest model and refitting models to their points; of `energy`, of drawing "
          "within structures, adding, merging and removing models");
  const char* by_energy = "structures.search: energy";
  b.Field("core", core, Within(1e-3, 100.0))
      .OnlyIf(energy, by_energy)
      .Help("the cost of a residual rises from this share of ε on, by its logarithm");
  b.Field("reach", reach, Within(1e-3, 1000.0))
      .OnlyIf(energy, by_energy)
      .Help("so many ε from its model a point can be; there it costs 1");
  b.Field("outlier_cost", outlier_cost, Within(0.0, 100.0))
      .OnlyIf(energy, by_energy)
      .Help("of a point without a model");
  b.Field("support_weight", support_weight, Within(0.0, 100.0))
      .OnlyIf(energy, by_energy)
      .Help(
          "of what the neighbours of a match say for it, added to its cost as an outlier; points of other data have "
          "none");
  b.Field("structure_cost", structure_cost, Within(0.0, 1e6)).OnlyIf(energy, by_energy).Help("of each model");
  b.Field("spatial_weight", spatial_weight, Within(0.0, 100.0))
      .OnlyIf(energy, by_energy)
      .Help("cost of two neighbours that have different models");
  b.Field("neighbors", neighbors, Within(1, 1000))
      .OnlyIf(energy, by_energy)
      .Help("nearest points, in all coordinates, that are a point's neighbours");
  b.Field("chooser", chooser)
      .OnlyIf(chosen, "structures.search: chosen")
      .Help("the file of a network that was trained with `method: structure_chooser`");
  b.Field("least_value", least_value, Within(0.0, 1.0))
      .OnlyIf(chosen, "structures.search: chosen")
      .Help("a structure is taken while the chooser expects it to be worth so much; 0: as many as `most`");
  b.Require(!chosen || !chooser.empty() || chosen_by != nullptr, "chooser", "a file");
}

}  // namespace diffsac
