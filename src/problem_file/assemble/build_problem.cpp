#include "problem_file/assemble/build_problem.hpp"

#include <fmt/format.h>

#include "base/files/check_sums.hpp"
#include "problem_file/assemble/homotopy.hpp"
#include "problem_file/mesh/mesh.hpp"

namespace conddp {
namespace {

void set_start(const Located<std::filesystem::path>& start, GuessSpec& guess) {
  std::error_code error;
  std::filesystem::path path = std::filesystem::absolute(start.value, error);
  if (error) path = start.value;  // reading the file reports the error
  const DataFileSpec data{{path.string(), start.place}, path, {}};
  guess = {.states = GuessSpec::States::kFile,
           .states_place = start.place,
           .states_file = data,
           .controls = GuessSpec::Controls::kFile,
           .controls_place = start.place,
           .controls_file = data};
  if (path.extension() == ".json") guess.multipliers_file = data;
}

}  // namespace

std::optional<BuiltProblem> build_problem(std::optional<ProblemSpec> spec,
                                          const BuildOptions& options, Diagnostics& out) {
  if (!spec) return std::nullopt;
  if (options.unplaced_solver) spec->solver.name.place = {};
  if (options.default_guess) spec->guess = {};
  if (options.start) set_start(*options.start, spec->guess);
  auto built = build_without_homotopy(*std::move(spec), options, out);
  if (!built || built->facts().solver.homotopy.empty()) return built;
  built->homotopy = Homotopy::build(*built, options, out);
  if (!built->homotopy) return std::nullopt;
  return built;
}

std::optional<BuiltProblem> build_problem(const BuiltProblem& built, const BuildOptions& options,
                                          Diagnostics& out) {
  return build_problem(*built.problem_spec, options, out);
}

std::string grid_setting(const BuiltProblem& built, int factor) {
  return built.facts().mesh ? fmt::format("mesh.factor={}", factor)
                            : fmt::format("mesh={{error: 1, factor: {}}}", factor);
}

std::optional<BuiltProblem> build_on_grid(const BuiltProblem& built, const OtherGrid& grid,
                                          Diagnostics& out) {
  constexpr int kFewestKnots = 10;
  const ProblemSpec& former = *built.problem_spec;
  std::vector<std::string> settings = former.settings;
  settings.push_back(grid_setting(built, grid.factor));
  auto spec = read_problem_text(former.text, former.file, settings, out);
  if (!spec) return std::nullopt;
  for (int i = 0; i < grid.halvings; ++i)
    if (!coarsen(*spec, kFewestKnots)) return std::nullopt;
  spec->sha256 = former.sha256;
  spec->guess = former.guess;
  if (grid.from_answer) spec->guess.sampling.reset();
  spec->solver.name.place = former.solver.name.place;
  BuildOptions options;
  for (const DroppedConstraint& constraint : built.dropped) options.drop.push_back(constraint.name);
  return build_problem(std::move(spec), options, out);
}

std::string problem_sha256(const BuiltProblem& built) {
  std::string all = built.problem_spec->definition;
  for (const PlantPart& part : built.plant.parts) all += '\n' + part.sha256;
  for (const InputFile& file : built.data_files) all += '\n' + file.sha256;
  return sha256(all);
}

}  // namespace conddp
