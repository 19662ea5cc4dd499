#include "lab/config/yaml.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "diffsac/core/registry.h"
#include "diffsac/core/status.h"
#include "diffsac/guidance/engine/checkpoint_info.h"
#include "lab/files/files.h"
#include "lab/options/config.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;
using Kind = ConfigTree::Kind;

constexpr const char* kInclude = "include";

/// Limits that no honest configuration meets: they stop documents whose aliases contain themselves or explode, and maps
/// so large that going through them for each of their keys takes minutes.
constexpr int kMaxDepth = 64;
constexpr int kMaxValues = 50000;

[[noreturn]] void Fail(ConfigPlace place, const YAML::Mark& mark, const std::string& what) {
  if (place.assignment.empty() && !mark.is_null()) place.line = mark.line + 1;
  const std::string start = PlaceText(place);
  throw Error((start.empty() ? "" : start + ": ") + what);
}

// And without zeros, which yaml-cpp takes for the end of its input in some places.
bool IsUtf8(const std::string& text) {
  if (text.find('\0') != std::string::npos) return false;
  try {
    static_cast<void>(nlohmann::json(text).dump());
    return true;
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

/// Copies yaml-cpp's nodes into trees.
class Converter {
 public:
  explicit Converter(const ConfigPlace& place) : place_(place) {}

  ConfigTree Convert(const YAML::Node& node, const YAML::Mark& mark, int depth = 0) {
    if (depth > kMaxDepth) Fail(place_, mark, "nested too deeply");
    if (++values_ > kMaxValues) Fail(place_, mark, "too many values");
    ConfigTree tree;
    tree.place = place_;
    if (place_.assignment.empty() && !mark.is_null()) tree.place.line = mark.line + 1;
    if (node.IsScalar()) {
      tree.kind = Kind::kScalar;
      tree.scalar = node.Scalar();
      tree.quoted = node.Tag() == "!";
    } else if (node.IsSequence()) {
      tree.kind = Kind::kSequence;
      for (const YAML::Node& item : node) tree.items.push_back(Convert(item, item.Mark(), depth + 1));
    } else if (node.IsMap()) {
      ConvertMap(node, depth, tree);
    }
    return tree;
  }

 private:
  void ConvertMap(const YAML::Node& node, int depth, ConfigTree& tree) {
    tree.kind = Kind::kMap;
    for (const auto& entry : node) {
      const YAML::Mark mark = entry.first.Mark();
      if (!entry.first.IsScalar()) Fail(place_, mark, "expected a plain word as key");
      const std::string& key = entry.first.Scalar();
      if (tree.Find(key) != nullptr) Fail(place_, mark, "duplicate key '" + key + "'");
      // The place of a value is its key's line: that is where a reader looks for it.
      tree.entries.push_back({key, Convert(entry.second, mark, depth + 1)});
    }
  }

  ConfigPlace place_;
  int values_ = 0;
};

/// Whether there is anything in a document, and where it begins.
class Document : public YAML::EventHandler {
 public:
  bool has_content = false;
  YAML::Mark mark;

  void OnDocumentStart(const YAML::Mark& start) override { mark = start; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override { has_content = true; }
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {
    has_content = true;
  }
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    has_content = true;
  }
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    has_content = true;
  }
  void OnMapEnd() override {}
};

void Emit(const ConfigTree& tree, YAML::Emitter& out) {
  switch (tree.kind) {
    case Kind::kNull:
      out << YAML::Null;
      return;
    case Kind::kScalar:
      if (tree.quoted) out << YAML::DoubleQuoted;
      out << tree.scalar;
      return;
    case Kind::kSequence: {
      bool flat = true;
      for (const ConfigTree& item : tree.items) flat = flat && item.kind == Kind::kScalar;
      if (flat) out << YAML::Flow;
      out << YAML::BeginSeq;
      for (const ConfigTree& item : tree.items) Emit(item, out);
      out << YAML::EndSeq;
      return;
    }
    case Kind::kMap:
      if (tree.entries.empty()) out << YAML::Flow;
      out << YAML::BeginMap;
      for (const ConfigEntry& entry : tree.entries) {
        out << YAML::Key;
        if (LooksLikeAnotherType(entry.key)) out << YAML::DoubleQuoted;
        out << entry.key << YAML::Value;
        Emit(entry.value, out);
      }
      out << YAML::EndMap;
      return;
  }
}

ConfigTree LoadFile(const std::string& path, std::vector<fs::path>& open_files);

/// The document that an `include` names, relative to the file that includes it.
ConfigTree LoadIncluded(const ConfigTree& name, std::vector<fs::path>& open_files) {
  const std::string where = PlaceText(name.place) + ": include: ";
  if (name.kind != Kind::kScalar) throw Error(where + "expected a file name, or a list of them");
  const std::string path = (fs::path(name.place.file).parent_path() / name.scalar).string();
  const fs::path identity = fs::weakly_canonical(path);
  if (std::find(open_files.begin(), open_files.end(), identity) != open_files.end()) {
    throw Error(where + "'" + path + "' includes itself");
  }
  if (!fs::exists(path)) throw Error(where + "cannot read '" + path + "': no such file");
  // A device or pipe may never end.
  if (!fs::is_regular_file(path)) throw Error(where + "cannot read '" + path + "': not a file");
  return LoadFile(path, open_files);
}

/// Takes `include` out of a document and puts the document on top of the files it names, each on top of those before.
ConfigTree ResolveInclude(ConfigTree tree, std::vector<fs::path>& open_files) {
  const auto entry = std::find_if(tree.entries.begin(), tree.entries.end(),
                                  [](const ConfigEntry& candidate) { return candidate.key == kInclude; });
  if (entry == tree.entries.end()) return tree;
  const ConfigTree included = std::move(entry->value);
  tree.entries.erase(entry);
  const std::vector<ConfigTree> names = included.kind == Kind::kSequence ? included.items : std::vector{included};
  ConfigTree base;
  base.kind = Kind::kMap;
  for (const ConfigTree& name : names) MergeTrees(base, LoadIncluded(name, open_files));
  MergeTrees(base, std::move(tree));
  return base;
}

ConfigTree LoadText(const std::string& text, const std::string& name, std::vector<fs::path>& open_files) {
  ConfigPlace place;
  place.file = name;
  ConfigTree tree = ParseYaml(text, place);
  if (tree.kind != Kind::kMap && tree.kind != Kind::kNull) {
    throw Error(PlaceText(tree.place) + ": expected a map of options (key: value)");
  }
  return ResolveInclude(std::move(tree), open_files);
}

ConfigTree LoadFile(const std::string& path, std::vector<fs::path>& open_files) {
  open_files.push_back(fs::weakly_canonical(path));
  ConfigTree tree = LoadText(ReadTextFile(path), path, open_files);
  open_files.pop_back();
  return tree;
}

}  // namespace

ConfigTree ParseYaml(const std::string& text, const ConfigPlace& place) {
  // yaml-cpp takes other bytes as they are, and what is written of them later for another encoding.
  if (!IsUtf8(text)) Fail(place, YAML::Mark::null_mark(), "expected UTF-8 text");
  try {
    // Not by YAML::LoadAll, which never ends on some broken texts.
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    Document first, second, third;
    parser.HandleNextDocument(first);
    // An end of the first one may be followed by nothing.
    const bool more = parser.HandleNextDocument(second) && (second.has_content || parser.HandleNextDocument(third));
    if (more) Fail(place, second.mark, "expected a single YAML document");
    const YAML::Node node = YAML::Load(text);
    return Converter(place).Convert(node, node.Mark());
  } catch (const YAML::Exception& exception) {
    // Not only its ParserException: others come of keys and tags that make no sense, and of nesting too deep.
    Fail(place, exception.mark, "not valid YAML: " + exception.msg);
  }
}

std::string DumpYaml(const ConfigTree& tree) {
  YAML::Emitter out;
  Emit(tree, out);
  return std::string(out.c_str()) + "\n";
}

std::string FlowYaml(const ConfigTree& tree) {
  YAML::Emitter out;
  out.SetSeqFormat(YAML::Flow);
  out.SetMapFormat(YAML::Flow);
  Emit(tree, out);
  return out.c_str();
}

Config ConfigFromFile(const std::string& path) {
  std::vector<fs::path> open_files;
  return Config(LoadFile(path, open_files));
}

Config ConfigFromYaml(const std::string& text, const std::string& name) {
  std::vector<fs::path> open_files;
  return Config(LoadText(text, name, open_files));
}

void SetYaml(Config* config, const std::string& assignment) {
  const auto equals = assignment.find('=');
  const std::vector<std::string> steps = SplitPath(assignment.substr(0, equals));
  const bool empty_step = std::find(steps.begin(), steps.end(), "") != steps.end();
  if (equals == std::string::npos || steps.empty() || empty_step) {
    throw Error("--set " + assignment + ": expected key.path=value");
  }
  std::vector<std::string> path = config->impl_->path;
  path.insert(path.end(), steps.begin(), steps.end());
  ConfigPlace place;
  // The whole path, so that messages name it even when a sub-document was set.
  place.assignment = JoinPath(path) + assignment.substr(equals);
  config->Put(JoinPath(steps), ParseYaml(assignment.substr(equals + 1), place));
}

std::string ToYaml(const Config& config) {
  const ConfigTree* tree = config.impl_->Get();
  ConfigTree empty;
  empty.kind = Kind::kMap;
  return DumpYaml(tree == nullptr || tree->kind == Kind::kNull ? empty : *tree);
}

namespace {

// Checkpoints of earlier versions hold YAML.
const Registered<CheckpointConfigReader> kYaml("yaml", {[](const std::string& text, const std::string& name) {
                                                 return ToJson(ConfigFromYaml(text, name));
                                               }});

using Values = std::vector<std::pair<std::string, std::string>>;

bool IsPlain(const ConfigTree& tree) { return tree.kind != Kind::kMap && tree.kind != Kind::kSequence; }

/// Every value by its path, in order.
void Flatten(const ConfigTree& tree, const std::string& path, Values* values) {
  const auto below = [&](const std::string& step) { return path.empty() ? step : path + "." + step; };
  if (IsPlain(tree)) values->emplace_back(path, FlowYaml(tree));
  for (const ConfigEntry& entry : tree.entries) Flatten(entry.value, below(entry.key), values);
  if (tree.kind != Kind::kSequence) return;
  if (std::all_of(tree.items.begin(), tree.items.end(), IsPlain)) return values->push_back({path, FlowYaml(tree)});
  for (std::size_t i = 0; i < tree.items.size(); ++i) {
    const ConfigTree* name = tree.items[i].Find("name");
    Flatten(tree.items[i], below(name != nullptr ? name->scalar : std::to_string(i)), values);
  }
}

Values ValuesOf(const std::string& yaml) {
  Values values;
  const ConfigTree tree = ParseYaml(yaml, {});
  if (tree.kind != Kind::kNull) Flatten(tree, "", &values);
  return values;
}

std::optional<std::string> ValueOf(const Values& values, const std::string& key) {
  const auto found = std::find_if(values.begin(), values.end(), [&](const auto& value) { return value.first == key; });
  return found == values.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

std::vector<ChangedKey> ChangedKeys(const std::string& before, const std::string& now) {
  const Values old_values = ValuesOf(before), new_values = ValuesOf(now);
  std::vector<ChangedKey> changed;
  for (const auto& [key, value] : old_values) {
    const auto other = ValueOf(new_values, key);
    if (other != value) changed.push_back({key, value, other});
  }
  for (const auto& [key, value] : new_values)
    if (!ValueOf(old_values, key)) changed.push_back({key, std::nullopt, value});
  return changed;
}

}  // namespace diffsac
