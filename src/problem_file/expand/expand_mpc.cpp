#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {

OrderedJson expand_mpc(const ProblemSpec& spec, const Plant& plant) {
  MpcSpec mpc = *spec.mpc;
  // Phases replace the gait in the expanded file: no cycles can be repeated, and no commands can
  // steer it.
  if (mpc.repeat.value == AfterTheEnd::kGait) mpc.repeat.value = AfterTheEnd::kHold;
  KeyWriter keys;
  describe(keys, mpc, {});
  OrderedJson json = std::move(keys.json);
  ProblemSpec of_states = spec;
  of_states.terminal_constraints = mpc.stop_when;
  json["stop_when"] = expand_terminal_constraints(of_states, plant);
  return json;
}

}  // namespace conddp
