#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "answer.hpp"
#include "batch/plan/problem_family.hpp"

namespace conddp::python {

/// A problem file, or a text in its place, with settings that replace its values. Methods that fail
/// at the problem throw ProblemFailure.
class Problem {
 public:
  using Settings = std::map<std::string, std::string>;  ///< key path and YAML text of its value
  /// States ((N + 1) x nx) and controls (N x nu, or a list by knot).
  using Guess = std::pair<pybind11::array_t<double, pybind11::array::c_style>, pybind11::object>;

  static Problem load(const std::string& file);
  /// Relative paths of the text are resolved in the folder.
  static Problem parse(const std::string& text, const std::string& folder);

  void set(const std::string& key, const std::string& value);
  /// JSON text of a key's value as set or in the file; throws std::out_of_range without one.
  std::string get(const std::string& key) const;
  /// Builds the problem; returns warnings and notes.
  std::vector<std::string> check() const;
  /// JSON text: sizes, columns, phases.
  std::string describe() const;

  /// Solves as `conddp solve` does, without the GIL. `more` are settings of this solve alone.
  std::shared_ptr<Answer> solve(const Settings& more, const std::shared_ptr<Answer>& warm_start,
                                const std::optional<Guess>& guess, bool verify,
                                const pybind11::object& on_iteration) const;
  /// Solves problems with further settings, each in one thread, as `conddp batch` does.
  std::vector<std::shared_ptr<Answer>> solve_many(const std::vector<Settings>& list, int jobs,
                                                  bool verify) const;

  std::unique_ptr<LoopTask> build_loop() const;

 private:
  explicit Problem(std::shared_ptr<const ProblemFamily> family) : family_(std::move(family)) {}
  std::vector<std::string> texts(const Settings& more) const;
  SolveTask task(const std::vector<std::string>& settings, Diagnostics& out) const;

  std::shared_ptr<const ProblemFamily> family_;
  Settings settings_;
};

}  // namespace conddp::python
