#include "problem_file/assemble/loop_commands.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "problem_file/assemble/loop_regulators.hpp"
#include "problem_file/read/read_problem.hpp"

namespace conddp {
namespace {

std::string text_of(const GaitCommand& command) {
  return fmt::format("{{at: {}, velocity: [{}, {}, 0], turn: {}}}", command.at.value, command.x,
                     command.y, command.turn);
}

std::vector<GaitCommand> commands_of_gait(const ProblemSpec& spec) {
  return spec.gait ? spec.gait->commands : std::vector<GaitCommand>();
}

/// Setting for a gait that follows the file's own commands before the first loop command, then the
/// loop commands up to `last`.
std::string setting_of(const ProblemSpec& spec, std::size_t last) {
  const std::vector<GaitCommand>& commands = spec.mpc->commands;
  std::string list;
  const auto add = [&](const GaitCommand& command) {
    list += (list.empty() ? "" : ", ") + text_of(command);
  };
  for (const GaitCommand& command : commands_of_gait(spec))
    if (command.at.value < commands.front().at.value) add(command);
  for (std::size_t i = 0; i <= last; ++i) add(commands[i]);
  return "gait.commands=[" + list + "]";
}

/// The loop with the commands up to `last`; empty, with a report, if it cannot be built.
std::optional<LoopCommand> with_commands(const ProblemSpec& spec, const BuiltProblem& built,
                                         const std::vector<double>& led_state, std::size_t last,
                                         Diagnostics& out) {
  std::vector<std::string> settings = spec.settings;
  settings.push_back(setting_of(spec, last));
  BuildOptions options{.plant = &built.plant};
  for (const DroppedConstraint& dropped : built.dropped) options.drop.push_back(dropped.name);
  Diagnostics own;
  auto led = read_problem_text(spec.text, spec.file, settings, own);
  if (led) led->guess = {};
  const auto problem = led ? build_without_homotopy(*led, options, own) : std::nullopt;
  if (problem && !own.has_errors())
    return LoopCommand{
        spec.mpc->commands[last].at.value, problem->problem,
        path_along(led->gait_way, problem->problem->times(), led_state, built.plant)};
  for (const Diagnostic& fault : own.list())
    if (fault.severity == Severity::kError) {
      out.error(spec.mpc->commands[last].place,
                fmt::format("the gait cannot follow the command: {}", fault.message), fault.hint);
      break;
    }
  return std::nullopt;
}

std::uint32_t bits_of(const ContactNames& held, const std::vector<ContactSpec>& contacts) {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (held.has(contacts[i].name.value)) bits |= std::uint32_t{1} << i;
  return bits;
}

/// Shortest time from the release of a contact to its touch-down, s; infinite without touch-down.
double shortest_swing(const std::vector<std::uint32_t>& held, const std::vector<double>& times) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t from = 0; from + 1 < held.size(); ++from) {
    std::uint32_t released = held[from] & ~held[from + 1];
    for (std::size_t to = from + 2; released != 0 && to < held.size(); ++to) {
      if ((released & held[to]) != 0) shortest = std::min(shortest, times[to] - times[from + 1]);
      released &= ~held[to];
    }
  }
  return shortest;
}

/// Reports invalid values of mpc.retime, given the contacts and the time of each knot.
void check_retiming(const MpcSpec& mpc, const std::vector<std::uint32_t>& held,
                    const std::vector<double>& times, Diagnostics& out) {
  const RetimeSpec& limits = *mpc.retime;
  if (mpc.repeat.value == AfterTheEnd::kNone)
    out.error(limits.place, "re-timing moves the end of the phases: something has to follow them",
              "write 'repeat: hold', or 'repeat: gait'");
  if (const double swing = shortest_swing(held, times); !is_before(limits.early.value, swing))
    out.error(limits.early.place,
              fmt::format("{:g} s before it touches down a foot has not lifted: the shortest swing "
                          "lasts {:g} s",
                          limits.early.value, swing),
              "take a shorter time");
  if (limits.late.value > 0 && is_before(limits.late.value, mpc.tick.value))
    out.error(limits.late.place,
              fmt::format("phases wait by whole ticks, and {:g} s are less than one of {:g} s",
                          limits.late.value, mpc.tick.value),
              "take a tick at least, or 0");
}

/// Reports a command that the loop never reaches. Commands are in phase time, and a loop with early
/// touch-downs advances through phase time faster than the clock.
bool comes_too_late(const GaitCommand& command, const MpcSpec& mpc, double phases_end,
                    Diagnostics& out) {
  const bool earlier = mpc.retime && mpc.retime->early.value > 0;
  const double end = earlier ? std::max(mpc.duration.value, phases_end) : mpc.duration.value;
  if (is_before(command.at.value, end)) return false;
  out.error(command.at.place,
            end > mpc.duration.value
                ? fmt::format("the phases of the loop have ended by then: they last {:g} s", end)
                : fmt::format("the loop has ended by then: it lasts {:g} s", end));
  return true;
}

/// Reports commands of the gait that come after all cycles that the loop repeats.
void check_known_commands(const ProblemSpec& spec, double phases_end, Diagnostics& out) {
  for (const GaitCommand& command : commands_of_gait(spec))
    if (!is_before(command.at.value, phases_end))
      return out.error(
          command.at.place,
          fmt::format("the gait has ended by then: in the loop it lasts {:g} s", phases_end),
          "take an earlier time, or leave the command out");
}

}  // namespace

bool has_gait(const ProblemSpec& spec) { return !spec.gait_way.empty(); }

int count_touch_downs(const ProblemSpec& spec) {
  int count = 0;
  for (std::size_t i = 1; i < spec.phases.size(); ++i)
    count += (bits_of(spec.phases[i].contacts, spec.contacts) &
              ~bits_of(spec.phases[i - 1].contacts, spec.contacts)) != 0;
  return count;
}

std::vector<LoopCommand> build_commands(const ProblemSpec& spec, const BuiltProblem& built,
                                        const std::vector<double>& led, Diagnostics& out) {
  std::vector<LoopCommand> result;
  const std::vector<GaitCommand>& commands = spec.mpc->commands;
  const double phases_end = built.problem->times().back();
  check_known_commands(spec, phases_end, out);
  if (commands.empty()) return result;
  if (!has_gait(spec)) {
    out.error(commands.front().place, "the file has no gait that commands could lead",
              "move references by times or knots instead");
    return result;
  }
  for (std::size_t i = 0; i < commands.size(); ++i) {
    if (comes_too_late(commands[i], *spec.mpc, phases_end, out)) return result;
    auto command = with_commands(spec, built, led, i, out);
    if (!command) return result;
    result.push_back(*std::move(command));
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
  Retiming retiming{.early = limits->early.value, .late = limits->late.value};
  for (int k = 0; k < built.problem->knots(); ++k)
    retiming.contacts.push_back(
        bits_of(spec.phases[built.problem->knot(k).phase].contacts, spec.contacts));
  check_retiming(*spec.mpc, retiming.contacts, built.problem->times(), out);
  return retiming;
}

}  // namespace conddp
