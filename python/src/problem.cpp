#include "problem.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include <fmt/format.h>


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
  /// Looks for a signal now. Python tells its main thread alone, so the workers of solve_many() cannot.
  void look() {
    const std::lock_guard lock(mutex_);
    if (error_) return;
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) error_ = std::make_exception_ptr(py::error_already_set());
  }
  /// With the GIL.
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

  /// Signals are looked for at this interval, since it takes the GIL.
  static constexpr std::chrono::milliseconds kInterval{20};

 private:
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

std::shared_ptr<Answer> answer_of(SolveTask task, const GridSolve::Options& options,
                                  std::vector<std::string> settings) {
  return std::make_shared<Answer>(
      Answer{solve_task(std::move(task), options, std::move(settings))});
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

std::string Problem::get(const std::string& key) const {
  const auto value = kept_.get(key);
  if (!value) throw std::out_of_range(key);
  return value->dump();
}

std::vector<std::string> Problem::check() const {
  Diagnostics out = kept_.texts();
  kept_.build(kept_.settings(), out);
  return told(out);
}

std::string Problem::describe() const {
  Diagnostics out = kept_.texts();
  return problem_outline(kept_.build(kept_.settings(), out).built).dump();
}

std::shared_ptr<Answer> Problem::solve(const Settings& more,
                                       const std::shared_ptr<Answer>& warm_start,
                                       const std::optional<Guess>& guess, bool verify,
                                       const py::object& on_iteration) const {
  const auto began = Clock::now();
  Watch watch(on_iteration);
  const std::vector<std::string> settings = kept_.settings(more);
  std::optional<SolveTask> made;
  {
    const py::gil_scoped_release released;
    Diagnostics out = kept_.texts();
    made = kept_.build(settings, out);
  }
  if (warm_start) start_from(*warm_start, *made);
  if (guess) start_from(*guess, *made);
  std::shared_ptr<Answer> answer;
  {
    const py::gil_scoped_release released;
    answer = answer_of(*std::move(made),
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
  for (const Settings& more : list) settings.push_back(kept_.settings(more));
  Watch watch(py::none{});
  std::vector<std::shared_ptr<Answer>> answers(list.size());
  std::exception_ptr failure;
  {
    const py::gil_scoped_release released;
    std::atomic<std::size_t> next = 0;
    std::mutex mutex;
    std::condition_variable ended;
    int running = jobs;
    const auto work = [&] {
      for (std::size_t i = next++; i < list.size(); i = next++) try {
          Diagnostics out = kept_.texts();
          answers[i] = answer_of(kept_.build(settings[i], out),
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
      const std::lock_guard lock(mutex);
      --running;
      ended.notify_one();
    };
    std::vector<std::jthread> workers;
    for (int i = 0; i < jobs; ++i) workers.emplace_back(work);
    std::unique_lock lock(mutex);
    while (!ended.wait_for(lock, Watch::kInterval, [&] { return running == 0; })) {
      lock.unlock();
      watch.look();
      lock.lock();
    }
  }
  watch.rethrow();
  if (failure) std::rethrow_exception(failure);
  return answers;
}

}  // namespace conddp::python
