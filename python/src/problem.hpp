#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "answer.hpp"

namespace conddp::python {

/// A problem as Python sees it. Methods that fail at the problem throw ProblemFailure.
class Problem {
 public:
  using Settings = KeptProblem::Settings;
  /// States ((N + 1) x nx) and controls (N x nu, or a list by knot).
  using Guess = std::pair<pybind11::array_t<double, pybind11::array::c_style>, pybind11::object>;

  static Problem load(const std::string& file) { return Problem(KeptProblem::load(file)); }
  /// Relative paths of the text are resolved in the folder.
  static Problem parse(const std::string& text, const std::string& folder) {
    return Problem(KeptProblem::parse(text, folder));
  }

  void set(const std::string& key, const std::string& value) { kept_.set(key, value); }
  /// JSON text of a key's value as set or in the file; throws std::out_of_range without one.
  std::string get(const std::string& key) const;
  /// Builds the problem; returns warnings and notes.
  std::vector<std::string> check() const;
  /// JSON text of the problem's outline.
  std::string describe() const;

  /// Solves as `conddp solve` does, without the GIL. `more` are settings of this solve alone.
  std::shared_ptr<Answer> solve(const Settings& more, const std::shared_ptr<Answer>& warm_start,
                                const std::optional<Guess>& guess, bool verify,
                                const pybind11::object& on_iteration) const;
  /// Solves problems with further settings, each in one thread, as `conddp batch` does.
  std::vector<std::shared_ptr<Answer>> solve_many(const std::vector<Settings>& list, int jobs,
                                                  bool verify) const;

  std::unique_ptr<LoopTask> build_loop() const { return kept_.build_loop(); }

 private:
  explicit Problem(KeptProblem kept) : kept_(std::move(kept)) {}

  KeptProblem kept_;
};

}  // namespace conddp::python
