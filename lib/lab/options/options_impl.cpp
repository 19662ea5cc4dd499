#include "lab/options/options_impl.h"

#include <algorithm>
#include <stdexcept>

#include "diffsac/core/status.h"
#include "lab/options/option_values.h"

namespace diffsac {
namespace {

using Impl = OptionsBinder::Impl;
using Kind = ConfigTree::Kind;
using Mode = Impl::Mode;
using Path = Impl::Path;
using Bind = Impl::Bind;

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

namespace {

void Read(const Config& config, bool stored, const Bind& bind) {
  Impl impl(Mode::kRead);
  impl.document = config.impl_->document.get();
  impl.path = config.impl_->path;
  impl.stored = stored;
  impl.ReadMap(config.impl_->Get(), bind);
}

}  // namespace

void ReadOptionsWith(const Config& config, const Bind& bind) { Read(config, false, bind); }
void ReadStoredOptionsWith(const Config& config, const Bind& bind) { Read(config, true, bind); }

Config ToConfigWith(const Bind& bind) {
  ConfigTree tree = Impl(Mode::kWrite).WriteMap(bind);
  if (HasUnfiniteNumber(tree)) throw std::logic_error("an option must be a finite number");
  return Config(std::move(tree));
}

void CheckOptionsWith(const Bind& bind) {
  // What is written is read back, so that one description serves files and callers in C++.
  Config config;
  config.impl_->document->root = Impl(Mode::kWrite).WriteMap(bind);
  ReadOptionsWith(config, bind);
}

std::vector<OptionDescription> DescribeOptionsWith(const Bind& bind) {
  Impl impl(Mode::kDescribe);
  OptionsBinder binder(&impl);
  bind(binder);
  return std::move(impl.described);
}

}  // namespace diffsac
