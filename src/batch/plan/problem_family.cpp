#include "batch/plan/problem_family.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "problem_file/yaml/key_path.hpp"

namespace conddp {
namespace {

/// Sections of a file that do not affect its robots or system.
constexpr std::string_view kBesidesThePlant[] = {
    "name",          "description", "initial_state", "phases",   "running_costs",
    "costs",         "gait",        "constraints",   "terminal", "perturbation",
    "initial_guess", "solver",      "mpc",           "controls"};

bool leaves_the_plant(const Setting& setting) {
  return std::find(std::begin(kBesidesThePlant), std::end(kBesidesThePlant),
                   first_step(setting.key.value)) != std::end(kBesidesThePlant);
}

}  // namespace

std::string shape_of(const ShootingProblem& problem) {
  std::string shape =
      fmt::format("{} {} {}", problem.nx(), problem.ndx(), problem.constraint_rows());
  for (int k = 0; k < problem.knots(); ++k) shape += fmt::format(" {}", problem.nu(k));
  return shape;
}

std::shared_ptr<const ProblemFamily> ProblemFamily::load(const std::filesystem::path& file,
                                                         const Place& place, Diagnostics& out) {
  return of(load_problem(file, place, out), out);
}

std::shared_ptr<const ProblemFamily> ProblemFamily::parse(std::string text,
                                                          const std::filesystem::path& file,
                                                          Diagnostics& out) {
  return of(parse_problem(std::move(text), file, out), out);
}

std::shared_ptr<const ProblemFamily> ProblemFamily::of(std::optional<ProblemDocument> document,
                                                       Diagnostics& out) {
  if (!document) return nullptr;
  auto family = std::make_shared<ProblemFamily>();
  family->document_ = *std::move(document);
  family->texts_ = out;
  auto base = build_problem(read_problem(family->document_, {}, out), {}, out);
  if (!base) return nullptr;
  family->base_ = *std::move(base);
  // Systems for contact steps and collocation, and discrete systems, also depend on the phases.
  const System& system = *family->base_.plant.system;
  if (system.robot_inside() != nullptr && !system.as_stepping() && !system.as_collocation()) {
    family->plant_ = family->base_.plant;
    family->plant_->start.reset();
  }
  return family;
}

const Plant* ProblemFamily::plant_with(const std::vector<Setting>& settings) const {
  const bool shares = plant_ && std::all_of(settings.begin(), settings.end(), leaves_the_plant);
  return shares ? &*plant_ : nullptr;
}

std::optional<BuiltProblem> ProblemFamily::build(
    const std::vector<Setting>& settings, Diagnostics& out,
    const std::optional<Located<std::filesystem::path>>& start) const {
  return build_problem(read_problem(document_, settings, out),
                       {.plant = plant_with(settings), .start = start}, out);
}

std::unique_ptr<LoopTask> ProblemFamily::build_loop(const std::vector<Setting>& settings,
                                                    Diagnostics& out) const {
  return conddp::build_loop(read_problem(document_, settings, out), {.plant = plant_with(settings)},
                            out);
}

}  // namespace conddp
