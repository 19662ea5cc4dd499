#include "lab/config/paths.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;

/// The current folder, for as long as it lives.
class CurrentFolder {
 public:
  explicit CurrentFolder(const std::string& path) : before_(fs::current_path()) { fs::current_path(path); }
  ~CurrentFolder() { fs::current_path(before_); }

 private:
  fs::path before_;
};

struct Folders {
  Folders() {
    for (const char* name : {"yaml/models/a", "here/models/a", "here/models/b", "kept/b", "kept/c"})
      fs::create_directories(folder / name);
    for (const char* name : {"yaml/models/a/net", "here/models/a/net", "here/models/b/net", "kept/b/net", "kept/c/net"})
      WriteFileAtomically(folder / name, "x");
    ::setenv("DIFFSAC_MODELS", (folder / "kept").c_str(), 1);
  }
  ~Folders() { ::unsetenv("DIFFSAC_MODELS"); }

  std::string Found(const std::string& path) const {
    const CurrentFolder here(folder / "here");
    WriteFileAtomically(folder / "yaml/row.yaml", "methods: [{checkpoint: " + path + "}]\n");
    return WithFoundPaths(ConfigFromFile(folder / "yaml/row.yaml")).Text("methods.0.checkpoint");
  }

  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("paths of a configuration are relative to its file, then to the current folder, then to folders of models") {
  const Folders all;
  CHECK(all.Found("models/a/net") == all.folder / "yaml/models/a/net");
  CHECK(all.Found("models/b/net") == "models/b/net");
  CHECK(all.Found("models/c/net") == all.folder / "kept/c/net");
  CHECK(all.Found("models/none/net") == "models/none/net");
  CHECK(all.Found("c/net") == "c/net");
  CHECK(all.Found(all.folder / "kept/c/net") == all.folder / "kept/c/net");
}

TEST_CASE("the shipped models are found from any folder") {
  const TemporaryFolder empty;
  const CurrentFolder here(empty.path());
  const auto row = ConfigFromYaml("{checkpoint: models/line/model.safetensors}");
  CHECK(fs::equivalent(RequiredPath(row.Sub("checkpoint"), "checkpoint"),
                       fs::path(DIFFSAC_SOURCE_DIR) / "models/line/model.safetensors"));
}

TEST_CASE("a file that comes with the programs is found from any folder") {
  const TemporaryFolder empty;
  const CurrentFolder here(empty.path());
  CHECK(fs::equivalent(SharedFile("configs/tables/line.yaml"),
                       fs::path(DIFFSAC_SOURCE_DIR) / "configs/tables/line.yaml"));
  CHECK_THROWS_WITH(SharedFile("configs/none.yaml"), Contains("share/diffsac/configs/none.yaml, configs/none.yaml"));
  for (const char* name : {"line.yaml", "configs/tables/line.yaml"})
    CHECK(fs::equivalent(NamedConfiguration(name, "configs/tables"),
                         fs::path(DIFFSAC_SOURCE_DIR) / "configs/tables/line.yaml"));
  WriteFileAtomically("line.yaml", "x");
  CHECK(NamedConfiguration("line.yaml", "configs") == "line.yaml");
  CHECK_THROWS_WITH(NamedConfiguration("none.yaml", "configs"),
                    Contains("none.yaml: no such file; looked for none.yaml, ") &&
                        Contains("share/diffsac/configs/none.yaml") && Contains("share/diffsac/none.yaml"));
}

TEST_CASE("a path of a configuration that is nowhere names its line and every place looked at") {
  const Folders all;
  WriteFileAtomically(all.folder / "yaml/row.yaml", "a: 1\ncheckpoint: models/none/net\npaths: [kept, gone]\n");
  const auto config = ConfigFromFile(all.folder / "yaml/row.yaml");
  const std::string file = all.folder / "yaml/row.yaml";
  CHECK_THROWS_WITH(RequiredPath(config.Sub("checkpoint"), "checkpoint"),
                    Contains(file + ":2: checkpoint: 'models/none/net': no such checkpoint") &&
                        Contains(all.folder / "yaml/models/none/net") && Contains(", models/none/net, ") &&
                        Contains(all.folder / "kept/none/net") && Contains("share/diffsac/models/none/net"));
  const CurrentFolder here(all.folder.path());
  CHECK_THROWS_WITH(RequirePaths(config, {"root", "paths"}, "file or folder"),
                    Contains("'gone': no such file or folder; looked for " + (all.folder / "yaml/gone") + ", gone"));
}

}  // namespace diffsac
