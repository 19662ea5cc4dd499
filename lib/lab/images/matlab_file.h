#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>

struct _mat_t;

namespace diffsac {

/// A MATLAB file (level 5 or 7.3) that is read variable by variable.
class MatlabFile {
 public:
  /// Throws Error naming the file.
  explicit MatlabFile(const std::string& path);

  /// A real matrix of numbers of any class but logical. Throws Error naming file and variable; `expected` says what it
  /// should be.
  Eigen::MatrixXd Matrix(const std::string& name, const std::string& expected) const;

  /// Rows and columns of a variable of two or three dimensions, an image say, of which nothing else is read. Throws as
  /// above.
  std::pair<int, int> Size(const std::string& name) const;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
  std::shared_ptr<_mat_t> file_;
};

}  // namespace diffsac
