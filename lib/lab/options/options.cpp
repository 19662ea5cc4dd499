#include "lab/options/options.h"

#include <algorithm>
#include <stdexcept>

#include "diffsac/core/former_names.h"
#include "diffsac/core/status.h"
#include "lab/options/config_tree.h"

namespace diffsac {

/// Reads, writes or describes one map. One object a group; groups share the document.
struct OptionsBinder::Impl {
  enum class Mode { kRead, kWrite, kDescribe };
  using Path = std::vector<std::string>;
  using Bind = std::function<void(OptionsBinder&)>;
  explicit Impl(Mode bind_mode) : mode(bind_mode) {}

  Mode mode;
  Path keys;  // Every valid key so far; the last is the one just bound.

  // Reading.
  const ConfigDocument* document = nullptr;  // For places.
  bool stored = false;                       // Unknown keys and keys that do not act are passed over.
  Path path;                                 // Of this map.
  const ConfigTree* value = nullptr;         // What stands there, null pointer when absent.
  const ConfigTree* map = nullptr;           // The same where it is a map.
  std::string unmet;                         // The message of the first unmet requirement.

  ConfigTree written;                        // Writing: this map.
  std::vector<OptionDescription> described;  // Describing: its keys.

  bool reading() const { return mode == Mode::kRead; }
  const ConfigTree* Find(const std::string& key) const {
    if (!reading() || map == nullptr) return nullptr;
    const ConfigTree* given = map->Find(key);
    return given != nullptr ? given : map->Find(FormerName(key));
  }
  /// Whether a key of the map that is read is one of `keys`, by its former name if the current one is not given.
  bool IsBound(const std::string& key) const;
  Path PathOf(const std::string& key) const {
    Path full = path;
    full.push_back(key);
    return full;
  }
  Impl Inner(const std::string& key) const {
    Impl inner(mode);
    inner.document = document;
    inner.stored = stored;
    inner.path = PathOf(key);
    return inner;
  }

  /// A document of its own of what stands at `part`, which messages call by its whole path.
  Config Part(const Path& part, const ConfigTree& root) const {
    Config raw(root);
    raw.impl_->document->root.kind = ConfigTree::Kind::kMap;
    raw.impl_->document->prefix = document->prefix;
    raw.impl_->document->prefix.insert(raw.impl_->document->prefix.end(), part.begin(), part.end());
    return raw;
  }
  /// Describes a key by the keys that `bind` binds below it.
  void Describe(const char* key, const std::string& type, const Bind& bind) {
    Impl inner = Inner(key);
    OptionsBinder binder(&inner);
    bind(binder);
    Start(key, type, ConfigTree());
    described.back().children = std::move(inner.described);
  }

  /// What is given for a key while reading; otherwise writes or describes it by `default_value`.
  const ConfigTree* Start(const char* key, const std::string& expected, const ConfigTree& default_value);
  [[noreturn]] void Fail(const Path& full, const ConfigTree& got, const std::string& expected,
                         const std::string& hint = "") const;
  void Unmet(const std::string& message) {
    if (reading() && unmet.empty()) unmet = message;
  }

  void ReadMap(const ConfigTree* tree, const Bind& bind);
  void CheckKeys() const;
  ConfigTree WriteMap(const Bind& bind);
};

namespace {

using Impl = OptionsBinder::Impl;
using Kind = ConfigTree::Kind;
using Mode = Impl::Mode;
using Path = Impl::Path;

template <class Value>
void BindValue(Impl& impl, const char* key, Value& value, const std::string& expected) {
  const ConfigTree* tree = impl.Start(key, expected, ValueTree(value));
  if (tree != nullptr && !ParseValue(*tree, value)) impl.Fail(impl.PathOf(key), *tree, expected);
}

template <class Number>
void BindLimited(Impl& impl, const char* key, Number& value, const Limits& limits, const std::string& type) {
  const std::string expected = ExpectedText(type, limits);
  const ConfigTree* tree = impl.Start(key, expected, ValueTree(value));
  if (tree == nullptr) return;
  const bool good = ParseValue(*tree, value) && IsWithin(value, limits);
  if (!good) impl.Fail(impl.PathOf(key), *tree, expected);
}

/// Reads a list; `check` throws for an item, given its path and tree, that is not good. `items`: of what, for the
/// description.
template <class Item, class Check>
void BindList(Impl& impl, const char* key, std::vector<Item>& value, const std::string& type, const std::string& items,
              const Check& check) {
  const ConfigTree* tree = impl.Start(key, impl.reading() ? type : type + items, ValueTree(value));
  if (tree == nullptr) return;
  if (tree->kind != Kind::kSequence) impl.Fail(impl.PathOf(key), *tree, type);
  value.clear();
  for (std::size_t i = 0; i < tree->items.size(); ++i) {
    Path path = impl.PathOf(key);
    path.push_back(std::to_string(i));
    Item item{};
    check(path, tree->items[i], item);
    value.push_back(item);
  }
}

template <class Number>
void BindNumbers(Impl& impl, const char* key, std::vector<Number>& value, const Limits& limits,
                 const std::string& list_type, const std::string& type) {
  BindList(impl, key, value, list_type, ExpectedText("", limits),
           [&](const Path& path, const ConfigTree& tree, Number& item) {
             const bool good = ParseValue(tree, item) && IsWithin(item, limits);
             if (!good) impl.Fail(path, tree, ExpectedText(type, limits));
           });
}

/// Throws unless the tree is one of the choices.
void ParseChoice(const Impl& impl, const Path& path, const ConfigTree& tree, const Path& choices, std::string& value) {
  std::string parsed;
  const bool is_word = ParseValue(tree, parsed);
  const auto is_choice = [&] { return std::find(choices.begin(), choices.end(), parsed) != choices.end(); };
  if (is_word && !is_choice()) parsed = CurrentName(parsed);
  if (!is_word || !is_choice())
    impl.Fail(path, tree, ExpectedText(choices),
              is_word ? "; did you mean '" + NearestWord(parsed, choices) + "'?" : "");
  value = parsed;
}

}  // namespace

const ConfigTree* OptionsBinder::Impl::Start(const char* key, const std::string& expected,
                                             const ConfigTree& default_value) {
  keys.push_back(key);
  if (mode == Mode::kWrite) written.entries.push_back({key, default_value});
  if (mode == Mode::kDescribe) {
    OptionDescription description{key, expected, "", "", "", {}};
    if (default_value.kind != Kind::kNull) description.default_value = FlowText(default_value);
    described.push_back(std::move(description));
  }
  return Find(key);
}

void OptionsBinder::Impl::Fail(const Path& full, const ConfigTree& got, const std::string& expected,
                               const std::string& hint) const {
  // A --set shows its key and value already.
  const bool shown = GivenBySet(*document, full);
  throw Error(WhereText(*document, full) + ": expected " + expected + (shown ? "" : ", got " + GotText(got)) + hint);
}

bool OptionsBinder::Impl::IsBound(const std::string& key) const {
  const auto bound = [this](const std::string& name) {
    return std::find(keys.begin(), keys.end(), name) != keys.end();
  };
  const std::string current = CurrentName(key);
  return bound(key) || (bound(current) && map->Find(current) == nullptr);
}

void OptionsBinder::Impl::CheckKeys() const {
  if (map == nullptr || stored) return;
  for (const ConfigEntry& entry : map->entries) {
    if (IsBound(entry.key)) continue;
    const std::string start = PlaceText(entry.value.place);
    const std::string nearest = NearestWord(entry.key, keys);
    Path full = document->prefix;
    for (const std::string& step : PathOf(entry.key)) full.push_back(step);
    throw Error((start.empty() ? "" : start + ": ") + "unknown key '" + JoinPath(full) + "'" +
                (nearest.empty() ? "" : "; did you mean '" + nearest + "'?"));
  }
}

void OptionsBinder::Impl::ReadMap(const ConfigTree* tree, const Bind& bind) {
  value = tree;
  map = tree != nullptr && tree->kind == Kind::kMap ? tree : nullptr;
  OptionsBinder binder(this);
  bind(binder);
  if (value != nullptr && value->kind != Kind::kNull && map == nullptr) Fail(path, *value, "a map of options");
  CheckKeys();
  if (!unmet.empty()) throw Error(unmet);
}

ConfigTree OptionsBinder::Impl::WriteMap(const Bind& bind) {
  written.kind = Kind::kMap;
  OptionsBinder binder(this);
  bind(binder);
  return std::move(written);
}

OptionsBinder& OptionsBinder::Field(const char* key, bool& value) {
  BindValue(*impl_, key, value, "true or false");
  return *this;
}
OptionsBinder& OptionsBinder::Field(const char* key, int& value, Limits limits) {
  BindLimited(*impl_, key, value, limits, "an integer");
  return *this;
}
OptionsBinder& OptionsBinder::Field(const char* key, std::int64_t& value, Limits limits) {
  BindLimited(*impl_, key, value, limits, "an integer");
  return *this;
}
OptionsBinder& OptionsBinder::Field(const char* key, std::uint64_t& value) {
  BindValue(*impl_, key, value, "an integer of at least 0");
  return *this;
}
OptionsBinder& OptionsBinder::Field(const char* key, double& value, Limits limits) {
  BindLimited(*impl_, key, value, limits, "a number");
  return *this;
}
OptionsBinder& OptionsBinder::Field(const char* key, std::string& value) {
  BindValue(*impl_, key, value, "a text");
  return *this;
}

OptionsBinder& OptionsBinder::Field(const char* key, Range& value, Limits limits) {
  const bool bounded = !ExpectedText("", limits).empty();
  BindLimited(*impl_, key, value, limits, std::string("a number or a range [low, high]") + (bounded ? "," : ""));
  return *this;
}

OptionsBinder& OptionsBinder::Field(const char* key, std::vector<double>& value, Limits limits) {
  BindNumbers(*impl_, key, value, limits, "a list of numbers", "a number");
  return *this;
}
OptionsBinder& OptionsBinder::Field(const char* key, std::vector<int>& value, Limits limits) {
  BindNumbers(*impl_, key, value, limits, "a list of integers", "an integer");
  return *this;
}

OptionsBinder& OptionsBinder::Field(const char* key, std::vector<std::string>& value) {
  BindList(*impl_, key, value, "a list of texts", "",
           [this](const Path& path, const ConfigTree& tree, std::string& item) {
             if (!ParseValue(tree, item)) impl_->Fail(path, tree, "a text");
           });
  return *this;
}

OptionsBinder& OptionsBinder::Field(const char* key, Config& raw) {
  const ConfigTree* held = raw.impl_->Get();
  const ConfigTree* tree = impl_->Start(key, "a map", held == nullptr ? ConfigTree() : *held);
  if (tree == nullptr) return *this;
  if (tree->kind != Kind::kMap && tree->kind != Kind::kNull) impl_->Fail(impl_->PathOf(key), *tree, "a map of options");
  raw = impl_->Part(impl_->PathOf(key), *tree);
  return *this;
}

OptionsBinder& OptionsBinder::Choice(const char* key, std::string& value, const std::vector<std::string>& choices) {
  const ConfigTree* tree = impl_->Start(key, ExpectedText(choices), ValueTree(value));
  if (tree != nullptr) ParseChoice(*impl_, impl_->PathOf(key), *tree, choices, value);
  return *this;
}
OptionsBinder& OptionsBinder::Choice(const char* key, std::string& value, std::initializer_list<const char*> choices) {
  return Choice(key, value, std::vector<std::string>(choices.begin(), choices.end()));
}

OptionsBinder& OptionsBinder::Choices(const char* key, std::vector<std::string>& value,
                                      const std::vector<std::string>& choices) {
  BindList(*impl_, key, value, "a list", " of " + ExpectedText(choices).substr(std::string("one of ").size()),
           [&](const Path& path, const ConfigTree& tree, std::string& item) {
             ParseChoice(*impl_, path, tree, choices, item);
           });
  return *this;
}
OptionsBinder& OptionsBinder::Choices(const char* key, std::vector<std::string>& value,
                                      std::initializer_list<const char*> choices) {
  return Choices(key, value, std::vector<std::string>(choices.begin(), choices.end()));
}

OptionsBinder& OptionsBinder::GroupWith(const char* key, const Impl::Bind& bind) {
  Impl inner = impl_->Inner(key);
  if (impl_->mode == Mode::kWrite) {
    impl_->Start(key, "", inner.WriteMap(bind));
  } else if (impl_->mode == Mode::kDescribe) {
    impl_->Describe(key, "a map", bind);
  } else {
    inner.ReadMap(impl_->Start(key, "", ConfigTree()), bind);
  }
  return *this;
}

OptionsBinder& OptionsBinder::ListWith(const char* key, std::size_t size,
                                       const std::function<void(std::size_t)>& resize,
                                       const std::function<void(std::size_t, OptionsBinder&)>& bind) {
  const auto bind_at = [&bind](std::size_t index) { return [&bind, index](OptionsBinder& b) { bind(index, b); }; };
  if (impl_->mode == Mode::kWrite) {
    ConfigTree list;
    list.kind = Kind::kSequence;
    for (std::size_t i = 0; i < size; ++i) list.items.push_back(Impl(Mode::kWrite).WriteMap(bind_at(i)));
    impl_->Start(key, "", list);
    return *this;
  }
  if (impl_->mode == Mode::kDescribe) {
    resize(1);
    impl_->Describe(key, "a list of maps", bind_at(0));
    return *this;
  }
  const ConfigTree* tree = impl_->Start(key, "", ConfigTree());
  if (tree == nullptr) return *this;
  if (tree->kind != Kind::kSequence && tree->kind != Kind::kNull) impl_->Fail(impl_->PathOf(key), *tree, "a list");
  resize(tree->items.size());
  for (std::size_t i = 0; i < tree->items.size(); ++i) {
    Impl inner = impl_->Inner(key);
    inner.path.push_back(std::to_string(i));
    inner.ReadMap(&tree->items[i], bind_at(i));
  }
  return *this;
}

OptionsBinder& OptionsBinder::Rest(Config& raw) {
  if (impl_->mode == Mode::kDescribe) {
    impl_->Start("...", "anything", ConfigTree());
  } else if (impl_->mode == Mode::kWrite) {
    const ConfigTree* held = raw.impl_->Get();
    if (held != nullptr)
      impl_->written.entries.insert(impl_->written.entries.end(), held->entries.begin(), held->entries.end());
  } else {
    raw = impl_->Part(impl_->path, ConfigTree());
    ConfigTree& root = raw.impl_->document->root;
    if (impl_->value != nullptr) root.place = impl_->value->place;
    if (impl_->map == nullptr) return *this;
    for (const ConfigEntry& entry : impl_->map->entries) {
      if (impl_->IsBound(entry.key)) continue;
      root.entries.push_back(entry);
      impl_->keys.push_back(entry.key);
    }
  }
  return *this;
}

OptionsBinder& OptionsBinder::Help(const std::string& text) {
  if (impl_->mode == Mode::kDescribe) impl_->described.back().help = text;
  return *this;
}

OptionsBinder& OptionsBinder::OnlyIf(bool acts, const std::string& when) {
  if (impl_->mode == Mode::kDescribe) impl_->described.back().when = when;
  if (acts) return *this;
  const std::string& key = impl_->keys.back();
  std::erase_if(impl_->written.entries, [&](const ConfigEntry& entry) { return entry.key == key; });
  if (impl_->Find(key) != nullptr && !impl_->stored)
    impl_->Unmet(WhereText(*impl_->document, impl_->PathOf(key)) + ": acts only with " + when);
  return *this;
}

OptionsBinder& OptionsBinder::Require(bool ok, const char* key, const std::string& expected) {
  return Reject(!ok, key, "expected " + expected);
}

OptionsBinder& OptionsBinder::Reject(bool wrong, const std::string& key, const std::string& message) {
  if (!wrong || !impl_->reading()) return *this;
  Path full = impl_->path;
  for (std::string& step : SplitPath(key)) full.push_back(std::move(step));
  impl_->Unmet(WhereText(*impl_->document, full) + ": " + message);
  return *this;
}

OptionsBinder::Presence OptionsBinder::StartOptional(const char* key, bool has_value) {
  impl_->keys.push_back(key);
  if (impl_->mode == Mode::kDescribe) return Presence::kGiven;
  if (impl_->mode == Mode::kWrite) return has_value ? Presence::kGiven : Presence::kAbsent;
  const ConfigTree* tree = impl_->Find(key);
  if (tree == nullptr) return Presence::kAbsent;
  return tree->kind == Kind::kNull ? Presence::kNone : Presence::kGiven;
}

void OptionsBinder::DescribeAsNone() {
  if (impl_->mode == Mode::kDescribe) impl_->described.back().default_value.clear();
}

namespace {

void Read(const Config& config, bool stored, const Impl::Bind& bind) {
  Impl impl(Mode::kRead);
  impl.document = config.impl_->document.get();
  impl.path = config.impl_->path;
  impl.stored = stored;
  impl.ReadMap(config.impl_->Get(), bind);
}

}  // namespace

void ReadOptionsWith(const Config& config, const Impl::Bind& bind) { Read(config, false, bind); }
void ReadStoredOptionsWith(const Config& config, const Impl::Bind& bind) { Read(config, true, bind); }

Config ToConfigWith(const Impl::Bind& bind) {
  ConfigTree tree = Impl(Mode::kWrite).WriteMap(bind);
  if (HasUnfiniteNumber(tree)) throw std::logic_error("an option must be a finite number");
  return Config(std::move(tree));
}

void CheckOptionsWith(const Impl::Bind& bind) {
  // What is written is read back, so that one description serves files and callers in C++.
  Config config;
  config.impl_->document->root = Impl(Mode::kWrite).WriteMap(bind);
  ReadOptionsWith(config, bind);
}

std::vector<OptionDescription> DescribeOptionsWith(const Impl::Bind& bind) {
  Impl impl(Mode::kDescribe);
  OptionsBinder binder(&impl);
  bind(binder);
  return std::move(impl.described);
}

}  // namespace diffsac
