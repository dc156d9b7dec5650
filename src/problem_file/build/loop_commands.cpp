#include "problem_file/build/loop_commands.hpp"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "problem_file/read/read_problem.hpp"

namespace conddp {
namespace {

std::string text_of(const GaitCommand& command) {
  return fmt::format("{{at: {}, velocity: [{}, {}, 0], turn: {}}}", command.at.value, command.x,
                     command.y, command.turn);
}

/// The setting of a gait that is led by what the file knows before the first command, and by the
/// commands up to one of them.
std::string setting_of(const ProblemSpec& spec, std::size_t last) {
  const std::vector<GaitCommand>& commands = spec.mpc->commands;
  std::string list;
  const auto add = [&](const GaitCommand& command) {
    list += (list.empty() ? "" : ", ") + text_of(command);
  };
  for (const GaitCommand& command : spec.gait_commands)
    if (command.at.value < commands.front().at.value) add(command);
  for (std::size_t i = 0; i <= last; ++i) add(commands[i]);
  return "gait.commands=[" + list + "]";
}

bool has_gait(const ProblemSpec& spec) { return spec.phases.front().name.place.path == "gait"; }

/// The problem with the commands up to one of them; null where it cannot be, which is reported.
std::shared_ptr<const ShootingProblem> with_commands(const ProblemSpec& spec,
                                                     const BuiltProblem& built, std::size_t last,
                                                     Diagnostics& out) {
  std::vector<std::string> settings = spec.settings;
  settings.push_back(setting_of(spec, last));
  BuildOptions options{.plant = &built.plant};
  for (const DroppedConstraint& dropped : built.dropped) options.drop.push_back(dropped.name);
  Diagnostics own;
  auto led = read_problem_text(spec.text, spec.file, settings, own);
  if (led) led->guess = {};
  const auto problem = led ? build_without_homotopy(*led, options, own) : std::nullopt;
  if (problem && !own.has_errors()) return problem->problem;
  for (const Diagnostic& fault : own.list())
    if (fault.severity == Severity::kError) {
      out.error(spec.mpc->commands[last].place,
                fmt::format("the gait cannot follow the command: {}", fault.message), fault.hint);
      break;
    }
  return nullptr;
}

std::uint32_t bits_of(const ContactNames& held, const std::vector<ContactSpec>& contacts) {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (held.all || std::any_of(held.names.begin(), held.names.end(), [&](const Name& name) {
          return name.value == contacts[i].name.value;
        }))
      bits |= std::uint32_t{1} << i;
  return bits;
}

}  // namespace

std::vector<LoopCommand> build_commands(const ProblemSpec& spec, const BuiltProblem& built,
                                        Diagnostics& out) {
  std::vector<LoopCommand> result;
  const std::vector<GaitCommand>& commands = spec.mpc->commands;
  if (commands.empty()) return result;
  if (!has_gait(spec)) {
    out.error(commands.front().place, "the file has no gait that commands could lead",
              "move references by times or knots instead");
    return result;
  }
  for (std::size_t i = 0; i < commands.size(); ++i) {
    if (!is_before(commands[i].at.value, spec.mpc->duration.value)) {
      out.error(commands[i].at.place, fmt::format("the loop has ended by then: it lasts {:g} s",
                                                  spec.mpc->duration.value));
      return result;
    }
    auto problem = with_commands(spec, built, i, out);
    if (problem == nullptr) return result;
    result.push_back({commands[i].at.value, std::move(problem)});
  }
  return result;
}

std::optional<Retiming> build_retiming(const ProblemSpec& spec, const BuiltProblem& built,
                                       Diagnostics& out) {
  const std::optional<RetimeSpec>& limits = spec.mpc->retime;
  if (!limits) return std::nullopt;
  if (!spec.mpc->plant.simulated_contacts) {
    out.error(limits->place,
              "contacts of the phases are never early or late: there is nothing to re-time",
              "write 'plant: {contacts: simulated, dt: 0.002}'");
    return std::nullopt;
  }
  Retiming retiming{.early = limits->early, .late = limits->late};
  for (int k = 0; k < built.problem->knots(); ++k)
    retiming.contacts.push_back(
        bits_of(spec.phases[built.problem->knot(k).phase].contacts, spec.contacts));
  return retiming;
}

}  // namespace conddp
