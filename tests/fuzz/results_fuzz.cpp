// What --merge, --compare and --update read back, as a bundle (fuzz_target.h): `shards` holds one text of records a
// file, `runs` the folders a/ and b/.

#include <filesystem>

#include "fuzz/fuzz_target.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/eval/shard_records.h"
#include "lab/report/compare_runs.h"
#include "lab/report/markdown_report.h"
#include "lab/report/merge.h"
#include "lab/report/results_page.h"
#include "lab/report/run_reader.h"

namespace diffsac::testing {
namespace {

Bundle ShardsSeed() {
  Bundle bundle{"shards", {}};
  for (int index = 1; index <= 2; ++index) {
    ExperimentResults results = MadeUpResults();
    results.problems = {4, 4};
    results.shard = {index, 2};
    for (Cell& cell : results.cells)
      std::erase_if(cell.records,
                    [&](const ProblemRecord& r) { return r.index % 2 != static_cast<unsigned>(index - 1); });
    bundle.files.push_back({"part" + std::to_string(index), ShardRecords(results, "")});
  }
  return bundle;
}

Bundle RunsSeed() {
  Bundle bundle{"runs", {}};
  for (const std::string run : {"a", "b"}) {
    const ExperimentResults results = MadeUpResults();
    const Report report = MakeReport(results);
    const std::string folder = Scratch() + "/seed";
    std::filesystem::create_directories(folder);
    WriteResults(report, folder);
    EndResults(report, folder);
    bundle.files.push_back({run + "/config.yaml", WriteExperiment(results.experiment)});
    for (const char* name : {"results.json", "problems.csv"})
      bundle.files.push_back({run + "/" + name, FilesBelow(folder, name, 1 << 20).at(0)});
  }
  return bundle;
}

void Merge(const Bundle& bundle) {
  std::vector<ShardContent> shards;
  for (const Bundle::File& file : bundle.files) shards.push_back(ReadShardRecords(file.content, file.name));
  const ExperimentResults results = MergeShards(std::move(shards), bundle.Find("partial") != nullptr);
  MarkdownReport(MakeReport(results));
}

void Compare() {
  const std::string a = Scratch() + "/a", b = Scratch() + "/b";
  const ExperimentResults first = ReadRun(a);
  IsMade(first.experiment, a, "");
  ComparisonTables(CompareRuns(first, ReadRun(b), a, b));
  MarkdownReport(MakeReport(first));
}

}  // namespace

std::vector<std::string> Seeds() { return {BundleText(ShardsSeed()), BundleText(RunsSeed())}; }

}  // namespace diffsac::testing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diffsac::testing;
  const Bundle bundle = ParseBundle({reinterpret_cast<const char*>(data), size});
  std::vector<std::string> names = {"--merge", Scratch()};
  for (const Bundle::File& file : bundle.files) names.push_back(file.name);
  if (bundle.kind == "runs") {
    WriteBundle(bundle);
    Parses(names, Compare);
  } else {
    Parses(names, [&] { Merge(bundle); });
  }
  return 0;
}
