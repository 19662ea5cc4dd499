#include "lab/eval/structure_tables.h"

#include <algorithm>
#include <cmath>

#include "lab/eval/tables.h"

namespace diffsac {
namespace {

bool HasStructureSets(const ExperimentResults& results) {
  return std::any_of(results.cells.begin(), results.cells.end(), [](const Cell& cell) {
    return std::any_of(cell.records.begin(), cell.records.end(),
                       [](const ProblemRecord& record) { return !std::isnan(record.one_structure_sets); });
  });
}

}  // namespace

std::vector<MetricTable> StructureKinds(const ExperimentResults& results) {
  // As the papers do, over all problems: AdelaideRMF's scenes are single pairs.
  const std::size_t scenes = MostScenes(results);
  const std::string all = scenes > 1 ? kAllPairs : "mean";
  std::vector<MetricTable> kinds;
  const auto add = [&](const std::string& heading, const MetricColumn& column, bool costs) {
    kinds.push_back({heading, {}, costs});
    AddConditions(results, column, "", &kinds.back());
  };
  add("misclassification error in %, mean, lower is better",
      {"", 0, all, "misclassification", 2, false, &PaperValue::misclassification}, true);
  add("misclassification error in %, median, lower is better",
      {"", 0, all, "misclassification_median", 2, false, &PaperValue::misclassification_median}, false);
  add("recall of structures" + (scenes > 1 ? ", unweighted mean over " + std::to_string(scenes) + " scenes" : "") +
          ", higher is better",
      {"", 0, "mean", "recall", 3, true, &PaperValue::recall}, false);
  if (std::any_of(results.cells.begin(), results.cells.end(), JudgesAngles)) {
    const Tolerance c = results.experiment.tolerance();
    for (const bool half : {true, false}) {
      const std::string name = MetricName("recall_AUC", half ? 0.5 * c.value : c.value);
      add(name + " of structures in %, higher is better",
          {"", 0, all, name, 2, true, half ? &PaperValue::recall_auc_half : &PaperValue::recall_auc, 100.0}, false);
    }
    const std::string within = MetricName("structures_within", c);
    add("structures within " + FixedText(c.value, 1) + "° in %, higher is better",
        {"", 0, all, within, 1, true, nullptr, 100.0}, false);
  }
  if (!HasStructureSets(results)) return kinds;
  add("share of the first 20 minimal sets that are of one true structure alone", {"", 0, "mean", kSetsMetric, 3},
      false);
  kinds.back().intervals = true;
  add("share of the true structures that such a set is of", {"", 0, "mean", "structures_in_sets", 3}, false);
  return kinds;
}

}  // namespace diffsac
