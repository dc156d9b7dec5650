#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/json/ordered_json.hpp"
#include "base/text/csv_line.hpp"
#include "base/text/strict_number.hpp"
#include "commands/closed_loops.hpp"
#include "mpc/closed_loop.hpp"
#include "output/solution/csv_cells.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/yaml/key_path.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

constexpr const char* kOption = "--largest";
constexpr const char* kTrialsFile = "largest.csv";

/// A number of the file, and the interval searched for the largest value that the loop survives.
struct SearchedNumber {
  std::string key;
  double low = 0, high = 0;
};

/// Parses "KEY=[LOW, HIGH]"; empty if malformed.
std::optional<SearchedNumber> parse_searched(const std::string& text) {
  const std::size_t open = text.find("=["), comma = text.find(',', open);
  if (open == 0 || open == std::string::npos || comma == std::string::npos || !text.ends_with(']'))
    return std::nullopt;
  const auto number = [&](std::size_t from, std::size_t to) {
    return parse_number(trimmed_csv(std::string_view(text).substr(from, to - from))).value;
  };
  const auto low = number(open + 2, comma), high = number(comma + 1, text.size() - 1);
  if (!low || !high || *low >= *high) return std::nullopt;
  return SearchedNumber{text.substr(0, open), *low, *high};
}

/// A value of the key as a setting whose messages name the option.
Setting setting_of(const std::string& key, double value, Diagnostics& out) {
  const std::string number = fmt::format("{}", value), text = key + '=' + number;
  const int source = out.add_source(kOption, text), column = static_cast<int>(key.size()) + 2;
  YamlNode node{.kind = YamlNode::Kind::kScalar, .mark = {source, 1, column}, .text = number};
  return {{key, {{source, 1, 1}, key}}, std::move(node), text};
}

/// True if the key has a number, or a formula of parameters, in a problem file.
bool is_number_of_file(YamlNode root, std::string_view key) {
  const YamlNode* node = find_present(root, key);
  return node != nullptr && node->kind == YamlNode::Kind::kScalar && !node->quoted &&
         (node->text.starts_with('=') || parse_number(node->text).value.has_value());
}

/// A problem file, and the loops built from it for many values.
class LoopFamily {
 public:
  LoopFamily(const MpcArguments& arguments, std::string key)
      : arguments_(arguments), key_(std::move(key)) {}

  /// Reads the file. Returns false with errors, in texts().
  bool load() {
    document_ = load_problem_of(arguments_, texts_);
    settings_ = parse_settings(settings_of(arguments_), texts_);
    return document_ && !texts_.has_errors();
  }
  const Diagnostics& texts() const { return texts_; }

  /// The loop with a value of the key, or of the unchanged file; null with errors.
  std::unique_ptr<LoopTask> build(std::optional<double> value, Diagnostics& out) const {
    std::vector<Setting> settings = settings_;
    if (value) settings.push_back(setting_of(key_, *value, out));
    return build_loop(read_problem(*document_, settings, out), build_options_of(arguments_), out);
  }

  /// Reports the value that caused the errors, which may refer to any place in the file.
  void blame(double value, Diagnostics& out) const {
    out.error({}, fmt::format("{}: the loop with {}={} cannot be built", kOption, key_, value));
  }

  /// Reports a key that is not a number, neither in the file nor among its defaults.
  void check_key(Diagnostics& out) const {
    YamlNode root = document_->root;
    for (const Setting& setting : settings_) apply_setting(root, setting, out);
    if (out.has_errors() || is_number_of_file(std::move(root), key_)) return;
    if (key_.starts_with("mpc.plant.set.")) return;  // optional in the file: trials check it
    const auto task = build(std::nullopt, out);
    if (!task) return;
    Diagnostics unused;
    auto whole = parse_problem(expanded_text(task->built), {}, unused);
    if (whole && is_number_of_file(std::move(whole->root), key_)) return;
    const int source = out.add_source(kOption, arguments_.largest);
    out.error({{source, 1, 1}, key_},
              fmt::format("'{}' is neither a number of the file nor one of its defaults", key_),
              fmt::format("write a number there; 'conddp check {} --expand' lists all numbers",
                          arguments_.file));
  }

 private:
  const MpcArguments& arguments_;
  const std::string key_;
  Diagnostics texts_;
  std::optional<ProblemDocument> document_;
  std::vector<Setting> settings_;
};

/// Searches for the largest value of a number whose loop survives.
class Search {
 public:
  Search(const MpcArguments& arguments, SearchedNumber number)
      : arguments_(arguments), number_(std::move(number)), family_(arguments, number_.key) {}

  int run() {
    const bool ready = prepare();
    print_messages(diagnostics_, verbosity_of(arguments_));
    if (!ready) return kExitBadInput;
    create_folder(folder_);  // so that a failure wastes no work
    const InterruptGuard guard;
    const auto largest =
        largest_survived(number_.low, number_.high, (number_.high - number_.low) / kParts,
                         [this](double value) { return survives(value); });
    if (failure_) print_messages(*failure_, verbosity_of(arguments_));
    if (failure_) return kExitBadInput;
    if (InterruptGuard::signal() != 0) return kExitSignalBase + InterruptGuard::signal();
    print(largest);
    return largest ? kExitConverged : kExitNotConverged;
  }

 private:
  /// Ratio of the initial to the final search interval.
  static constexpr int kParts = 128;

  /// True if the search must stop early.
  bool is_over() const { return failure_ || InterruptGuard::signal() != 0; }

  /// Checks all possible errors before the first loop is simulated: the key, both ends, and a
  /// number between them, which integer keys do not accept.
  bool prepare() {
    if (!family_.load()) return fail(family_.texts());
    Diagnostics key = family_.texts();
    family_.check_key(key);
    if (key.has_errors()) return fail(std::move(key));
    constexpr double kBetween = 0.381966;
    for (const double share : {0.0, 1.0, kBetween})
      if (!check_value(std::lerp(number_.low, number_.high, share), share == 0)) return false;
    return true;
  }

  bool check_value(double value, bool first) {
    Diagnostics own = family_.texts();
    const auto task = family_.build(value, own);
    if (!task) family_.blame(value, own);
    if (task && !task->mpc.loop.stop)
      own.error(task->built.facts().mpc->place,
                fmt::format("{}: --largest would always find HIGH", kNothingStopsALoop),
                kHowToStopALoop);
    if (own.has_errors()) return fail(std::move(own));
    if (!first) return true;
    folder_ = output_folder(arguments_, task->built);
    diagnostics_ = std::move(own);  // warnings of the first value only
    return true;
  }

  bool fail(Diagnostics reasons) {
    diagnostics_ = std::move(reasons);
    return false;
  }

  struct Trial {
    double value = 0;
    std::unique_ptr<LoopTask> task;
    ClosedLoopResult result;
  };

  bool survives(double value) {
    if (is_over()) return false;
    Diagnostics own = family_.texts();
    Trial trial{.value = value, .task = family_.build(value, own)};
    if (!trial.task) {
      family_.blame(value, own);
      failure_ = std::move(own);
      return false;
    }
    trial.result = simulate_task(arguments_, *trial.task);
    if (trial.result.end == LoopEnd::interrupted) return false;
    const bool survived = trial.result.end == LoopEnd::finished;
    add_row(trial, survived);
    if (survived || !shown_.task) shown_ = std::move(trial);
    write();  // saved in case the next trial fails or is interrupted
    return survived;
  }

  void add_row(const Trial& trial, bool survived) {
    const ClosedLoopResult& result = trial.result;
    rows_ += fmt::format("{},{},{}", trial.value, survived ? 1 : 0, to_string(result.end));
    for (const double figure : {tabulated_time(result.end_time), result.cost, result.violation}) {
      rows_ += ',';
      append_cell(figure, rows_);
    }
    rows_ += '\n';
  }

  /// The loop to be written: the one that survives the largest value, or the first if none
  /// survives.
  LoopRun shown_run() const {
    std::vector<std::string> settings = settings_of(arguments_);
    settings.push_back(fmt::format("{}={}", number_.key, shown_.value));
    return {*shown_.task, shown_.result, std::move(settings)};
  }

  /// Writes the trials so far, and the files of a loop.
  void write() {
    AtomicFiles files;
    paths_ = add_loop(shown_run(), folder_, files);
    paths_.push_back(folder_ / kTrialsFile);
    files.add(paths_.back(),
              csv_cell(number_.key) + ",survived,end,time_s,cost,violation\n" + rows_);
    files.commit();
  }

  void print(const std::optional<double>& largest) const {
    if (arguments_.json)
      print_result(json_text(json_of(largest)));
    else if (!arguments_.quiet)
      print_result(line_of(largest) + loop_summary(shown_run(), paths_));
  }

  /// mpc.json with the result of the search.
  OrderedJson json_of(const std::optional<double>& largest) const {
    OrderedJson json = loop_json(shown_run());
    json["largest"] = {{"key", number_.key}, {"low", number_.low}, {"high", number_.high}};
    json["largest"]["survived"] = largest ? OrderedJson(*largest) : OrderedJson();
    return json;
  }

  std::string line_of(const std::optional<double>& largest) const {
    if (!largest) return fmt::format("{}: the loop fails at {}\n", number_.key, number_.low);
    return fmt::format("{}: the loop lasts up to {}{}\n", number_.key, *largest,
                       *largest == number_.high ? ", the whole range" : "");
  }

  const MpcArguments& arguments_;
  const SearchedNumber number_;
  LoopFamily family_;
  Diagnostics diagnostics_;             ///< from the initial checks
  std::optional<Diagnostics> failure_;  ///< from a trial
  std::filesystem::path folder_;
  std::string rows_;                          ///< one per trial
  std::vector<std::filesystem::path> paths_;  ///< written files
  Trial shown_;                               ///< trial whose files are written
};

}  // namespace

std::string largest_defect(const std::string& text) {
  if (parse_searched(text)) return {};
  return fmt::format(
      "'{}' is not KEY=[LOW, HIGH], a key of the file and two numbers, the lower one first", text);
}

int search_largest(const MpcArguments& arguments) {
  return Search(arguments, *parse_searched(arguments.largest)).run();
}

}  // namespace conddp
