#include "problem.hpp"

#include <atomic>
#include <chrono>
#include <exception>
#include <filesystem>
#include <mutex>
#include <thread>

#include <fmt/format.h>

#include "batch/run/warm_solve.hpp"
#include "failure.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/yaml/canonical_definition.hpp"
#include "problem_file/yaml/key_path.hpp"

namespace py = pybind11;

namespace conddp::python {
namespace {

using Clock = std::chrono::steady_clock;

std::vector<std::string> told(const Diagnostics& diagnostics) {
  std::vector<std::string> list;
  for (const Diagnostic& d : diagnostics.list())
    list.push_back(fmt::format("{}:{}:{}: {}: {}{}{}", d.file, d.line, d.column,
                               severity_name(d.severity), d.message, d.hint.empty() ? "" : "; ",
                               d.hint));
  return list;
}

/// Ends a solve at Ctrl-C or at an exception of the callback, which is thrown afterwards.
class Watch {
 public:
  explicit Watch(const py::object& on_iteration) : on_iteration_(on_iteration) {}

  void set(SolverOptions& options) {
    options.interrupted = [this] { return is_interrupted(); };
    if (!on_iteration_.is_none())
      options.on_iteration = [this](const IterationRecord& row) { tell(row); };
  }
  /// With the GIL.
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  /// Signals are looked for at this interval, since it takes the GIL.
  static constexpr std::chrono::milliseconds kInterval{20};

  bool is_interrupted() {
    const std::lock_guard lock(mutex_);
    if (error_ || Clock::now() < next_) return error_ != nullptr;
    next_ = Clock::now() + kInterval;
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) error_ = std::make_exception_ptr(py::error_already_set());
    return error_ != nullptr;
  }

  void tell(const IterationRecord& row) {
    const py::gil_scoped_acquire gil;
    if (error_) return;
    try {
      py::dict figures;
      figures["iteration"] = row.iteration;
      figures["cost"] = row.cost;
      figures["stationarity"] = row.stationarity;
      figures["gap"] = row.gap;
      figures["constraint"] = row.constraint;
      figures["step"] = row.step;
      figures["regularization"] = row.regularization;
      figures["time_s"] = row.time_s;
      on_iteration_(figures);
    } catch (py::error_already_set&) {
      error_ = std::current_exception();
    }
  }

  const py::object& on_iteration_;
  std::mutex mutex_;
  Clock::time_point next_ = Clock::now();
  std::exception_ptr error_;
};

std::shared_ptr<Answer> answer_of(SolveTask& task, const GridSolve::Options& options,
                                  std::vector<std::string> settings) {
  GridSolve solve(task, options);
  Diagnostics of_grids;
  auto result = solve.run(of_grids);
  if (!result) throw ProblemFailure(of_grids);
  settings = solve.with_grid(std::move(settings));
  auto answer = std::make_shared<Answer>(
      Answer{std::move(task), solve.solver(), *std::move(result), std::move(settings),
             solve.rounds(), std::nullopt});
  if (options.verify) {
    Solution solution = answer->solution();
    solution.answer.judged = answer->task.judged;
    answer->certificate = certify_answer(solution);
  }
  return answer;
}

/// Starts from an answer, on the grid of the task.
void start_from(const Answer& former, SolveTask& task) {
  const ShootingProblem& from = *former.task.built.problem;
  const ShootingProblem& to = *task.built.problem;
  BuiltProblem& built = task.built;
  const Eigen::VectorXd initial = built.guess.x(0);
  if (shape_of(from) == shape_of(to)) {
    built.guess = former.result.trajectory;
    built.multipliers = multipliers_of(former.result);
  } else if (from.nx() == to.nx() && from.phases().size() == to.phases().size()) {
    built.guess = on_grid(from, former.result.trajectory, to);
  } else {
    throw std::invalid_argument(
        "warm_start: the answer has other states or phases than this problem");
  }
  built.guess.x(0) = initial;
  built.guess_used.states = built.guess_used.controls = "a former answer";
  built.guess_used.multipliers = built.multipliers ? "those of the former answer" : "none";
}

void take(const py::array_t<double, py::array::c_style>& numbers, const char* name, int knot,
          Eigen::Map<Eigen::VectorXd> out) {
  if (numbers.ndim() != 1 || numbers.shape(0) != out.size())
    throw std::invalid_argument(
        fmt::format("guess: the {} of knot {} must be {} numbers", name, knot, out.size()));
  for (Eigen::Index i = 0; i < out.size(); ++i) out[i] = numbers.data()[i];
  if (!out.allFinite())
    throw std::invalid_argument(fmt::format("guess: the {} of knot {} are not finite", name, knot));
}

void start_from(const Problem::Guess& guess, SolveTask& task) {
  Trajectory& out = task.built.guess;
  const auto rows = [&](const py::object& list, const char* name, int count, auto place) {
    if (static_cast<int>(py::len(list)) != count)
      throw std::invalid_argument(
          fmt::format("guess: {} {} are needed, {} given", count, name, py::len(list)));
    for (int k = 0; k < count; ++k)
      take(py::array_t<double, py::array::c_style>::ensure(list[py::int_(k)]), name, k, place(k));
  };
  rows(guess.first, "states", out.knots() + 1, [&](int k) { return out.x(k); });
  rows(guess.second, "controls", out.knots(), [&](int k) { return out.u(k); });
  task.built.guess_used.states = task.built.guess_used.controls = "given numbers";
}

}  // namespace

Problem Problem::load(const std::string& file) {
  Diagnostics out;
  auto family = ProblemFamily::load(file, {}, out);
  if (!family) throw ProblemFailure(out);
  return Problem(std::move(family));
}

Problem Problem::parse(const std::string& text, const std::string& folder) {
  Diagnostics out;
  auto family = ProblemFamily::parse(text, std::filesystem::path(folder) / "problem.yaml", out);
  if (!family) throw ProblemFailure(out);
  return Problem(std::move(family));
}

void Problem::set(const std::string& key, const std::string& value) {
  Diagnostics out;
  if (!parse_setting(key + "=" + value, out)) throw ProblemFailure(out);
  settings_[key] = value;
}

std::string Problem::get(const std::string& key) const {
  YamlNode root = family_->document().root;
  Diagnostics out = family_->texts();
  for (const Setting& setting : parse_settings(texts({}), out)) apply_setting(root, setting, out);
  const YamlNode* node = find_present(root, key);
  if (out.has_errors()) throw ProblemFailure(out);
  if (node == nullptr) throw std::out_of_range(key);
  return json_of(*node).dump();
}

std::vector<std::string> Problem::texts(const Settings& more) const {
  Settings all = settings_;
  for (const auto& [key, value] : more) all[key] = value;
  std::vector<std::string> list;
  for (const auto& [key, value] : all) list.push_back(key + "=" + value);
  return list;
}

SolveTask Problem::task(const std::vector<std::string>& settings, Diagnostics& out) const {
  const std::vector<Setting> parsed = parse_settings(settings, out);
  auto built = family_->build(parsed, out);
  if (!built || out.has_errors()) throw ProblemFailure(out);
  SolveTask task{.built = *std::move(built)};
  task.candidates = usable_solvers(task.built, out);
  if (task.candidates.empty()) throw ProblemFailure(out);
  return task;
}

std::vector<std::string> Problem::check() const {
  Diagnostics out = family_->texts();
  task(texts({}), out);
  return told(out);
}

std::string Problem::describe() const {
  Diagnostics out = family_->texts();
  const BuiltProblem built = task(texts({}), out).built;
  OrderedJson json = motion_names(built);
  json["name"] = built.facts().name.value;
  json["knots"] = built.problem->knots();
  return json.dump();
}

std::shared_ptr<Answer> Problem::solve(const Settings& more,
                                       const std::shared_ptr<Answer>& warm_start,
                                       const std::optional<Guess>& guess, bool verify,
                                       const py::object& on_iteration) const {
  const auto began = Clock::now();
  Watch watch(on_iteration);
  const std::vector<std::string> settings = texts(more);
  std::optional<SolveTask> made;
  {
    const py::gil_scoped_release released;
    Diagnostics out = family_->texts();
    made = task(settings, out);
  }
  if (warm_start) start_from(*warm_start, *made);
  if (guess) start_from(*guess, *made);
  std::shared_ptr<Answer> answer;
  {
    const py::gil_scoped_release released;
    answer = answer_of(*made,
                       {.verify = verify,
                        .began = began,
                        .watch =
                            [&](SolverOptions& options) {
                              watch.set(options);
                              return nullptr;
                            }},
                       settings);
  }
  watch.rethrow();
  return answer;
}

std::vector<std::shared_ptr<Answer>> Problem::solve_many(const std::vector<Settings>& list,
                                                         int jobs, bool verify) const {
  std::vector<std::vector<std::string>> settings;
  for (const Settings& more : list) settings.push_back(texts(more));
  Watch watch(py::none{});
  std::vector<std::shared_ptr<Answer>> answers(list.size());
  std::exception_ptr failure;
  {
    const py::gil_scoped_release released;
    std::atomic<std::size_t> next = 0;
    std::mutex mutex;
    const auto work = [&] {
      for (std::size_t i = next++; i < list.size(); i = next++) try {
          Diagnostics out = family_->texts();
          SolveTask own = task(settings[i], out);
          answers[i] = answer_of(own,
                                 {.verify = verify,
                                  .watch =
                                      [&](SolverOptions& options) {
                                        watch.set(options);
                                        options.threads = 1;
                                        options.look_further = 0;
                                        return nullptr;
                                      }},
                                 settings[i]);
          if (answers[i]->result.status == SolveStatus::interrupted) next = list.size();
        } catch (...) {
          const std::lock_guard lock(mutex);
          if (!failure) failure = std::current_exception();
          next = list.size();
        }
    };
    std::vector<std::jthread> workers;
    for (int i = 0; i < jobs; ++i) workers.emplace_back(work);
  }
  watch.rethrow();
  if (failure) std::rethrow_exception(failure);
  return answers;
}

std::unique_ptr<LoopTask> Problem::build_loop() const {
  Diagnostics out = family_->texts();
  const std::vector<Setting> parsed = parse_settings(texts({}), out);
  auto task = family_->build_loop(parsed, out);
  if (!task || out.has_errors()) throw ProblemFailure(out);
  return task;
}

}  // namespace conddp::python
