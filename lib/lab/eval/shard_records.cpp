#include "lab/eval/merge.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <concepts>
#include <sstream>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/eval/record_fields.h"

namespace diffsac {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "diffsac shard 10";

// The whole of a text as a number, or 0, which is never valid here.
int PositiveNumber(const std::string& text) {
  int value = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  return result.ec == std::errc() && result.ptr == end && value > 0 ? value : 0;
}

// The library's own conversion is undefined for numbers that no integer holds.
template <class Integer>
Integer Whole(const Json& value) {
  const bool held = value.is_number_unsigned()
                        ? std::in_range<Integer>(value.get<std::uint64_t>())
                        : value.is_number_integer() && std::in_range<Integer>(value.get<std::int64_t>());
  if (!held) throw Error("expected an integer");
  return value.get<Integer>();
}

std::vector<std::size_t> Wholes(const Json& values) {
  std::vector<std::size_t> read;
  for (const Json& value : values) read.push_back(Whole<std::size_t>(value));
  return read;
}

struct AppendToLine {
  Json& line;
  void operator()(const char*, double value) const {
    if (std::isfinite(value))
      line.push_back(value);
    else
      line.push_back(std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf");
  }
  template <std::integral Count>
  void operator()(const char*, Count value) const {
    line.push_back(value);
  }
  void operator()(const char*, Degeneracy value) const { line.push_back(std::string(ToString(value))); }
  void operator()(const char*, const std::vector<double>& values) const { line.push_back(values); }
};

class TakeValues {
 public:
  TakeValues(const Json& line, std::size_t* next) : line_(line), next_(next) {}
  void operator()(const char*, double& value) const {
    const Json& item = Next();
    value = item.is_string() ? std::strtod(item.get<std::string>().c_str(), nullptr) : item.get<double>();
  }
  void operator()(const char*, bool& value) const { value = Next().get<bool>(); }
  void operator()(const char*, Degeneracy& value) const { value = FromString<Degeneracy>(Next().get<std::string>()); }
  void operator()(const char*, std::vector<double>& values) const { values = Next().get<std::vector<double>>(); }
  template <std::integral Count>
  void operator()(const char*, Count& value) const {
    value = Whole<Count>(Next());
  }

 private:
  const Json& Next() const { return line_.at((*next_)++); }

  const Json& line_;
  std::size_t* next_;
};

std::string Dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"; }

// Cells, rather than names, which would be most of the file.
Json RecordLine(const Cell& cell, const ProblemRecord& record) {
  Json line = {cell.condition, cell.method,  record.index,
               record.id,      record.scene, std::string(ToString(record.status))};
  VisitAll(record, AppendToLine{line});
  return line;
}

void ReadRecord(const Json& line, ExperimentResults* results) {
  const auto condition = Whole<std::size_t>(line.at(0)), method = Whole<std::size_t>(line.at(1));
  if (condition >= results->experiment.conditions.size() || method >= results->experiment.methods.size())
    throw Error("no such row");
  ProblemRecord record;
  record.index = Whole<std::uint64_t>(line.at(2));
  record.id = line.at(3).get<std::string>();
  record.scene = line.at(4).get<std::string>();
  record.status = StatusFromText(line.at(5).get<std::string>());
  record.done = true;
  std::size_t next = 6;
  VisitAll(record, TakeValues(line, &next));
  if (next != line.size()) throw Error("too many values");
  auto& cells = results->cells;
  if (cells.empty() || cells.back().condition != condition || cells.back().method != method)
    cells.push_back({condition, method, {}});
  cells.back().records.push_back(std::move(record));
}

std::size_t RecordCount(const ExperimentResults& results) {
  std::size_t count = 0;
  for (const Cell& cell : results.cells) count += cell.records.size();
  return count;
}

Json LearnedJson(const std::vector<LearnedRow>& rows) {
  Json list = Json::array();
  for (const LearnedRow& row : rows)
    list.push_back({row.method, row.facts.parameters, row.facts.samples, row.facts.run_samples, row.facts.start});
  return list;
}

std::vector<LearnedRow> ReadLearned(const Json& list) {
  std::vector<LearnedRow> rows;
  for (const Json& row : list)
    rows.push_back({Whole<std::size_t>(row.at(0)),
                    {Whole<std::int64_t>(row.at(1)), Whole<std::int64_t>(row.at(2)), Whole<std::int64_t>(row.at(3)),
                     row.at(4).get<std::string>()}});
  return rows;
}

Json ReliabilityJson(const std::vector<ReliabilityCurve>& curves) {
  Json list = Json::array();
  for (const ReliabilityCurve& curve : curves) {
    Json scenes = Json::array();
    for (const auto& [scene, reliability] : curve.scenes) {
      Json bins = Json::array();
      for (const Reliability::Bin& bin : reliability.bins()) bins.push_back({bin.points, bin.predicted, bin.inliers});
      scenes.push_back({scene, bins});
    }
    list.push_back({curve.label, curve.condition, scenes});
  }
  return list;
}

std::vector<ReliabilityCurve> ReadReliability(const Json& list, std::size_t conditions) {
  std::vector<ReliabilityCurve> curves;
  for (const Json& item : list) {
    ReliabilityCurve curve{item.at(0).get<std::string>(), Whole<std::size_t>(item.at(1)), {}};
    if (curve.condition >= conditions) throw Error("no such condition");
    for (const Json& scene : item.at(2))
      for (int b = 0; b < Reliability::kBins; ++b) {
        const Json& bin = scene.at(1).at(static_cast<std::size_t>(b));
        curve.scenes[scene.at(0).get<std::string>()].Add(
            b, {bin.at(0).get<double>(), bin.at(1).get<double>(), bin.at(2).get<double>()});
      }
    curves.push_back(std::move(curve));
  }
  return curves;
}

Json HeaderJson(const ExperimentResults& results, const std::string& setup) {
  ExperimentOptions experiment = results.experiment;
  experiment.threads = 0;
  return {{"format", kFormat},
          {"shard", results.shard.index},
          {"shards", results.shard.count},
          {"complete", !results.partial},
          {"records", RecordCount(results)},
          {"problems", results.problems},
          {"dataset", results.dataset},
          {"fits_label", results.fits_label},
          {"learned", LearnedJson(results.learned)},
          {"reliability", ReliabilityJson(results.reliability)},
          {"left_out", experiment.left_out},
          {"git_revision", results.git_revision},
          {"machine", results.machine},
          {"setup", setup},
          {"experiment", WriteExperiment(experiment)}};
}

ShardContent ReadHeader(const Json& header, const std::string& name) {
  ShardContent content;
  content.name = name;
  if (header.at("format") != kFormat) throw Error("another format");
  content.experiment = header.at("experiment").get<std::string>();
  content.setup = header.at("setup").get<std::string>();
  ExperimentResults& results = content.results;
  results.experiment = ReadExperiment(ConfigFromYaml(content.experiment, name));
  results.experiment.left_out = header.at("left_out").get<std::vector<std::string>>();
  results.shard = {Whole<int>(header.at("shard")), Whole<int>(header.at("shards"))};
  results.partial = !header.at("complete").get<bool>();
  results.problems = Wholes(header.at("problems"));
  results.dataset = header.at("dataset").get<std::string>();
  results.fits_label = header.at("fits_label").get<std::string>();
  results.learned = ReadLearned(header.at("learned"));
  for (const LearnedRow& row : results.learned)
    if (row.method >= results.experiment.methods.size()) throw Error("no such row");
  results.reliability = ReadReliability(header.at("reliability"), results.experiment.conditions.size());
  results.git_revision = header.at("git_revision").get<std::string>();
  results.machine = header.at("machine").get<std::string>();
  return content;
}

}  // namespace

Shard ShardFromText(const std::string& text) {
  const std::size_t slash = text.find('/');
  Shard shard{0, 0};
  if (slash != std::string::npos)
    shard = {PositiveNumber(text.substr(0, slash)), PositiveNumber(text.substr(slash + 1))};
  if (shard.index < 1 || shard.index > shard.count)
    throw Error("--shard: expected i/n with 1 <= i <= n, as in 2/3; got '" + text + "'");
  return shard;
}

std::string ToString(const Shard& shard) { return std::to_string(shard.index) + "/" + std::to_string(shard.count); }

std::vector<std::size_t> ShardPositions(std::size_t count, std::size_t batch, const Shard& shard) {
  const auto shards = static_cast<std::size_t>(shard.count), mine = static_cast<std::size_t>(shard.index - 1);
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < count; ++i)
    if (i / batch % shards == mine) positions.push_back(i);
  return positions;
}

std::string ShardRecords(const ExperimentResults& results, const std::string& setup) {
  std::string text = Dump(HeaderJson(results, setup));
  for (const Cell& cell : results.cells)
    for (const ProblemRecord& record : cell.records) text += Dump(RecordLine(cell, record));
  return text;
}

ShardContent ReadShardRecords(const std::string& text, const std::string& name) {
  const auto fail = [&](const std::string& why) {
    return Error(name + ": not a shard's " + kShardRecords + ", or damaged (" + why + ")");
  };
  std::istringstream lines(text);
  std::string line;
  std::size_t number = 1;
  try {
    if (!std::getline(lines, line)) throw Error("empty");
    const Json header = Json::parse(line);
    ShardContent content = ReadHeader(header, name);
    for (++number; std::getline(lines, line); ++number) ReadRecord(Json::parse(line), &content.results);
    if (RecordCount(content.results) != Whole<std::size_t>(header.at("records"))) throw Error("records are missing");
    return content;
  } catch (const Json::exception& error) {
    throw fail("line " + std::to_string(number) + " is not as it was written");
  } catch (const Error& error) {
    throw fail("line " + std::to_string(number) + ": " + error.what());
  }
}

}  // namespace diffsac
