#include "diffsac/core/yaml_tree.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

using Kind = YamlTree::Kind;

/// Limits that no honest configuration meets: they stop documents whose aliases contain themselves or explode, and maps
/// so large that going through them for each of their keys takes minutes.
constexpr int kMaxDepth = 64;
constexpr int kMaxValues = 50000;

[[noreturn]] void Fail(YamlPlace place, const YAML::Mark& mark, const std::string& what) {
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
  explicit Converter(const YamlPlace& place) : place_(place) {}

  YamlTree Convert(const YAML::Node& node, const YAML::Mark& mark, int depth = 0) {
    if (depth > kMaxDepth) Fail(place_, mark, "nested too deeply");
    if (++values_ > kMaxValues) Fail(place_, mark, "too many values");
    YamlTree tree;
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
  void ConvertMap(const YAML::Node& node, int depth, YamlTree& tree) {
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

  YamlPlace place_;
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

bool LooksLikeAnotherType(const std::string& text) {
  double number = 0.0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), number);
  if (result.ec != std::errc::invalid_argument && result.ptr == text.data() + text.size()) return true;
  static constexpr std::array<const char*, 6> kWords = {"true", "false", "yes", "no", "on", "off"};
  for (const char* word : kWords) {
    if (text == word) return true;
  }
  return text.empty();
}

void Emit(const YamlTree& tree, YAML::Emitter& out) {
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
      for (const YamlTree& item : tree.items) flat = flat && item.kind == Kind::kScalar;
      if (flat) out << YAML::Flow;
      out << YAML::BeginSeq;
      for (const YamlTree& item : tree.items) Emit(item, out);
      out << YAML::EndSeq;
      return;
    }
    case Kind::kMap:
      if (tree.entries.empty()) out << YAML::Flow;
      out << YAML::BeginMap;
      for (const YamlEntry& entry : tree.entries) {
        out << YAML::Key;
        if (LooksLikeAnotherType(entry.key)) out << YAML::DoubleQuoted;
        out << entry.key << YAML::Value;
        Emit(entry.value, out);
      }
      out << YAML::EndMap;
      return;
  }
}

bool ParseIndex(const std::string& text, std::size_t& index) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), index);
  return result.ec == std::errc() && result.ptr == text.data() + text.size();
}

const YamlTree* Child(const YamlTree& tree, const std::string& step) {
  if (tree.kind == Kind::kMap) return tree.Find(step);
  std::size_t index = 0;
  if (tree.kind != Kind::kSequence || !ParseIndex(step, index) || index >= tree.items.size()) return nullptr;
  return &tree.items[index];
}

}  // namespace

const YamlTree* YamlTree::Find(const std::string& key) const {
  for (const YamlEntry& entry : entries) {
    if (entry.key == key) return &entry.value;
  }
  return nullptr;
}

YamlTree* YamlTree::Find(const std::string& key) {
  return const_cast<YamlTree*>(static_cast<const YamlTree&>(*this).Find(key));
}

YamlTree ParseYaml(const std::string& text, const YamlPlace& place) {
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

void MergeYaml(YamlTree& base, YamlTree over) {
  if (base.kind == Kind::kMap && over.kind == Kind::kNull) return;
  if (base.kind != Kind::kMap || over.kind != Kind::kMap) {
    base = std::move(over);
    return;
  }
  base.place = over.place;
  for (YamlEntry& entry : over.entries) {
    if (YamlTree* old = base.Find(entry.key)) {
      MergeYaml(*old, std::move(entry.value));
    } else {
      base.entries.push_back(std::move(entry));
    }
  }
}

std::string DumpYaml(const YamlTree& tree) {
  YAML::Emitter out;
  Emit(tree, out);
  return std::string(out.c_str()) + "\n";
}

std::string FlowYaml(const YamlTree& tree) {
  YAML::Emitter out;
  out.SetSeqFormat(YAML::Flow);
  out.SetMapFormat(YAML::Flow);
  Emit(tree, out);
  return out.c_str();
}

std::string DoubleText(double value) {
  if (!std::isfinite(value)) throw std::logic_error("an option must be a finite number");
  std::array<char, 40> buffer;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  std::string text(buffer.data(), result.ptr);
  // YAML 1.1 readers take 1e-04 for a word and 1.0e-04 for a number.
  const auto exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) text.insert(exponent, ".0");
  return text;
}

std::string PlaceText(const YamlPlace& place) {
  if (!place.assignment.empty()) return "--set " + place.assignment;
  if (place.file.empty() || place.line == 0) return place.file;
  return place.file + ":" + std::to_string(place.line);
}

std::vector<std::string> SplitPath(const std::string& dotted_path) {
  std::vector<std::string> path;
  if (dotted_path.empty()) return path;
  std::size_t begin = 0;
  for (std::size_t end = dotted_path.find('.'); end != std::string::npos; end = dotted_path.find('.', begin)) {
    path.push_back(dotted_path.substr(begin, end - begin));
    begin = end + 1;
  }
  path.push_back(dotted_path.substr(begin));
  return path;
}

std::string JoinPath(const std::vector<std::string>& path) {
  std::string joined;
  for (const std::string& step : path) joined += (joined.empty() ? "" : ".") + step;
  return joined;
}

const YamlTree* Config::Impl::Get() const {
  const YamlTree* tree = &document->root;
  for (const std::string& step : path) {
    tree = Child(*tree, step);
    if (tree == nullptr) return nullptr;
  }
  return tree;
}

namespace {

// The path that a reader of the file knows.
std::string ShownPath(const YamlDocument& document, const std::vector<std::string>& path) {
  std::vector<std::string> whole = document.prefix;
  whole.insert(whole.end(), path.begin(), path.end());
  return JoinPath(whole);
}

}  // namespace

bool GivenBySet(const YamlDocument& document, const std::vector<std::string>& path) {
  const YamlTree* tree = &document.root;
  for (const std::string& step : path) {
    tree = Child(*tree, step);
    if (tree == nullptr) return false;
  }
  return tree->place.assignment.starts_with(ShownPath(document, path) + "=");
}

std::string WhereText(const YamlDocument& document, const std::vector<std::string>& path) {
  YamlPlace place = document.root.place;
  // The first line of a file tells nothing; that of a part does.
  if (document.prefix.empty()) place.line = 0;
  const YamlTree* tree = &document.root;
  for (const std::string& step : path) {
    tree = Child(*tree, step);
    if (tree == nullptr) break;
    place = tree->place;
  }
  const std::string start = PlaceText(place), shown = ShownPath(document, path);
  if (shown.empty() || GivenBySet(document, path)) return start;
  return (start.empty() ? "" : start + ": ") + shown;
}

}  // namespace diffsac
