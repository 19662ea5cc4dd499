#include "lab/train/configuration_reference.h"

#include <algorithm>

#include "diffsac/core/status.h"
#include "lab/config/dataset_registry.h"
#include "lab/config/estimator_registry.h"
#include "lab/config/option_reference.h"
#include "lab/eval/experiment.h"
#include "lab/train/learner.h"

namespace diffsac {
namespace {

using Descriptions = std::vector<OptionDescription>;

constexpr char kIntroduction[] =
    R"(Made by `diffsac_train --describe-options` from what the code itself reads; `cmake --build --preset release --target
diffsac_reference` writes it.

A configuration is one YAML file, of a training or of a table. Its concepts:

| concept | |
|---|---|
| key | belongs to a group; each is in the tables below, with default and range. An unknown key, a wrong type, a value out of range or a key that cannot act is an error that names file, line and nearest key |
| `type`, `method`, `task` | choose what is made; which other keys there are depends on them |
| `include` | files that are read first, the file's own keys override theirs. A table includes at most two: its problems and its rows |
| row | `methods: {NAME: {type: ...}}`: what a table compares. `rows` chooses and orders them |
| `settings`, `use` | named parts of rows; a row takes them by `use: NAME`, later ones and its own keys override earlier ones |
| `preset` | of a row: `recommended`, `paper` and such, the options that the row's keys then change |
| condition | a column of a table: `sweep: {KEY: [...]}` for each value of one option of the data, `conditions` where more differs |
| `seeds` | the whole table with each, whose mean it shows |
| `mixture` | training on several data sets, drawn by weight |
| `${KEY}` | another key's value, in any text; `--set a.b=value` sets any key on the command line |

What is read, all includes, settings and defaults resolved, is written to `config.yaml` in the run folder.

Paths in a file (`include`, `checkpoint`, `start_from`, `chooser`, `paths`, `root`, `folder`) are relative to that file. But for `include`,
what is not there is looked for in the current folder, as what `--set` gives is, and what begins with `models/` then in `$DIFFSAC_MODELS`
and in `share/diffsac/models` beside the program, and last in the library. Where nothing is found, the message names every place.)";

constexpr char kMainMethod[] = "diffsac";

// "Other defaults of homography: ..." for the tasks that differ from the first one; `describe` throws Error for a task
// that is not estimated.
template <class Describe>
std::string TaskDifferences(const Descriptions& first, const Describe& describe) {
  std::vector<std::pair<std::string, std::string>> tasks;  // a difference and those that have it
  for (const std::string& name : TaskNames()) {
    try {
      const std::string text = DifferenceText(first, describe(TaskFromString(name)));
      if (text.empty()) continue;
      const auto same = std::find_if(tasks.begin(), tasks.end(), [&](const auto& task) { return task.first == text; });
      if (same == tasks.end())
        tasks.push_back({text, "`" + name + "`"});
      else
        same->second += ", `" + name + "`";
    } catch (const Error&) {
    }
  }
  std::string all;
  for (const auto& [text, names] : tasks) all += (all.empty() ? "" : "\n\n") + ("Of " + names + ": " + text + ".");
  return all;
}

std::string Paragraphs(const std::string& first, const std::string& second) {
  return second.empty() ? first : first + "\n\n" + second;
}

Descriptions DescribeTraining(const std::string& method, Task task) {
  Descriptions keys = DescribeOptions(TrainConfig(method, task));
  // Its default is what was asked for.
  for (OptionDescription& key : keys)
    if (key.key == "task") key.default_value = TaskNames().front();
  return keys;
}

// The keys that are not those of the main method's configuration.
Descriptions OwnKeys(const Descriptions& base, const Descriptions& keys) {
  Descriptions own;
  for (const OptionDescription& key : keys) {
    const auto old = std::find_if(base.begin(), base.end(), [&](const auto& other) { return other.key == key.key; });
    const bool common = key.key == "method" ||
                        (old != base.end() && old->options == key.options && DifferenceText({*old}, {key}).empty());
    if (!common) own.push_back(key);
  }
  return own;
}

void AddTraining(OptionReference* reference) {
  reference->AddText(2, "Training configuration (`diffsac_train`)", "");
  const auto describe = [](Task task) { return DescribeTraining(kMainMethod, task); };
  const Descriptions base = describe(TaskFromString(TaskNames().front()));
  const auto& learners = Registry<LearnerEntry>::Instance();
  std::string methods = "`method` is one of " + learners.NamesText() +
                        ". The defaults are those of `task: " + TaskNames().front() + "` and `method: " + kMainMethod +
                        "`.";
  reference->AddOptions("top level", Paragraphs(methods, TaskDifferences(base, describe)), "", typeid(TrainConfig),
                        base);
  for (const std::string& name : learners.Names()) {
    if (name == kMainMethod) continue;
    const std::string title = "`method: " + name + "`";
    reference->AddOptions(title, learners.Find(name, "").help + " What differs:", " of " + title, typeid(void),
                          OwnKeys(base, DescribeTraining(name, TaskFromString(TaskNames().front()))));
  }
}

void AddData(OptionReference* reference) {
  reference->AddText(2, "Data (`data` of both programs)", "`type` chooses, the other keys are the type's.");
  const auto& datasets = Registry<DatasetEntry>::Instance();
  for (const std::string& name : datasets.Names()) {
    const DatasetEntry& entry = datasets.Find(name, "");
    const std::string title = "`type: " + name + "`";
    reference->AddOptions(title, entry.help, " of " + title, entry.options, entry.describe());
  }
  reference->AddOptions("`type: mixture`", "Training alone: examples of several datasets, drawn by weight.",
                        " of `type: mixture`", typeid(void), DescribeMixture());
}

void AddExperiments(OptionReference* reference) {
  reference->AddText(2, "Experiments (`diffsac_eval`)", "");
  reference->AddOptions("top level of an experiment", "", " of an experiment", typeid(ExperimentOptions),
                        DescribeOptions<ExperimentOptions>());
}

void AddRows(OptionReference* reference) {
  reference->AddText(
      2, "Rows of an experiment (`methods`)",
      "`type` chooses, the other keys are the type's. A row with a network has a `checkpoint`, whose group\n"
      "`inference` has the defaults of the row's other keys.");
  const auto& methods = Registry<EstimatorEntry>::Instance();
  for (const std::string& name : methods.Names()) {
    const EstimatorEntry& entry = methods.Find(name, "");
    const std::vector<std::string> tasks = TaskNames();
    const auto first = std::find_if(tasks.begin(), tasks.end(), [&](const std::string& task) {
      try {
        entry.describe(TaskFromString(task));
        return true;
      } catch (const Error&) {
        return false;
      }
    });
    const std::string title = "`type: " + name + "`";
    const Descriptions keys = entry.describe(TaskFromString(*first));
    reference->AddOptions(title, Paragraphs(entry.help, TaskDifferences(keys, entry.describe)), " of " + title,
                          entry.options, keys);
  }
}

}  // namespace

std::string ConfigurationReference() {
  OptionReference reference;
  reference.AddText(1, "Configuration reference", kIntroduction);
  AddTraining(&reference);
  AddData(&reference);
  AddExperiments(&reference);
  AddRows(&reference);
  return reference.text();
}

}  // namespace diffsac
