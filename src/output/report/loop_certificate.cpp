#include "output/report/loop_certificate.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/files/text_file.hpp"
#include "base/json/json_document.hpp"
#include "base/stopwatch.hpp"
#include "base/text/csv_line.hpp"
#include "base/text/strict_number.hpp"
#include "output/mpc/loop_files.hpp"
#include "output/mpc/plant_replay.hpp"
#include "output/report/certificate_report.hpp"
#include "output/report/document_claims.hpp"
#include "output/solution/solution_json.hpp"

namespace conddp {
namespace {

/// Tolerance on numbers of different builds, relative to them or 1.
constexpr double kOtherBuild = 1e-6;
/// Key that a search over several loops adds to a loop's document; not compared.
constexpr std::string_view kSearched = "largest";
/// Tolerance on sums over rows for a different summation order, relative to them or 1.
constexpr double kSummation = 1e-12;

double figure_of(const OrderedJson& value) {
  return value.is_number() ? value.get<double>() : Check::kNone;
}

const OrderedJson& member_of(const OrderedJson& document, const std::string& key) {
  return solution_member(document, key.c_str());
}

/// A member of an object; null if missing.
OrderedJson part_of(const OrderedJson& object, const std::string& key) {
  return object.is_object() ? object.value(key, OrderedJson()) : OrderedJson();
}

/// The file names of a list without their folders, which depend on the working directory.
std::vector<std::string> file_names(const OrderedJson& list) {
  std::vector<std::string> names;
  for (const OrderedJson& file : list)
    names.push_back(std::filesystem::path(solution_text(file, "file")).filename().string());
  return names;
}

/// The first difference between two tables, in words; empty if they agree.
std::string first_difference(std::string_view claimed, std::string_view found, double tolerance) {
  const auto line_of = [](std::string_view& rest) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    return line;
  };
  const auto same = [tolerance](std::string_view a, std::string_view b) {
    if (a == b) return true;
    const auto x = parse_number(a).value, y = parse_number(b).value;
    return x && y && std::abs(*x - *y) <= tolerance * std::max(1.0, std::abs(*y));
  };
  for (int line = 1; !claimed.empty() || !found.empty(); ++line) {
    if (claimed.empty()) return fmt::format("line {} is missing", line);
    if (found.empty()) return fmt::format("line {} is one too many", line);
    const auto a = split_csv_line(line_of(claimed)), b = split_csv_line(line_of(found));
    if (a.size() != b.size())
      return fmt::format("line {} has {} cells in place of {}", line, a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i)
      if (!same(a[i].text, b[i].text))
        return fmt::format("line {}, cell {}: '{}' in the file, '{}' in the replay", line, i + 1,
                           a[i].text, b[i].text);
  }
  return {};
}

class LoopJudge {
 public:
  LoopJudge(const OrderedJson& document, const std::filesystem::path& folder, const LoopTask& task)
      : document_(document),
        folder_(folder),
        task_(task),
        tolerance_(is_of_this_build() ? 0 : kOtherBuild),
        ticks_(claimed_ticks()),
        late_(late_ticks()) {}

  LoopCertificate judge() {
    add(configuration_check(member_of(member_of(document_, "problem"), "configuration"),
                            task_.built));
    judge_clock();
    judge_plant();
    judge_loop();
    return std::move(certificate_);
  }

 private:
  /// Compares by keys: parsed documents have them in another order.
  bool is_of_this_build() const {
    const OrderedJson& tool = member_of(document_, "tool");
    for (const char* key : {"name", "version", "revision"}) solution_text(tool, key);
    return OrderedJson::diff(tool, tool_json()).empty();
  }

  /// Without a measured clock, only the file's disturbances make solves late.
  void judge_clock() {
    const std::string clock = solution_text(document_, "clock");
    const auto& is_late = task_.mpc.controller.is_late;
    const bool by_the_file =
        std::all_of(late_.begin(), late_.end(), [&](int tick) { return is_late && is_late(tick); });
    state(
        "clock", clock == "wall" || (clock == "simulated" && by_the_file),
        clock == "simulated"
            ? "ticks are late without a disturbance that causes it, although the clock is simulated"
            : fmt::format("'{}' is neither 'simulated' nor 'wall'", clock));
  }

  void add(Check check) { certificate_.checks.checks.push_back(std::move(check)); }
  void state(std::string name, bool holds, std::string message) {
    add({.name = std::move(name),
         .holds = holds,
         .message = holds ? std::string() : std::move(message)});
  }
  void figures(std::string name, double claimed, double found, double tolerance,
               std::string place = {}) {
    const bool both_missing = std::isnan(claimed) && std::isnan(found);
    add({.name = std::move(name),
         .holds = both_missing || std::abs(claimed - found) <= tolerance,
         .claimed = claimed,
         .found = found,
         .tolerance = tolerance,
         .place = std::move(place)});
  }

  /// The text of a file next to the document. If the file does not exist, its name is recorded as
  /// missing.
  std::optional<std::string> file_beside(const char* name) {
    std::error_code error;
    if (!std::filesystem::exists(folder_ / name, error)) {
      certificate_.missing.emplace_back(name);
      return std::nullopt;
    }
    TextFile file = read_text_file(folder_ / name, kMaxDataBytes);
    if (!file.defect.empty()) {
      state(name, false, file.defect);
      return std::nullopt;
    }
    return std::move(file.text);
  }

  /// Checks the rows of the plant using only its equations.
  void judge_plant() {
    const auto text = file_beside(kPlantFile);
    if (!text) return;
    try {
      compare_plant(read_plant_rows(*text, task_));
    } catch (const MalformedSolution& malformed) {
      state("plant", false, malformed.what());
    }
  }

  void compare_plant(const PlantRows& rows) {
    const PlantReplay replay = replay_plant(rows, task_);
    add({.name = "plant",
         .holds = replay.excess <= 1,
         .found = replay.deviation,
         .tolerance = replay.allowed,
         .place = replay.place,
         .message = plant_message(replay)});
    // If phases are re-timed, the rows alone do not determine which phase applied when.
    if (!task_.mpc.controller.retiming) judge_figures(replay);
    figures("plant's end", figure_of(member_of(document_, "end_time_s")), rows.times.back(),
            kSameTime);
    const std::string claimed = solution_text(document_, "end");
    state("plant's way to end", claimed == to_string(replay.end) && !replay.goes_on_after_end,
          replay.goes_on_after_end ? "a row before the last one ends the loop"
                                   : fmt::format("'{}' in the file, '{}' by the last row", claimed,
                                                 to_string(replay.end)));
    judge_last_state(rows.x.back());
  }

  static std::string plant_message(const PlantReplay& replay) {
    if (replay.excess <= 1) return {};
    if (!std::isfinite(replay.deviation)) return "a number is missing or not finite";
    return fmt::format("is off by {:.3g}, where the decimals of the times allow {:.1e}",
                       replay.deviation, replay.allowed);
  }

  void judge_figures(const PlantReplay& replay) {
    const double cost = figure_of(member_of(document_, "cost")),
                 violation = figure_of(member_of(document_, "violation"));
    figures("plant's cost", cost, finite_or_nan(replay.cost),
            replay.cost_rounding + kSummation * std::max(1.0, std::abs(replay.cost)));
    figures("plant's violation", violation, finite_or_nan(replay.violation),
            kSummation * std::max(1.0, replay.violation));
  }

  void judge_last_state(const std::vector<double>& x) {
    std::string message;
    for (std::size_t i = 0; i < x.size() && message.empty(); ++i) {
      const std::string& name = task_.built.state_columns[i].name;
      const double claimed = figure_of(part_of(member_of(document_, "last_state"), name));
      if (claimed == x[i] || (std::isnan(claimed) && std::isnan(x[i]))) continue;
      message = fmt::format("{}: {} in the file, {} in the last row", name, claimed, x[i]);
    }
    state("plant's last state", message.empty(), message);
  }

  static double finite_or_nan(double value) { return std::isfinite(value) ? value : Check::kNone; }

  /// Simulates the loop again, with the controller.
  void judge_loop() {
    MpcOptions controller = task_.mpc.controller;
    controller.clock = nullptr;
    if (solution_text(document_, "clock") == "wall")
      controller.is_late = [this, by_the_file = controller.is_late](int tick) {
        return late_.contains(tick) || (by_the_file && by_the_file(tick));
      };
    ClosedLoopOptions loop = task_.mpc.loop;
    if (solution_text(document_, "end") == to_string(LoopEnd::interrupted))
      loop.interrupted = [left = ticks_]() mutable { return left-- <= 0; };
    Mpc mpc(task_.built.problem, task_.built.guess, controller);
    const ClosedLoopResult result = run_closed_loop(mpc, loop);
    const LoopRun run{task_, result, {}};
    compare_documents(loop_json(run));
    compare_table(kPlantFile, closed_loop_csv(run));
    compare_table(kTicksFile, ticks_csv(run));
  }

  std::set<int> late_ticks() const {
    std::set<int> late;
    for (const OrderedJson& tick : solution_list(document_, "late_ticks")) {
      const bool is_whole = tick.is_number_integer();
      if (const double number = is_whole ? tick.get<double>() : -1; number < 0 || number >= ticks_)
        throw MalformedSolution{
            fmt::format("'late_ticks' has {}, which is none of {:g} ticks", tick.dump(), ticks_)};
      late.insert(tick.get<int>());
    }
    return late;
  }
  double claimed_ticks() const {
    const OrderedJson& ticks = member_of(document_, "ticks");
    if (!ticks.is_number_integer()) throw MalformedSolution{"'ticks' is not a whole number"};
    return ticks.get<double>();
  }

  /// Compares all statements of the document about the loop.
  void compare_documents(const OrderedJson& found) {
    static const std::set<std::string> kBeside = {"format", "problem", "tool", "clock"};
    for (const auto& [key, value] : found.items())
      if (!kBeside.contains(key)) compare(key, member_of(document_, key), value);
    compare_keys("document", document_, found);
    compare_problem(member_of(document_, "problem"), member_of(found, "problem"));
    if (document_.contains(kSearched)) judge_search(document_[std::string(kSearched)]);
  }

  /// Reports unknown keys of an object.
  void compare_keys(const char* name, const OrderedJson& claimed, const OrderedJson& found) {
    std::string unknown;
    for (const auto& [key, value] : claimed.items())
      if (!found.contains(key) && key != kSearched)
        unknown += (unknown.empty() ? "'" : ", '") + key + '\'';
    state(name, unknown.empty(), fmt::format("has {}, which conddp does not write", unknown));
  }

  /// Claims of a search must match the loop of this document; the other loops are not simulated.
  void judge_search(const OrderedJson& search) {
    static const std::set<std::string> kKeys = {"key", "low", "high", "survived"};
    std::set<std::string> keys;
    if (search.is_object())
      for (const auto& [key, value] : search.items()) keys.insert(key);
    if (keys != kKeys || !search["key"].is_string())
      throw MalformedSolution{"'largest' has to have 'key', 'low', 'high' and 'survived'"};
    const double low = figure_of(search["low"]), high = figure_of(search["high"]);
    const bool any = !search["survived"].is_null();
    const double shown = any ? figure_of(search["survived"]) : low;
    state("largest/survived", low <= shown && shown <= high,
          fmt::format("{} does not lie between {} and {}", shown, low, high));
    const OrderedJson& overrides = solution_list(member_of(document_, "problem"), "overrides");
    const std::string setting = fmt::format("{}={}", search["key"].get<std::string>(), shown);
    state("largest/key", !overrides.empty() && overrides.back() == setting,
          fmt::format("the loop was not simulated with '{}'", setting));
  }

  /// Compares name and files of the problem. The contents of the files are compared on reading.
  void compare_problem(const OrderedJson& claimed, const OrderedJson& found) {
    compare_keys("problem", claimed, found);
    compare("problem/name", member_of(claimed, "name"), member_of(found, "name"));
    for (const char* key : {"robots", "data_files"}) {
      const auto files = file_names(solution_list(claimed, key)),
                 read = file_names(member_of(found, key));
      state(fmt::format("problem/{}", key), files == read,
            fmt::format("[{}] in the file, [{}] in the problem", fmt::join(files, ", "),
                        fmt::join(read, ", ")));
    }
  }

  void compare(const std::string& name, const OrderedJson& claimed, const OrderedJson& found) {
    if (found.is_object()) {
      for (const auto& [key, value] : found.items())
        compare(name + "/" + key, part_of(claimed, key), value);
      return state(name, claimed.size() == found.size(),
                   fmt::format("{} entries in place of {}", claimed.size(), found.size()));
    }
    if (found.is_number() || (found.is_null() && claimed.is_number()))
      return figures(name, figure_of(claimed), figure_of(found),
                     tolerance_ * std::max(1.0, std::abs(figure_of(found))));
    // Parsed documents have their keys in alphabetical order.
    state(name, nlohmann::json(claimed) == nlohmann::json(found),
          fmt::format("{} in the file, {} in the replay", claimed.dump(), found.dump()));
  }

  void compare_table(const char* name, const std::string& found) {
    if (std::count(certificate_.missing.begin(), certificate_.missing.end(), name) > 0) return;
    const auto text = file_beside(name);
    if (!text) return;
    const std::string difference = first_difference(*text, found, tolerance_);
    state(name, difference.empty(), difference);
  }

  const OrderedJson& document_;
  const std::filesystem::path& folder_;
  const LoopTask& task_;
  const double tolerance_;
  const double ticks_;        ///< number of ticks in the document
  const std::set<int> late_;  ///< late ticks
  LoopCertificate certificate_;
};

}  // namespace

LoopCertificate certify_loop(const OrderedJson& document, const std::filesystem::path& folder,
                             const LoopTask& task) {
  double seconds = 0;
  LoopCertificate certificate;
  {
    const Stopwatch watch(seconds);
    certificate = LoopJudge(document, folder, task).judge();
  }
  certificate.time_s = seconds;
  return certificate;
}

std::string certificate_line(const LoopCertificate& certificate) {
  if (!certificate.checks.holds()) return failure_line(certificate.checks);
  return fmt::format("replayed ({} checks)", certificate.checks.checks.size());
}

OrderedJson certificate_json(const LoopCertificate& certificate) {
  return {{"holds", certificate.checks.holds()},
          {"checks", checks_json(certificate.checks)},
          {"missing_files", certificate.missing},
          {"time_s", certificate.time_s}};
}

}  // namespace conddp
