#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace conddp {

/// Appends a step to the path of a key during its lifetime.
class PathStep {
 public:
  PathStep(std::string& path, std::string_view step) : path_(path), length_(path.size()) {
    if (!path.empty()) path += '.';
    path += step;
  }
  PathStep(std::string& path, std::size_t index) : PathStep(path, std::to_string(index)) {}
  ~PathStep() { path_.resize(length_); }
  PathStep(const PathStep&) = delete;
  PathStep& operator=(const PathStep&) = delete;

 private:
  std::string& path_;
  const std::size_t length_;
};

}  // namespace conddp
