#include "batch/run/worker_process.hpp"

#include <poll.h>

#include <gtest/gtest.h>

namespace conddp {
namespace {

/// Waits for the next answer.
WorkerProcess::Answer next_answer(WorkerProcess& worker) {
  constexpr int kLongestWait = 5000;  // ms
  for (;;) {
    if (const auto answer = worker.take_answer()) return *answer;
    pollfd output{worker.output(), POLLIN, 0};
    if (::poll(&output, 1, kLongestWait) != 1 || !worker.read_some()) return {};
  }
}

TEST(WorkerProcess, GivesWholeAnswersInTheirOrder) {
  // Answers two items and half of the third, and the rest after a fourth.
  WorkerProcess worker({"/bin/sh", "-c",
                        R"(read a; read b; read c; printf '2 3\nabcde1 0\nf4 2\ngh';)"
                        R"(read d; printf 'ijkl'; read e)"});
  for (const std::size_t item : {5, 6, 7}) worker.send({item}, "line");
  WorkerProcess::Answer answer = next_answer(worker);
  EXPECT_EQ(answer.result, "ab");
  EXPECT_EQ(answer.solution, "cde");
  answer = next_answer(worker);
  EXPECT_EQ(answer.result, "f");
  EXPECT_EQ(answer.solution, "");
  EXPECT_FALSE(worker.take_answer());
  worker.send({8}, "line");
  answer = next_answer(worker);
  EXPECT_EQ(answer.result, "ghij");
  EXPECT_EQ(answer.solution, "kl");
  ASSERT_EQ(worker.unanswered().size(), 1u);
  EXPECT_EQ(worker.unanswered().front().item, 8u);
  EXPECT_EQ(worker.reap(true).exit_status, -1);
}

}  // namespace
}  // namespace conddp
