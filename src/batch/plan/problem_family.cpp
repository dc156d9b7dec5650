#include "batch/plan/problem_family.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/build/build_problem.hpp"
#include "problem_file/data/warm_start.hpp"
#include "problem_file/plant/plant_builder.hpp"
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

std::optional<ProblemInstance> build_instance(std::optional<ProblemSpec> spec, const Plant* plant,
                                              Diagnostics& out) {
  if (!spec) return std::nullopt;
  ProblemInstance instance{std::make_unique<const ProblemSpec>(*std::move(spec)), {}};
  auto built = build_problem(*instance.spec, {.plant = plant}, out);
  if (!built) return std::nullopt;
  instance.built = *std::move(built);
  return instance;
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
  auto document = load_problem(file, place, out);
  if (!document) return nullptr;
  auto family = std::make_shared<ProblemFamily>();
  family->document_ = *std::move(document);
  family->texts_ = out;
  auto base = build_instance(read_problem(family->document_, {}, out), nullptr, out);
  if (!base) return nullptr;
  family->base_ = *std::move(base);
  // Systems for contact steps and collocation, and discrete systems, also depend on the phases.
  const System& system = *family->base_.built.plant.system;
  if (system.robot_inside() != nullptr && !system.as_stepping() && !system.as_collocation()) {
    Diagnostics reported_before;
    family->plant_ = build_plant(*family->base_.spec, reported_before);
  }
  return family;
}

const Plant* ProblemFamily::plant_with(const std::vector<Setting>& settings) const {
  const bool shares = plant_ && std::all_of(settings.begin(), settings.end(), leaves_the_plant);
  return shares ? &*plant_ : nullptr;
}

std::optional<ProblemInstance> ProblemFamily::build(
    const std::vector<Setting>& settings, Diagnostics& out,
    const Located<std::filesystem::path>* start) const {
  auto spec = read_problem(document_, settings, out);
  if (spec && start != nullptr) set_warm_start(start->value, start->place, *spec);
  return build_instance(std::move(spec), plant_with(settings), out);
}

std::unique_ptr<LoopTask> ProblemFamily::build_loop(const std::vector<Setting>& settings,
                                                    Diagnostics& out) const {
  auto spec = read_problem(document_, settings, out);
  if (!spec) return nullptr;
  return conddp::build_loop(*std::move(spec), {.plant = plant_with(settings)}, out);
}

}  // namespace conddp
