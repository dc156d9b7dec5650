#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "batch/session/kept_problem.hpp"

namespace conddp {

/// Answers requests of `conddp serve`, JSON objects, with JSON objects on one line
/// (docs/command_line.md). Problems and answers stay in memory under names of the requests.
class ProblemServer {
 public:
  /// Requests longer than this are refused, bytes.
  static constexpr std::size_t kLongestRequest = 64 << 20;

  /// `watch` sets the callbacks of a solve's options, as for GridSolve.
  explicit ProblemServer(std::function<std::shared_ptr<void>(SolverOptions&)> watch)
      : watch_(std::move(watch)) {}

  /// The reply to a request, without a line end. Errors of all kinds are replies.
  std::string reply(std::string_view request);
  /// The reply to a request that is too long to be read.
  static std::string refusal();

 private:
  OrderedJson answer(const OrderedJson& request);
  OrderedJson load(const OrderedJson& request);
  OrderedJson solve(const OrderedJson& request);
  OrderedJson drop(const OrderedJson& request);

  std::function<std::shared_ptr<void>(SolverOptions&)> watch_;
  std::map<std::string, KeptProblem, std::less<>> problems_;
  std::map<std::string, std::shared_ptr<const KeptAnswer>, std::less<>> answers_;
};

}  // namespace conddp
