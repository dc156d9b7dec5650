#include "systems/expressions/foreign_words.hpp"

#include <algorithm>
#include <span>

namespace conddp {
namespace {

struct ForeignWord {
  std::string_view word;
  std::string_view hint;
};

constexpr std::string_view kSteps =
    "there is no rounding and no remainder; smooth_step(a, width) is a step";
constexpr std::string_view kChoice = "write if(condition, a, b)";
constexpr std::string_view kPhaseTime = "the time of the phase is 'phase_time'";
constexpr std::string_view kFinalTime = "the time of the last node is 'final_time'";
constexpr std::string_view kLimit = "write smooth_min(smooth_max(a, lower, width), upper, width)";

constexpr ForeignWord kNames[] = {{"e", "the exponential function is exp(a)"},
                                  {"True", "conditions are comparisons: a < b"},
                                  {"False", "conditions are comparisons: a < b"},
                                  {"true", "conditions are comparisons: a < b"},
                                  {"false", "conditions are comparisons: a < b"},
                                  {"inf", "expressions have finite numbers"},
                                  {"t_phase", kPhaseTime},
                                  {"tf", kFinalTime},
                                  {"t_f", kFinalTime},
                                  {"t_final", kFinalTime}};

constexpr ForeignWord kFunctions[] = {{"ln", "write log(a), the natural logarithm"},
                                      {"log2", "write log(a)/log(2)"},
                                      {"exp2", "write 2^a"},
                                      {"square", "write a^2"},
                                      {"sqr", "write a^2"},
                                      {"power", "write a^b"},
                                      {"cbrt", "write a^(1/3)"},
                                      {"sec", "write 1/cos(a)"},
                                      {"csc", "write 1/sin(a)"},
                                      {"cot", "write 1/tan(a)"},
                                      {"arcsin", "write asin(a)"},
                                      {"arccos", "write acos(a)"},
                                      {"arctan", "write atan(a)"},
                                      {"arctan2", "write atan2(y, x)"},
                                      {"fabs", "write smooth_abs(a, width)"},
                                      {"sgn", "write 2*smooth_step(a, width) - 1"},
                                      {"step", "write smooth_step(a, width)"},
                                      {"heaviside", "write smooth_step(a, width)"},
                                      {"sigmoid", "write smooth_step(a, width)"},
                                      {"relu", "write smooth_max(a, 0, width)"},
                                      {"clip", kLimit},
                                      {"clamp", kLimit},
                                      {"sat", kLimit},
                                      {"where", kChoice},
                                      {"ifelse", kChoice},
                                      {"if_else", kChoice},
                                      {"norm_2", "write norm(v)"},
                                      {"sum", "write dot(v, [1, 1, 1])"},
                                      {"sumsqr", "write dot(v, v)"},
                                      {"floor", kSteps},
                                      {"ceil", kSteps},
                                      {"round", kSteps},
                                      {"mod", kSteps},
                                      {"fmod", kSteps}};

constexpr ForeignWord kOperators[] = {{"if", kChoice}, {"mod", kSteps}, {"div", kSteps}};

std::string_view find_hint(std::span<const ForeignWord> words, std::string_view word) {
  const auto found = std::ranges::find(words, word, &ForeignWord::word);
  return found == words.end() ? std::string_view() : found->hint;
}

}  // namespace

std::string_view foreign_name_hint(std::string_view name) { return find_hint(kNames, name); }
std::string_view foreign_function_hint(std::string_view name) {
  return find_hint(kFunctions, name);
}
std::string_view foreign_operator_hint(std::string_view word) {
  return find_hint(kOperators, word);
}

}  // namespace conddp
