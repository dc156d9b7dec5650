#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "problem_file/assemble/build_mpc.hpp"
#include "problem_text.hpp"

namespace conddp {

/// A problem with a closed loop.
struct LoadedLoop : Loaded {
  explicit LoadedLoop(const std::string& text, const std::vector<std::string>& settings = {})
      : Loaded(text, settings) {
    if (built && spec->mpc) mpc = build_mpc(*built, diagnostics);
  }
  long warnings() const {
    return std::count_if(diagnostics.list().begin(), diagnostics.list().end(),
                         [](const auto& d) { return d.severity == Severity::kWarning; });
  }
  ClosedLoopResult run() const {
    Mpc controller(built->problem, built->guess, mpc->controller);
    return run_closed_loop(controller, mpc->loop);
  }
  std::optional<BuiltMpc> mpc;
};

/// Text of an example problem.
inline std::string text_of(const std::string& name) {
  Diagnostics out;
  return load_problem(kProblems / (name + ".yaml"), {}, out)->text;
}

}  // namespace conddp
