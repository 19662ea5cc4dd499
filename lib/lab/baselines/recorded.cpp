#include "lab/baselines/recorded.h"

#include <zlib.h>

#include <iterator>
#include <optional>
#include <string_view>
#include <vector>

#include "diffsac/estimate/task_dispatch.h"
#include "lab/config/estimator_registry.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"

namespace diffsac {
namespace {

/// The text of a file, which may be compressed (.gz).
std::string ReadRecording(const std::string& path) {
  if (!path.ends_with(".gz")) return ReadTextFile(path);
  const gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) throw Error(path + ": cannot be opened");
  std::string text, part(1 << 16, '\0');
  int count = 0;
  while ((count = gzread(file, part.data(), static_cast<unsigned>(part.size()))) > 0)
    text.append(part, 0, static_cast<std::size_t>(count));
  const bool whole = gzclose(file) == Z_OK && count == 0;
  if (!whole) throw Error(path + ": is damaged");
  return text;
}

constexpr std::string_view kColumns = "row,condition,id,seed,ms,model";

std::optional<ModelParameters> NumbersOf(const std::string& text) {
  const std::vector<std::string_view> words = SplitWords(text, " ");
  ModelParameters numbers(static_cast<Eigen::Index>(words.size()));
  for (std::size_t i = 0; i < words.size(); ++i)
    if (!ParseNumber(words[i], &numbers[static_cast<Eigen::Index>(i)])) return std::nullopt;
  return numbers;
}

/// Focal lengths are recorded in pixels, behind E.
ModelParameters InSolverUnits(ModelParameters model, const Problem& problem) {
  DispatchDescription(problem.task, [&]<class Description>() {
    if constexpr (requires { Description::kUnknownFocal; }) {
      const auto space = FocalSpaceOf(Description::kUnknownFocal, problem);
      if (space && model.size() == Description::Model::Parameters::SizeAtCompileTime)
        for (int k = 0; k < 2; ++k) model[9 + k] /= space->unit[static_cast<std::size_t>(k)];
    }
  });
  return model;
}

}  // namespace

void RecordedOptions::Bind(OptionsBinder& b) {
  b.Field("recording", recording).Help("a file of `scripts/peers/two_view.py`, or of the same form");
  b.Field("row", row).Help("which of its rows");
}

RecordedRow::RecordedRow(const RecordedOptions& options) : options_(options) {
  const std::string text = ReadRecording(options.recording);
  std::string_view rest = text, line;
  bool named = false;
  for (std::size_t number = 1; TakeLine(&rest, &line); ++number) {
    const auto fail = [&](const std::string& what) {
      throw Error(options.recording + ":" + std::to_string(number) + ": " + what);
    };
    if (line.empty() || line.front() == '#') continue;
    if (!named) {
      if (line != kColumns) fail("expected the columns " + std::string(kColumns));
      named = true;
      continue;
    }
    std::size_t at = 0;
    const std::vector<std::string> fields = TakeCsvLine(std::string(line), &at);
    double seed = 0.0;
    Record record;
    if (fields.size() != 6) fail("expected six fields, as " + std::string(kColumns));
    if (!ParseNumber(fields[3], &seed) || seed < 0.0) fail("seed '" + fields[3] + "': expected a number");
    if (!ParseNumber(fields[4], &record.ms)) fail("ms '" + fields[4] + "': expected a number");
    const std::optional<ModelParameters> model = NumbersOf(fields[5]);
    if (!model) fail("model '" + fields[5] + "': expected numbers with spaces between them");
    if (fields[0] != options.row) continue;
    record.model = *model;
    records_[{fields[1], fields[2], static_cast<std::uint64_t>(seed)}] = record;
    seeds_.insert(static_cast<std::uint64_t>(seed));
  }
  if (records_.empty()) throw Error(options.recording + ": has no row '" + options.row + "'");
}

Estimate RecordedRow::Of(const Example& example, const std::string& condition, std::uint64_t seed) const {
  const std::string id = ProblemName(example);
  if (seeds_.count(seed) == 0) seed = *std::next(seeds_.begin(), static_cast<std::ptrdiff_t>(seed % seeds_.size()));
  const auto found = records_.find({condition, id, seed});
  if (found == records_.end())
    throw Error(options_.recording + ": row '" + options_.row + "' has no estimate of '" + id + "', condition '" +
                condition + "', seed " + std::to_string(seed) + "; was it recorded for another choice of problems?");
  const Record& record = found->second;
  Estimate estimate =
      TimedEstimate(NormalizedProblem(example.problem), [&]<MinimalModel Model>(const NormalizedProblem& space) {
        Estimate accepted;
        if (record.model.size() == 0) return accepted;
        if (record.model.size() != Model::Parameters::SizeAtCompileTime)
          throw Error(options_.recording + ": '" + id + "': expected " +
                      std::to_string(Model::Parameters::SizeAtCompileTime) + " numbers of a model, not " +
                      std::to_string(record.model.size()));
        if (record.model.allFinite())
          AcceptModel<Model>(space, InSolverUnits(record.model, example.problem), &accepted);
        return accepted;
      });
  if (estimate.status != Status::kOk)
    estimate.inliers.assign(static_cast<std::size_t>(example.problem.points.rows()), 0);
  estimate.stats.ms_consensus = estimate.stats.ms_total = record.ms;
  return estimate;
}

const RegisteredEstimator<RecordedOptions> kRecorded(
    "recorded", "What another program estimated of the same problems, from a file (docs/peers.md).",
    [](Task) { return RecordedOptions(); },
    [](const RecordedOptions& options) {
      return TableRow([row = RecordedRow(options)](const Example& example, const RowCall& call) {
        return row.Of(example, call.condition, call.experiment_seed);
      });
    });

}  // namespace diffsac
